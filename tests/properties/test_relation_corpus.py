"""Rungs in the manner of real machines: the relation equals the interpreter, prescan included."""

from __future__ import annotations

from collections import Counter
from random import Random

import pytest
from amounts import amount
from relation import Relation
from relation_corpus import corpus, machine_text

pytestmark = pytest.mark.slow


def test_the_corpus_has_a_thousand_rungs() -> None:
    texts = [machine_text(seed) for seed in range(40)]
    rungs = [line for text in texts for line in text.splitlines() if line.endswith(";")]
    assert len(rungs) > 1_000
    assert len(set(rungs)) > 300


def test_machines_equal_the_interpreter() -> None:
    count = Counter[str]()
    for number, program in enumerate(corpus(amount(3))):
        for turned in (False, True):
            found = Relation(program, turned=turned).differences(Random(number), 6, count)
            assert found == [], f"machine {number}, turned {turned}"
    assert count["values"] > 1_000
