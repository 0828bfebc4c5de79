"""No output of any command replaces a file that somebody owns.

Every parameter of every command is an input, an output, or a word; one that stands in none of the tables
fails the first test. Every output is then given each file that its command reads, imports or finds named in
the rack, and a file of another kind.
"""

from __future__ import annotations

import enum
import inspect
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

import pytest
import typer
from captured import conversation, modbus_tcp, pcap
from l5x_files import machine
from scanrack.commands import build
from scanrack.jobs.fuzz import folder_lock
from scanrack.traces.export.formats import FORMATS
from typer.testing import CliRunner

INPUTS = {
    "run rack", "watch rack", "share trace", "show trace", "query trace", "plot trace", "export trace",
    "compare a", "compare b", "repair trace",
    "replay path", "replay rack", "replay program", "ladder file", "l5x file",
    "l5x against", "why file", "xref file", "fuzz rack", "fuzz invariants", "fuzz scenario",
    "fuzz begin_with", "check files",
    "prove rack", "prove new", "tags rack", "run ua_users", "watch ua_users",
    "serve program", "serve rack", "import capture", "conform plan", "conform source",
    "device pcl601 program list file", "device pcl601 program write file",
    "device pmc006 program check file", "device pmc006 program write file",
}  # fmt: skip
"""Parameters that name files to be read."""

FRESH = {"new folder", "fuzz tests"}
"""Outputs that have to be new or empty: tests/unit/jobs/test_new_project.py, test_fuzz_written_tests.py."""

WORDS = {
    "new example", "run duration", "run tag", "run server", "watch server", "watch speed", "watch duration",
    "show ranges", "share at",
    "query text", "query show",
    "plot tag", "plot title", "plot ranges", "export signal", "export ranges",
    "compare tolerance_time", "compare align_at", "compare realign_at", "replay tolerance_time",
    "ladder routine", "ladder at", "l5x export", "l5x stepper",
    "prove only", "why what", "why at", "why until", "why want", "xref tag", "fuzz check",
    "fuzz duration", "fuzz processor", "fuzz time", "fuzz only", "fuzz without", "fuzz dask", "drive target",
    "check drive", "prove outputs", "debug key",
    "conform path", "conform counter", "conform wire", "conform scene", "conform scan",
    "serve serial",
    "serve tcp", "serve ethernet_ip", "serve address", "serve pin", "serve machine", "serve thumbwheel",
    "serve fault",
    "device pcl601 read name", "device pcl601 set name",
    "device pmc006 read name", "device pmc006 set name", "device identify port",
    "device identify address", "rules ids", "rules bit", "rules firmware", "tags tag", "replay configuration",
    "conform configuration",
}  # fmt: skip
"""Parameters of type str that name no file."""


class Output(NamedTuple):
    """An output of a command.

    Attributes:
        words: the command, where {} is the output.
        name: that an output of its kind has.
        used: files that the command reads, imports or finds named, in the folder below.
        target: where the output goes, if the words do not say so.
    """

    words: str
    name: str
    used: Sequence[str]
    target: str = "{}"


RUN = ("line.toml", "line.py", "lib.py", "unit.pclt")
RUNGS = ("rungs.toml", "line.rung")
ONE = "--scans 1 -q"

