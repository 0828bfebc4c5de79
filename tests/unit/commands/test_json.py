"""--json: one object on standard output, whatever the command; its numbers are those of the text."""

import json
from pathlib import Path
from typing import Any

import pytest
from scanrack.commands import build
from scanrack.io_images.amci3601 import RULES
from typer.testing import CliRunner

RACK = """program = "line.rung"
run_for_s = 0.2

[[slot]]
number = 1
module = "amci3601"
"""
RUNGS = "PROGRAM line\nTAG Go : BOOL := 1\nTAG Lamp : BOOL\nROUTINE Main\nXIC(Go)OTE(Lamp);\nEND\n"
FAULT = """def logic(scan):
    print("hello")
    if scan.number == 30:
        raise ValueError("no more")
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rack of rungs, one whose program faults in scan 30, and a trace of each: 2 ms a scan."""
    here = tmp_path_factory.mktemp("json")
    (here / "line.rung").write_text(RUNGS, encoding="utf-8")
    (here / "line.toml").write_text(RACK, encoding="utf-8")
    (here / "fault.py").write_text(FAULT, encoding="utf-8")
    (here / "fault.toml").write_text(RACK.replace("line.rung", "fault.py"), encoding="utf-8")
    return here


@pytest.fixture(autouse=True)
def _inside(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    if not Path("line.mcap").exists():
        answer("run", "line.toml", status=0)


def answer(*words: str, status: int) -> Any:
    """Run a command with --json; return what it prints, read."""
    done = CliRunner().invoke(build(), [*words, "--json"])
    assert done.exit_code == status, done.output
    return json.loads(done.stdout)


def test_run() -> None:
    found = answer("run", "line.toml", "--no-record", status=0)
    assert (found["ended"], found["scans"], found["time_ns"]) == ("done", 100, 200_000_000)
    assert (found["fault"], found["trace"], found["moves"]) == (None, None, [])
    assert {row["rule"] for row in found["every_start"]} == {"CER-01"}


def test_run_that_faults_and_prints() -> None:
    found = answer("run", "fault.toml", "--no-record", status=1)
    assert found["ended"] == "fault"
    assert (found["fault"]["scan"], found["fault"]["now_ns"]) == (30, 60_000_000)
    assert found["fault"]["text"] == "ValueError: no more"
    assert found["fault"]["where"].endswith("fault.py:4")


def test_show() -> None:
    found = answer("show", "line.mcap", status=0)
    assert (found["scans"], found["first"], found["last"], found["end_ns"]) == (100, 0, 99, 198_000_000)
    assert [(slot["number"], slot["module"]) for slot in found["slots"]] == [(1, "amci3601")]
    assert {"line.toml", "line.rung"} <= set(found["attached"])
    assert next(each["scan"] for each in found["changes"]) == 0
    assert (found["more_events"], found["more_changes"]) == (0, 0)
    assert len(answer("show", "line.mcap", "--limit", "1", status=0)["changes"]) == 1


@pytest.mark.parametrize(
    ("option", "value", "scans"),
    [("--range", "100ms:", 0), ("--range", ":1ms", 1), ("--range", "0:0", 1), ("--range", "5:", 0)],
)
def test_show_of_a_part(option: str, value: str, scans: int) -> None:
    """Nothing changes after scan 0, in which the status bits of power-up appear."""
    found = answer("show", "line.mcap", option, value, status=0)
    assert len({each["scan"] for each in found["changes"] if each["scan"] is not None}) == scans


def test_query() -> None:
    found = answer("query", "line.mcap", "slot1.in.CONFIG_ERROR", "--show", "slot1.in.position", status=0)
    (one,) = found["occurrences"]
    assert (found["count"], one["first"], one["last"], one["open"]) == (1, 0, 99, True)
    assert one["duration_ns"] == 200_000_000 - 2_000_000
    assert list(one["shown"]) == ["slot1.in.position"]
    nothing = answer("query", "line.mcap", "slot1.in.COMMAND_ERROR", status=1)
    assert nothing == {"aggregate": None, "count": 0, "occurrences": []}


def test_why_and_xref() -> None:
    asked = answer("why", "line.toml", "Lamp", "--at", "9", status=0)
    assert (asked["what"], asked["scan"], asked["now_ns"], asked["fault"]) == ("Lamp", 9, 18_000_000, None)
    assert asked["text"].startswith("Lamp is on since 0 s: Main rung 0: OTE(Lamp)")
    assert answer("why", "line.mcap", "Lamp", "--at", "9", status=0)["scan"] == 9
    found = answer("xref", "line.rung", "Lamp", status=0)
    (mention,) = found["mentions"]
    assert mention == {
        "tag": "Lamp",
        "reads": False,
        "writes": True,
        "program": "line",
        "routine": "Main",
        "unit": "rung",
        "number": 0,
        "text": "OTE(Lamp)",
    }


def test_rules() -> None:
    found = answer("rules", "amci3601", status=0)
    assert [row["id"] for row in found["rules"]] == list(RULES)
    (one,) = answer("rules", "amci3601", "--id", "CMD-03", status=0)["rules"]
    assert (one["sets"], one["text"]) == (["COMMAND_ERROR"], RULES["CMD-03"].text)


def test_check() -> None:
    assert set(answer("check", "line.toml", status=1)) == {"findings", "ignored", "not_seen"}


@pytest.mark.slow
def test_fuzz(tmp_path: Path) -> None:
    words = ("fuzz", "fault.toml", "--out", str(tmp_path / "out"), "--runs", "1", "--jobs", "1")
    found = answer(*words, status=1)
    (broken,) = found["broken"]
    assert (broken["scan"], broken["now_ns"]) == (30, 60_000_000)
    assert Path(broken["folder"]).is_dir()
    assert found["runs"] >= 0
