"""What is proved is broken by no random scan; a refutation has run on the compiled program."""

from __future__ import annotations

import pytest
from amounts import amount
from proofs import Proofs

pytestmark = pytest.mark.extra("prove")


def tried(first: int, programs: int) -> Proofs:
    found = Proofs()
    for seed in range(first, first + programs):
        found.try_one(seed, runs=2, scans=60)
    return found


def test_no_random_scan_breaks_a_proof() -> None:
    found = tried(0, max(8, amount(8)))
    assert found.broken == []
    assert found.count["proved"] > 5
    assert found.count["refuted"] > 5
    assert found.count["scans"] > 500
