"""Ordeals and scripts: sound adapters stand them, adapters with one deliberate mistake are found out."""

from __future__ import annotations

import pytest
from adapter_ordeals import KINDS, complaints, ordeals
from adapter_scripts import scripts
from adapterbench import BENCHES
from amounts import amount
from broken_adapters import MISTAKES
from hypothesis import HealthCheck, Phase, find, given, settings
from lockstep_adapters import differs

pytestmark = pytest.mark.slow

EXAMPLES = 20
SEARCH = settings(
    max_examples=EXAMPLES,
    derandomize=True,
    deadline=None,
    database=None,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)


@pytest.mark.parametrize("controller", BENCHES)
@settings(max_examples=amount(6), deadline=None)
@given(ordeal=ordeals())
def test_a_sound_adapter_stands_every_ordeal(controller, ordeal):
    assert complaints(ordeal, BENCHES[controller]) == []


@pytest.mark.parametrize(("mistake", "controller"), MISTAKES, ids=[mistake.name for mistake, _ in MISTAKES])
def test_every_broken_adapter_is_found(mistake, controller):
    def complains(ordeal):
        return complaints(ordeal, BENCHES[controller]) != []

    with mistake.made():
        if mistake.theme in KINDS:
            search(ordeals(mistake.theme), complains)
        else:
            search(scripts(controller, mistake.theme), differs)


def search(strategy, shows_it):
    """Fail unless an example shows the mistake; it is played once, though `find` asks again."""
    shown: list[object] = []

    def has_shown_it(example):
        if not shown and shows_it(example):
            shown.append(example)
        return bool(shown)

    find(strategy, has_shown_it, settings=SEARCH)
