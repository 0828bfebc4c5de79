"""A start whose answer is lost is not repeated blindly: short moves, one reply lost at each moment."""

from __future__ import annotations

import pytest
from adapterbench import AdapterBench, AdapterBench006, move

STEPS = 40
"""At 1,000 steps/s: 40 ms, over before anybody can have noticed that the answer is missing."""


@pytest.mark.slow
@pytest.mark.parametrize("lost", [1, 2])
@pytest.mark.parametrize(("make", "rest_ms"), [(AdapterBench, 400), (AdapterBench006, 1200)])
def test_every_short_move_is_made_exactly_once(make, rest_ms, lost):
    bench = make(scan_ms=1).configured()
    for made, after_ms in enumerate(range(0, 120, 4), start=1):
        bench.give(*move(STEPS, 1000), ms=after_ms)
        bench.module.controller.line.faults.drop_next = lost
        bench.run(rest_ms)
        assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
        assert bench.position == bench.motor == made * STEPS
        bench.release(50)
