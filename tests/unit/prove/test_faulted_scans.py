"""The scan of a major fault belongs to the proof: claims are about what stands when the processor stops."""

from __future__ import annotations

import pytest
from scanrack.ladder.files import parse_program
from slc_bench import imported

pytestmark = pytest.mark.extra("prove")

STOPS = """PROGRAM p
TAG A : DINT[4] := [1,1,1,1]
TAG Ix : DINT
TAG Go : BOOL
TAG X : TIMER
TAG L : BOOL
TAG M : BOOL
ROUTINE Main
XIC(Go)ADD(Ix,1,Ix);
OTL(L);
XIC(Go)MOV(-5,X.PRE);
TON(X,1000,0);
OTU(L);
OTL(M);
OTU(M);
END
"""


def test_a_claim_is_about_what_stands_when_the_processor_stops() -> None:
    found = parse_program(STOPS).prove(never="L")
    assert (found.word, found.verdict.k) == ("refuted", 1)
    assert "the processor stops" in str(found)
    assert "PRE is -5" in str(found)
    assert parse_program(STOPS).prove(never="M").word == "proved"  # it is written behind the fault


def test_no_scan_follows_a_major_fault() -> None:
    """L stops the processor in its first scan; M would be set in the next one."""
    rungs = "XIC(L)OTL(M);\nXIC(Go)OTL(L);\nXIC(L)MOV(9,Ix);\nMOV(A[Ix],A[0]);\n"
    text = STOPS[: STOPS.index("XIC(Go)")] + rungs + "END\n"
    assert parse_program(text).prove(never="M").word == "proved"
    assert parse_program(text).prove(reachable="L").word == "reached"
    assert parse_program(text.replace("A[Ix]", "A[1]")).prove(never="M").word == "refuted"


@pytest.mark.parametrize("claim", [{"always": "A[Ix] = 1"}, {"never": "A[Ix] = 2"}], ids=str)
def test_a_condition_whose_subscript_leaves_its_array_is_broken(claim: dict[str, str]) -> None:
    text = STOPS.replace("XIC(Go)MOV(-5,X.PRE);\n", "")
    found = parse_program(text).prove(**claim)
    assert (found.word, found.verdict.k) == ("refuted", 4)
    assert found.end == (
        "the condition can't be computed: A[Ix]: subscript 4 is out of range; must be 0 to 3",
    )
    assert parse_program(text).prove(always="Ix > 3 OR A[Ix] = 1").word == "refuted"  # all parts are computed


def test_what_is_to_be_reached_is_not_where_it_cannot_be_computed() -> None:
    text = STOPS.replace("XIC(Go)MOV(-5,X.PRE);\n", "XIC(Go)MOV(4,Ix);\n")
    assert parse_program(text).prove(reachable="A[Ix] = 2").word != "reached"


def test_a_fault_that_no_run_has_ends_no_scan() -> None:
    text = STOPS.replace("XIC(Go)MOV(-5,X.PRE);\n", "").replace("XIC(Go)ADD(Ix,1,Ix);\n", "")
    assert parse_program(text).prove(never="L").word == "proved"


SLOW = """PROGRAM p
TAG K : CONTROL := {"LEN": 2}
TAG A : DINT[2]
TAG Q : DINT
TAG Go : BOOL
TAG L : BOOL
ROUTINE Main
OTL(L);
XIC(Go)AVE(A[0],0,Q,K,2,0);
OTU(L);
END
"""


def test_an_instruction_without_a_model_may_fault_unless_its_row_says_that_it_does_not() -> None:
    found = parse_program(SLOW).prove(never="L")
    assert found.word == "unknown"
    assert "AVE" in found.verdict.blame[0]
    quiet = SLOW.replace("AVE(A[0],0,Q,K,2,0)", "TOD(Q,A[0])")
    assert parse_program(quiet).prove(never="L").word == "proved"


BYTES = """PROGRAM p
TAG R : REAL := 1.0
TAG D : DINT
TAG Go : BOOL
ROUTINE Main
XIC(Go)NEG(R,R);
COP(R,D,1);
END
"""


def test_what_the_relation_leaves_open_is_no_defect() -> None:
    found = parse_program(BYTES).prove(always="D > 0")
    assert (found.word, found.verdict.blame) == ("unknown", ("Main rung 1: COP(R,D,1), not modeled",))
    clock = imported("XIC S:4/3 OTE B3:0/1", data=["B3:0 0 0"]).program
    found = clock.prove(never="B3:0/1")
    assert (found.word, found.verdict.blame) == ("unknown", ("the processor writes S[4] itself",))
