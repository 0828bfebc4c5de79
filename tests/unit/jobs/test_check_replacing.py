"""`scanrack check RACK --for DRIVE`: the uses of a 3601's words that mean something else there."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

RACK = 'program = "{}"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
RUNGS = """PROGRAM line
SLOT axis : 1
TAG Error : BOOL
TAG Done : BOOL
TAG Go : BOOL
ALIAS Ready : Local:1:I.Data[0].3
ROUTINE Main
XIC(axis.status.COMMAND_ERROR)OTE(Error);
XIC(Error)MOV(2048,axis.O.Data[0]);
XIC(Ready)XIC(axis.status.MOVE_COMPLETE)OTE(Done);
XIC(Go)OTE(axis.command.ABSOLUTE_MOVE);
XIC(Local:1:I.Data[1].4)OTL(Done);
END
"""
TEXT = """PROGRAM line
SLOT axis : 1
TAG Done : BOOL
ROUTINE Main ST
Done := axis.status.INVALID_PROFILE OR axis.status.MOVING_CW;
axis.O.Data[1] := 1;
END
"""
FUNCTION = """from scanrack.io_images.amci3601 import StatusMsw
def logic(scan):
    inputs, outputs = scan.slot[1].inputs, scan.slot[1].outputs
    if inputs.bit(0, 9) or inputs[0] & StatusMsw.STOPPED:
        outputs.set_bit(0, 11, True)
    if inputs.bit(0, 7):
        outputs[0] = 0
"""


def listed(folder: Path, name: str, program: str, drive: str) -> list[tuple[int, str]]:
    """Return line and row of each finding."""
    (folder / name).write_text(program, encoding="utf-8")
    (folder / "rack.toml").write_text(RACK.format(name), encoding="utf-8")
    done = CliRunner().invoke(build(), ["check", str(folder / "rack.toml"), "--for", drive])
    lines = [line for line in done.stdout.splitlines() if "drive-differs" in line]
    assert done.exit_code == (1 if lines else 0), done.output
    return [
        (int(line.split(":")[line.split(":").index(" drive-differs") - 1]), line[line.rindex("[") + 1 :][:4])
        for line in lines
    ]


def test_rungs(tmp_path):
    assert listed(tmp_path, "line.rung", RUNGS, "smd23e2") == [
        (8, "D-24"), (9, "D-02"), (10, "D-20"), (11, "D-01"), (12, "D-33"),
    ]  # fmt: skip


def test_rungs_on_a_drive_with_a_3601_s_command_word(tmp_path):
    assert listed(tmp_path, "line.rung", RUNGS, "anf2") == [(10, "D-20"), (12, "D-41")]


def test_structured_text(tmp_path):
    assert listed(tmp_path, "line.rung", TEXT, "smd23e2") == [(5, "D-22"), (6, "D-10")]


def test_a_function_of_the_scan(tmp_path):
    assert listed(tmp_path, "line.py", FUNCTION, "smd23e2") == [(4, "D-20"), (4, "D-22"), (5, "D-02")]


def test_a_program_of_blocks_is_told_its_configuration_and_its_own_bits():
    feeder = Path(__file__).parents[3] / "examples" / "feeder" / "feeder.toml"
    done = CliRunner().invoke(build(), ["check", str(feeder), "--for", "smd23e2"])
    uses = [line.partition(": drive-differs: ")[2].partition(":")[0] for line in done.stdout.splitlines()]
    assert uses[:2] == ["configuration", "card.status.IN_ESTOP"]
    assert "2 findings" in done.stdout


@pytest.mark.parametrize("drive", ["smd23", "amci3601", ""])
def test_an_unknown_drive_is_refused(drive):
    done = CliRunner().invoke(build(), ["check", "rack.toml", "--for", drive])
    assert done.exit_code == 2
    assert "smd23e2, smd24e2, sd17060e2, ang1, anf2" in done.stderr
