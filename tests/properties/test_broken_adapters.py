"""Ordeals and scripts: sound adapters stand them, adapters with one deliberate mistake are found out."""

from __future__ import annotations

import pytest
from adapter_ordeals import KINDS, complaints, ordeals
from adapter_scripts import scripts
from adapterbench import AdapterBench, AdapterBench006
from broken_adapters import MISTAKES
from hypothesis import HealthCheck, Phase, find, given, settings
from lockstep_adapters import differs

BENCHES = {"PCL601": AdapterBench, "PMC006": AdapterBench006}
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
@settings(max_examples=12, deadline=None)
@given(ordeal=ordeals())
def test_a_sound_adapter_stands_every_ordeal(controller, ordeal):
    assert complaints(ordeal, BENCHES[controller]) == []


@pytest.mark.parametrize(("mistake", "controller"), MISTAKES, ids=[mistake.name for mistake, _ in MISTAKES])
def test_every_broken_adapter_is_found(mistake, controller):
    def complains(ordeal):
        return complaints(ordeal, BENCHES[controller]) != []

    with mistake.made():
        if mistake.theme in KINDS:
            find(ordeals(mistake.theme), complains, settings=SEARCH)
        else:
            find(scripts(controller, mistake.theme), differs, settings=SEARCH)
