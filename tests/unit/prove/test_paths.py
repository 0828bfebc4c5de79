"""Paths through an instruction: each begins with the decisions of the one before, on the same terms."""

from random import Random

import pytest
from relation import Relation
from scanrack.ladder.files.rungfile import parse_program
from scanrack.ladder.prove.algebra.meaning import BOOL
from scanrack.ladder.prove.algebra.terms import T, and_, var
from scanrack.ladder.prove.relation.paths import Paths
from scanrack.ladder.prove.relation.symbols import UnmodeledError

PASSES = """PROGRAM passes
TAG Fine : LREAL
TAG Block : INT[8]
TAG Table : DINT[6]
TAG Ctl : CONTROL := {{"LEN": 3}}
ROUTINE Main
FAL(Ctl,?,?,{mode},Table[Ctl.POS],{expression});
END
"""


@pytest.mark.parametrize("mode", ["ALL", "INC", "2"])
@pytest.mark.parametrize("expression", ["Fine", "Block[1]*Fine"])
def test_passes_of_a_value_whose_rounding_is_not_modeled(mode, expression):
    """An LREAL that is stored as a DINT may be out of range, which ends the passes."""
    relation = Relation(parse_program(PASSES.format(mode=mode, expression=expression)))
    assert [found for seed in range(20) for found in relation.differences(Random(seed), 4)] == []
    assert relation.machine.cut == []


def test_a_repeated_prefix_meets_the_same_unknowns():
    paths = Paths()
    made: list[T] = []

    def unknown():
        made.append(var(f"?{len(made)}", BOOL))
        return made[-1]

    def run():
        known = and_(paths.unknown(BOOL, unknown), var("Go", BOOL))
        return paths.decide(known), paths.decide(known), paths.decide(var("Stop", BOOL))

    assert [path.result for path in paths.walk(run)] == [
        (first, first, stop) for first in (True, False) for stop in (True, False)
    ]
    assert len(made) == 1


def test_a_run_that_decides_something_else_when_it_is_repeated_is_refused():
    paths, count = Paths(), iter(range(9))

    def run():
        return paths.decide(var(f"Go{next(count)}", BOOL)), paths.decide(var("Stop", BOOL))

    with pytest.raises(UnmodeledError, match="when it is repeated"):
        paths.walk(run)
