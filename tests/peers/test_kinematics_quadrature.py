"""Motions beside a velocity profile that is integrated numerically.

The peer shares no formula with the project: rates are drawn as functions of the ramp's time (flat,
a triangle, a trapezoid flat for half of it), their time follows from the speed that they must make,
the peak of a short move is searched for, and scipy does the integrals.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scanrack.runtime.kinematics import MILLI, PICO, Motion, Profile, Shape, change_speed, move, run, stop

integrate = pytest.importorskip("scipy.integrate", reason="the quadrature needs scipy")
optimize = pytest.importorskip("scipy.optimize", reason="the search for a peak speed needs scipy")

Array = NDArray[np.float64]
TOLERANCE_STEPS = 1e-3
KNOTS = {
    Shape.CONSTANT: ((0.0, 1.0), (1.0, 1.0)),
    Shape.TRIANGULAR: ((0.0, 0.5, 1.0), (0.0, 1.0, 0.0)),
    Shape.TRAPEZOIDAL: ((0.0, 0.25, 0.75, 1.0), (0.0, 1.0, 1.0, 0.0)),
}
PART = np.linspace(0.0, 1.0, 33)  # an even number of intervals between any two knots

speeds = st.integers(1, 1_000_000)
rates = st.integers(1, 2000)
shapes = st.sampled_from(Shape)


@dataclass
class Course:
    """Velocity over time and its integral, in s, steps/s and steps."""

    time: Array
    speed: Array
    position: Array

    @classmethod
    def of(cls, *stretches: tuple[Array, Array]) -> Course:
        """Return the stretches one after the other, integrated; each counts time from its own start."""
        time, speed, position = (np.zeros(1) for _ in range(3))
        for own_time, own_speed in stretches:
            if own_time[-1] == 0.0:
                continue
            made = integrate.cumulative_simpson(own_speed, x=own_time, initial=0)
            time = np.append(time, time[-1] + own_time)
            speed = np.append(speed, own_speed)
            position = np.append(position, position[-1] + made)
        return cls(time, speed, position)


def ramp(from_sps: float, to_sps: float, rate_spmss: float | Fraction, shape: Shape) -> tuple[Array, Array]:
    """Return time and speed of a speed change with a peak rate."""
    rate = float(rate_spmss) * 1000 * np.interp(PART, *KNOTS[shape]) * np.sign(to_sps - from_sps)
    gained = integrate.cumulative_trapezoid(rate, PART, initial=0)
    seconds = (to_sps - from_sps) / gained[-1] if from_sps != to_sps else 0.0
    return seconds * PART, from_sps + seconds * gained


def cruise(speed_sps: float, steps: float) -> tuple[Array, Array]:
    """Return time and speed of constant speed over some steps."""
    return steps / speed_sps * PART, np.full_like(PART, speed_sps)


def length(*stretches: tuple[Array, Array]) -> float:
    """Return the steps made in some stretches."""
    return float(sum(integrate.simpson(speed, dx=time[1]) for time, speed in stretches))


def assert_follows(motion: Motion, course: Course, origin: float = 0.0) -> None:
    """Assert that a motion is where the course is, at every point of the course's grid."""
    for seconds, speed, position in zip(course.time, course.speed, course.position, strict=True):
        at_ns = round(seconds * 1e9)
        expected = origin + position + speed * (at_ns * 1e-9 - seconds)
        travel = motion.travel_at(motion.start_ns + at_ns) / PICO
        assert travel == pytest.approx(expected, rel=0, abs=TOLERANCE_STEPS)


def state(motion: Motion, t_ns: int) -> tuple[float, float]:
    """Return speed in steps/s and travel in steps; the motion's own word, which `test_a_run` checks."""
    segment = motion.segment_at(t_ns)
    return float(segment.exact_speed_at(t_ns) / MILLI), float(segment.exact_travel_at(t_ns) / PICO)


def peer_of_move(distance: int, profile: Profile) -> Course:
    """Return the course of a move, its peak searched for where the distance is short."""
    shape = profile.shape
    assert isinstance(shape, Shape)

    def ramps(peak: float) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        up = ramp(profile.start_sps, peak, profile.acceleration_spmss, shape)
        return up, ramp(peak, profile.start_sps, profile.deceleration_spmss, shape)

    peak = float(profile.speed_sps)
    if length(*ramps(peak)) > distance:
        peak = optimize.brentq(
            lambda peak: length(*ramps(peak)) - distance, profile.start_sps, peak, xtol=1e-9, rtol=1e-14
        )
    up, down = ramps(peak)
    return Course.of(up, cruise(peak, max(0.0, distance - length(up, down))), down)


@given(st.integers(1, 8_388_608), speeds, speeds, rates, rates, shapes)
def test_a_move(distance: int, start: int, more: int, up: int, down: int, shape: Shape) -> None:
    profile = Profile(start, start + more, up, down, shape)
    motion, course = move(0, 0, distance, profile), peer_of_move(distance, profile)
    assert_follows(motion, course)
    assert motion.end_ns == pytest.approx(course.time[-1] * 1e9, rel=1e-12, abs=10)


@given(speeds, speeds, rates, shapes, st.integers(0, 400))
def test_a_run(start: int, more: int, rate: int, shape: Shape, cruise_steps: int) -> None:
    motion = run(0, 0, 1, Profile(start, start + more, rate, rate, shape))
    up = ramp(start, start + more, rate, shape)
    assert_follows(motion, Course.of(up, cruise(start + more, cruise_steps)))


@given(speeds, speeds, rates, rates, shapes, shapes, st.floats(0, 1.2))
def test_a_stop_from_any_point(
    start: int, more: int, rate: int, stop_rate: int, shape: Shape, stop_shape: Shape, part: float
) -> None:
    motion = run(0, 0, 1, Profile(start, start + more, rate, rate, shape))
    now_ns = int(part * ramp(start, start + more, rate, shape)[0][-1] * 1e9)
    held = stop(motion, now_ns, start, stop_rate, stop_shape)
    speed, position = state(motion, now_ns)
    down = ramp(speed, start, stop_rate, stop_shape)
    assert held.final_steps is not None
    left = held.final_steps - position - length(down)
    assert -TOLERANCE_STEPS < left < 1 + TOLERANCE_STEPS
    assert_follows(held, Course.of(cruise(speed, max(left, 0.0)), down), origin=position)


@given(speeds, speeds, rates, rates, shapes, shapes, st.floats(0, 1.2), speeds)
def test_a_speed_change_from_any_point(
    start: int, more: int, rate: int, new_rate: int, shape: Shape, new_shape: Shape, part: float, new: int
) -> None:
    motion = run(0, 0, 1, Profile(start, start + more, rate, rate, shape))
    now_ns = int(part * ramp(start, start + more, rate, shape)[0][-1] * 1e9)
    changed = change_speed(motion, now_ns, new, new_rate, new_rate, new_shape)
    speed, position = state(motion, now_ns)
    course = Course.of(ramp(speed, new, new_rate, new_shape), cruise(new, 1000))
    assert_follows(changed, course, origin=position)
