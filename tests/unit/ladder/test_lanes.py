"""The search for the last change in many stretches at once finds what the search scan by scan finds."""

from contextlib import suppress
from itertools import pairwise

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_programs import programs
from scanrack.ladder import LadderFault
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.cells import Cell
from scanrack.ladder.debug.lanes.search import Lanes
from scanrack.ladder.files import parse_program, parse_structured

TAGS = """PROGRAM p
INSTRUCTION Latch
INPUT On : BOOL REQUIRED
INPUT Off : BOOL REQUIRED
OUTPUT Held : BOOL
INOUT Sum : DINT
LOCAL Wait : TIMER
ROUTINE Logic
[XIC(On),XIC(Held)]XIO(Off)OTE(Held);
XIC(Held)TON(Wait,40,0);
XIC(Wait.DN)ADD(Sum,1,Sum);
END
END INSTRUCTION
SLOT card : 1
TAG A : BOOL
TAG B : BOOL
TAG Seen : BOOL
TAG N : DINT
TAG M : DINT
TAG W : INT
TAG X : REAL
TAG T : TIMER
TAG C : COUNTER
TAG Row : DINT[4]
TAG Other : DINT[4]
TAG L : Latch
ALIAS In : card.I.Data[0]
ROUTINE Main
XIC(In.0)OTE(A);
XIC(In.1)OTE(B);
"""
ROWS = {
    "contacts and coils": "XIC(A)XIO(B)OTE(Seen);",
    "latches": "XIC(A)OTL(Seen);XIC(B)OTU(Seen);",
    "a one-shot counts": "XIC(A)ONS(Seen)ADD(N,1,N);",
    "a timer that ends": "XIC(A)TON(T,50,0);XIC(T.DN)ADD(N,1,N);",
    "a timer off-delayed": "XIC(A)TOF(T,30,0);XIC(T.DN)OTE(Seen);",
    "a retentive timer": "XIC(A)RTO(T,70,0);XIC(B)RES(T);",
    "a counter": "XIC(A)CTU(C,3,0);XIC(C.DN)RES(C);",
    "arithmetic": "XIC(A)CPT(N,N*3-M/2);MOD(N,7,M);",
    "an overflow is left to the slow way": "XIC(A)ADD(N,100000000,N);",
    "bits of words": "XIC(A)OTE(W.3);XIC(B)OTE(W.15);AND(W,255,M);",
    "a division by zero": "XIC(A)SUB(3,M,M);DIV(100,M,N);",
    "REAL": "XIC(A)CPT(X,X*1.5+0.25);GRT(X,20.0)CLR(X);",
    "copies": "MOV(In,Row[1]);XIC(A)COP(Row[0],Other[0],4);XIC(B)FLL(7,Row[2],2);",
    "a computed subscript": "AND(In,3,N);MOV(In,Row[N]);",
    "an add-on instruction": "Latch(L,A,B,N);",
    "routines": "XIC(A)JSR(Sub);\nEND\nROUTINE Sub\nADD(N,1,N);XIC(B)OTE(Seen);",
    "limits": "LIM(1,In,2)OTE(Seen);LIM(2,In,1)OTE(W.0);",
    "MCR": "XIC(A)MCR();XIC(B)OTE(Seen);MCR();",
    "a jump": "XIC(A)JMP(on);ADD(N,1,N);LBL(on)XIC(B)OTE(Seen);",
}
STATEMENTS = {
    "IF": "IF A AND NOT B THEN N := N + 1; ELSIF B THEN M := N; ELSE N := 0; END_IF;",
    "CASE": "CASE N OF 0: N := 1; 1,2: N := N + 1; ELSE N := 0; END_CASE;",
    "FOR": "FOR M := 0 TO 3 DO Row[M] := Row[M] + M; END_FOR; IF A THEN N := Row[3]; END_IF;",
    "WHILE": "WHILE N > 3 DO N := N - 2; END_WHILE; IF A THEN N := N + 9; END_IF;",
}
LEFT = ("a division by zero", "a jump")
"""What is left to the slow way."""
STILL = ("IF", "WHILE")
"""Their values never change."""
LENGTH = 8


