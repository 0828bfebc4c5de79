"""Ordeals of an adapter: one motion, one thing that befalls it, and what then has to be true of the machine.

`complaints(ordeal, bench)` puts a bench through it and returns the laws that were broken, as sentences.
What the image says is compared with where the simulated motor truly stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest
from adapterbench import BENCHES, CONFIGURE_006, AdapterBench, AdapterBench006, AdapterBenchDrive, move
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.thousands import split_thousands
from scanrack.runtime.machine import Switch

COMPLETE = {"MODULE_OK", "MOVE_COMPLETE"}
STOPPED = {"MODULE_OK", "STOPPED"}
UNKNOWN = STOPPED | {"POSITION_INVALID"}
POWERED_UP = {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}

pytestmark = pytest.mark.slow

LIMITS = (Switch(InputBit.CW_LIMIT, 6000, None), Switch(InputBit.CCW_LIMIT, None, -6000))
LONG_MS = 700
"""Of a fault that is sure to be noticed: longer than three exchanges that fail, and 500 ms."""

AROUND_THE_START_MS = range(16, 36, 4)
"""A PCL601 answers a start 20 to 33 ms after the command: closer together than its answer is long."""


@dataclass(frozen=True)
class Ordeal:
    """One motion and what befalls it.

    Attributes:
        kind: name of what befalls it, see `KINDS`.
        distance: steps, signed; 3000 to 5000 take about a second.
        short: whether the distance is divided by 100, so that it takes less time than a lost reply.
        at_ms: how long after the command.
        count: of replies that suffer.
    """

    kind: str
    distance: int
    short: bool
    at_ms: int
    count: int

    @property
    def steps(self) -> int:
        """What is commanded."""
        return self.distance // 100 if self.short else self.distance

    @property
    def sign(self) -> int:
        """+1 CW, -1 CCW."""
        return 1 if self.distance > 0 else -1


Laws = Iterator[tuple[str, bool]]


def _start(bench: AdapterBench, ordeal: Ordeal) -> None:
    bench.give(*move(ordeal.steps, 5000, 100, 100), ms=ordeal.at_ms)


def _arrives(bench: AdapterBench, steps: int) -> Laws:
    yield "a move that is complete has made its steps, once", bench.motor == steps
    yield "a move ends in MOVE_COMPLETE", bench.bits == COMPLETE
    yield "the position shown is the motor's", bench.position == bench.motor


def undisturbed(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """Nothing befalls it: 5,000 steps/s, 40 ms of either ramp, 60 ms on a PMC006, and polls."""
    ideal_ms = 0 if ordeal.short else abs(ordeal.steps) / 5 + 64
    bench.give(*move(ordeal.steps, 5000, 100, 100), ms=0.8 * ideal_ms)
    yield "a move is not faster than programmed", abs(bench.motor) < abs(ordeal.steps) or ordeal.short
    bench.run(0.2 * ideal_ms + 400)
    yield from _arrives(bench, ordeal.steps)


def replies_lost(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """One or two replies are lost after the controller has acted."""
    bench.module.controller.line.faults.drop_next = 0 if ordeal.at_ms else ordeal.count
    _start(bench, ordeal)
    bench.module.controller.line.faults.drop_next += ordeal.count if ordeal.at_ms else 0
    bench.run(1800)
    yield from _arrives(bench, ordeal.steps)


def replies_damaged(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """One or two replies have a wrong bit."""
    _start(bench, ordeal)
    bench.module.controller.line.faults.corrupt_next = ordeal.count
    bench.run(1800)
    yield from _arrives(bench, ordeal.steps)


def line_down(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """Both directions are cut, and a command comes meanwhile."""
    line = bench.module.controller.line
    _start(bench, ordeal)
    line.take_down()
    bench.run(LONG_MS)
    yield (
        "without the controller MODULE_OK is clear, and the position invalid",
        bench.bits == {"POSITION_INVALID"},
    )
    bench.release(50).give(*move(-ordeal.steps), ms=50)
    line.put_up()
    bench.run(1200)
    yield "after a loss the axis has stopped, and nobody knows where", bench.bits == UNKNOWN
    yield "no command counts that came meanwhile", 0 <= bench.motor * ordeal.sign <= abs(ordeal.steps)
    yield "the position shown is the motor's", bench.position == bench.motor
    bench.release(100).give(*move(100), ms=800)
    yield "a new edge counts again", "MOVE_COMPLETE" in bench.bits


def power_lost(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """The controller's power is cycled; it is configured again, and its position preset."""
    _start(bench, ordeal)
    bench.module.cycle_device()
    bench.run(600)
    yield "a controller that has lost its power has to be configured", bench.bits == POWERED_UP
    yield "no position is shown then", bench.position == 0
    bench.release(50).give(*bench.configuration, ms=500).release(50)
    yield (
        "after a configuration the position is 0 and invalid",
        (bench.position == 0 and bench.bits == {"MODULE_OK", "POSITION_INVALID"}),
    )


