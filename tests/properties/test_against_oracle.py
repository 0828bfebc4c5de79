"""Random but plausible scripts, played on the module and on a plain oracle in lockstep.

The oracle (`oracle3601` and its neighbours in tests/support) is written from the manual: a loop over
250 µs ticks, floats for motion. It shares nothing with the module but the image and the names of bits.
Where both are right within the tolerance of floats but would part for good, a script is given up.
"""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from lockstep3601 import GivenUp, Lockstep
from stories3601 import THEMES, scripts


@pytest.mark.parametrize("theme", THEMES)
def test_module_and_oracle_show_the_same_bits(theme):
    @given(script=scripts(theme))
    def lockstep(script):
        setting, steps = script
        bench = Lockstep(setting)
        with contextlib.suppress(GivenUp):
            for step in steps:
                step.play(bench)

    lockstep()