OUTPUTS = {
    "run record": Output(f"run line.toml {ONE} --record {{}}", "new.mcap", RUN),
    "run retain": Output(f"run rungs.toml {ONE} --record x.mcap --retain {{}}", "a.tags", (*RUNGS, "x.mcap")),
    "watch record": Output("watch line.toml --for 10ms --record {}", "new.mcap", RUN),
    "plot out": Output("plot run.mcap -q --out {}", "new.html", ("run.mcap",)),
    "share out": Output("share run.mcap --out {}", "new.html", ("run.mcap",)),
    **{
        f"export {each.name}": Output(
            f"export run.mcap -q {each.option} {{}}", f"new.{each.name}", ("run.mcap",)
        )
        for each in FORMATS
    },
    "import out": Output("import talk.pcap --out {}", "new.mcap", ("talk.pcap",)),
    "import simulated_to": Output(
        "import talk.pcap --out a.mcap --simulated {}", "new.mcap", ("talk.pcap", "a.mcap")
    ),
    "conform result_file": Output("conform --judge run.mcap -q --out {}", "new.json", ("run.mcap",)),
    "conform html": Output("conform --judge run.mcap -q --out x.json --html {}", "new.html", ("run.mcap",)),
    "repair output": Output("repair torn.mcap -q --out {}", "new.mcap", ("torn.mcap",)),
    "replay record": Output(
        "replay --into session run.mcap -q --trust --record {}", "new.mcap", ("run.mcap",)
    ),
    "l5x html": Output("l5x new.L5X --against old.L5X --html {}", "new.html", ("new.L5X", "old.L5X")),
    "ladder svg": Output("ladder rungs.toml --svg {}", "new.svg", RUNGS),
    "ladder svg of a program": Output("ladder line.rung --svg {}", "new.svg", ("line.rung",)),
    "l5x out": Output("l5x line.rung --export line --out {}", "new.L5X", ("line.rung",)),
    "serve record": Output("serve pcl601 --pty --program unit.pclt --record {}", "new.mcap", ("unit.pclt",)),
    "serve memory": Output("serve pcl601 --pty --program unit.pclt --memory {}", "new.json", ("unit.pclt",)),
    "show folder": Output("show run.mcap --extract {}", "new", ("run.mcap",)),
    "prove html": Output("prove rungs.toml -q --html {}", "new.html", RUNGS),
    "prove out": Output("prove claims.toml -q --out {}", "new", ("claims.toml", "line.rung")),
    "fuzz out": Output("fuzz line.toml --runs 1 -j 1 -q --out {}", "new", RUN),
}
"""The outputs by command and parameter."""

DEFAULTS = {
    "run": Output(f"run line.toml {ONE}", "line.mcap", (), "line.mcap"),
    "run with units": Output(f"run line.toml {ONE} --record a.mcap", "a.line.mcap", (), "a.line.mcap"),
    "run, trace in the rack file": Output(f"run named.toml {ONE}", "named.trace", (), "named.trace"),
    "plot": Output("plot run.mcap -q", "run.html", (), "run.html"),
    "share": Output("share run.mcap", "run.html", (), "run.html"),
    "import": Output("import talk.pcap", "talk.mcap", (), "talk.mcap"),
    "fuzz": Output("fuzz line.toml --runs 1 -j 1 -q", "line-fuzz", (), "line-fuzz"),
    "prove": Output("prove claims.toml -q", "claims-prove", (), "claims-prove"),
    "editor schema": Output("editor schema --write", "rack.schema.json", (), "rack.schema.json"),
}
"""Outputs that no option names."""

ELSEWHERE = ("serve record", "serve memory", "watch record", "export parquet", "fuzz out", "prove out")
"""Commands that take long to end, or need more than is installed for sure: tests of theirs let them run."""

FOLDERS = ("show folder", "fuzz out", "prove out")
"""Outputs that are a folder; the system says that a file is none."""

RACK = 'program = "{}"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
CLAIM = '[[prove.property]]\nname = "off"\nnever = "A"\n'
UNIT = '[[unit]]\naddress = 1\nprogram = "unit.pclt"\n'


def commands(group: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[str, Callable[..., object]]]:
    """Yield every command with its function."""
    group = group or typer.main.get_command(build())
    for name in group.list_commands(None):
        command = group.get_command(None, name)
        if hasattr(command, "list_commands"):
            yield from commands(command, (*path, name))
        else:
            yield " ".join((*path, name)), command.callback


def types_of(annotation: Any) -> set[Any]:
    """Return the types in an annotation: `Annotated[list[Path] | None, ...]` has list, Path, None."""
    inner = get_args(annotation)
    if hasattr(annotation, "__metadata__"):
        return types_of(inner[0])
    return set().union({annotation}, *map(types_of, inner))


def test_every_parameter_is_an_input_an_output_or_a_word() -> None:
    files, words = set(), set()
    for command, function in commands():
        for each in inspect.signature(inspect.unwrap(function), eval_str=True).parameters.values():
            kinds = types_of(each.annotation)
            if Path in kinds:
                files.add(f"{command} {each.name}")
            elif any(kind is str for kind in kinds) and not any(_is_enum(kind) for kind in kinds):
                words.add(f"{command} {each.name}")
    known = {name.partition(" of ")[0] for name in OUTPUTS}
    assert files - INPUTS - FRESH == known - words
    assert words - INPUTS - known == WORDS
    assert files | words >= INPUTS


