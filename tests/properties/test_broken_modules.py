"""The lockstep finds every deliberately broken module, with the scripts of the CI profile if it can.

Each mistake is looked for with the scripts of its own theme, in the order in which the CI profile plays
them, up to the first difference. `benchmarks/broken_modules.py` tells in how many scripts and seconds.

Which mistakes sixty scripts show is a matter of the draw, and Hypothesis draws otherwise when a strategy or
a constant of a loaded module changes: over six seeds they missed up to two, the worst of which took 104.
So that an unrelated change turns nothing red here, what sixty don't find gets more.
"""

from __future__ import annotations

import pytest
from broken3601 import MISTAKES
from hunt3601 import CI_EXAMPLES, hunt, scripts_of, symptom
from stories3601 import THEMES

BUDGETS = (CI_EXAMPLES, 4 * CI_EXAMPLES, 16 * CI_EXAMPLES)


@pytest.mark.slow
@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda mistake: mistake.name)
def test_a_broken_module_is_found(mistake):
    assert any(hunt(mistake, examples).examples for examples in BUDGETS), mistake.sentence


def test_there_is_one_mistake_of_each_class():
    assert len({mistake.name for mistake in MISTAKES}) == len(MISTAKES) >= 30
    assert {mistake.theme for mistake in MISTAKES} <= set(THEMES)
    assert all(mistake.sentence.endswith(".") for mistake in MISTAKES)


@pytest.mark.slow
def test_the_module_itself_is_not_found_broken():
    assert not any(symptom(script) for script in scripts_of("states")[:20])
