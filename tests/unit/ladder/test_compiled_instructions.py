"""Instructions with state are written as Python, in programs and add-ons; the interpreter runs the rest."""

from typing import Any

import pytest
from ladder_lockstep import differences, outcome
from scanrack.ladder.compiler import source_of
from scanrack.ladder.files import parse_program

TAGS = """TYPE Part (Size : INT, Good : BOOL, Weight : REAL)
TYPE Clock (Year : DINT, Month : DINT, Day : DINT, Rest : DINT[4], More : DINT)
{}
TAG Go : BOOL
TAG I : DINT
TAG Value : REAL
TAG Small : SINT
TAG Wide : LINT := 4294967296
TAG Table : DINT[6] := [3, -1, 2, 70000, 5, 3]
TAG Words : INT[6] := [1, 2, 3, 4, 5, 6]
TAG Grid : DINT[2,3] := [[1, 2, 3], [4, 5, 6]]
TAG Parts : Part[4] := [{{"Size": 7, "Good": true, "Weight": 1.5}}]
TAG One : Part := {{"Size": 3}}
TAG Now : Clock
TAG Control : CONTROL := {{"LEN": 4}}
TAG Controls : CONTROL[2] := [{{"LEN": 2}}, {{"LEN": 3}}]
TAG Loop : PID := {{"UPD": 0.5, "MAXS": 50.0, "KP": 1.5, "KI": 0.25, "KD": 0.1, "SP": 20.0}}
TAG Digital : ALARM_DIGITAL := {{"MinDurationPRE": 20}}
TAG Analog : ALARM_ANALOG := {{"HLimit": 2.0, "HHLimit": 4.0, "Deadband": 1.0, "ROCPeriod": 0.02}}
TAG Text : STRING := "ab"
"""

ADD_ON = """INSTRUCTION Inner
INOUT Row : INT[3]
LOCAL Own : DINT[4] := [4, 3, 2, 1]
LOCAL Control : CONTROL := {"LEN": 3}
LOCAL Analog : ALARM_ANALOG := {"HLimit": 2.0}
LOCAL Loop : PID := {"UPD": 0.5, "MAXS": 50.0, "KP": 1.5, "SP": 20.0}
LOCAL Clock : DINT[7]
OUTPUT Found : DINT
ROUTINE Logic
%s
END
END INSTRUCTION
TAG Inners : Inner[2]
"""

WRITTEN = (
    "XIC(Go)FSC(Control,?,?,ALL,Table[Control.POS]=I);",
    "XIC(Go)FSC(Control,?,?,INC,Table[Control.POS]>I)OTU(Control.IN);",
    "XIC(Go)FAL(Control,?,?,2,Words[Control.POS],Table[Control.POS]*I);",
    "XIC(Go)FAL(Control,?,?,ALL,Table[I],Words[Control.POS]/I);",
    "XIC(Go)FFL(I,Words,Control,?,?);",
    "XIC(Go)FFL(Value,Table[2],Controls[I],?,?)XIO(Go)FFU(Table[2],Small,Controls[I],?,?);",
    "XIC(Go)LFL(One,Parts[1],Control,?,?)XIO(Go)LFU(Parts[1],Parts[0],Control,?,?);",
    "XIC(Go)FFL(Parts[0],Parts[I],Control,?,?)OTU(Control.EU)FFU(Parts[I],One,Control,?,?);",
    "OTU(Control.EN)BSL(Table[1],Control,Go,?);",
    "OTU(Control.EN)MOV(70,Control.LEN)BSR(Table,Control,Go,?);",
    "SIZE(Grid[0,0],1,I);",
    "SQI(Table,3,I,Control,?,?)ADD(Value,1,Value);",
    "XIC(Go)SQI(Table[1],I,Table[I],Controls[I],?,?)[SQI(Table,-1,3,Control,?,?),XIC(Go)]MOV(I,Control.POS);",
    "XIC(Go)SQO(Table,I,Small,Control,?,?);",
    "XIC(Go)SQO(Table[2],65535,Words[I],Controls[I],?,?)OTU(Controls[I].EN);",
    "MOV(70000,Control.LEN)XIC(Go)SQO(Table,-1,Wide,Control,?,?)OTU(Control.EN);",
    "XIC(Go)SQL(Table,Wide,Control,?,?)OTU(Control.EN);",
    "XIC(Go)SQL(Table[I],Small,Controls[1],?,?)MOV(I,Controls[1].POS);",
    "XIC(Go)ALMD(Digital,0,Go,0,0,?,?);",
    "ALMA(Analog,Value,Go,0,0,?,?,?,?);",
    "PID(Loop,Value,I,Small,0,0,0);",
    "PID(Loop,Value,I,Value,0,Go,I);",
    "CONCAT(Text,'x',Text)MID(Text,2,I,Text);",
    "DTOS(I,Text)INSERT(Text,'-',I,Text);",
)

