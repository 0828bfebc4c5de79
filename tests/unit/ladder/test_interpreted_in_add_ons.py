"""Instructions that the interpreter executes for the compiled program work inside of add-on instructions."""

import pytest
from scanrack.ladder.files import parse_program
from scanrack.ladder.state.memory import same

TEXT = r"""PROGRAM line
INSTRUCTION Track
INPUT Part : DINT REQUIRED
INOUT Note : STRING
INOUT Parts : DINT[1]
LOCAL Queue : DINT[4]
LOCAL Level : CONTROL
LOCAL Every : CONTROL
LOCAL Text : STRING
LOCAL Warn : ALARM_DIGITAL
LOCAL Size : DINT
OUTPUT Mean : REAL
ROUTINE Logic
OTU(Level.EN)FFL(Part,Queue,Level,4,0);
AVE(Queue,0,Mean,Every,4,0);
DTOS(Part,Text)CONCAT(Note,Text,Note);
SIZE(Parts,0,Size);
MOV(Size,Parts[0]);
GRT(Part,2)ALMD(Warn,0,0,0,0,?,?);
END
END INSTRUCTION
TAG Tracks : Track[2]
TAG Notes : STRING[2] := ["a", "b"]
TAG Short : DINT[3]
TAG Long : DINT[5]
TAG Part : DINT
ROUTINE Main
ADD(Part,1,Part);
Track(Tracks[0],Part,Notes[0],Short);
EQU(Part,2)Track(Tracks[1],Part,Notes[1],Long);
END
"""


@pytest.mark.parametrize("kind", ["compile", "interpret"])
def test_locals_and_inouts_are_those_of_the_call(kind):
    engine = getattr(parse_program(TEXT), kind)()
    for _ in range(3):
        engine.step()
    tags = engine.tags
    assert [tags["Notes[0]"], tags["Notes[1]"]] == ["a123", "b2"]
    assert [tags["Short[0]"], tags["Long[0]"]] == [3, 5]
    assert [tags[f"Tracks[0].Queue[{each}]"] for each in range(4)] == [1, 2, 3, 0]
    assert [tags["Tracks[0].Level.POS"], tags["Tracks[1].Level.POS"]] == [3, 1]
    assert tags["Tracks[0].Mean"] == 0.25  # of the first scan: the rung has stayed true
    assert [tags["Tracks[0].Warn.InAlarm"], tags["Tracks[1].Warn.InAlarm"]] == [True, False]


def test_both_back_ends_agree():
    engines = parse_program(TEXT).compile(), parse_program(TEXT).interpret()
    for _ in range(4):
        for engine in engines:
            engine.step()
        ours, theirs = (engine.memory.snapshot() for engine in engines)
        assert [path for path in ours if not same(ours[path], theirs[path])] == []