def program_of(name):
    if name in ROWS:
        return parse_program(TAGS + ROWS[name].replace(";", ";\n") + "\nEND\n")
    tags = "\n".join(
        each for each in TAGS.splitlines() if each.startswith("TAG") and not each.endswith("Latch")
    )
    return parse_structured(f"{tags}\n\nA := N.0; {STATEMENTS[name]}\n", "p")


def stretches_of(debugger, inputs):
    """Do a scan for each input; return stretches, the latest first, and how to run their scans one by one."""
    past = debugger._past
    images = [leaf for leaf in debugger.engine.memory.layout.images if not leaf.output]
    for value in inputs:
        for leaf in images:
            debugger.engine.memory.cells[leaf.ident].cell_contents[0] = value
        debugger.scan()
    starts = list(past.source.snapshots(debugger.scans - 1))
    return past, [past._stretch(start, end) for end, start in pairwise(starts)]


def check(name, inputs):
    return checked(*stretches_of(Debugger(program_of(name)), inputs))


def checked(past, stretches):
    """Compare both ways for the last element of every leaf; return how often the quick one knew."""
    lanes = Lanes(past.engine.lowered, past.engine.memory, past.images)
    known = 0
    for leaf in past.engine.lowered.layout.leaves.values():
        if leaf.is_image or leaf.slot is not None or not past.engine.memory.has(leaf):
            continue
        cell = Cell(leaf, leaf.size - 1)
        for stretch, found in zip(stretches, lanes.last_changes([cell], stretches), strict=True):
            if found.known:
                known += 1
                slow = past._change_in(
                    stretch.first,
                    stretch.last,
                    lambda engine, cell=cell: engine.memory.read(cell.leaf, cell.index),
                )
                assert (leaf.path, found.scan) == (leaf.path, slow)
    return known


@pytest.fixture(autouse=True)
def short_chapters(monkeypatch):
    monkeypatch.setattr("scanrack.ladder.debug.journal.EVERY", LENGTH)


INPUTS = [(7 * at * at + at // 5) % 4 for at in range(60)]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ROWS, *STATEMENTS])
def test_it_finds_what_the_slow_way_finds(name):
    known = check(name, INPUTS)
    assert (known > 0) == (name not in LEFT), "it has searched nothing"


@pytest.mark.slow
@pytest.mark.parametrize("name", [*ROWS, *STATEMENTS])
def test_a_search_finds_what_the_search_scan_by_scan_finds(name, monkeypatch):
    for limit, value in (("ONE_BY_ONE", 1), ("FIRST_ONE_BY_ONE", 1), ("SIDE_BY_SIDE", 3)):
        monkeypatch.setattr(f"scanrack.ladder.debug.replay.{limit}", value)
    past, _ = stretches_of(Debugger(program_of(name)), INPUTS)
    memory, found = past.engine.memory, 0
    for leaf in past.engine.lowered.layout.leaves.values():
        cell = Cell(leaf, leaf.size - 1)
        for end in (len(INPUTS) - 1, 3 * LENGTH + 2) if memory.has(leaf) else ():
            slow = past.last_change(lambda engine, cell=cell: engine.memory.read(cell.leaf, cell.index), end)
            assert (leaf.path, past.last_change_of([cell], end)) == (leaf.path, slow)
            found += slow is not None
    assert (found > 0) == (name not in STILL), "no value changes"


@pytest.mark.slow
@settings(max_examples=amount(8), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.sampled_from([*ROWS, *STATEMENTS]), st.lists(st.integers(-40, 40), min_size=3 * LENGTH, max_size=80)
)
def test_whatever_the_inputs(name, inputs):
    check(name, inputs)


@pytest.mark.slow
@settings(
    max_examples=amount(3),
    deadline=None,
    suppress_health_check=[
        HealthCheck.function_scoped_fixture,
        HealthCheck.too_slow,
        HealthCheck.data_too_large,
    ],
)
@given(programs(), st.dictionaries(st.sampled_from(("A", "B", "C")), st.booleans()))
def test_random_programs(text, values):
    debugger = Debugger(parse_program(text))
    for name, value in values.items():
        debugger.tags[name] = value
    with suppress(LadderFault):
        debugger.scan(4 * LENGTH)
    starts = list(debugger._past.source.snapshots(debugger.scans - 1))
    checked(debugger._past, [debugger._past._stretch(start, end) for end, start in pairwise(starts)])
