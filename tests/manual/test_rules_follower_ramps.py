"""Encoder follower: rates that are not zero, the speed they allow, and the exact end [chapter 4].

The follower goes no faster than lets it stop on the last step that is owed,
v*v = 2 * deceleration * owed, and its speed changes no faster than its rates.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest
from follower3601 import follow, follower_bench

EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])

IN_MODE = {"MODULE_OK", "ENC_FOLLOWER"}


@EITHER_WAY
@pytest.mark.rules("FOL-10", "FOL-02", "STS-M05", "STS-M06")
def test_ramps_catch_up_exactly(direction):
    """1000 steps owed at once, rates 20 and 10: v*v*(1/40,000 + 1/20,000) = 1000.

    So 3651/s after 182.6 ms and 333 steps, and another 365.1 ms down; the steps
    are whole ones and so are the ticks, which costs a little time at the end.
    """
    bench = follow(follower_bench(), direction, (1, 1), (20, 10)).turn_encoder(1000, 0.25)
    moving = "MOVING_CW" if direction > 0 else "MOVING_CCW"
    for ms in range(10, 180, 10):
        bench.run(10)
        assert bench.bits == {*IN_MODE, moving, "ACCELERATING"}
        assert abs(direction * bench.position - ms * ms / 100) <= 0.02 * ms + 1  # a*t*t/2, half a tick late
    bench.run(20)
    for _ in range(20, 340, 10):
        before = direction * bench.position
        bench.run(10)
        assert bench.bits >= {*IN_MODE, moving}
        assert "ACCELERATING" not in bench.bits
        assert 0 < direction * bench.position - before <= 37
    bench.run(60)
    assert (bench.position, bench.bits) == (direction * 1000, IN_MODE)


@EITHER_WAY
@pytest.mark.rules("FOL-05", "FOL-10")
@pytest.mark.parametrize("counts", range(4_997, 5_001))
def test_without_a_deceleration_it_stops_on_the_last_step_at_full_speed(counts, direction):
    """Some 5000 steps at 20 steps/ms/s: v*v = 2 * 20,000 * 5000, 14,142/s or 3.5 steps a scan at the end."""
    bench = follow(follower_bench(scan_ms=0.25), direction, (1, 1), (20, 0)).turn_encoder(counts, 0.25)
    before = 0
    for _ in range(4 * 720):
        bench.scan()
        assert before <= direction * bench.position <= counts
        before = direction * bench.position
    assert (before, bench.bits) == (counts, IN_MODE)


@pytest.mark.rules("FOL-05", "FOL-10")
@pytest.mark.parametrize("rates", [(2000, 2000), (2000, 1000), (20, 10), (0, 10)])
def test_ccw_is_the_mirror_image_of_cw_in_every_scan(rates):
    cw, ccw = (
        follow(follower_bench(scan_ms=0.25), direction, (1, 1), rates).turn_encoder(200, 0.25)
        for direction in (1, -1)
    )
    for _ in range(1_500):
        assert (cw.scan().position, cw.bits & {"ACCELERATING", "DECELERATING"}) == (
            -ccw.scan().position,
            ccw.bits & {"ACCELERATING", "DECELERATING"},
        )
    assert cw.position == 200


@EITHER_WAY
@pytest.mark.rules("FOL-10", "FOL-05")
@pytest.mark.parametrize(("rates", "after_ms", "steps"), [((20, 0), 50, 25), ((0, 10), 50, 211)])
def test_one_rate_of_the_two(direction, rates, after_ms, steps):
    """1000 steps owed at once: 20 * 50 * 50 / 2000; or 4472/s at once, v*v = 2 * 10,000 * 1000, and slower.

    In 50 ms at 10 steps/ms/s the latter is 4.472 * 50 - 10 * 50 * 50 / 2000 = 211.1 steps.
    """
    bench = follow(follower_bench(), direction, (1, 1), rates).turn_encoder(1000, 0.25).run(after_ms)
    assert abs(direction * bench.position - steps) <= 2


@pytest.mark.slow
@pytest.mark.rules("FOL-10")
@pytest.mark.parametrize("rates", [(20, 10), (1, 1), (2000, 2000), (5, 0), (0, 5), (2000, 1)])
@pytest.mark.parametrize("ratio", [(1, 1), (3, 7), (7, 3)])
def test_never_beyond_never_back_and_all_there_in_the_end(ratio, rates):
    """A master that starts, stops, and starts again; the follower comes later, with the exact number."""
    bench = follow(follower_bench(scan_ms=1), 1, ratio, rates)
    counted = 0
    for counts in (400, 0, 100, 7):
        bench.module.machine.turn_encoder(counts, bench.now_ns, bench.now_ns + 50_000_000)
        for _ in range(100):
            before = bench.position
            bench.scan()
            assert before <= bench.position <= bench.encoder * Fraction(*ratio)
        counted += counts
    bench.run(2_600)
    assert bench.position == counted * ratio[0] // ratio[1]


@pytest.mark.rules("FOL-10")
@pytest.mark.parametrize("rates", [(20, 10), (3, 50)])
def test_the_speed_changes_no_faster_than_the_rates(rates):
    """Per 10 ms: by 10 * rate steps/s, and a step more or less in each of two spans of 10 ms."""
    bench = follow(follower_bench(scan_ms=1), 1, (1, 1), rates)
    bench.module.machine.turn_encoder(5000, bench.now_ns, bench.now_ns + 1_000_000_000)
    spans, before = [], 0
    for _ in range(250):
        bench.run(10)
        spans.append(bench.position - before)
        before = bench.position
    for earlier, later in pairwise(spans):
        assert -rates[1] / 10 - 2 <= later - earlier <= rates[0] / 10 + 2
    assert bench.position == 5000


@pytest.mark.slow
@EITHER_WAY
@pytest.mark.rules("FOL-10")
def test_a_master_that_turns_back(direction):
    """It decelerates first, so it goes on for a while; then it comes back to the exact position."""
    bench = follow(follower_bench(scan_ms=1), direction, (1, 1), (20, 10))
    bench.turn_encoder(2000, 500).turn_encoder(-2500, 300).run(3_000)
    assert (bench.position, bench.bits) == (direction * -500, IN_MODE)


@EITHER_WAY
@pytest.mark.rules("FOL-10", "STS-M00", "STS-M01")
def test_the_direction_shown_is_that_of_the_steps_until_it_turns_back(direction):
    """Also between two of them, with what is owed lying on the other side already."""
    bench = follow(follower_bench(), direction, (1, 1), (20, 1)).turn_encoder(400, 400).turn_encoder(-400, 5)
    away, back = ("MOVING_CW", "MOVING_CCW") if direction > 0 else ("MOVING_CCW", "MOVING_CW")
    shown: list[tuple[int, bool]] = []
    while not shown or direction * (bench.position - shown[-1][0]) >= 0:
        shown.append((bench.position, away in bench.bits))
        bench.scan()
    assert back in bench.bits
    farthest = max(direction * position for position, _ in shown)
    assert all(moves_away for position, moves_away in shown if direction * position < farthest)
    assert 0 < shown[0][0] * direction < farthest


@pytest.mark.rules("FOL-10", "FOL-05")
def test_rates_may_change_while_it_follows():
    bench = follow(follower_bench(scan_ms=1), 1, (1, 1), (1, 1)).turn_encoder(3000, 300)
    lag = bench.encoder - bench.position
    assert lag > 2_900  # 0.3 s at 1 step/ms/s are 45 steps
    follow(bench, 1).run(13)  # 250 a tick make up for it in 12 ticks
    assert bench.position == 3000


@pytest.mark.rules("FOL-04", "FOL-06")
@pytest.mark.parametrize("leave", [False, True])
def test_what_is_owed_is_dropped_when_the_direction_bit_is_reset(leave):
    bench = follow(follower_bench(), 1, (1, 1), (20, 10)).turn_encoder(3000, 300)
    follow(bench, 0, (1, 1), (20, 10)) if not leave else bench.out().scan()
    position = bench.position
    assert 0 < position < 3000
    bench.run(100)
    assert (bench.position, bench.bits - {"STOPPED"} <= IN_MODE) == (position, True)
    follow(bench, 1, (1, 1), (20, 10)).run(100)
    assert bench.position == position
