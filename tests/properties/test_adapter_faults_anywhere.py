"""Both adapters, any command, any fault at any moment: it ends at rest, with the position that it shows."""

from __future__ import annotations

import pytest
from adapterbench import CONFIGURE_006, AdapterBench, AdapterBench006, move
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st

RATES = (4, 0, 100, 100)
COMMANDS = {
    "relative": (tuple(move(1500, 4000, 100, 100)),),
    "held and resumed": (tuple(move(1500, 4000, 100, 100)), (4,), (), (8, 0, 0, 0, *RATES)),
    "manual": ((128, 0, 0, 0, *RATES), ()),
    "registration": ((128, 0, 1, 500, *RATES), (0, 0, 1, 500, *RATES)),
    "one shot": ((128,), ()),
}
FAR = {"relative": 1500, "held and resumed": 1500, "one shot": 1}
"""Where a command ends at the furthest, steps."""


def bench_for(controller: str) -> AdapterBench:
    """Return an adapter with everything switched on that it refuses by default."""
    if controller == "PCL601":
        return AdapterBench().configured(*CONFIGURE_006)
    return AdapterBench006(hold="immediate", registration="polled").configured()


def give_words(bench: AdapterBench, words: tuple[tuple[int, ...], ...], each_ms: int) -> None:
    """Write one image after the other, each for a while."""
    for image in words:
        bench.give(*image, ms=each_ms)


@pytest.mark.slow
@settings(max_examples=amount(10), deadline=None)
@given(
    controller=st.sampled_from(["PCL601", "PMC006"]),
    command=st.sampled_from(sorted(COMMANDS)),
    each_ms=st.integers(1, 200).map(lambda half: 2 * half),
    before_ms=st.integers(0, 300).map(lambda half: 2 * half),
    fault=st.sampled_from(["drop", "corrupt", "down"]),
    count=st.integers(1, 4),
)
def test_it_ends_at_rest_with_the_position_that_it_shows(
    controller, command, each_ms, before_ms, fault, count
):
    bench = bench_for(controller)
    words = COMMANDS[command]
    bench.give(*words[0], ms=before_ms)
    line = bench.module.controller.line
    if fault == "down":
        line.take_down()
        bench.run(100 * count)
        line.put_up()
    elif fault == "drop":
        line.faults.drop_next = count
    else:
        line.faults.corrupt_next = count
    give_words(bench, words[1:], each_ms)
    bench.release(2000)
    assert bench.bits.isdisjoint({"MOVING_CW", "MOVING_CCW", "CONFIG_ERROR"})
    assert "MODULE_OK" in bench.bits
    assert bench.position == bench.motor >= 0
    assert bench.motor <= FAR.get(command, 20_000)