def limit_met(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """A limit lies in the way; the move would end behind it."""
    side = "IN_CW_LIMIT" if ordeal.sign > 0 else "IN_CCW_LIMIT"
    bench.give(*move(ordeal.sign * 12_000, 5000, 100, 100), ms=2200)
    yield (
        "a move ends at an end limit, on the side where it lies",
        bench.bits - {"IN_HOME"}
        == (
            UNKNOWN | {"INPUT_ERROR", side}  # a PMC006's home switch shares its pin with the CCW limit
        ),
    )
    yield "at once", 6000 <= bench.motor * ordeal.sign <= 6300
    yield "the position shown is the motor's", bench.position == bench.motor


def held(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """A move over 5,000 steps is held on its way, and resumed."""
    bench.give(*move(ordeal.sign * 5000, 5000, 100, 100), ms=200 + ordeal.at_ms // 2)
    bench.give(4, ms=400)
    stands = bench.motor
    yield "a hold ends in HOLD_STATE", bench.bits == {"MODULE_OK", "HOLD_STATE"}
    bench.run(200)
    yield "a held axis stands still", bench.motor == stands and abs(stands) < 5000
    bench.release(50).give(8, 0, 0, 0, 5, 0, 100, 100, ms=1600)
    yield from _arrives(bench, ordeal.sign * 5000)


def stopped(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """An immediate stop."""
    bench.give(*move(ordeal.distance, 5000, 100, 100), ms=150 + ordeal.at_ms // 2)
    bench.give(16, ms=250)
    stands = bench.motor
    yield "an immediate stop ends in STOPPED, the position invalid", bench.bits == UNKNOWN
    bench.run(200)
    yield "a stopped axis stands still", bench.motor == stands and abs(stands) < abs(ordeal.distance)
    yield "the position shown is the motor's", bench.position == bench.motor


def pulses_after_a_stop(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """An immediate stop, and before it can have ended, a preset and a move for one scan each."""
    bench.give(*move(ordeal.distance, 5000, 100, 100), ms=150 + ordeal.at_ms // 2)
    bench.give(16, ms=2).release(2)
    bench.give(512, 0, *split_thousands(700), ms=2).release(2)
    bench.give(*move(50), ms=2).release(600)
    yield "each of them is done, in their order", (bench.position, bench.bits) == (750, COMPLETE)


def emergency_stop(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """The emergency stop is pressed."""
    bench.give(*move(ordeal.distance, 5000, 100, 100), ms=150 + ordeal.at_ms // 2)
    bench.level(InputBit.ESTOP, True)
    bench.run(250)
    yield (
        "an emergency stop is an input error, the position invalid",
        bench.bits
        == UNKNOWN
        | {
            "INPUT_ERROR",
            "IN_ESTOP",
        },
    )


def by_hand(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """A manual move is let go."""
    bit = 128 if ordeal.sign > 0 else 256
    bench.give(bit, 0, 0, 0, 5, 0, 100, 100, ms=400)
    yield "a manual move goes the way of its bit", bench.motor * ordeal.sign > 500
    bench.release(400)
    stands = bench.motor
    yield "a manual move that is let go ends in STOPPED", bench.bits == STOPPED
    bench.run(100)
    yield "the position shown is the motor's", bench.position == bench.motor == stands


def preset(bench: AdapterBench, ordeal: Ordeal) -> Laws:
    """The position is preset; moves go on from there."""
    bench.give(512, 0, *split_thousands(ordeal.distance), ms=50).release(50)
    yield "a preset is shown", bench.position == ordeal.distance
    bench.give(1, 0, *split_thousands(ordeal.distance + 50), 5, 0, 100, 100, ms=500)
    yield "an absolute move goes from the preset position", bench.motor == 50
    yield "and ends on its target", bench.position == ordeal.distance + 50 and bench.bits == COMPLETE


KINDS: dict[str, Callable[[AdapterBench, Ordeal], Laws]] = {
    each.__name__: each
    for each in (
        undisturbed,
        replies_lost,
        replies_damaged,
        line_down,
        power_lost,
        limit_met,
        held,
        stopped,
        pulses_after_a_stop,
        emergency_stop,
        by_hand,
        preset,
    )
}


def ordeals(kind: str) -> st.SearchStrategy[Ordeal]:
    """Return a strategy for ordeals of a kind."""
    return st.builds(
        Ordeal,
        st.just(kind),
        st.integers(3000, 5000) | st.integers(-5000, -3000),
        st.booleans(),
        st.sampled_from([0, *AROUND_THE_START_MS, 50, 120, 300]),
        st.integers(1, 2),
    )


def complaints(ordeal: Ordeal, over: type[AdapterBench] = AdapterBench) -> list[str]:
    """Put a fresh adapter through an ordeal; return the laws that were broken."""
    bench = over(*LIMITS, **_options(over, ordeal))
    configuration = CONFIGURE_006 if over is AdapterBenchDrive else bench.configuration
    bench.give(*configuration, ms=400).release(50).give(512, ms=50).release(50)
    if bench.bits != {"MODULE_OK"}:
        return ["an adapter that is configured and preset is ready"]
    broken = [law for law, holds in KINDS[ordeal.kind](bench, ordeal) if not holds]
    return [*broken, *["nothing claims rest while the motor turns"] * bool(bench.lies)]


def _options(over: type[AdapterBench], ordeal: Ordeal) -> dict[str, Any]:
    """Return the options of an adapter: a drive has two inputs, for limits or an emergency stop."""
    if over is AdapterBenchDrive:
        first = "estop" if ordeal.kind == "emergency_stop" else "cw_limit"
        return {"in1": first, "in2": "ccw_limit", "unwired": "inactive"}
    return {"hold": "immediate"} if over is AdapterBench006 else {}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("controller", BENCHES)
def test_a_sound_adapter_stands_every_ordeal(controller: str, kind: str) -> None:
    @settings(max_examples=amount(2), deadline=None)
    @given(ordeal=ordeals(kind))
    def stands(ordeal: Ordeal) -> None:
        assert complaints(ordeal, BENCHES[controller]) == []

    stands()