READ = (
    "GSV(WallClockTime,,LocalDateTime,Table);",
    "GSV(WallClockTime,,LocalDateTime,Table[I]);",
    "GSV(WallClockTime,,DateTime,Now);",
    "GSV(WallClockTime,,CurrentValue,Wide);",
    "GSV(WallClockTime,,CurrentValue,Small);",
    "GSV(WallClockTime,,CurrentValue,Words[4]);",
    "GSV(Controller,,ControllerLogUnsavedEntryCount,Wide);",
    "GSV(Controller,,TimeSlice,Table[1]);",
)

INSIDE = (
    "FSC(Control,?,?,ALL,Own[Control.POS]=Row[0])XIC(Control.FD)MOV(Control.POS,Found);",
    "FFL(Found,Row,Control,?,?)OTU(Control.EN)XIC(Control.DN)FFU(Row,Found,Control,?,?);",
    "ALMA(Analog,Row[0],0,0,0,?,?,?,?)XIC(Analog.HInAlarm)MOV(1,Found);",
    "PID(Loop,Row[0],0,Found,0,0,0);",
    "GSV(WallClockTime,,LocalDateTime,Clock)MOV(Clock[6],Found);",
)

LEFT = (
    "AVE(Words,0,Value,Control,?,?);",
    "XIC(Go)AVE(Table,0,Small,Controls[I],?,?);",
    "XIC(Go)STD(Grid[0,I],1,Value,Controls[0],?,?)MOV(3,Controls[0].LEN);",
    "XIC(Go)SRT(Table,0,Control,?,?);",
    "XIC(Go)FBC(Table,Table[1],Words,Control,?,?,Controls[0],?,?);",
    "XIC(Go)DDT(Table,Table[1],Words,Controls[I],?,?,Control,?,?)OTU(Controls[I].EN);",
    "GSV(WallClockTime,,CurrentValue,Value);",
)
"""Those that the interpreter executes on an edge, and a target of a type that `write` leaves to it."""

SCANS = [
    (ms, {"Go": go, "I": i, "Value": value})
    for ms, go, i, value in (
        *(
            (10, True, 1, 3.0),
            (15, True, 1, 3.0),
            (10, False, 1, 5.0),
            (33, True, 3, 5.5),
            (10, False, 0, 1.0),
        ),
        *(
            (10, True, 0, 0.5),
            (10, False, 1, -3.0),
            (20, True, 1, 1e38),
            (10, False, 1, 2.5),
            (10, True, 1, 70.0),
        ),
        (10, True, 7, 0.0),
    )
]


def engines(text):
    program = parse_program(text)
    return program.compile(), program.interpret()


def check(ours, theirs):
    """Do the scans on both; return the number of scans before a major fault, which must be the same."""
    for number, (ms, values) in enumerate(SCANS):
        fault, memory, minor = outcome(ours, ms, values)
        fault_there, memory_there, minor_there = outcome(theirs, ms, values)
        assert (fault, minor, differences(memory, memory_there)) == (fault_there, minor_there, {}), number
        if fault:
            return number
    return len(SCANS)


def text_of(*rungs, before=""):
    return "\n".join(["PROGRAM p", TAGS.format(before), "ROUTINE Main", *rungs, "END", ""])


@pytest.mark.parametrize("rung", [*WRITTEN, *READ])
def test_instructions_are_written_as_python(rung):
    ours, theirs = engines(text_of(rung))
    assert "interpret(" not in source_of(ours.lowered)
    assert check(ours, theirs) >= 3


