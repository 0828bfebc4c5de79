"""Motion in an L5X: read, noted by the command, stubbed, and bound to a 3601 of the rack."""

import json
import sys

import l5x_files as files
import pytest
from scanrack.commands import build
from scanrack.rockwell.l5x import import_l5x
from typer.testing import CliRunner

TAGS = (
    files.tag("Go", "BOOL"),
    files.tag("Feed", "AXIS_CIP_DRIVE"),
    files.tag("Do", "MOTION_INSTRUCTION"),
    files.tag("Both", "COORDINATE_SYSTEM"),
)
AXIS = """<Tag Name="Turn" TagType="Base" DataType="AXIS_VIRTUAL"><Data Format="Axis"><AxisParameters
ConversionConstant="100.0" RotaryAxis="Rotary" PositionUnwind="36000" HomeMode="Active" MaximumSpeed="50.0"/>
</Data></Tag>"""
SYSTEM = """<Tag Name="Both" TagType="Base" DataType="COORDINATE_SYSTEM"><Data Format="CoordinateSystem">
<CoordinateSystemParameters Dimension="2" Axes="Turn Feed"/></Data></Tag>"""
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


def test_the_command_notes_ideal_axes(machine):
    machine("XIC(Go)MSO(Feed,Do);", "XIC(Go)MAS(Feed,Do,Jog,Yes,5,0,No,0,0);", "XIC(Go)MCSR(Both,Do);")
    status, output = command("l5x", "machine.L5X", "--json")
    report = json.loads(output)
    assert (status, report["imported"], report["ran"]) == (0, 3, 3)
    notes = {each["name"]: each["text"] for each in report["notes"]}
    assert notes["Feed"] == "MSO, MAS move an ideal axis, unless [axes] binds it to a 3601"
    assert notes["Both"].startswith("MCSR move an ideal axis")


def test_a_rack_binds_an_axis(machine):
    machine("XIC(Go)MSO(Feed,Do);")
    status, output = command("run", "machine.toml", "--scans", "5", "--no-record")
    assert (status, "is not an axis of the rack" in output) == (0, False)


def test_a_rerun_binds_the_axis_too(machine):
    machine("MSO(Feed,Do);")
    assert command("run", "machine.toml", "--scans", "5", "--record", "m.mcap", "-q")[0] == 0
    status, output = command("replay", "--into", "session", "m.mcap")
    assert (status, "is no axis of the rack" in output) == (0, False)


def test_what_a_3601_cannot_do_is_refused_by_name(machine):
    machine("XIC(Go)MAHD(Feed,Do,Motor,Forward);")
    status, output = command("run", "machine.toml", "--scans", "5", "--no-record")
    assert status == 2
    assert "Feed is a 3601, which can't do MAHD" in output


@pytest.mark.slow
def test_axes_of_an_export_bring_their_maxima_their_unwind_and_their_system(machine, tmp_path):
    """50 % of 50 units/s; 36,000 counts of 100 a unit are a turn; the system moves its second axis, too."""
    controls = (files.tag(name, "MOTION_INSTRUCTION") for name in ("Do", "More", "Halt"))
    own = (files.tag("Go", "BOOL"), files.tag("Feed", "AXIS_VIRTUAL"), files.tag("P", "REAL", "2"))
    tags = (*own, *controls, AXIS, SYSTEM)
    rate = "% of Maximum,100,% of Maximum,100,% of Maximum,Trapezoidal,100,100,% of Time,Disabled,Programmed"
    jog = f"MAJ(Turn,Do,Forward,50,{rate},0,None);"
    line = "MCLM(Both,More,0,P[0],10,0,10,0,10,0,0,0,0,0,0,0,0,0,0,None,0,0);"
    rungs = (f"XIO(Go){jog}", "XIC(Go)MAS(Turn,Halt,All,No,0,0,No,0,0);", f"XIC(Go){line}")
    text = files.machine(*rungs, tags=tags)
    (tmp_path / "axes.L5X").write_text(text, encoding="utf-8")
    controller = import_l5x(tmp_path / "axes.L5X").controller
    assert controller is not None
    engine = controller.engine
    for _ in range(200):
        engine.step(100)
    assert engine.tags["Turn.ActualVelocity"] == 25.0
    assert 0 <= engine.tags["Turn.ActualPosition"] < 360
    engine.tags["P"] = [0.0, 10.0]
    engine.tags.Go = True
    for _ in range(600):
        engine.step(100)
    assert (engine.tags["Feed.ActualPosition"], engine.tags["More.PC"]) == (10.0, True)


def test_gsv_reads_the_tolerance_that_an_export_gives_a_coordinate_system(tmp_path):
    system = SYSTEM.replace('Dimension="2"', 'Dimension="2" CommandPositionTolerance="0.125"')
    text = files.machine(
        "GSV(CoordinateSystem,Both,CommandPositionTolerance,Got);",
        tags=(files.tag("Got", "REAL"), files.tag("Turn", "AXIS_VIRTUAL"), TAGS[1], system),
    )
    (tmp_path / "axes.L5X").write_text(text, encoding="utf-8")
    controller = import_l5x(tmp_path / "axes.L5X").controller
    assert controller is not None
    controller.engine.step(100)
    assert controller.engine.tags.Got == 0.125
