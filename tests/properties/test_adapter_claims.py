"""No image of an adapter claims rest while the motor turns, and every command edge has an effect or a bit."""

from __future__ import annotations

import pytest
from amounts import amount
from rest_claims import violations

SEQUENCES, OF_EACH_TEST = 300, 25
PLAYED = min(amount(8), OF_EACH_TEST)
"""Of each test: a third in `.ci/run`, all with --long, as `.ci/long` does."""


@pytest.mark.parametrize("seed", range(3))
def test_claims_are_true_and_edges_count(seed):
    assert violations(seed) == []


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, SEQUENCES, OF_EACH_TEST))
def test_claims_are_true_and_edges_count_in_300_sequences(first):
    assert {seed: wrong for seed in range(first, first + PLAYED) if (wrong := violations(seed)) != []} == {}
