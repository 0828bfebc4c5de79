"""ASSERT: a false condition that power reaches is a major fault, type 4 code 990."""

import pytest
from ladder_bench import both
from scanrack.ladder import BuildError, LadderFault, Program
from scanrack.ladder.files import parse_program, parse_structured
from slc_bench import after

TAGS = "TAG Go : BOOL\nTAG N : DINT\nTAG Name : STRING"
ASSERTION = 4, 990  # the first code that 1756-PM014 leaves to users


def fault_of(engine):
    with pytest.raises(LadderFault) as caught:
        engine.step()
    assert (caught.value.type, caught.value.code) == ASSERTION
    return caught.value


@pytest.mark.parametrize("engine", both(TAGS, "XIC(Go)ASSERT(N=1 AND Name<>'off')ADD(N,1,N);"), ids=str)
def test_a_false_assert_on_a_true_rung_is_a_major_fault(engine):
    engine.step()  # not reached
    engine.tags.Go, engine.tags.N = True, 1
    engine.step()
    assert engine.tags.N == 2
    fault = fault_of(engine)
    assert "ASSERT: the condition is false [N = 2, Name = '']" in str(fault)
    assert (fault.site.routine, fault.site.rung) == ("Main", 0)
    assert engine.tags.N == 2  # the scan has ended there


@pytest.mark.parametrize("engine", both(TAGS, "ASSERT(Go);"), ids=str)
def test_a_bit_is_a_condition(engine):
    assert "[Go = 0]" in str(fault_of(engine))
    engine.tags.Go = True
    engine.step()


def test_a_number_is_none():
    program = parse_program(f"PROGRAM one\n{TAGS}\nROUTINE Main\nASSERT(N);\nEND\n")
    with pytest.raises(BuildError, match="compare it, as in count <> 0"):
        program.build()


@pytest.mark.parametrize("back_end", [Program.compile, Program.interpret])
def test_a_line_of_structured_text_is_named(back_end):
    engine = back_end(parse_structured(f"{TAGS}\nIF NOT Go THEN\n  ASSERT(N >= 1);\nEND_IF;\n", "one"))
    fault = fault_of(engine)
    assert (fault.site.unit, fault.site.line) == ("line", 5)
    assert "[N = 0]" in str(fault)
    engine.tags.N = 1
    engine.step()


def test_an_slc_500_has_it_too():
    bench = after("XIC B3/0 ASSERT B3/1", data=["B3:0 0"])
    bench["B3:0"] = 1
    fault = bench.scan()
    assert fault is not None
    assert (fault.type, fault.code) == ASSERTION
