"""LEN of a CONTROL bounds the loops of file instructions where nothing can write it, and only there."""

import pytest
from scanrack.ladder import LadderLogic
from scanrack.ladder.files import parse_program

pytestmark = pytest.mark.extra("prove")

HEAD = """PROGRAM files
TAG A : BOOL
TAG Go : BOOL
TAG K : CONTROL := {"LEN": 4}
TAG Row : DINT[6]
TAG N : DINT
ROUTINE Main
XIC(A)FAL(K,?,?,ALL,Row[K.POS],7);
"""


def program(*rungs: str) -> LadderLogic:
    return parse_program(f"{HEAD}{chr(10).join(rungs)}\nEND\n")


def test_a_length_that_nothing_writes_is_known_and_named_as_an_assumption() -> None:
    behind, last = (program().prove(never=f"Row[{number}] = 7") for number in (4, 3))
    assert behind
    assert behind.held == (("K.LEN", 4),)
    assert not last
    assert last.steps


@pytest.mark.parametrize("rung", ["MOV(N,K.LEN);", "XIC(K.LEN.0)OTE(Go);"])
def test_a_length_that_the_program_or_somebody_outside_writes_is_not(rung: str) -> None:
    assert str(program(rung).prove(never="Row[4] = 7")).startswith("unknown")


@pytest.mark.parametrize("asked", [{"free": ["K.LEN"]}, {"written_outside": ["K.LEN"]}])
def test_a_length_that_changes_outside_is_not(asked: dict[str, list[str]]) -> None:
    assert str(program().prove(never="Row[4] = 7", **asked)).startswith("unknown")
