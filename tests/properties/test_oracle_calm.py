"""Letting time pass while nothing but the motion goes on: the oracle shows what it shows tick by tick."""

from __future__ import annotations

import pytest
from hypothesis import given
from lockstep3601 import GivenUp, Lockstep
from stories3601 import scripts


class Patient(Lockstep):
    """A lockstep that looks at every tick."""

    def calm_exchanges(self):
        return 0


def shown(bench, steps):
    """Time and the oracle's image after each step, as far as the script is played."""
    images = []
    try:
        for step in steps:
            step.play(bench)
            images.append((bench.now_ns, bench.oracle.image))
    except GivenUp:
        pass
    return images


@pytest.mark.slow
@given(scripts())
def test_calm_ticks_change_nothing_but_the_motion(script):
    setting, steps = script
    at_once, one_by_one = shown(Lockstep(setting), steps), shown(Patient(setting), steps)
    assert all(a == b for a, b in zip(at_once, one_by_one, strict=False))
