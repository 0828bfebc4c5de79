"""Profiles of AMCI's networked drives: worked examples of the SMD manual, p. 44 to 51, and moves in time."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import sqrt

import pytest
from drive_unit import ready
from hypothesis import given
from hypothesis import strategies as st
from scanrack.runtime.kinematics import (
    NANO,
    PICO,
    Jerk,
    Profile,
    Shape,
    move,
    ramp_distance,
    ramp_time,
    register,
    run,
    stop,
)
from scanrack.runtime.kinematics.course import PHASES, phases_of

pytestmark = pytest.mark.rules


def seconds(change: float, rate: float, jerk: int) -> float:
    """Return the time of a speed change by the formulas of SMD p. 46."""
    a, j = 1000 * rate, 10 * jerk * rate
    if jerk == 0:
        return change / a
    return 2 * sqrt(change / j) if sqrt(change * j) <= a else change / a + a / j


def top_speed(distance: float, start: float, speed: float, rates: tuple[int, int], jerk: int) -> float:
    """Return the speed that a move reaches: the programmed one, or where both ramps fill the distance."""

    def ramps(top: float) -> float:
        return sum(seconds(top - start, rate, jerk) * (start + top) / 2 for rate in rates)

    low, high = start, speed
    for _ in range(200):
        middle = (low + high) / 2
        low, high = (middle, high) if ramps(middle) <= distance else (low, middle)
    return high if ramps(speed) > distance else speed


def duration(distance: float, start: float, speed: float, rates: tuple[int, int], jerk: int) -> float:
    top = top_speed(distance, start, speed, rates, jerk)
    ramps = sum(seconds(top - start, rate, jerk) * (start + top) / 2 for rate in rates)
    return sum(seconds(top - start, rate, jerk) for rate in rates) + (distance - ramps) / top


class TestWorkedExamples:
    def test_smd_p44_constant_acceleration(self):
        up, down = (ramp_time(NANO * (100_000 - 141), rate, Shape.CONSTANT) / 10**9 for rate in (20, 25))
        assert (round(float(up), 3), round(float(down), 3)) == (4.993, 3.994)
        lengths = [
            float(ramp_distance(141_000, 100_000_000, rate, Shape.CONSTANT) / PICO) for rate in (20, 25)
        ]
        assert [round(length) for length in lengths] == [250_000, 200_000]

    def test_smd_p51_trapezoidal(self):
        time_ns, rising = Jerk(400).course(30_000 * NANO, 58)
        assert float(time_ns) / 1e9 == pytest.approx(0.51724 + 0.25, abs=5e-6)
        assert float(1 - 2 * rising) == pytest.approx(0.348, abs=5e-4)

    def test_smd_p46_rise_is_100_over_j_seconds_for_any_rate(self):
        for rate in (1, 58, 5000):
            time_ns, rising = Jerk(400).course(10**7 * NANO, rate)
            assert time_ns * rising == Fraction(10**11, 400)

    def test_smd_p46_triangular_is_twice_the_root(self):
        time_ns, rising = Jerk(20).course(9_000 * NANO, 50)
        assert rising == Fraction(1, 2)
        assert float(time_ns) / 1e9 == pytest.approx(2 * sqrt(9_000 / (20 * 50_000 / 100)), abs=3e-9)

    def test_smd_p46_both_formulas_meet_where_the_rate_is_just_reached(self):
        # sqrt(dV * j) = a: dV = a / (J / 100)
        assert Jerk(50).course(100_000 * NANO, 50)[0] == 2 * Fraction(10**11, 50)


def test_the_phases_of_a_quarter_and_a_half_are_those_of_the_fixed_shapes():
    for shape, rising in ((Shape.TRAPEZOIDAL, Fraction(1, 4)), (Shape.TRIANGULAR, Fraction(1, 2))):
        found = phases_of(rising)
        assert [[Fraction(part, found[-1][1]) for part in phase] for phase in found] == [
            [Fraction(part, 72) for part in phase] for phase in PHASES[shape]
        ]


jerks = st.sampled_from([1, 7, 20, 100, 371, 400, 5000])
rates = st.tuples(st.sampled_from([1, 10, 37, 58, 500, 5000]), st.sampled_from([1, 10, 25, 58, 5000]))
speeds = st.sampled_from([(1, 2), (50, 10_000), (1000, 5000), (1000, 31_000), (141, 100_000), (1, 2_999_999)])


@given(distance=st.integers(1, 300_000), ends=speeds, rates=rates, jerk=jerks)
def test_r13_a_move_ends_exactly_and_lasts_as_the_formulas_say(distance, ends, rates, jerk):
    plan = move(0, 0, distance, Profile(ends[0], ends[1], rates[0], rates[1], Jerk(jerk)))
    assert plan.end_ns is not None
    assert plan.position_at(plan.end_ns) == distance
    assert plan.position_at(plan.end_ns - 1) < distance
    assert plan.end_ns / 1e9 == pytest.approx(
        duration(distance, ends[0], ends[1], rates, jerk), rel=1e-6, abs=1e-8
    )


@given(distance=st.integers(1, 300_000), ends=speeds, rates=rates, jerk=jerks)
def test_travel_and_speed_have_no_jump(distance, ends, rates, jerk):
    plan = move(0, 0, distance, Profile(ends[0], ends[1], rates[0], rates[1], Jerk(jerk)))
    for before, after in pairwise(plan.segments):
        at = after.start_ns
        steepest = 1000 * max(rates) * 1000 / 10**9  # 1e-3 step/s in a ns: segments begin at whole ns
        assert abs(before.exact_travel_at(at) - after.exact_travel_at(at)) <= steepest + 1
        assert abs(before.exact_speed_at(at) - after.exact_speed_at(at)) <= 3 * steepest + 1
    assert all(left.travel_at(left.until_ns) >= left.travel_at(left.start_ns) for left in plan.segments)


@given(at_ms=st.integers(1, 6000), ends=speeds, rates=rates, jerk=jerks)
def test_a_stop_ends_on_a_step_with_the_ramp_of_its_speed(at_ms, ends, rates, jerk):
    running = run(0, 0, 1, Profile(ends[0], ends[1], rates[0], rates[1], Jerk(jerk)))
    at_ns = 1_000_000 * at_ms
    held = stop(running, at_ns, ends[0], rates[1], Jerk(jerk))
    speed = float(running.segment_at(at_ns).exact_speed_at(at_ns)) / 1000
    ramp = seconds(speed - ends[0], rates[1], jerk) * (speed + ends[0]) / 2
    assert held.final_steps == pytest.approx(running.travel_at(at_ns) / PICO + ramp, abs=1.01)
    assert held.end_ns is not None
    assert held.position_at(held.end_ns) == held.final_steps


def test_a_registration_distance_is_made_exactly():
    running = run(0, 0, 1, Profile(1000, 10_000, 50, 37, Jerk(371)))
    at = running.steps_at(10**9)
    assert register(running, 10**9, 5000, 1000, 37, Jerk(371)).final_steps == at + 5000


class TestMovesInTime:
    @pytest.mark.parametrize(
        ("distance", "speed", "rates", "jerk"),
        [
            pytest.param(10_000, 5_000, (20, 10), 0, id="SMD p. 44"),
            pytest.param(-1_500, 5_000, (20, 10), 0, id="SMD p. 44, short"),
            pytest.param(20_000, 10_000, (50, 50), 400, id="SMD p. 51, trapezoidal"),
            pytest.param(20_000, 10_000, (50, 50), 20, id="SMD p. 46, triangular"),
            pytest.param(-3_000, 10_000, (50, 50), 200, id="SMD p. 46, short"),
            pytest.param(60_000, 31_000, (58, 25), 371, id="SMD p. 51, unequal rates"),
        ],
    )
    def test_a_relative_move(self, distance, speed, rates, jerk):
        unit = ready()
        sign = -1 if distance < 0 else 1
        words = (distance // 1000, 0) if distance % 1000 == 0 else (sign, distance - 1000 * sign)
        unit.command(2, words, divmod(speed, 1000), rates, jerk=jerk)
        ends_ms = 1000 * duration(abs(distance), 1000, speed, rates, jerk)
        unit.wait(ends_ms - 0.1)
        assert ("MOVING_CW" if distance > 0 else "MOVING_CCW") in unit.status
        assert not unit.status & {"MOVE_COMPLETE", "STOPPED"}
        unit.wait(0.2)
        assert unit.status >= {"MOVE_COMPLETE", "STOPPED"}
        assert unit.position == distance