def _is_enum(kind: object) -> bool:
    return isinstance(kind, type) and issubclass(kind, enum.Enum)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a rack of Python, one of rungs, and recordings."""
    folder = tmp_path_factory.mktemp("made")
    (folder / "line.toml").write_text(RACK.format("line.py") + UNIT, encoding="utf-8")
    (folder / "named.toml").write_text('trace = "named.trace"\n' + RACK.format("line.py"), encoding="utf-8")
    (folder / "line.py").write_text(
        "import lib\n\n\ndef logic(scan):\n    lib.step(scan)\n", encoding="utf-8"
    )
    (folder / "lib.py").write_text("def step(scan):\n    pass\n", encoding="utf-8")
    (folder / "unit.pclt").write_text("END\n", encoding="utf-8")
    talk = [(True, modbus_tcp(1, "06 0005 0064")), (False, modbus_tcp(1, "06 0005 0064"))]
    (folder / "talk.pcap").write_bytes(pcap(conversation(talk)))
    (folder / "rungs.toml").write_text(RACK.format("line.rung"), encoding="utf-8")
    (folder / "claims.toml").write_text(f"{RACK.format('line.rung')}{CLAIM}", encoding="utf-8")
    (folder / "line.rung").write_text(
        "PROGRAM line\nTAG A : BOOL\nROUTINE Main\nOTE(A);\nEND\n", encoding="utf-8"
    )
    with pytest.MonkeyPatch.context() as here:
        here.chdir(folder)
        assert scanrack("run named.toml --scans 50 -q --record run.mcap") == (0, "")
    for name in ("old.L5X", "new.L5X"):
        (folder / name).write_text(machine("XIC(A)OTE(B);"), encoding="utf-8")
    (folder / "torn.mcap").write_bytes((folder / "run.mcap").read_bytes()[:-40])
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    shutil.copytree(made, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scanrack(words: str) -> tuple[int, str]:
    result = CliRunner().invoke(build(), words.split())
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
    return result.exit_code, result.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", OUTPUTS)
def test_a_file_in_use_is_never_replaced(folder: Path, name: str) -> None:
    output = OUTPUTS[name]
    for used in output.used:
        ways = [used, f"symbolic-{used}"]
        (folder / ways[1]).symlink_to(used)
        if (folder / used).exists():
            ways.append(f"hard-{used}")
            (folder / ways[2]).hardlink_to(folder / used)
        before = content(folder)
        for way in ways:
            status, said = scanrack(output.words.format(way))
            assert status == (3 if name in FOLDERS else 2), (way, said)
            assert way in said
            assert content(folder) == before, way


@pytest.mark.parametrize("output", [*OUTPUTS.values(), *DEFAULTS.values()], ids=[*OUTPUTS, *DEFAULTS])
def test_a_file_of_another_kind_is_never_replaced(folder: Path, output: Output) -> None:
    target = folder / output.target.format(output.name)
    if target.suffix:
        target.write_text("Call the customer about the feeder.\n", encoding="utf-8")
    else:
        target.mkdir()
        (target / "state.txt").write_text("mine", encoding="utf-8")
    before = content(folder)
    status, said = scanrack(output.words.format(target.name))
    if output.words.startswith("show"):
        assert status == 0  # its own files stand beside the others
        assert (target / "state.txt").read_text(encoding="utf-8") == "mine"
        return
    assert status == 2
    assert target.name in said
    assert "another" in said
    assert content(folder) == before


@pytest.mark.parametrize("name", [name for name in OUTPUTS if name not in ELSEWHERE])
def test_a_new_file_is_written_and_replaced_by_its_like(folder: Path, name: str) -> None:
    output = OUTPUTS[name]
    for _ in range(2):
        assert scanrack(output.words.format(output.name)) == (0, "")
        assert (folder / output.name).exists()


def test_an_extracted_file_replaces_nothing(folder: Path) -> None:
    (folder / "out").mkdir()
    (folder / "out" / "lib.py").write_text("mine", encoding="utf-8")
    status, said = scanrack("show run.mcap --extract out")
    assert status == 2
    assert "lib.py already exists" in said
    assert (folder / "out" / "lib.py").read_text(encoding="utf-8") == "mine"


def test_the_folder_of_a_campaign_is_known_by_its_files(folder: Path) -> None:
    with folder_lock.locked(folder / "new"):
        assert (folder / "new" / folder_lock.NAME).exists()
    (folder / "new" / "more").mkdir()
    with folder_lock.locked(folder / "new"):
        pass
    with (
        pytest.raises(ValueError, match="has files of another kind: use another folder with --out"),
        folder_lock.locked(folder),
    ):
        pass
    assert not (folder / folder_lock.NAME).exists()


def content(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
