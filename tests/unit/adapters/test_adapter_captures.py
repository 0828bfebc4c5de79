"""What the capture input captures on an adapter: the count, or the position, as read after the edge."""

from __future__ import annotations

import pytest
from adapterbench import MS, AdapterBench, AdapterBench006, AdapterBenchDrive, move
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.thousands import join_reported

pytestmark = pytest.mark.slow  # together they take seconds

WITH_ENCODER = (0x853D, 63, 1, 0)
"""Capture instead of external input, and a quadrature encoder."""

WITHOUT = (0x843D, 63, 1, 0)
FSET = (0x8435, 63, 1, 0)
"""A PMC006's FSET takes one of capture, external input and emergency stop."""

CAPTURE_AND_HOME = (0x8415, 63, 1, 0)
"""And a CW limit, which is not wired."""

PHASES = range(30)
"""Milliseconds, more than a poll takes."""


def captured(bench: AdapterBench) -> int:
    return join_reported(bench.image[6], bench.image[7])


def configured(controller: str) -> AdapterBench:
    if controller == "PCL601":
        return AdapterBench(scan_ms=1).configured(*WITHOUT)
    if controller == "drive":
        bench = AdapterBenchDrive(scan_ms=1, in2="capture", unwired="inactive")
        return bench.configured(*CAPTURE_AND_HOME)
    return AdapterBench006(scan_ms=1, capture="fset").configured(*FSET)


def captured_encoder(phase: int, *, turning: bool) -> int:
    """Turn the encoder by one count a millisecond up to 500, and energize the input there."""
    bench = AdapterBench(scan_ms=1).configured(*WITH_ENCODER)
    bench.run(phase)
    end_ns = bench.now_ns + 500 * MS
    bench.module.machine.turn_encoder(1000 if turning else 500, bench.now_ns, end_ns + 500 * MS * turning)
    bench.run(500).level(InputBit.CAPTURE, True)
    bench.run(100)
    return captured(bench)


@pytest.mark.parametrize("phase", PHASES)
def test_the_count_of_an_encoder_that_rests_at_the_edge_is_captured(phase: int) -> None:
    assert captured_encoder(phase, turning=False) == 500


def test_the_count_of_an_encoder_that_turns_is_captured_within_a_poll_after_the_edge() -> None:
    late = [captured_encoder(phase, turning=True) - 500 for phase in PHASES]
    assert min(late) > 5
    assert max(late) <= 24


@pytest.mark.parametrize("controller", ["PCL601", "PMC006", "drive"])
@pytest.mark.parametrize("phase", range(0, 60, 4))
def test_the_position_of_an_axis_that_rests_at_the_edge_is_captured(controller: str, phase: int) -> None:
    """The motor has just come to its target, and the adapter has not read that yet."""
    bench = configured(controller)
    bench.run(phase).put(*move(300, 5000, 100, 100))
    while bench.motor < 300:
        bench.run(1)
    bench.level(InputBit.CAPTURE, True)
    bench.run(200)
    assert captured(bench) == bench.motor == 300


@pytest.mark.parametrize("controller", ["PCL601", "PMC006", "drive"])
def test_the_edge_to_inactive_captures_nothing(controller: str) -> None:
    bench = configured(controller)
    bench.level(InputBit.CAPTURE, True)
    bench.run(100).give(*move(300, 5000, 100, 100), ms=500)
    bench.level(InputBit.CAPTURE, False)
    assert captured(bench.run(200)) == 0


@pytest.mark.parametrize("steps", range(300, 440, 10))
def test_a_capture_as_a_move_ends_leaves_the_position_right(steps: int) -> None:
    """The status read for the capture may be the first that shows the end: the position is older than it."""
    bench = AdapterBench(scan_ms=1).configured(*WITH_ENCODER)
    bench.put(*move(steps, 5000, 100, 100))
    while bench.motor < steps:
        bench.run(1)
    bench.level(InputBit.CAPTURE, True)
    bench.run(100, until="MOVE_COMPLETE")
    assert bench.bits - {"IN_CAPTURE"} == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == steps
