"""Instructions without a model in two programs: equal only where they act alike and find the same."""

from __future__ import annotations

import pytest
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove import ScanBounds
from scanrack.ladder.prove.difference import Difference, compare
from slc_bench import imported

pytestmark = pytest.mark.extra("prove")

TAGS = (
    *("A : REAL[3] := [1.0,2.0,4.0]", 'K : CONTROL := {"LEN": 3}', 'M : CONTROL := {"LEN": 3}', "Q : REAL"),
    *("I : REAL", "Go : BOOL", "Other : BOOL", "Lamp : BOOL", "B : DINT[2]", "C : DINT[2]", "R : DINT[4]"),
    *("P : PID", "Al : ALARM_DIGITAL", "W : STRING", "D : DINT", "Bar : SINT[4]"),
)
ROWS = {
    "AVE": "AVE(A[0],0,Q,K,3,0)",
    "STD": "STD(A[0],0,Q,K,3,0)",
    "PID": "PID(P,I,0,Q,0,0,0)",
    "ALMD": "ALMD(Al,0,0,0,0,?,?)",
    "FBC": "FBC(B[0],C[0],R[0],K,?,?,M,?,?)",
    "DDT": "DDT(B[0],C[0],R[0],K,?,?,M,?,?)",
    "RTOS": "RTOS(Q,W)",
    "TOD": "TOD(D,C[0])",
}


def program(*rungs: str, **initials: str) -> object:
    tags = []
    for each in TAGS:
        name, _, kind = each.partition(" : ")
        kind = f"{kind.partition(' := ')[0]} := {initials[name]}" if name in initials else kind
        tags.append(f"{name} : {kind}")
    lines = ["PROGRAM p", *(f"TAG {each}" for each in tags), "ROUTINE Main", *rungs, "END", ""]
    return parse_program("\n".join(lines))


def compared(old: object, new: object) -> Difference:
    return compare(old, new)  # type: ignore[arg-type]


def names(found: Difference) -> set[str]:
    return {each.name.partition(".")[0].partition("[")[0] for each in found.changed}


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow) if name in ("PID", "RTOS") else name for name in ROWS]
)
def test_an_inverted_condition_is_listed_and_an_edit_elsewhere_is_not(name: str) -> None:
    row, lamp = ROWS[name], "XIC(Other)OTE(Lamp);"
    old = program(f"XIC(Go){row};", lamp)
    assert names(compared(old, program(f"XIO(Go){row};", lamp)))
    assert names(compared(old, program(f"XIC(Go){row};", "XIO(Other)OTE(Lamp);"))) == {"LAMP"}


def test_what_nothing_reads_is_compared_too() -> None:
    old = program(f"XIC(Go){ROWS['AVE']};")
    assert "Q" in names(compared(old, program(f"XIC(Go){ROWS['STD']};")))
    assert "Q" in names(compared(old, program(f"XIC(Go){ROWS['AVE']};", A="[1.0,2.0,5.0]")))
    assert compared(old, program(f"XIC(Go){ROWS['AVE']};", "NOP();")).changed == []


def test_what_one_program_alone_writes_is_compared_with_what_the_other_keeps() -> None:
    found = compared(program("XIC(Go)ADD(D,1,D);"), program("XIC(Go)OTE(Lamp);"))
    assert (found.removed, found.added, names(found)) == (["D"], ["LAMP"], {"D", "LAMP"})


PERIOD = """CONTROLLER p
TAG Go : BOOL
TAG Level : REAL
TAG Smooth : REAL
TAG F : FILTER_LOW_PASS := {"WLag": 1.0}
TASK Main : CONTINUOUS RUNS Inputs
TASK Fast : PERIODIC %d ms PRIORITY 3 RUNS Filtering
PROGRAM Filtering
ROUTINE S ST
F.In := Level;
LPF(F);
Smooth := F.Out;
END
END PROGRAM
PROGRAM Inputs
ROUTINE R
XIC(Go)MOV(5.0,Level);
END
END PROGRAM
"""


def test_the_period_of_a_task_decides_what_its_blocks_do() -> None:
    old, same, new = (parse_program(PERIOD % ms) for ms in (10, 10, 20))
    bounds = ScanBounds(50, 100)
    found = {each.name: each.scans for each in compare(old, new, bounds).changed}
    assert found["SMOOTH"]
    assert "LEVEL" not in found
    assert compare(old, same, bounds).changed == []


def test_a_fault_that_stops_one_program_alone_is_listed_with_what_stands_then() -> None:
    claim = ("OTL(Lamp);", "XIC(Go)ADD(D,1,D);", "{row};", "OTU(Lamp);")
    old, new = (
        program(*[each.replace("{row}", row) for each in claim])
        for row in ("MOV(C[D],B[0])", "MOV(C[0],B[0])")
    )
    found = compared(old, new)
    assert found.fault is not None
    assert found.fault.scans
    assert "LAMP" in names(found)


@pytest.mark.parametrize(
    ("old", "new", "differs"), [("NEG(Q,I);", "MUL(Q,-1.0,I);", False), ("MOV(0.0,I);", "NEG(I,I);", True)]
)
def test_the_sign_of_zero_counts(old: str, new: str, differs: bool) -> None:
    found = compared(program(old, "COP(I,D,1);"), program(new, "COP(I,D,1);"))
    assert ("I" in names(found)) is differs
    assert "D" in names(found)  # the sign of NaN is not known


def test_a_step_of_a_computation_is_a_function_of_its_operands() -> None:
    old = program("SIN(Q,I);", "XIC(Go)MOV(I,A[0]);")
    assert names(compared(old, program("SIN(Q,I);", "XIC(Go)SIN(Q,A[0]);"))) == set()
    assert names(compared(old, program("COS(Q,I);", "XIC(Go)MOV(I,A[0]);"))) >= {"I", "A"}


@pytest.mark.slow
def test_rows_of_an_slc_are_functions_too() -> None:
    data = ["F8:0 2.5 0", "N7:0 3 0"]
    old, new = (
        imported(f"{contact} I:1/0 SIN F8:0 F8:1", "OTU S:5/0", data=data).program
        for contact in ("XIC", "XIO")
    )
    assert "F8" in names(compared(old, new))
    assert compared(old, old).changed == []
