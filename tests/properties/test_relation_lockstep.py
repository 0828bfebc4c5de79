"""The terms of a scan equal the interpreter, whatever the program and the values before the scan."""

from random import Random

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from ladder_programs import programs
from relation import Relation
from scanrack.ladder.files import parse_program
from structured_programs import structured

pytestmark = pytest.mark.slow

_SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]


@settings(max_examples=amount(20), deadline=None, suppress_health_check=_SLOW)
@given(programs(), st.integers(0, 1 << 32))
def test_a_program_of_rungs(text, seed):
    _check(text, seed)


@settings(max_examples=amount(4), deadline=None, suppress_health_check=_SLOW)
@given(structured(), st.integers(0, 1 << 32))
def test_a_program_with_structured_text(text, seed):
    _check(text, seed)


def _check(text, seed):
    assert Relation(parse_program(text)).differences(Random(seed), 4) == []
