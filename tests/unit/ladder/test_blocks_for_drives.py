"""The motion blocks in a rack with a networked drive: the feeder with another rack, mixed racks, refusals."""

from pathlib import Path

import pytest
from drive_bench import MODELS
from scanrack import open_bench
from scanrack.io_images.amci3601.words import WORDS_3601
from scanrack.jobs.check import check_rack, check_replacement, load_any
from scanrack.ladder import LadderError
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.files.rungreader import is_of_library, load_library
from scanrack.ladder.model.stubs import Stubs

FEEDER = Path(__file__).parents[3] / "examples" / "feeder"
SMD23E2 = MODELS["smd23e2"]
DRIVES = Stubs(modules={1: WORDS_3601, 2: SMD23E2.words})

CONFIGURATION = "TAG Words : INT[8] := [16#843C, 16#003C, 0, 500, 0, 0, 0, 0]"
OWN_CONFIGURATION = "TAG Words : INT[10] := [16#8037, 16#0003, 0, 500, 2000, 0, 0, 50, 28, 0]"
"""Home and emergency stop at inputs 1 and 2, active when on; starting speed 500."""

ONE_AXIS = """PROGRAM p
USE axis3601
TAG Axis : AXIS_3601
TAG Module : Amci3601
ROUTINE Main
Amci3601(Module,Axis,Local:{0}:I.Data[0],Local:{0}:O.Data[0]);
END
"""


@pytest.fixture
def feeder(tmp_path):
    """The feeder with the two lines changed that `check --for smd23e2` names, and a drive in its rack."""
    program = (FEEDER / "feeder.rung").read_text(encoding="utf-8")
    rack = (FEEDER / "feeder.toml").read_text(encoding="utf-8")
    for before, after in (
        (CONFIGURATION, OWN_CONFIGURATION),
        ("card.status.IN_ESTOP", "card.status.INPUT_2"),
    ):
        assert program.count(before) == 1
        program = program.replace(before, after)
    module = 'module = "amci3601"\nfirmware = "4.1"'
    assert module in rack
    rack = rack.replace(module, 'module = "smd23e2"\noptions = { in1 = "home", in2 = "estop" }')
    (tmp_path / "feeder.rung").write_text(program, encoding="utf-8")
    (tmp_path / "feeder.toml").write_text(rack, encoding="utf-8")
    with open_bench(tmp_path / "feeder.toml") as bench:
        yield bench


def test_check_for_the_drive_names_both_lines():
    """The call whose words are the configuration, and the rung with the input."""
    report = check_replacement(load_any(str(FEEDER / "feeder.toml"))[0], SMD23E2)
    lines = (FEEDER / "feeder.rung").read_text(encoding="utf-8").splitlines()
    named = [lines[each.place.line - 1] for each in report.findings]
    assert named == [
        "Configure3601(Configure,Axis,Words,Awake);",
        "XIC(Trouble)XIO(card.status.IN_ESTOP)TON(Quiet,1000,0);",
    ]


@pytest.mark.slow
def test_the_feeder_runs_on_a_drive_with_two_lines_changed(feeder):
    """The story of `examples/feeder/test_feeder.py`, on the drive."""
    feeder.run_until("Feeding", within="5 s")
    assert (feeder.slot[1].shaft, feeder["Axis.Position"]) == (-1300, 0)
    feeder.run_until("Out.Done", within="3 s")
    assert feeder["Axis.Position"] == 6000
    feeder.run_until("Back.Done", within="3 s")
    assert (feeder["Axis.Position"], feeder["Strokes.ACC"]) == (0, 1)
    feeder.run_until("Trouble", within="10 s")  # the rack file presses the button at 8 s
    assert "INP-01" in feeder.rules
    shaft = feeder.slot[1].shaft
    feeder.run_for("400 ms")  # of the 500 ms that the button is in
    assert feeder.slot[1].shaft == shaft
    feeder.run_until(lambda bench: not bench["Trouble"], within="5 s")
    feeder.run_until("Feeding", within="6 s")
    assert feeder["Axis.Position"] == 0


def test_a_rack_without_a_drive_has_the_blocks_as_they_are():
    program = parse_program(ONE_AXIS.format(1), stubs=Stubs(modules={1: WORDS_3601}))
    assert program.add_ons["AMCI3601"] is load_library("axis3601").add_ons["AMCI3601"]


def test_the_blocks_know_what_is_in_their_slot():
    """In a rack with both, `Model` of the 3601 is 0, and that of the drive 1."""
    models = [parse_program(ONE_AXIS.format(slot), stubs=DRIVES).tags["Module.Model"] for slot in (1, 2)]
    assert models == [0, 1]


def test_a_program_that_is_written_uses_the_library():
    program = parse_program(ONE_AXIS.format(2), stubs=DRIVES)
    text = program_text(program)
    assert "USE axis3601" in text
    assert "INSTRUCTION" not in text
    assert all(is_of_library(each, "axis3601") for each in program.add_ons.values())


def test_blocks_without_drives_are_refused_on_a_drive():
    program = parse_program(ONE_AXIS.format(2))
    program.take_stubs(DRIVES)
    with pytest.raises(LadderError, match="the module is a networked drive, but these blocks are for"):
        program.build()


@pytest.mark.parametrize(
    ("line", "instead", "found"),
    [
        ("2000, 0, 0, 50", "20, 0, 0, 50", "the configuration is invalid: The motor steps per turn"),
        (
            OWN_CONFIGURATION,
            CONFIGURATION,
            "the configuration of an SMD23E2 has 10 words: the array is shorter",
        ),
        (
            "MC_Reset(Reset,Axis,Quiet.DN);",
            "MC_Reset(Reset,Axis,Quiet.DN);\nMC_GearIn(Gear,Axis,Awake,1,1,10,10);",
            "MC_GEARIN: an SMD23E2 has no such command: the block ends with ErrorID 4096",
        ),
    ],
)
def test_check_knows_the_drive(feeder, tmp_path, line, instead, found):
    path = tmp_path / "feeder.rung"
    text = path.read_text(encoding="utf-8").replace(line, instead)
    path.write_text(text.replace("TAG Trouble", "TAG Gear : MC_GearIn\nTAG Trouble"), encoding="utf-8")
    report = check_rack(load_any(str(tmp_path / "feeder.toml"))[0])
    assert any(found in each.text for each in report.findings), report.findings
