"""Blend moves: the way and the times of a profile, by the manual's arithmetic [chapters 2, 4 and 5]."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, product

import pytest
from bench3601 import BLEND_CCW, BLEND_CW, Bench
from blends3601 import TWO_STEPS, C, T, Z, block, header, legs, program, send

EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])

SENSE = {0: set(), 1: {"ACCELERATING"}, -1: {"DECELERATING"}}


def run_blend(bench: Bench, direction: int = 1) -> Bench:
    return bench.out(BLEND_CW if direction > 0 else BLEND_CCW)


def moving(direction: int) -> str:
    return "MOVING_CW" if direction > 0 else "MOVING_CCW"


# -- the profile


@pytest.mark.parametrize(("direction", "scan_ms"), [(1, 0.25), (-1, 2)], ids=["cw", "ccw"])
@pytest.mark.rules("BLD-08", "BLD-10", "BLD-12", "BLD-13", "BLD-20", "STS-L08", "STS-M07", "STOP-06")
@pytest.mark.parametrize(
    "types", list(product((C, T, Z), repeat=3)), ids=lambda types: "".join("CT?Z"[kind] for kind in types)
)
def test_ramps_and_speeds_follow_the_arithmetic_of_chapter_2(types, direction, scan_ms):
    """1000 to 7000/s at 20, to 4000/s and to 1000/s at 10: all ramps take whole tens of ms in all shapes."""
    first, second, final = types
    segments = [(2500, 7000, 20, first), (5000, 4000, 10, second)]
    bench = program(Bench.ready(position=-direction * 100, scan_ms=scan_ms), segments, (10, final))
    run_blend(bench, direction)
    passed = Fraction(0)
    for ms, steps, _, ramp in legs(1000, segments, (10, final))[:-1]:
        while passed + Fraction(scan_ms) < ms:
            bench.scan()
            passed += Fraction(scan_ms)
            assert bench.bits == {"MODULE_OK", "BLEND_RUNNING", moving(direction), *SENSE[ramp]}
        if passed + Fraction(scan_ms) == ms:
            bench.scan()
            passed = ms
            assert bench.position == direction * (int(steps) - 100)
    end_ms = legs(1000, segments, (10, final))[-1][0]
    left = bench.until("MOVE_COMPLETE")
    assert 0 <= passed + Fraction(left) - end_ms < scan_ms
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == direction * (7_500 - 100)


@EITHER_WAY
@pytest.mark.rules("BLD-08", "BLD-10")
def test_backwards_is_the_same_profile_in_the_other_direction(direction):
    """Reading A-61: the same order of segments."""
    bench = program(Bench.ready())
    run_blend(bench, direction).run(200)
    assert bench.position == direction * 600
    bench.run(480 + 300)
    assert bench.position == direction * (3000 + 1050)
    bench.run(500 + 100)
    assert (bench.position, bench.bits) == (direction * TWO_STEPS, {"MODULE_OK", "MOVE_COMPLETE"})


@pytest.mark.rules("BLD-12")
@pytest.mark.parametrize("kind", [T, Z, 0b10], ids=["triangular", "trapezoidal", "10 is constant"])
@pytest.mark.parametrize("number", range(16))
def test_each_segment_has_its_own_two_bits(number, kind):
    """Segments at 2000 and 3000/s in turn, all at 10: only the one with the bits takes longer."""
    types = [kind if each == number else C for each in range(16)]
    segments = [(1000, 2000 + 1000 * (each % 2), 10, types[each]) for each in range(16)]
    bench = Bench.ready(scan_ms=1)
    send(bench, header(types, 10), *(block(*segment[:3]) for segment in segments)).out().scan()
    run_blend(bench)
    plain = [(*segment[:3], C if segment[3] == 0b10 else segment[3]) for segment in segments]
    end_ms = legs(1000, plain, (10, C))[-1][0]
    took = Fraction(bench.until("MOVE_COMPLETE"))
    assert 0 <= took - end_ms < 1
    assert bench.position == 16_000


@pytest.mark.rules("BLD-10")
def test_sixteen_segments_begin_and_end_where_they_should():
    """Up and down by every rate; the position is that of the sum of the lengths at every end of a segment."""
    speeds = [2000, 5000, 4000, 4500, 1000, 9000, 8000, 9000] * 2
    segments = [(9000 - number, speed, 10 + number, C) for number, speed in enumerate(speeds)]
    bench = program(Bench.ready(), segments, (7, C))
    run_blend(bench)
    start_ns = bench.now_ns
    for (_, _, _, _), (ms, steps, speed, _) in pairwise(legs(1000, segments, (7, C))[:-1]):
        scans = -(-ms * 4 // 1) - (bench.now_ns - start_ns) // 250_000
        bench.run(float(scans / 4))
        late_ms = Fraction(bench.now_ns - start_ns, 1_000_000) - ms
        assert abs(bench.position - (steps + speed * late_ms / 1000)) <= 1
    bench.until("MOVE_COMPLETE")
    assert bench.position == sum(length for length, *_ in segments)


@pytest.mark.rules("BLD-10")
def test_segments_at_the_starting_speed_have_no_ramps():
    """From 1000 to 2000/s at 10: 3e6/20,000 = 150 steps and 100 ms; nothing at either end."""
    bench = program(Bench.ready(), [(50, 1000, 20, T), (200, 2000, 10, C), (210, 1000, 10, C)], (1, Z))
    assert run_blend(bench).until("MOVE_COMPLETE") == 50 + 100 + 25 + 100 + 60
    assert bench.position == 460
