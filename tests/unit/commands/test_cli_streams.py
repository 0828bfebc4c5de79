"""Streams that are closed, full, or read no further; paths in a circle; commands that are not there."""

import subprocess
import sys
from pathlib import Path

import pytest
from scanrack.commands import COMMANDS, build
from scanrack.terminal import status
from typer.testing import CliRunner

RACK = """\
program = "line.rung"
run_for_s = 0.02

[[slot]]
number = 1
module = "amci3601"
"""
RUNGS = "PROGRAM line\nTAG Lamp : BOOL\nROUTINE Main\n{}END\n"
RUNG = "XIC(Lamp)OTL(Lamp);\n"
SCANRACK = f"{sys.executable} -m scanrack"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    here = tmp_path_factory.mktemp("streams")
    (here / "line.toml").write_text(RACK, encoding="utf-8")
    (here / "line.rung").write_text(RUNGS.format(RUNG), encoding="utf-8")
    (here / "long.rung").write_text(RUNGS.format(RUNG * 1500), encoding="utf-8")  # more than a pipe holds
    for name in ("loop.mcap", "loop.toml"):
        (here / name).symlink_to(name)
    return here


def shell(folder, line):
    """Run a line of bash; return the statuses of its last pipe, and what went to standard error."""
    script = f'{line.replace("scanrack", SCANRACK)}; echo "${{PIPESTATUS[*]}}" >statuses'
    done = subprocess.run(
        ["bash", "-c", script], cwd=folder, capture_output=True, text=True, timeout=120, encoding="utf-8"
    )
    return (folder / "statuses").read_text(encoding="utf-8").split(), done.stderr


CLOSED = "scanrack: standard output can't be written: Bad file descriptor\n"
FULL = "scanrack: standard output can't be written: No space left on device\n"

LINES = {
    "no standard input": (
        "scanrack drive amci3601 <&-",
        "2",
        "scanrack: no requests: standard input is closed\n",
    ),
    "a full disk behind a summary": ("scanrack run line.toml --no-record >/dev/full", "3", FULL),
    "a full disk behind --help": ("scanrack --help >/dev/full", "3", FULL),
    "a full disk behind everything": ("scanrack ladder line.rung >/dev/full 2>/dev/full", "3", ""),
    "a list read no further": ("scanrack xref long.rung | head -1", "141", ""),
    "replies read no further": ("yes '{}' | scanrack drive amci3601 | head -1", "141", ""),
    "no standard output": ("scanrack run line.toml --no-record >&-", "3", CLOSED),
    "no standard output behind an export": (
        "scanrack run line.toml -q --record a.mcap; scanrack export a.mcap --csv - >&-",
        "3",
        CLOSED,
    ),
    "no standard stream at all": ("scanrack run line.toml --no-record <&- >&- 2>&-", "3", ""),
}


@pytest.mark.slow
@pytest.mark.parametrize(("line", "ended", "told"), LINES.values(), ids=LINES)
def test_streams_that_are_not_what_they_should_be(folder, line, ended, told):
    statuses, said = shell(folder, line)
    assert (ended in statuses, said) == (True, told)


CIRCLES = {
    "a rack": (
        "run loop.toml",
        status.BAD_INPUT,
        "scanrack: loop.toml: the rack file can't be read: Too many levels of symbolic links\n",
    ),
    "a trace": (
        "run line.toml --record loop.mcap",
        status.CANNOT_WRITE,
        "scanrack: {folder}/loop.mcap: Too many levels of symbolic links\n",
    ),
}


@pytest.mark.parametrize(("line", "ended", "told"), CIRCLES.values(), ids=CIRCLES)
def test_what_a_run_reads_and_writes_is_not_in_a_circle(folder, line, ended, told, monkeypatch):
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(build(), line.split())
    assert (done.exit_code, done.stderr) == (ended, told.format(folder=folder))


READERS = {"query": "slot1.in.STOPPED", "export": "--csv out.csv", "compare": "loop.mcap"} | dict.fromkeys(
    ("show", "plot", "repair", "replay", "replay --into session"), ""
)


@pytest.mark.parametrize(("command", "extra"), READERS.items(), ids=READERS)
def test_a_circle_of_links_is_told_in_one_line(folder, command, extra, monkeypatch):
    monkeypatch.chdir(folder)
    done = CliRunner().invoke(build(), [*command.split(), "loop.mcap", *extra.split()])
    assert done.exit_code in (status.BAD_INPUT, status.CANNOT_WRITE)
    assert done.stderr.count("\n") == 1
    assert "Too many levels of symbolic links" in done.stderr


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("shwo", "no command 'shwo': did you mean show?"),
        ("exprot", "no command 'exprot': did you mean export?"),
        ("xyz", "no command 'xyz'; choose from new, run, watch, "),
    ],
)
def test_a_command_that_is_not_there(typed, told):
    done = CliRunner().invoke(build(), [typed])
    assert done.exit_code == status.BAD_INPUT
    assert told in " ".join(done.stderr.split())


def test_there_is_one_table_of_statuses():
    """Only the table gives a status a number: no module of the commands has one of its own."""
    assert status.__file__ is not None
    folder = Path(status.__file__).parent
    numbers = {name: value for name, value in vars(status).items() if name.isupper()}
    assert sorted(set(numbers.values())) == [0, 1, 2, 3, 130, 141]  # two commands' 3 is not the same
    for module in folder.glob("*.py"):
        text = module.read_text(encoding="utf-8")
        for literal in ("typer.Exit(0", "typer.Exit(1", "typer.Exit(2", "typer.Exit(3", "sys.exit(1"):
            assert literal not in text, module.name
        if module.stem != "status":
            assert not any(f"\n{name} = " in text for name in numbers), module.name


def test_every_command_is_listed_once():
    assert len(COMMANDS) == len(set(COMMANDS))
