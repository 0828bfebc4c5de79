"""What the relation does not follow is unknown wherever it acts: nothing false is proved around it."""

from __future__ import annotations

from random import Random

import pytest
from relation import Relation
from relation_programs import COPIES, DEEPEST, SHORT, nested
from scanrack.ladder.files import parse_program
from scanrack.ladder.prove.algebra.evaluation import evaluate
from scanrack.ladder.prove.algebra.meaning import INT
from scanrack.ladder.prove.algebra.numbers import add, mul
from scanrack.ladder.prove.algebra.terms import const, var
from scanrack.ladder.prove.relation.places import _choices


@pytest.mark.extra("prove")
@pytest.mark.parametrize(
    ("text", "claim"),
    [
        (COPIES, {"always": "Go OR S.DATA[0] = 10 + A"}),
        (COPIES, {"never": "NOT Go AND S.DATA[0] = 0"}),
        (SHORT, {"never": "NOT Go AND D[0] = 0"}),
    ],
    ids=str,
)
def test_what_a_refused_copy_leaves_is_unknown_only_where_it_acts(text: str, claim: dict[str, str]) -> None:
    found = parse_program(text).prove(**claim)
    assert (found.word, found.verdict.k) == ("refuted", 1)


@pytest.mark.parametrize(("text", "byte"), [(COPIES, "S.DATA"), (SHORT, "D")], ids=["string", "array"])
def test_a_refused_copy_without_power_changes_nothing(text: str, byte: str) -> None:
    program = parse_program(text)
    machine = Relation(program).machine
    key = f"{byte.upper()}", 0
    assert evaluate([machine.state[key]], {f"{key[0]}[0]": 5, "GO[0]": False}) == [5]
    for engine in (program.interpret(), program.compile()):
        engine.step(10)
        assert engine.tags[f"{byte}[0]"] == 0
    assert Relation(program).differences(Random(1), 20) == []


@pytest.mark.extra("prove")
def test_a_refused_add_on_acts_without_power() -> None:
    program = parse_program(nested(DEEPEST))
    for engine in (program.interpret(), program.compile()):
        engine.step(10)
        assert engine.tags["Y"]
    found = program.prove(never="Y")
    assert found.word == "unknown"
    assert found.verdict.blame[0] == "A11.Logic rung 0: add-on, calls more than 12 deep"


@pytest.mark.parametrize("go", [False, True])
def test_a_refused_add_on_is_not_followed_with_power_and_without(go: bool) -> None:
    machine = Relation(parse_program(nested(DEEPEST))).machine
    assert evaluate([machine.deep], {"G[0]": go}) == [True]


BITS = """PROGRAM bits
TAG W : DINT
TAG At : DINT
TAG Next : BOOL
TAG Set : BOOL
ROUTINE Main
XIC(Next)ADD(At,1,At);
[LES(At,28),GRT(At,31)]MOV(28,At);
XIC(Set)OTL(W.[At]);
END
"""


@pytest.mark.extra("prove")
def test_a_computed_bit_may_be_the_highest() -> None:
    found = parse_program(BITS).prove(never="W.31")
    assert (found.word, found.verdict.k) == ("refuted", 4)


BEHIND = """PROGRAM behind
TYPE Part (Size : DINT, Kind : DINT)
TAG Src : DINT[5] := [1,2,3,4,5]
TAG Out : DINT[8]
TAG Parts : Part[3]
TAG More : Part[4]
TAG At : DINT
ROUTINE Main
COP(Src[At],Out[0],8);
COP(Parts[At],More[0],4);
FLL(At,Src[At],7);
FLL(At,Parts[At],4);
END
"""


def test_a_copy_from_a_computed_element_ends_with_its_array() -> None:
    """Its last elements have one number each that may name them, and those behind have none."""
    found = Relation(parse_program(BEHIND))
    assert found.machine.cut == []
    assert found.differences(Random(1), 60) == []
    values = {f"SRC[{at}]": at + 1 for at in range(5)} | {"AT[0]": 0}
    assert evaluate([found.machine.state["OUT", 4]], values) == [5]


