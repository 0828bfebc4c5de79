"""Random scripts, played to each adapter over its simulated controller and to the plain oracle of a 3601."""

from __future__ import annotations

import pytest
from adapter_scripts import THEMES, scripts
from hypothesis import Phase, given, settings
from lockstep_adapters import played

EXAMPLES = {"PCL601": 6, "PMC006": 6}


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("controller", EXAMPLES)
def test_an_adapter_does_what_a_3601_does(controller, theme):
    @settings(max_examples=EXAMPLES[controller], phases=[Phase.explicit, Phase.generate])
    @given(script=scripts(controller, theme))
    def lockstep(script):
        played(script)

    lockstep()
