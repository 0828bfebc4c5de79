"""Whatever befalls the line, at whatever point of a move: no motion is doubled, and the image is safe."""

from __future__ import annotations

import pytest
from adapterbench import MS, AdapterBench, move
from amounts import amount
from hypothesis import given, settings
from hypothesis import strategies as st

DISTANCE = 2000
"""At 5,000 steps/s and 100 steps/ms/s: 1000 to 5,000 in 40 ms; 0.448 s in all."""


def faulty_move(at_ms: float, drop: int, corrupt: int) -> AdapterBench:
    """Let replies be lost and damaged so long after a move was commanded; return what came of it."""
    bench = AdapterBench(scan_ms=1).configured()
    bench.give(*move(DISTANCE, 5000, 100, 100), ms=at_ms)
    bench.module.controller.line.faults.drop_next = drop
    bench.module.controller.line.faults.corrupt_next = corrupt
    return bench.run(1800)  # eight replies in a row take 1.5 s


@pytest.mark.slow
@settings(max_examples=amount(6), deadline=None)
@given(st.integers(0, 600), st.integers(0, 4), st.integers(0, 4))
def test_lost_and_damaged_replies_never_double_a_motion(at_ms, drop, corrupt):
    bench = faulty_move(at_ms, drop, corrupt)
    assert bench.position == bench.motor
    if "POSITION_INVALID" in bench.bits:
        assert 0 <= bench.motor <= DISTANCE
        assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
        assert drop + corrupt >= 3
    else:
        assert bench.motor == DISTANCE
        assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


@pytest.mark.slow
@settings(max_examples=amount(5), deadline=None)
@given(st.integers(0, 600), st.integers(1, 1500))
def test_a_line_that_is_down_for_a_while_ends_in_a_known_state(at_ms, down_ms):
    bench = AdapterBench(scan_ms=1).configured()
    bench.give(*move(DISTANCE, 5000, 100, 100), ms=at_ms)
    bench.module.controller.line.take_down()
    bench.run(down_ms)
    bench.module.controller.line.put_up()
    bench.run(600)
    assert bench.position == bench.motor
    assert bench.bits in (
        {"MODULE_OK", "MOVE_COMPLETE"},
        {"MODULE_OK", "POSITION_INVALID", "STOPPED"},
    )
    if "MOVE_COMPLETE" in bench.bits:
        assert bench.motor == DISTANCE
    else:
        assert 0 <= bench.motor <= DISTANCE


@pytest.mark.slow
@settings(max_examples=amount(4), deadline=None)
@given(st.integers(0, 600))
def test_a_controller_that_loses_power_at_any_point_stands_still_and_says_so(at_ms):
    bench = AdapterBench(scan_ms=1).configured()
    bench.give(*move(DISTANCE, 5000, 100, 100), ms=at_ms)
    bench.module.cycle_device()
    before = bench.motor
    bench.run(150)
    assert before <= bench.motor <= before + 250  # a start under way is stopped when it is noticed
    at = bench.motor
    bench.run(500)
    assert bench.motor == at
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}


@settings(max_examples=amount(4), deadline=None)
@given(st.lists(st.integers(1, 40), min_size=1, max_size=12))
def test_advancing_once_or_in_pieces_gives_the_same_images(pieces):
    whole, parts = AdapterBench().configured(), AdapterBench().configured()
    for bench in (whole, parts):
        bench.put(*move(DISTANCE, 5000, 100, 100))
    for piece in pieces:
        parts.now_ns += piece * MS // 4
        parts.image = parts.module.update(parts.now_ns, parts.outputs)
    whole.image = whole.module.update(parts.now_ns, whole.outputs)
    assert list(whole.image) == list(parts.image)
