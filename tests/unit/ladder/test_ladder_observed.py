"""Forces, breakpoints and the power of rungs need no interpreted scan."""

import pytest
from scanrack.ladder import LadderFault
from scanrack.ladder.debug import Debugger
from scanrack.ladder.files import parse_program
from scanrack.ladder.interpreter import Interpreter

TEXT = """PROGRAM p
TAG Go : BOOL
TAG Lamp : BOOL
TAG Total : DINT
TAG Table : DINT[4]
TAG At : DINT
ROUTINE Main
XIC(Go)OTE(Lamp);
ADD(Total,1,Total);
MOV(Total,Table[At]);
END
"""


@pytest.fixture
def debugger(monkeypatch):
    """A debugger in whose program no scan can be interpreted after the first."""
    made = Debugger(parse_program(TEXT))
    made.scan()

    def refuse(*_given):
        raise AssertionError("the scan is interpreted")

    monkeypatch.setattr(Interpreter, "scan", refuse)
    return made


def test_a_forced_variable_is_held(debugger):
    debugger.force("Lamp", True)
    debugger.force("Total", 7)
    debugger.scan(3)
    assert (debugger.tags["Lamp"], debugger.tags["Total"], debugger.tags["Table"]) == (True, 7, [7, 0, 0, 0])
    debugger.unforce("Total")
    debugger.scan()
    assert debugger.tags["Total"] == 8


def test_forced_bits_are_held_and_the_others_run(debugger):
    debugger.force("Total.0", 1)
    debugger.force("Total.31", 1)
    debugger.tags["Total"] = 4  # with the forced bits 5 - 2**31; and 1 is 6, of which bit 0 is forced
    debugger.scan()
    assert debugger.tags["Total"] == 7 - (1 << 31)


def test_a_forced_element_of_an_array_is_held(debugger):
    debugger.force("Table[0]", 40)
    debugger.force("Table[3].1", 1)
    for at in (0, 3):
        debugger.tags["At"] = at
        debugger.tags["Total"] = 8
        debugger.scan()
    assert debugger.tags["Table"] == [40, 0, 0, 9 | 2]


def test_a_breakpoint_is_met(debugger):
    debugger.break_at("Main", 0)
    assert not debugger.scan()
    debugger.tags["Go"] = True
    (stop,) = debugger.scan()
    assert "Main, rung 0 is true" in str(stop)


def test_the_power_of_all_rungs_is_noted(debugger):
    assert debugger.truth("Main") == [(False, False), (True,), (True,)]
    debugger.tags["Go"] = True
    debugger.scan()
    assert debugger.truth("Main") == [(True, True), (True,), (True,)]


def test_a_scan_with_a_fault_shows_how_far_it_came():
    debugger = Debugger(parse_program(TEXT))
    debugger.scan()
    debugger.tags["At"] = 9
    with pytest.raises(LadderFault, match="subscript 9"):
        debugger.scan()
    assert debugger.truth("Main") == [(False, False), (True,), ()]
