"""Files that are no files, texts without an end, threads that go on: each command ends with a sentence."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import forked
import pytest
from scanrack.commands import build
from scanrack.jobs.record.order_repeater import lost_edits
from scanrack.terminal.terminal import LINE_MOST, MESSAGE_LINES, say
from scanrack.traces import TraceEvent
from typer.testing import CliRunner, Result

RACK = 'program = "{}"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def scanrack(words: str) -> Result:
    return CliRunner().invoke(build(), words.split())


COMMANDS = {
    "run rack.toml": "rack.toml",
    "check rack.toml": "rack.toml",
    "watch rack.toml": "rack.toml",
    "why rack.toml": "rack.toml",
    "xref rack.toml Run": "rack.toml",
    "fuzz rack.toml": "rack.toml",
    "run rack.py": "rack.py",
    "run with_py.toml": "line.py",
    "run with_rung.toml": "line.rung",
    "run with_st.toml": "line.st",
    "run with_steps.toml": "line.steps",
    "run with_L5X.toml": "line.L5X",
    "run with_SLC.toml": "line.SLC",
    "run with_unit.toml": "unit.pclt",
    "run good.toml --retain tags.json": "tags.json",
    "ladder line.rung": "line.rung",
    "l5x line.L5X": "line.L5X",
    "l5x line.SLC": "line.SLC",
    "l5x other": "other",
    "check unit.pclt": "unit.pclt",
    "serve pcl601 --program unit.pclt": "unit.pclt",
    "serve pmc006 --program listing": "listing",
    "fuzz good.toml --scenario scenario.json": "scenario.json",
    "fuzz good.toml --invariants must.py": "must.py",
    "show run.mcap": "run.mcap",
    "query run.mcap Run": "run.mcap",
    "repair run.mcap": "run.mcap",
    "replay run.mcap --into session": "run.mcap",
    "compare run.mcap run.mcap": "run.mcap",
}
"""Commands, and the file of theirs that is none."""


def write_racks(place: Path) -> None:
    for suffix in ("py", "rung", "st", "steps", "L5X", "SLC"):
        (place / f"with_{suffix}.toml").write_text(RACK.format(f"line.{suffix}"), encoding="utf-8")
    (place / "good.rung").write_text(
        "PROGRAM p\nTAG Run : BOOL\nROUTINE Main\nOTE(Run);\nEND\n", encoding="utf-8"
    )
    (place / "good.toml").write_text(RACK.format("good.rung"), encoding="utf-8")
    (place / "with_unit.toml").write_text(
        f'{RACK.format("good.rung")}[[unit]]\nprogram = "unit.pclt"\n', encoding="utf-8"
    )


@pytest.mark.parametrize("words", COMMANDS)
@pytest.mark.parametrize("kind", ["fifo", "device"])
def test_what_is_no_file_is_refused_at_once(place: Path, words: str, kind: str) -> None:
    write_racks(place)
    name = COMMANDS[words]
    if kind == "fifo":
        os.mkfifo(place / name)
    else:
        (place / name).symlink_to("/dev/zero")
    result = scanrack(words)
    assert result.exit_code == 2, (result.output, result.exception)
    assert name in result.stderr or "/dev/zero" in result.stderr


SECRET = "root:$6$salt$thehash:19000:0:99999:7:::"


@pytest.mark.parametrize("name", ["line.rung", "line.st", "line.steps", "unit.pclt", "rack.toml", "line.L5X"])
def test_a_link_to_a_file_of_another_kind_is_not_shown(place: Path, name: str) -> None:
    write_racks(place)
    (place / "shadow").write_text(f"{SECRET}\n", encoding="utf-8")
    (place / name).symlink_to("shadow")
    for words in (words for words, file in COMMANDS.items() if file == name):
        result = scanrack(words)
        assert result.exit_code == 2, words
        assert "thehash" not in result.output, words


def test_a_stored_program_of_a_unit_has_its_suffix(place: Path) -> None:
    write_racks(place)
    (place / "shadow").write_text(f"{SECRET}\n", encoding="utf-8")
    rack = (place / "with_unit.toml").read_text(encoding="utf-8").replace("unit.pclt", "shadow")
    (place / "with_unit.toml").write_text(rack, encoding="utf-8")
    result = scanrack("run with_unit.toml")
    assert result.exit_code == 2
    assert 'with_unit.toml:6: unit.program = "shadow": a stored program has the suffix .pclt' in result.stderr
    assert "thehash" not in result.output


RAISES = """
def logic(scan):
    raise RuntimeError({})
"""


@pytest.mark.parametrize("text", ["'x' * 50_000", "'x\\n' * 25_000"], ids=["a line", "lines"])
@pytest.mark.parametrize("loading", [True, False])
def test_a_text_without_an_end_is_shortened(place: Path, text: str, loading: bool) -> None:
    program = RAISES.format(text)
    (place / "line.py").write_text(program + "logic(None)\n" * loading, encoding="utf-8")
    (place / "rack.toml").write_text(RACK.format("line.py"), encoding="utf-8")
    result = scanrack("run rack.toml --record t.mcap")
    assert result.exit_code == 2 if loading else 1
    assert len(result.output) < 20_000
    assert "50,000 characters" in result.output or "more lines" in result.output
    if not loading:
        assert (place / "t.mcap").stat().st_size < 50_000
        assert len(scanrack("show t.mcap").output) < 20_000


def test_what_is_said_is_shortened_and_data_is_whole(capsys: pytest.CaptureFixture[str]) -> None:
    say("x" * (LINE_MOST + 1))
    say("x\n" * (MESSAGE_LINES + 9), err=True)
    told = capsys.readouterr()
    assert told.out == f"{'x' * LINE_MOST}... (4,001 characters)\n"
    assert told.err == "x\n" * MESSAGE_LINES + "... (10 more lines)\n"
    say("x" * 100_000, whole=True)
    assert len(capsys.readouterr().out) == 100_001


def test_an_order_without_a_name_is_no_edit() -> None:
    assert lost_edits([TraceEvent(3, 0, "/orders", {})]) == []


GOES_ON = """
import threading

def logic(scan):
    if scan.first:
        threading.Thread(target=threading.Event().wait, name="pump").start()
"""


@pytest.mark.slow
def test_a_thread_that_goes_on_is_named_and_ended(place: Path) -> None:
    (place / "line.py").write_text(GOES_ON, encoding="utf-8")
    (place / "rack.toml").write_text(RACK.format("line.py"), encoding="utf-8")
    words = [sys.executable, "-m", "scanrack", "run", "rack.toml", "--for", "20ms", "--no-record", "--quiet"]
    done = forked.run(words, capture_output=True, text=True, timeout=300, encoding="utf-8")
    assert done.returncode == 0
    assert done.stderr == "scanrack: threads of the program still run, and are ended in 2 s: pump\n"