@pytest.mark.parametrize(
    ("least", "step", "begin", "named"),
    [(0, 1, 5, 0), (0, 1, 4, 4), (0, 3, 7, 1), (3, 3, 1, 1), (0, 3, 4, 4)],
)
def test_an_index_behind_all_elements_names_one_in_its_column(
    least: int, step: int, begin: int, named: int
) -> None:
    """A copy asks for it and does not use it; of five elements only one is named by the others."""
    leaf = parse_program(BEHIND).build().layout.leaf("SRC")
    index = add(mul(var("at", INT, least, least + 3), const(step)), const(begin))
    number, places_ = _choices(leaf, index)
    assert ([*places_], evaluate([number], {"at": least})) == ([named], [0])


ZERO = """PROGRAM zero
TAG R : REAL
TAG L : LREAL
TAG Q : REAL
TAG M : LREAL
ROUTINE Main
MOD(R,7.0,Q);
MOD(L,R,M);
END
"""


@pytest.mark.parametrize(
    ("value", "rest"), [(-7.0, "-0.0"), (7.0, "0.0"), (-0.0, "-0.0"), (0.0, "0.0"), (-7.5, "-0.5")]
)
def test_a_remainder_of_zero_has_the_sign_of_the_dividend(value: float, rest: str) -> None:
    program = parse_program(ZERO)
    state = Relation(program).machine.state["Q", 0]
    assert str(evaluate([state], {"R[0]": value})[0]) == rest
    for engine in (program.interpret(), program.compile()):
        engine.tags["R"] = value
        engine.step(10)
        assert str(engine.tags["Q"]) == rest


def test_the_comparison_tells_the_signs_of_zero_apart() -> None:
    assert Relation(parse_program(ZERO)).differences(Random(1), 60) == []


NEVER = """PROGRAM guarded
TAG Left : BOOL
TAG Right : BOOL
TAG Fwd : BOOL
TAG Rev : BOOL
TAG Both : BOOL
ROUTINE Main
XIC(Left)XIO(Rev)OTE(Fwd);
XIC(Right)XIO(Fwd)OTE(Rev);
END
ROUTINE Never ST
Both := Fwd AND Rev;
END
"""


@pytest.mark.extra("prove")
def test_statements_of_a_routine_never_run_with_the_proof() -> None:
    """Without them nothing writes the bit, and a run would set it as an input."""
    from scanrack.ladder.prove import ProgramSystem
    from scanrack.ladder.prove.answers import answer
    from scanrack.ladder.prove.monitors import monitored

    watched = monitored(parse_program(NEVER))
    (asked,) = watched.properties
    found = answer(ProgramSystem(watched.program), watched, asked)
    assert (found.word, asked.claim.sentence) == ("proved", "never Both")


GAPS = """PROGRAM gaps
TYPE Part (Size : SINT, On : BOOL, Off : BOOL)
TAG Raw : SINT[4]
TAG P : Part
TAG Out : SINT[4]
ROUTINE Main
ADD(Raw[1],4,Raw[1]);
COP(Raw[0],P,1);
COP(P,Out[0],2);
END
"""


def test_bits_beside_the_members_of_a_structure_are_those_that_a_copy_left() -> None:
    program = parse_program(GAPS)
    engine = program.compile()
    engine.step(10)
    assert engine.tags["Out[1]"] == 4
    assert Relation(program).differences(Random(1), 20) == []


@pytest.mark.extra("prove")
def test_no_proof_takes_the_bits_beside_members_for_0() -> None:
    assert not parse_program(GAPS).prove(never="Out[1] > 3")
    assert parse_program(GAPS).prove(never="Out[1].0 AND NOT P.On")
