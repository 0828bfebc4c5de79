"""Random scripts, played to each adapter over its simulated controller and to the plain oracle of a 3601."""

from __future__ import annotations

import pytest
from adapter_scripts import THEMES, scripts
from hypothesis import Phase, given, settings
from lockstep_adapters import played

EXAMPLES = {"homing": 2}
"""By theme; 4 of the others: a search for home takes seconds, of virtual time, too."""


@pytest.mark.slow
@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("controller", ["PCL601", "PMC006"])
def test_an_adapter_does_what_a_3601_does(controller, theme, request):
    examples = 100 if request.config.getoption("--long") else EXAMPLES.get(theme, 4)

    @settings(max_examples=examples, phases=[Phase.explicit, Phase.generate])
    @given(script=scripts(controller, theme))
    def lockstep(script):
        played(script)

    lockstep()
