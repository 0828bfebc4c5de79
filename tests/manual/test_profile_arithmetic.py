"""Chapter 2, Calculating Move Profiles: its formulas, factors and notes, met to the ns and to the step.

The expected figures are worked out by hand from the printed equations:

    Ta = (Vs - Vo)/a      Da = Ta * (Vo + Vs)/2      Ds = N - (Da + Dd)      Tt = Ta + Td + Ds/Vs

with a in steps/s/s, a thousand times what is sent [calculation note 1]. The example throughout:
Vo 1000, Vs 5000, acceleration 20, deceleration 10:

    Ta = 4000/20,000 = 0.2 s    Da = 0.2 * 3000 = 600 steps
    Td = 4000/10,000 = 0.4 s    Dd = 0.4 * 3000 = 1200 steps
    N = 10,000: Ds = 8200, 1.64 s, Tt = 2.24 s
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest
from scanrack.runtime.kinematics import (
    MILLI,
    NANO,
    PICO,
    Profile,
    Shape,
    blend,
    move,
    ramp_distance,
    ramp_time,
    register,
    run,
    single_step,
    stop,
    stopping_distance,
)

SECOND = 10**9
MS = 10**6
EXAMPLE = Profile(1000, 5000, 20, 10)
FACTORS = [
    pytest.param(Shape.CONSTANT, Fraction(1), id="chapter 2, Ta and Da: constant"),
    pytest.param(Shape.TRIANGULAR, Fraction(2), id="chapter 2, Triangular S Curve: 2 Ta"),
    pytest.param(Shape.TRAPEZOIDAL, Fraction(4, 3), id="chapter 2, Trapezoidal S Curve: 4/3 Ta"),
]


@pytest.mark.parametrize(
    ("rate", "time_ns", "steps"),
    [
        pytest.param(20, 200 * MS, 600, id="chapter 2, Ta and Da: acceleration 20"),
        pytest.param(10, 400 * MS, 1200, id="chapter 2, Td and Dd: deceleration 10"),
    ],
)
def test_time_and_distance_of_a_ramp(rate: int, time_ns: int, steps: int) -> None:
    assert ramp_time(4_000 * NANO, rate, Shape.CONSTANT) == time_ns
    assert ramp_distance(1_000_000, 5_000_000, rate, Shape.CONSTANT) == steps * PICO
    assert stopping_distance(5_000_000, 1000, rate, Shape.CONSTANT) == steps * PICO


@pytest.mark.parametrize(("shape", "factor"), FACTORS)
def test_factor_of_the_shape_on_time_and_distance(shape: Shape, factor: Fraction) -> None:
    # Vo 1000, Vs 7000: Ta = 0.3 s and Da = 1200 steps before the factor, whole numbers after it
    assert ramp_time(6_000 * NANO, 20, shape) == factor * 300 * MS
    assert ramp_distance(1_000_000, 7_000_000, 20, shape) == factor * 1200 * PICO


@pytest.mark.parametrize(("shape", "factor"), FACTORS)
def test_a_motion_ramps_as_calculated(shape: Shape, factor: Fraction) -> None:
    motion = run(0, 0, 1, Profile(1000, 7000, 20, 10, shape))
    time_ns = int(factor * 300 * MS)
    assert motion.ramp_at(time_ns - 1) == 1
    assert motion.ramp_at(time_ns) == 0
    assert motion.speed_at(time_ns) == 7000 * MILLI
    assert motion.travel_at(time_ns) == factor * 1200 * PICO
    assert motion.steps_at(time_ns - 1) == factor * 1200 - 1


def test_chapter_2_trapezoidal_profile_at_its_joints() -> None:
    motion = move(0, 0, 10_000, EXAMPLE)
    assert motion.end_ns == 2_240 * MS
    assert [motion.position_at(t * MS) for t in (0, 200, 1840, 2240, 9000)] == [0, 600, 8800, 10_000, 10_000]
    assert [motion.ramp_at(t * MS) for t in (0, 200, 1840, 2240)] == [1, 0, -1, 0]
    assert [motion.speed_at(t * MS) for t in (0, 200, 1840, 2240)] == [1_000_000, 5_000_000, 5_000_000, 0]


def test_chapter_2_in_the_middle_of_the_ramps() -> None:
    motion = move(0, 0, 10_000, EXAMPLE)
    # after 0.1 s: 1000 * 0.1 + 20,000 * 0.01/2 = 200 steps, at 1000 + 20,000 * 0.1 = 3000 steps/s
    assert (motion.travel_at(100 * MS), motion.speed_at(100 * MS)) == (200 * PICO, 3_000_000)
    # 0.2 s before the end: 1000 * 0.2 + 10,000 * 0.04/2 = 400 steps to go, at 3000 steps/s
    assert (motion.travel_at(2040 * MS), motion.speed_at(2040 * MS)) == (9600 * PICO, 3_000_000)
    assert [motion.instant_of(k) for k in (200, 600, 8800, 9600)] == [
        100 * MS,
        200 * MS,
        1840 * MS,
        2040 * MS,
    ]


def test_chapter_2_in_the_other_direction_and_at_another_time() -> None:
    motion = move(5 * SECOND, 2500, -10_000, EXAMPLE)
    assert (motion.start_ns, motion.end_ns) == (5 * SECOND, 7 * SECOND + 240 * MS)
    assert [motion.position_at(5 * SECOND + t * MS) for t in (200, 2240)] == [1900, -7500]


@pytest.mark.parametrize(("shape", "factor"), FACTORS)
def test_chapter_2_note_2_triangular_profile(shape: Shape, factor: Fraction) -> None:
    # A peak of 4000 takes k * (4000^2 - 1000^2)/(2 * 20,000) = k * 375 steps up and k * 750 down,
    # in k * 0.15 and k * 0.3 s; so a distance of k * 1125 steps must give just that peak.
    distance = factor * 1125
    profile = Profile(1000, 5000, 20, 10, shape)
    motion = move(0, 0, int(distance), profile)
    top_ns = int(factor * 150 * MS)
    assert motion.end_ns is not None
    assert motion.end_ns == factor * 450 * MS
    assert motion.speed_at(top_ns) == 4_000_000
    assert motion.travel_at(top_ns) == factor * 375 * PICO
    assert (motion.ramp_at(top_ns - 1), motion.ramp_at(top_ns)) == (1, -1)
    assert motion.position_at(motion.end_ns) == distance


def test_chapter_2_notes_2_and_3_where_the_two_profiles_meet() -> None:
    # 600 + 1200 steps: the programmed speed is just reached, in 0.2 + 0.4 s, with nothing in between
    motion = move(0, 0, 1800, EXAMPLE)
    assert motion.end_ns == 600 * MS
    assert motion.speed_at(200 * MS) == 5_000_000
    assert [segment.ramp for segment in motion.segments] == [1, -1]
    short = move(0, 0, 1799, EXAMPLE)
    assert [segment.ramp for segment in short.segments] == [1, -1]
    assert short.speed_at(short.segments[0].until_ns) < 5_000_000
    assert [segment.ramp for segment in move(0, 0, 1801, EXAMPLE).segments] == [1, 0, -1]


def test_chapter_2_note_1_rates_are_in_steps_per_ms_per_second() -> None:
    # 1 step/ms/s is 1000 steps/s/s: a thousand steps/s more take one second
    assert ramp_time(1_000 * NANO, 1, Shape.CONSTANT) == SECOND


def test_chapter_4_trapezoidal_s_curve_is_constant_for_half_of_its_time() -> None:
    # Vo 1000, Vs 7000, acceleration 20: 0.4 s, of which 0.1 to 0.3 s at the full 20 steps/s per ms
    motion = run(0, 0, 1, Profile(1000, 7000, 20, 10, Shape.TRAPEZOIDAL))
    gains = [motion.speed_at((ms + 1) * MS) - motion.speed_at(ms * MS) for ms in range(400)]
    # thousandths of a step/s are rounded down, so a gain is one off at most
    assert all(19_999 <= gain <= 20_001 for gain in gains[100:300])
    assert all(gain < 19_999 for gain in gains[:99] + gains[301:])
    assert gains[0] < 200
    assert sum(gains) == 6_000_000


def test_chapter_4_triangular_s_curve_peaks_at_the_programmed_rate() -> None:
    # Vo 1000, Vs 7000, acceleration 20: 0.6 s, half the change at 0.3 s, the full rate only there
    motion = run(0, 0, 1, Profile(1000, 7000, 20, 10, Shape.TRIANGULAR))
    gains = [motion.speed_at((ms + 1) * MS) - motion.speed_at(ms * MS) for ms in range(600)]
    assert motion.speed_at(300 * MS) == 4_000_000
    assert 19_900 <= max(gains) <= 20_000
    assert gains.index(max(gains)) in (299, 300)
    assert all(later > earlier for earlier, later in pairwise(gains[:300]))


def test_chapter_4_the_shape_holds_for_the_deceleration_too() -> None:
    # 0.6 s and 2400 steps up, 1.2 s and 4800 steps down with the triangular factor, 6 s at 7000 between;
    # half the change after half of the ramp
    motion = move(0, 0, 49_200, Profile(1000, 7000, 20, 10, Shape.TRIANGULAR))
    assert motion.end_ns == 7800 * MS
    assert (motion.ramp_at(6600 * MS - 1), motion.ramp_at(6600 * MS)) == (0, -1)
    assert motion.speed_at(7200 * MS) == 4_000_000


@pytest.mark.parametrize("distance", [1, 2, 17, 5000])
def test_chapter_2_starting_speed_equal_to_the_programmed_speed(distance: int) -> None:
    motion = move(0, 0, distance, Profile(1000, 1000, 20, 10))
    assert [segment.ramp for segment in motion.segments] == [0]
    assert [motion.instant_of(k) for k in (1, distance)] == [MS, distance * MS]
    assert motion.end_ns == distance * MS


def test_chapter_2_a_move_begins_and_ends_at_the_starting_speed() -> None:
    motion = move(0, 0, 10_000, Profile(1, 5000, 20, 10))
    assert motion.end_ns is not None
    assert motion.speed_at(0) == MILLI
    # a ns before the end: 1 step/s and at most what 10,000 steps/s/s make in 4 ns
    assert MILLI <= motion.speed_at(motion.end_ns - 1) <= MILLI + 1


def test_chapter_2_the_lowest_starting_speed_takes_a_second_per_step() -> None:
    motion = single_step(0, 0, 1, 1)
    assert motion.instant_of(1) == SECOND
    assert move(0, 0, 2, Profile(1, 1, 1, 1)).end_ns == 2 * SECOND


def test_chapter_4_hold_ends_on_a_whole_step() -> None:
    # at 1 s the example is at 600 + 0.8 * 5000 = 4600 and stops 1200 steps later
    held = stop(move(0, 0, 10_000, EXAMPLE), SECOND, 1000, 10, Shape.CONSTANT)
    assert (held.final_steps, held.end_ns) == (5800, 1400 * MS)
    # 0.1 ms later it is half a step further: the other half is run first, for 0.1 ms
    late = stop(move(0, 0, 10_000, EXAMPLE), SECOND + 100_000, 1000, 10, Shape.CONSTANT)
    assert (late.final_steps, late.end_ns) == (5801, 1400 * MS + 200_000)
    assert (late.ramp_at(SECOND + 199_999), late.ramp_at(SECOND + 200_000)) == (0, -1)


@pytest.mark.parametrize(("shape", "factor"), FACTORS)
@pytest.mark.parametrize("deceleration", [3, 6, 10, 11, 12, 15, 24, 30])
def test_chapter_4_hold_stops_where_the_arithmetic_says_whatever_the_rate(
    deceleration: int, shape: Shape, factor: Fraction
) -> None:
    # From a cruise on a whole step, the stop is on the first whole step at or after k * 12,000/d steps,
    # even where the time of the ramp, k * 4/d s, has thirds or elevenths of a ns.
    held = stop(move(0, 0, 100_000, EXAMPLE), SECOND, 1000, deceleration, shape)
    distance = factor * (5000**2 - 1000**2) / (2 * 1000 * deceleration)
    assert held.final_steps == 4600 - (-distance // 1)


def test_the_instant_of_a_step_that_an_s_curve_makes_on_a_round_one() -> None:
    # Vo 1040, Vs 5040, acceleration 20, triangular: 0.4 s and 1216 steps, jerk 20,000^2/4000 = 100,000.
    # After 0.06 s: 1040 * 0.06 + 100,000 * 0.06^3/6 = 62.4 + 3.6 = 66 steps.
    # 0.18 s before its end: 1216 - (5040 * 0.18 - 100,000 * 0.18^3/6) = 1216 - 907.2 + 97.2 = 406 steps.
    motion = run(0, 0, 1, Profile(1040, 5040, 20, 20, Shape.TRIANGULAR))
    assert (motion.instant_of(66), motion.instant_of(406), motion.instant_of(1216)) == (
        60 * MS,
        220 * MS,
        400 * MS,
    )


def test_chapter_4_registration_with_just_the_steps_that_it_takes_to_stop() -> None:
    # From 5000 to 1000 with 10: 1200 steps. At 1 s the example is on step 4600, 0.1 ms later half a step on:
    # the ramp then has half a step less to go, 1199.5 steps at 3000 on the average.
    running = run(0, 0, 1, EXAMPLE)
    ended = register(running, SECOND, 1200, 1000, 10, Shape.CONSTANT)
    assert (ended.final_steps, ended.end_ns, ended.ramp_at(SECOND)) == (5800, 1400 * MS, -1)
    under_way = register(running, SECOND + 100_000, 1200, 1000, 10, Shape.CONSTANT)
    assert under_way.final_steps == 5800
    assert under_way.end_ns == SECOND + 100_000 + -(-1199_500_000_000 // 3000)
    with pytest.raises(ValueError, match="1199 registration steps are too few to stop: must be 1200"):
        register(running, SECOND, 1199, 1000, 10, Shape.CONSTANT)


def test_chapter_4_registration_keeps_the_speed_until_the_deceleration() -> None:
    # 2000 steps from 4600 on: 800 at 5000 in 0.16 s, then 1200 in 0.4 s
    ended = register(run(0, 0, 1, EXAMPLE), SECOND, 2000, 1000, 10, Shape.CONSTANT)
    assert (ended.final_steps, ended.end_ns) == (6600, 1560 * MS)
    assert [ended.ramp_at(t * MS) for t in (1000, 1159, 1160, 1559, 1560)] == [0, 0, -1, -1, 0]


def test_chapter_4_blend_ramps_from_speed_to_speed() -> None:
    # 1000 -> 5000 with 20: 0.2 s, 600 steps; 1400 more at 5000: 0.28 s
    # 5000 -> 3000 with 10: 0.2 s, 800 steps; 1200 more at 3000: 0.4 s
    # 3000 -> 4000 with 5: 0.2 s, 700 steps; 300 more at 4000: 0.075 s; 4000 -> 1000 with 10: 0.3 s, 750
    legs = [(2000, 5000, 20), (2000, 3000, 10), (1750, 4000, 5)]
    motion = blend(0, 0, -1, 1000, [(*leg, Shape.CONSTANT) for leg in legs], 10, Shape.CONSTANT)
    joints_ms = [0, 200, 480, 680, 1080, 1280, 1355, 1655]
    assert [motion.position_at(t * MS) for t in joints_ms] == [
        0, -600, -2000, -2800, -4000, -4700, -5000, -5750,
    ]  # fmt: skip
    assert [motion.ramp_at(t * MS) for t in joints_ms] == [1, 0, -1, 0, 1, 0, -1, 0]
    assert [motion.speed_at(t * MS) // MILLI for t in joints_ms] == [
        1000, 5000, 5000, 3000, 3000, 4000, 4000, 0,
    ]  # fmt: skip
    assert motion.end_ns == 1655 * MS
