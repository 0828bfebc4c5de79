"""Random scripts, played to each adapter over its simulated controller and to the plain oracle of a 3601."""

from __future__ import annotations

import pytest
from adapter_scripts import scripts
from hypothesis import Phase, given, settings
from lockstep_adapters import AdapterLockstep


@pytest.mark.parametrize("controller", ["PCL601", "PMC006"])
def test_an_adapter_does_what_a_3601_does(controller):
    @settings(max_examples=15, phases=[Phase.explicit, Phase.generate])
    @given(script=scripts(controller))
    def lockstep(script):
        setting, steps = script
        bench = AdapterLockstep(setting)
        for step in steps:
            step.play(bench)
        bench.run_to_rest()

    lockstep()
