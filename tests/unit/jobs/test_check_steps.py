"""`scanrack check` of programs that go from step to step: what a command finds when it is reached."""

import pytest
from check_programs import SOUND, check

FEEDER, PACKER = SOUND["feeder.rung"], SOUND["packer.py"]
WAITS = "EQU(State,30)XIC(feed.status.MOVE_COMPLETE)MOV(10,State);"
ZEROES = "    rung(step == 4, status.MOVING_CW, CLR(words[0]), MOV(5, step))\n"

PLANTED = {
    "no wait for the end": ("feeder.rung", FEEDER, WAITS, "EQU(State,30)MOV(10,State);", "move-interrupted"),
    "a wait for its begin": (
        "feeder.rung",
        FEEDER,
        WAITS,
        "EQU(State,30)XIC(feed.status.MOVING_CW)MOV(10,State);",
        "move-interrupted",
    ),
    "a coil that is always on": (
        "feeder.rung",
        FEEDER.replace("TAG Faulted", "TAG Always : BOOL\nTAG Faulted"),
        WAITS,
        "OTE(Always);\nEQU(State,30)XIC(Always)MOV(10,State);",
        "move-interrupted",
    ),
    "a bit that stays": (
        "packer.py",
        PACKER,
        ZEROES,
        ZEROES.replace("CLR(words[0]), ", ""),
        "command-held",
    ),
}
"""What is replaced in a sound program by what, and the rule that finds it."""


@pytest.mark.parametrize("name", PLANTED)
def test_a_command_that_comes_too_soon_is_found(name, tmp_path):
    file, text, old, new, rule = PLANTED[name]
    assert old in text
    assert [each.rule for each in check(tmp_path, file, text.replace(old, new)).findings] == [rule]


@pytest.mark.parametrize(("name", "text"), [("feeder.rung", FEEDER), ("packer.py", PACKER)])
def test_steps_that_wait_have_no_findings(name, text, tmp_path):
    assert check(tmp_path, name, text).findings == ()


@pytest.mark.parametrize(
    "wait",
    [
        "EQU(State,30)XIO(feed.status.MOVING_CW)XIO(feed.status.MOVING_CCW)MOV(10,State);",
        "EQU(State,30)GEQ(feed.I.Data[2],5)MOV(10,State);",
        "EQU(State,30)TON(Pause,900,0);\nXIC(Pause.DN)MOV(10,State);",
        "EQU(State,30)XIC(feed.status.MOVE_COMPLETE)OTE(There);\nXIC(There)EQU(State,30)MOV(10,State);",
    ],
    ids=["still", "position", "time", "coil"],
)
def test_other_waits_count_too(wait, tmp_path):
    text = FEEDER.replace(WAITS, wait)
    for name, kind in (("Pause", "TIMER"), ("There", "BOOL")):
        if name in wait:
            text = text.replace("TAG Faulted", f"TAG {name} : {kind}\nTAG Faulted")
    assert check(tmp_path, "feeder.rung", text).findings == ()


ELEMENT = """\
def logic(scan):
    outputs = scan.slot[1].outputs
    if outputs[0] == 1:
        outputs[0] = 4
"""
BEYOND = """\
def logic(scan):
    for number in (8, -1):
        scan.slot[1].outputs.set_bit(number, 0, True)
    scan.slot[1].outputs.set_bit(0, -1, True)
"""
OPPOSITE = """\
PROGRAM line
TAG Go : INT[8] := [1, 0, 4, 0, 5, -3, 10, 10]
ROUTINE Main
XIC(Local:2:I.Data.0)COP(Go,Local:1:O.Data[0],8);
END
"""


@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("element.py", ELEMENT, None),
        ("beyond.py", BEYOND, "no-place"),
        ("opposite.rung", OPPOSITE, "out-of-range"),
    ],
    ids=["steps in an element", "no such word or bit", "a speed of opposite signs"],
)
def test_a_check_survives_unusual_words(name, text, rule, tmp_path):
    found = {each.rule for each in check(tmp_path, name, text).findings}
    assert (rule in found) is bool(rule)


def test_two_words_that_are_no_number_are_shown(tmp_path):
    texts = [each.text for each in check(tmp_path, "opposite.rung", OPPOSITE).findings]
    assert "the move's speed is (5, -3): must be 1 to 1000000" in texts
