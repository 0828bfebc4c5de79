"""Motion in an L5X: read, noted by the command, stubbed, and bound to a 3601 of the rack."""

import json
import sys

import l5x_files as files
import pytest
from scanrack.commands import build
from typer.testing import CliRunner

TAGS = (
    files.tag("Go", "BOOL"),
    files.tag("Feed", "AXIS_CIP_DRIVE"),
    files.tag("Do", "MOTION_INSTRUCTION"),
    files.tag("Both", "COORDINATE_SYSTEM"),
)
RACK = """program = "machine.L5X"
[axes.Feed]
slot = 1
[[slot]]
number = 1
module = "amci3601"
"""


@pytest.fixture
def machine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    (tmp_path / "machine.toml").write_text(RACK, encoding="utf-8")

    def make(*rungs):
        (tmp_path / "machine.L5X").write_text(files.machine(*rungs, tags=TAGS), encoding="utf-8")

    return make


def command(*arguments):
    result = CliRunner().invoke(build(), list(arguments))
    return result.exit_code, result.output


def test_the_command_notes_axes_that_need_a_rack(machine):
    machine("XIC(Go)MSO(Feed,Do);", "XIC(Go)MAS(Feed,Do,Jog,Yes,5,0,No,0,0);", "XIC(Go)MCSR(Both,Do);")
    status, output = command("l5x", "machine.L5X", "--json")
    report = json.loads(output)
    assert (status, report["imported"], report["ran"]) == (0, 3, 3)
    notes = {each["name"]: each["text"] for each in report["notes"]}
    assert notes["Feed"].startswith("MSO, MAS end with ER, ERR 11")
    assert notes["Both"].startswith("MCSR end with ER")


def test_a_rack_binds_an_axis(machine):
    machine("XIC(Go)MSO(Feed,Do);")
    status, output = command("run", "machine.toml", "--scans", "5", "--no-record")
    assert (status, "is not an axis of the rack" in output) == (0, False)


def test_a_rerun_binds_the_axis_too(machine):
    machine("MSO(Feed,Do);")
    assert command("run", "machine.toml", "--scans", "5", "--record", "m.mcap", "-q")[0] == 0
    status, output = command("rerun", "m.mcap")
    assert (status, "is no axis of the rack" in output) == (0, False)


def test_what_a_3601_cannot_do_is_refused_by_name(machine):
    machine("XIC(Go)MAHD(Feed,Do,Motor,Forward);")
    status, output = command("run", "machine.toml", "--scans", "5", "--no-record")
    assert status == 2
    assert "Feed is a 3601, which can't do MAHD" in output