@pytest.mark.parametrize("rung", INSIDE)
def test_instructions_are_written_in_add_ons(rung):
    ours, theirs = engines(
        text_of("Inner(Inners[0],Words);", "XIC(Go)Inner(Inners[I],Words);", before=ADD_ON % rung)
    )
    assert "interpret(" not in source_of(ours.lowered)
    assert check(ours, theirs) >= 3


@pytest.mark.parametrize("rung", LEFT)
def test_the_rest_is_interpreted(rung):
    ours, theirs = engines(text_of(rung))
    assert "interpret(" in source_of(ours.lowered)
    assert check(ours, theirs) >= 3


ON_AN_EDGE = (
    *("AVE(Table,0,Value,Control,?,?)", "STD(Table,0,Value,Control,?,?)", "SRT(Table,0,Control,?,?)"),
    *("FBC(Table,Table[1],Words,Control,?,?,Controls[0],?,?)", "MSG(Note)"),
)


@pytest.mark.parametrize("instruction", ON_AN_EDGE)
def test_the_interpreter_is_not_asked_while_a_rung_stays_as_it_is(instruction, monkeypatch):
    before = "STUB MSG : done after 0 ms\nTAG Note : MESSAGE"
    ours = parse_program(text_of(f"XIC(Go){instruction};", before=before)).compile()
    asked: list[object] = []
    execute = ours.interpreter.execute

    def noted(*given: Any) -> Any:
        asked.append(given)
        return execute(*given)

    monkeypatch.setattr(ours.interpreter, "execute", noted)
    counts = []
    for go in (False, False, True, True, True, True, False, False):
        ours.tags.Go = go
        ours.step()
        counts.append(len(asked))
    assert counts[1] == 0
    assert counts[2] == 1
    assert counts[4] == counts[5]
    assert counts[6] == counts[7]


def test_a_queue_longer_than_its_array_faults_alike():
    rungs = (
        "MOV(9,Control.LEN);",
        "OTU(Control.EN)FFL(I,Words,Control,?,?);",
        "XIC(Go)FFU(Words,I,Control,?,?);",
    )
    ours, theirs = engines(text_of(*rungs))
    assert check(ours, theirs) == 3  # Go rises in the fourth scan; at power-up a true rung is no edge
    ours, theirs = engines(text_of(*rungs[:2]))
    assert check(ours, theirs) == 6  # the seventh item has no place


POS_BY_TWO_NAMES = """INSTRUCTION Twice
INOUT Own : CONTROL
INOUT Pos : DINT
INPUT Go : BOOL REQUIRED
ROUTINE Logic
XIC(Go)FAL(Own,?,?,ALL,Pos,2147483647);
END
END INSTRUCTION
TAG Called : Twice
"""


def test_fal_that_writes_its_pos_by_another_name_keeps_it_a_dint():
    """The element after 2,147,483,647 is -2,147,483,648, which is below 0 in the next scan."""
    ours, theirs = engines(text_of("Twice(Called,Control,Control.POS,Go);", before=POS_BY_TWO_NAMES))
    assert check(ours, theirs) == 1
    assert ours.tags["Control.POS"] == -(1 << 31)


LREALS = """TAG Double : LREAL
TAG Number : STRING
TAG Held : PID := {"UPD": 1.0, "MAXI": 100.0, "MAXS": 100.0, "MAXCV": 100.0, "MAXTIE": 100.0}
"""


@pytest.mark.parametrize("value", [0.1, 1e39, 16777217.0, 1e-50])
def test_an_lreal_operand_of_a_real_computation_is_rounded(value):
    """RTOS and PID compute with REAL: 0.1 is 0.100000001, 1e39 too large, 1e-50 is 0."""
    rungs = ("RTOS(Double,Number);", "PID(Held,Double,Double,Value,0,1,Double);")
    ours, theirs = engines(text_of(*rungs, before=LREALS))
    for engine in (ours, theirs):
        engine.tags.Double = value
    assert check(ours, theirs) == len(SCANS)
    if value == 0.1:
        assert ours.tags["Number"] == "0.100000001"
