"""The lines of a Python program that ran in scans of a recording.

Broken on purpose: lines of all files, rows counted from the first traced one, no orders of the session: red.
"""

import json
import sys

import pytest
from scanrack.commands import build
from scanrack.jobs.bench.of_trace import lines_of_trace
from scanrack.runtime.live.actions import Write, message_of
from scanrack.traces import open_trace
from typer.testing import CliRunner

RACK = """
name = "small"
program = "small.py"
scan_ms = 2
watchdog_ms = 0
[[slot]]
number = 1
module = "1769-IQ16"
[[slot]]
number = 2
module = "1762-OW8"
"""
FUNCTION = """\
import beside

count = 0


def logic(scan):
    global count
    count += 1
    if count % 3:
        return
    beside.add(scan)
    scan.slot[2].outputs[0] = 1
"""
BESIDE = """\
def add(scan):
    text = str(scan.number)
    text = text * 2
    text = text * 3
    text = text * 4
"""
BY_FILE = "from pathlib import Path\n" + FUNCTION.replace(
    "count += 1", "count += int(Path('by').read_text())"
).replace("= 1\n", "= count\n")
FIELDS = """\
from scanrack import Logic


class Small(Logic):
    rounds = 0

    def every_scan(self):
        if self.rounds > 3:
            self.rounds -= 1
"""


@pytest.fixture
def lines(tmp_path, monkeypatch):
    """Runs a program for 20 scans, and returns the lines of some of them."""

    def run(program, *scans, latest=()):
        monkeypatch.chdir(tmp_path)
        sys.modules.pop("beside", None)
        (tmp_path / "small.py").write_text(program, encoding="utf-8")
        (tmp_path / "beside.py").write_text(BESIDE, encoding="utf-8")
        (tmp_path / "by").write_text("1", encoding="utf-8")
        (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
        words = ["run", "rack.toml", "--record", "run.mcap", "--scans", "20"]
        assert CliRunner().invoke(build(), words).exit_code == 0
        (tmp_path / "by").write_text("2", encoding="utf-8")
        (tmp_path / "again").mkdir()
        sys.modules.pop("beside", None)  # its lines are observed only if it is loaded again
        with open_trace(tmp_path / "run.mcap") as trace:
            return lines_of_trace(trace, tmp_path / "again", scans, latest=latest)

    return run


def test_each_scan_has_the_lines_of_the_programs_own_file(lines):
    short, whole = (8, 9, 10), (8, 9, 11, 12)
    found = lines(FUNCTION, 10, 13)
    assert found.departs is None
    assert found.lines == {10: short, 11: whole, 12: short, 13: short}


def test_a_program_that_does_otherwise_when_it_runs_again_says_from_which_scan_on(lines):
    """The count in scan 2 is 3, and 6 when it runs again."""
    assert lines(BY_FILE, 0, 5).departs == 2


def test_orders_of_a_session_that_are_not_written_yet_are_given_again(lines):
    write = json.dumps(message_of(Write("small.rounds", 5)))
    found = lines(FIELDS, 3, 8, latest=[(5, write)])
    assert found.lines == {3: (8,), 4: (8,), 5: (8, 9), 6: (8, 9), 7: (8,), 8: (8,)}


def test_scans_that_the_recording_lacks_are_named(lines):
    with pytest.raises(ValueError, match="no scan from 20 to 30"):
        lines(FUNCTION, 20, 30)
