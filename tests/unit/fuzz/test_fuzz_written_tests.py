"""Tests that a campaign writes: few runs reach all that it reached, and fail once the program loses it."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from scanrack.commands import build
from scanrack.jobs import ContactPress, Kind, Scenario, load_job
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.written_tests import play, write_tests
from scanrack.traces.files.guard import OwnedError
from typer.testing import CliRunner

RUNGS = """PROGRAM Line
TAG Lamp : BOOL
TAG Both : BOOL
ROUTINE Main
XIC(Local:1:I.Data.0)OTE(Lamp);
XIC(Local:1:I.Data.0)XIC(Local:1:I.Data.1)OTE(Both);
END
"""
RACK = """program = "line.rung"
run_for_s = 0.1
[[slot]]
number = 1
module = "1769-IQ16"
options = { inputs = { start = 0, more = 1 } }
"""
START = ContactPress(1, "start", 20_000_000, 20_000_000)
MORE = ContactPress(1, "more", 20_000_000, 20_000_000)
NEVER = """from scanrack import never


@never
def two(now):
    "Never two at once."
    return now.tags["Both"]
"""


@pytest.fixture
def line(tmp_path):
    """A rack with two buttons, as a function that writes the tests of scenarios for it."""
    (tmp_path / "line.rung").write_text(RUNGS, encoding="utf-8")
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "must_hold.py").write_text(NEVER, encoding="utf-8")

    def write(*scenarios, invariants=()):
        bench_of.cache_clear()
        rack = tmp_path / "line.toml"
        files = tuple(tmp_path / each for each in invariants)
        setup = Setup(str(rack), files, (), 50, frozenset({Kind.INPUTS}))
        return write_tests(tmp_path / "reached", setup, load_job(str(rack)), scenarios)

    return write


ALL = Scenario(pushes=(START, MORE))


def test_the_run_that_reaches_most_is_enough(line, tmp_path):
    assert line(Scenario(), Scenario(pushes=(START,)), ALL) == 1
    text = (tmp_path / "reached" / "test_reached.py").read_text(encoding="utf-8")
    assert re.findall(r"'Main: (.+)',", text) == [
        "OTE(Both)",
        "OTE(Lamp)",
        "XIC(Local:1:I.Data.0)",
        "XIC(Local:1:I.Data.1)",
    ]


def test_a_run_that_breaks_something_is_left_out(line, tmp_path):
    assert line(ALL, Scenario(pushes=(START,)), invariants=["must_hold.py"]) == 1
    went = play(tmp_path / "line.toml", tmp_path / "reached" / "scenario-1.json", 50)
    assert went.reached == {"Main: OTE(Lamp)", "Main: XIC(Local:1:I.Data.0)"}


def test_a_folder_with_something_in_it_is_left_alone(line, tmp_path):
    (tmp_path / "reached").mkdir()
    (tmp_path / "reached" / "notes.txt").write_text("mine", encoding="utf-8")
    with pytest.raises(OwnedError, match="is not an empty folder"):
        line(ALL)
    assert [each.name for each in (tmp_path / "reached").iterdir()] == ["notes.txt"]


@pytest.mark.long
@pytest.mark.slow
def test_the_written_tests_pass_and_fail_once_the_program_has_lost_a_rung(line, tmp_path):
    line(Scenario(pushes=(START,)), invariants=["must_hold.py"])
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path / "reached")]
    assert subprocess.run(command, cwd=tmp_path, capture_output=True, check=False).returncode == 0
    lost = RUNGS.replace("XIC(Local:1:I.Data.0)OTE(Lamp);\n", "XIC(Local:1:I.Data.2)OTE(Lamp);\n")
    (tmp_path / "line.rung").write_text(lost, encoding="utf-8")
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=False, encoding="utf-8"
    )
    assert done.returncode == 1
    assert "Main: OTE(Lamp)" in done.stdout


@pytest.mark.slow
def test_the_command_writes_them_and_refuses_a_folder_with_something_in_it_before_the_search(
    line, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    words = ["fuzz", "line.toml", "--runs", "1", "-j", "1", "-q", "--write-tests", "reached"]
    first = CliRunner().invoke(build(), words)
    assert (first.exit_code, "written: pytest reached" in first.stderr) == (0, True)
    again = CliRunner().invoke(build(), words)
    assert again.exit_code == 2
    assert "reached is not an empty folder" in again.stderr
