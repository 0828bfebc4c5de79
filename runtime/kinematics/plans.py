"""Functions that plan every start of a motion, and every change to a motion in progress.

    move            a distance: up, constant, down; exact
    run             no distance: up, then constant forever
    single_step     one step
    stop            down from any point to the starting speed, onto a whole step
    change_speed    from any point to another speed, then constant forever
    register        a number of additional steps, deceleration included
    go_on           like `register`, but accelerates until the deceleration is due
    creep           down from any point to the starting speed, then at that speed to the motion's end

A change takes effect at an instant: travel and speed continue from their current values, and an S-curve
starts over.

Two values are rounded down to 1e-9 step/s: the peak speed of a move that is too short for its programmed
speed, and the current speed at a change in the middle of a ramp. Everything else follows chapter 2 exactly.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from .course import Course
from .motion import Motion
from .profile import Profile
from .shape import FINE, NANO, PICO, AnyShape, Jerk, Rate, ramp_time, stopping_distance

FINEST = 10**6
"""Largest denominator of the travel at a change, where travel is in units of 1e-18 step.

Finer fractions are rounded, since their denominators would grow without limit in a motion with many changes
during S-curves.
"""


def move(now_ns: int, origin: int, distance: int, profile: Profile) -> Motion:
    """Plan a move over an exact distance [chapter 2, Calculating Move Profiles].

    >>> example = move(0, 0, 10_000, Profile(1000, 5000, 20, 10))
    >>> example.end_ns, example.position_at(200_000_000), example.position_at(example.end_ns)
    (2240000000, 600, 10000)

    Args:
        distance: in steps, not 0; its sign is the direction.

    Raises:
        ValueError: the distance is 0.
    """
    if distance == 0:
        raise ValueError("distance must not be 0")
    steps = abs(distance)
    base_nsps, peak_nsps = NANO * profile.base_sps, NANO * profile.speed_sps
    course = Course(now_ns)
    if profile.has_ramps:
        peak_nsps = _peak_from(base_nsps, steps, profile)
        course.ramp(base_nsps, peak_nsps, profile.acceleration_spmss, profile.shape)
    course.arrive(steps, peak_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    return course.ended(1 if distance > 0 else -1, origin)


def run(now_ns: int, origin: int, direction: int, profile: Profile) -> Motion:
    """Plan an endless motion: acceleration, then constant speed [chapter 4, Manual Move].

    >>> endless = run(0, 0, -1, Profile(1000, 5000, 20, 10))
    >>> endless.position_at(1_200_000_000), endless.end_ns
    (-5600, None)

    Raises:
        ValueError: the direction is invalid.
    """
    course = Course(now_ns)
    if profile.has_ramps:
        base_nsps, speed_nsps = NANO * profile.base_sps, NANO * profile.speed_sps
        course.ramp(base_nsps, speed_nsps, profile.acceleration_spmss, profile.shape)
    return course.endless(direction, origin, NANO * profile.speed_sps)


def single_step(now_ns: int, origin: int, direction: int, speed_sps: int) -> Motion:
    """Plan a single step, made after one step period at the given speed [chapter 4, One Shot Manual Move].

    >>> single_step(0, 7, +1, 1000).instant_of(1)
    1000000

    Args:
        speed_sps: in steps/s, from 1.

    Raises:
        ValueError: the direction is invalid, or the speed is below 1.
    """
    _check_speed(speed_sps)
    course = Course(now_ns)
    course.cruise_to(1, NANO * speed_sps)
    return course.ended(direction, origin)


def stop(motion: Motion, now_ns: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape) -> Motion:
    """Plan a controlled stop: less than one step at the current speed, then a ramp to starting speed.

    The stop ends on the first whole step that the deceleration allows. Below the starting speed the stop has
    no ramp, and ends immediately with the whole steps made so far.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> held = stop(running, 1_000_000_000, 1000, 10, Shape.CONSTANT)
    >>> held.final_steps, held.end_ns
    (5800, 1400000000)

    Args:
        motion: the current motion; a motion that has ended stays ended.
        now_ns: start of the stop, not before the motion's `start_ns`.
        start_sps: starting speed in steps/s.
        deceleration_spmss: in steps/ms/s, above 0.
    """
    course, speed_nsps = takeover(motion, now_ns)
    base_nsps = NANO * start_sps
    if speed_nsps >= base_nsps:
        steps = course.steps_to_stop(speed_nsps, base_nsps, deceleration_spmss, shape)
        course.arrive(steps, speed_nsps, base_nsps, deceleration_spmss, shape)
    return course.ended(motion.direction, motion.origin)


def change_speed(
    motion: Motion,
    now_ns: int,
    speed_sps: int,
    acceleration_spmss: Rate,
    deceleration_spmss: Rate,
    shape: AnyShape,
) -> Motion:
    """Plan a change to another speed, above or below the starting speed, followed by constant speed.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> slower = change_speed(running, 1_000_000_000, 500, 20, 10, Shape.CONSTANT)
    >>> slower.speed_at(1_450_000_000), slower.position_at(1_450_000_000)
    (500000, 5837)

    Args:
        now_ns: start of the change, not before the motion's `start_ns`.
        speed_sps: the new speed in steps/s, from 1.
        acceleration_spmss: above 0; used if the new speed is higher.
        deceleration_spmss: above 0; used if the new speed is lower.

    Raises:
        ValueError: the motion is over, or the speed is below 1.
    """
    _check_speed(speed_sps)
    course, from_nsps = takeover(motion, now_ns)
    if from_nsps == 0:
        raise ValueError(f"no speed to change at {now_ns} ns: the motion ended at {motion.end_ns} ns")
    to_nsps = NANO * speed_sps
    if to_nsps != from_nsps:
        rate_spmss = acceleration_spmss if to_nsps > from_nsps else deceleration_spmss
        course.ramp(from_nsps, to_nsps, rate_spmss, shape)
    return course.endless(motion.direction, motion.origin, to_nsps)


def register(
    motion: Motion, now_ns: int, steps: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape
) -> Motion:
    """Plan the end of a registration move after a number of further whole steps, deceleration included.

    The motion keeps its speed until it must decelerate [chapter 4, Registration Move]. The rounded-up
    stopping distance is enough, since the ramp is shortened by the fraction of a step already made.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> register(running, 1_000_000_000, 2000, 1000, 10, Shape.CONSTANT).final_steps
    6600

    Args:
        now_ns: instant of the mark, not before the motion's `start_ns`.
        steps: number of steps after the whole steps made so far, from 1.
        start_sps: starting speed in steps/s; below it the stop has no ramp.
        deceleration_spmss: in steps/ms/s, above 0.

    Raises:
        ValueError: the steps are fewer than the deceleration needs, or the motion is over.
    """
    course, speed_nsps = takeover(motion, now_ns)
    if speed_nsps == 0:
        raise ValueError(f"nothing to register at {now_ns} ns: the motion ended at {motion.end_ns} ns")
    stop_pico = stopping_distance(motion.speed_at(now_ns), start_sps, deceleration_spmss, shape)
    if steps < 1 or steps * PICO < stop_pico:
        steps_needed = max(1, -(-stop_pico // PICO))
        raise ValueError(f"{steps} registration steps are too few to stop: must be {steps_needed} or more")
    base_nsps = min(speed_nsps, NANO * start_sps)
    course.arrive(motion.steps_at(now_ns) + steps, speed_nsps, base_nsps, deceleration_spmss, shape)
    return course.ended(motion.direction, motion.origin)


def go_on(motion: Motion, now_ns: int, steps: int, profile: Profile) -> Motion:
    """Plan the end of a motion as a move over a number of further whole steps, from its current speed.

    The motion accelerates to the programmed speed, or as far as the steps allow.

    >>> slewing = run(0, 0, +1, Profile(500, 2000, 1, 1))
    >>> ending = go_on(slewing, 0, 4000, Profile(500, 2000, 1, 1))
    >>> ending.end_ns == move(0, 0, 4000, Profile(500, 2000, 1, 1)).end_ns
    True

    Args:
        now_ns: start of the move, not before the motion's `start_ns`.
        steps: number of steps after the whole steps made so far, from 1.
        profile: has the same starting and programmed speeds as the motion.

    Raises:
        ValueError: the steps are fewer than the deceleration needs, or the motion is over.
    """
    course, speed_nsps = takeover(motion, now_ns)
    if speed_nsps == 0:
        raise ValueError(f"no motion to continue at {now_ns} ns: the motion ended at {motion.end_ns} ns")
    target, base_nsps = motion.steps_at(now_ns) + steps, NANO * profile.base_sps
    stopping_steps = course.steps_to_stop(speed_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    if target < stopping_steps:
        steps_needed = stopping_steps - target + steps
        raise ValueError(f"{steps} steps are too few to stop: must be {steps_needed} or more")
    peak_nsps = max(speed_nsps, _peak_from(speed_nsps, course.steps_left(target), profile))
    course.ramp(speed_nsps, peak_nsps, profile.acceleration_spmss, profile.shape)
    course.arrive(target, peak_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    return course.ended(motion.direction, motion.origin)


def _peak_from(speed_nsps: int, steps: Rate, profile: Profile) -> int:
    """Return the peak speed, in 1e-9 step/s rounded down, of a move of N steps from a speed v to rest.

    The peak is the programmed speed, or the speed at which chapter 2's two ramps add up to N [calculation
    note 2]:

        Vp^2 = (2*N*a*d/k + d*v^2 + a*Vo^2) / (a + d)
    """
    shape = profile.shape
    if isinstance(shape, Jerk):
        return _peak_with_jerk(speed_nsps, Fraction(steps), profile)
    up_rate, down_rate = 1000 * profile.acceleration_spmss, 1000 * profile.deceleration_spmss
    distance_term = 2 * steps * up_rate * down_rate * NANO**2 * shape.denominator
    speed_terms = (down_rate * speed_nsps**2 + up_rate * (NANO * profile.base_sps) ** 2) * shape.numerator
    peak_square = (distance_term + speed_terms) // ((up_rate + down_rate) * shape.numerator)
    return min(NANO * profile.speed_sps, isqrt(int(peak_square)))


def _peak_with_jerk(from_nsps: int, steps: Fraction, profile: Profile) -> int:
    """Return the peak speed, in 1e-9 step/s rounded down, of a move from a speed to rest.

    Both ramps get longer as the peak rises, so bisection finds the highest peak whose ramps fit into the
    steps.
    """
    base_nsps, distance = NANO * profile.base_sps, steps * PICO * FINE

    def length(end_nsps: int, peak_nsps: int, rate: Rate) -> Fraction:
        return ramp_time(abs(peak_nsps - end_nsps), rate, profile.shape) * (peak_nsps + end_nsps) / 2

    def ramps_fit(peak_nsps: int) -> bool:
        ramp_up = length(from_nsps, peak_nsps, profile.acceleration_spmss)
        return ramp_up + length(base_nsps, peak_nsps, profile.deceleration_spmss) <= distance

    low_nsps, high_nsps = max(from_nsps, base_nsps), NANO * profile.speed_sps
    if low_nsps >= high_nsps or ramps_fit(high_nsps):
        return high_nsps
    while high_nsps - low_nsps > 1:
        middle_nsps = (low_nsps + high_nsps) // 2
        if ramps_fit(middle_nsps):
            low_nsps = middle_nsps
        else:
            high_nsps = middle_nsps
    return low_nsps


def creep(motion: Motion, now_ns: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape) -> Motion:
    """Plan the rest of a motion at the starting speed: a ramp down, then constant speed to the same end.

    A motion on its last ramp does not change.

    >>> from scanrack.runtime.kinematics import Shape
    >>> slow = creep(move(0, 0, 4000, Profile(500, 2000, 1, 1)), 1_000_000_000, 500, 1, Shape.CONSTANT)
    >>> slow.position_at(2_000_000_000), slow.final_steps, slow.end_ns  # 1000 up, 1000 down, 2000 at 500/s
    (2000, 4000, 6000000000)

    Args:
        motion: the current motion, which must have an end.
        now_ns: start of the ramp, not before the motion's `start_ns`.
        start_sps: starting speed in steps/s, not above the motion's starting speed.
        deceleration_spmss: in steps/ms/s, above 0.

    Raises:
        ValueError: the motion has no end.
    """
    if motion.final_steps is None:
        raise ValueError("an endless motion has no end to creep to")
    course, speed_nsps = takeover(motion, now_ns)
    if speed_nsps == 0:
        return motion
    base_nsps = min(speed_nsps, NANO * start_sps)
    if course.steps_to_stop(speed_nsps, base_nsps, deceleration_spmss, shape) > motion.final_steps:
        return motion
    course.ramp(speed_nsps, base_nsps, deceleration_spmss, shape)
    course.cruise_to(motion.final_steps, base_nsps)
    return course.ended(motion.direction, motion.origin)


def _check_speed(speed_sps: int) -> None:
    if speed_sps < 1:
        raise ValueError(f"speed {speed_sps} steps/s: must be 1 or more")


def takeover(motion: Motion, now_ns: int) -> tuple[Course, int]:
    """Return a course that continues a motion from `now_ns`, and the speed at `now_ns` in 1e-9 step/s."""
    segment = motion.segment_at(now_ns)
    travel = segment.exact_travel_at(now_ns) * FINE
    if travel.denominator > FINEST:
        travel = Fraction(travel // 1)
    return Course(now_ns, travel), int(segment.exact_speed_at(now_ns) * FINE)
