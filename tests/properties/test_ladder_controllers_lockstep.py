"""Random controllers: compiled, interpreted and debugged alike; their text reads back; edits keep values."""

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_lockstep import check_debugged, check_lockstep, check_observed
from scanrack.ladder import Controller, LadderFault
from scanrack.ladder.files import parse_program, program_text
from scanrack.ladder.state.memory import same

TAGS = """CONTROLLER generated
ALLOW repeated coils
TAG A : BOOL
TAG B : BOOL
TAG N : DINT
TAG Delay : TIMER := {"PRE": 25}
TAG Table : DINT[4]
TAG Own : DINT
TAG Index : DINT
"""

OWN = 'TAG A : BOOL\nTAG Own : DINT\nTAG Mine : TIMER := {"PRE": 15}\nALIAS Named : Own\n'
NAMES = ("P", "Q", "R")

rungs = st.sampled_from(
    [
        "XIC(A)OTE(B);",
        "XIO(B)OTE(A);",
        "XIC(S:FS)ADD(N,100,N);",
        "ADD(Own,1,Own);",
        "ADD(Named,Own,N);",
        "XIC(B)TON(Delay,?,?);",
        "TON(Mine,?,?);",
        "XIC(Mine.DN)RES(Mine)ADD(N,1,N);",
        "MOV(Own,Table[Index]);",
        "ADD(Index,1,Index)GRT(Index,4)MOV(0,Index);",
        "MOV(\\P.Own,N);",
        "XIC(\\Q.A)OTE(A);",
        "JSR(Sub,0);",
        "EVENT(Bell);",
        "AFI()MCR();",
        "GRT(N,50)TND();",
        "MUL(N,N,N);",
        "GSV(Task,Fast,OverlapCount,N);",
        "JMP(Past);",
    ]
)
bodies = st.lists(rungs, min_size=1, max_size=6)


@st.composite
def controllers(draw):
    """Text of a controller with three programs, some with tags and a fault routine of their own."""
    parts = [TAGS]
    tasks: dict[str, list[str]] = {"C": [], "Fast": [], "Bell": []}
    for name in NAMES:
        tasks[draw(st.sampled_from(sorted(tasks)))].append(name)
    listed = {name: f" RUNS {', '.join(programs)}" if programs else "" for name, programs in tasks.items()}
    preempt = [draw(st.sampled_from(("", " PREEMPT"))) for _ in range(2)]
    rate = draw(st.sampled_from(("3", "7.5", "10", "25")))
    priority = draw(st.integers(1, 15))
    parts.append(f"TASK C : CONTINUOUS{listed['C']}\n")
    parts.append(f"TASK Fast : PERIODIC {rate} ms PRIORITY {priority}{preempt[0]}{listed['Fast']}\n")
    parts.append(f"TASK Bell : EVENT{preempt[1]}{listed['Bell']}\n")
    for name in NAMES:
        fault = draw(st.booleans())
        parts.append(f"PROGRAM {name}{' FAULT Trouble' if fault else ''}\n")
        own = draw(st.booleans())
        parts.append(OWN if own or name in "PQ" else "TAG Mine : TIMER\nALIAS Named : N\n")
        parts.append("ROUTINE Main\n" + "\n".join(draw(bodies)) + "\nLBL(Past)NOP();\nEND\n")
        parts.append("ROUTINE Sub\nADD(N,7,N);\nXIC(A)OTE(B);\nEND\n")
        if fault:
            clears = draw(st.booleans())
            parts.append("ROUTINE Trouble\nMOV(0,Index);\n")
            parts.append("FLL(0,Table,4)SSV(Program,THIS,MajorFaultRecord,Table);\n" if clears else "")
            parts.append("END\n")
        parts.append("END PROGRAM\n")
    return "".join(parts)


changes = st.dictionaries(st.sampled_from(("A", "B")), st.booleans())
numbers = st.dictionaries(st.sampled_from(("N", "Own", "Index")), st.integers(-2, 60))
scans = st.lists(st.tuples(st.sampled_from((0.7, 4, 10, 33)), changes, numbers), min_size=1, max_size=8)
chosen = settings(
    max_examples=amount(25),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)


@pytest.mark.slow
@chosen
@given(controllers(), scans)
def test_both_back_ends_in_lockstep(text, moments):
    check_lockstep(text, moments)


@pytest.mark.slow
@settings(chosen, max_examples=amount(6))
@given(controllers(), scans, st.data())
def test_controllers_under_forces_and_breakpoints(text, moments, data):
    check_observed(text, moments, lambda choices: data.draw(st.sampled_from(choices)))


@pytest.mark.slow
@chosen
@given(text=controllers(), moments=scans, watched=st.booleans())
def test_a_debugged_controller_does_what_the_compiled_one_does(text, moments, watched):
    check_debugged(text, [(*each, {}) for each in moments], watched=watched)


@pytest.mark.slow
@chosen
@given(controllers())
def test_a_controller_as_text_reads_as_the_same(text):
    controller = parse_program(text)
    again = parse_program(program_text(controller))
    assert program_text(again) == program_text(controller)
    assert again.routines == controller.routines
    assert isinstance(again, Controller)
    assert isinstance(controller, Controller)
    assert again.tasks == controller.tasks


@pytest.mark.slow
@chosen
@given(controllers(), st.integers(1, 5))
def test_an_edit_that_changes_nothing_is_not_noticed(text, count):
    straight, before, after = (parse_program(text) for _ in range(3))
    try:
        for _ in range(count):
            straight.step()
            before.step()
        after.take_over(before)
        straight.step()
        after.step()
    except LadderFault:  # ends both runs, and is compared above
        return
    ours, theirs = after.engine.memory.snapshot(), straight.engine.memory.snapshot()
    assert all(same(ours[path], theirs[path]) for path in theirs)
