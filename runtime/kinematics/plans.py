"""Plans: every start of a motion, and every change of a running motion.

    move            a distance: up, constant, down; exact
    run             no distance: up, then constant without end
    single_step     one step
    stop            down from any point to the starting speed, onto a whole step
    change_speed    from any point to another speed, then constant without end
    register        a number of additional steps, the deceleration included
    go_on           like `register`, but accelerates until the deceleration is due
    creep           down from any point to the starting speed, then at it to the motion's end

A change takes over at an instant: travel and speed continue from their present
values; inside an S-curve the shape restarts.

Two values are rounded, both down to 1e-9 step/s: the peak speed of a move too
short for its programmed speed, and the present speed where a change takes over
in the middle of a ramp. Everything else is exact by chapter 2.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from .course import Course
from .motion import Motion
from .profile import Profile
from .shape import FINE, NANO, PICO, AnyShape, Jerk, Rate, ramp_time, stopping_distance

FINEST = 10**6
"""Greatest denominator of the travel, in 1e-18 step, at which a change takes over.

S-curves give finer fractions, which would grow without limit in a motion that is changed repeatedly, so
they are rounded.
"""


def move(now_ns: int, origin: int, distance: int, profile: Profile) -> Motion:
    """Plan a move over a distance, ending exactly on it [chapter 2, Calculating Move Profiles].

    >>> example = move(0, 0, 10_000, Profile(1000, 5000, 20, 10))
    >>> example.end_ns, example.position_at(200_000_000), example.position_at(example.end_ns)
    (2240000000, 600, 10000)

    Args:
        distance: in steps, its sign the direction, not 0.

    Raises:
        ValueError: the distance is 0.
    """
    if distance == 0:
        raise ValueError("distance must not be 0")
    steps = abs(distance)
    base_nsps, peak_nsps = NANO * profile.base_sps, _peak_speed(steps, profile)
    course = Course(now_ns)
    if profile.has_ramps:
        course.ramp(base_nsps, peak_nsps, profile.acceleration_spmss, profile.shape)
    course.arrive(steps, peak_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    return course.ended(1 if distance > 0 else -1, origin)


def _peak_speed(steps: int, profile: Profile) -> int:
    """Return the speed that a move over a distance reaches, in 1e-9 step/s, rounded down."""
    if not profile.has_ramps:
        return NANO * profile.speed_sps
    return _peak_from(NANO * profile.base_sps, steps, profile)


def run(now_ns: int, origin: int, direction: int, profile: Profile) -> Motion:
    """Plan an endless motion: accelerate, then constant speed [chapter 4, Manual Move].

    >>> endless = run(0, 0, -1, Profile(1000, 5000, 20, 10))
    >>> endless.position_at(1_200_000_000), endless.end_ns
    (-5600, None)

    Raises:
        ValueError: an illegal direction.
    """
    course = Course(now_ns)
    if profile.has_ramps:
        base_nsps, speed_nsps = NANO * profile.base_sps, NANO * profile.speed_sps
        course.ramp(base_nsps, speed_nsps, profile.acceleration_spmss, profile.shape)
    return course.endless(direction, origin, NANO * profile.speed_sps)


def single_step(now_ns: int, origin: int, direction: int, speed_sps: int) -> Motion:
    """Plan one step, made one period of the speed from now [chapter 4, One Shot Manual Move].

    >>> single_step(0, 7, +1, 1000).instant_of(1)
    1000000

    Args:
        speed_sps: in steps/s, from 1.

    Raises:
        ValueError: an illegal direction, or a speed below 1.
    """
    _check_speed(speed_sps)
    course = Course(now_ns)
    course.cruise_to(1, NANO * speed_sps)
    return course.ended(direction, origin)


def stop(motion: Motion, now_ns: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape) -> Motion:
    """Plan the controlled stop of a motion: less than one step at its speed, then down to the starting speed.

    It ends on the first whole step that the deceleration allows. Below the starting
    speed no ramp is made, and it ends at once with the whole steps made.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> held = stop(running, 1_000_000_000, 1000, 10, Shape.CONSTANT)
    >>> held.final_steps, held.end_ns
    (5800, 1400000000)

    Args:
        motion: the present one; an ended motion stays ended.
        now_ns: when it takes over, not before the motion's `start_ns`.
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
    """Plan a change to another speed, above or below the starting speed, then constant without end.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> slower = change_speed(running, 1_000_000_000, 500, 20, 10, Shape.CONSTANT)
    >>> slower.speed_at(1_450_000_000), slower.position_at(1_450_000_000)
    (500000, 5837)

    Args:
        now_ns: when it takes over, not before the motion's `start_ns`.
        speed_sps: the new speed in steps/s, from 1.
        acceleration_spmss: used if the new speed is higher, above 0.
        deceleration_spmss: used if the new speed is lower, above 0.

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
    """Plan the end of a registration move after a number of further whole steps, the deceleration included.

    The present speed lasts until the deceleration is due [chapter 4, Registration Move]. Steps of exactly
    the stopping distance suffice: if a step is under way, the ramp loses that fraction.

    >>> from scanrack.runtime.kinematics import Shape
    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> register(running, 1_000_000_000, 2000, 1000, 10, Shape.CONSTANT).final_steps
    6600

    Args:
        now_ns: when it takes over, not before the motion's `start_ns`.
        steps: number of steps after the whole steps made so far, from 1.
        start_sps: starting speed in steps/s; below it no ramp is made.
        deceleration_spmss: in steps/ms/s, above 0.

    Raises:
        ValueError: the steps are fewer than the deceleration needs, or the motion is over.
    """
    course, speed_nsps = takeover(motion, now_ns)
    if speed_nsps == 0:
        raise ValueError(f"nothing to register at {now_ns} ns: the motion ended at {motion.end_ns} ns")
    stop_pico = stopping_distance(motion.speed_at(now_ns), start_sps, deceleration_spmss, shape)
    if steps < 1 or steps * PICO < stop_pico:
        steps_least = max(1, -(-stop_pico // PICO))
        raise ValueError(f"{steps} registration steps are too few to stop in: must be {steps_least} or more")
    base_nsps = min(speed_nsps, NANO * start_sps)
    course.arrive(motion.steps_at(now_ns) + steps, speed_nsps, base_nsps, deceleration_spmss, shape)
    return course.ended(motion.direction, motion.origin)


def go_on(motion: Motion, now_ns: int, steps: int, profile: Profile) -> Motion:
    """Plan the end of a motion as a move over a number of further whole steps, from its present speed.

    It accelerates to the programmed speed, or as far as the steps allow, and ends exactly.

    >>> slewing = run(0, 0, +1, Profile(500, 2000, 1, 1))
    >>> ending = go_on(slewing, 0, 4000, Profile(500, 2000, 1, 1))
    >>> ending.end_ns == move(0, 0, 4000, Profile(500, 2000, 1, 1)).end_ns
    True

    Args:
        now_ns: when it takes over, not before the motion's `start_ns`.
        steps: number of steps after the whole steps made so far, from 1.
        profile: starting and programmed speed, neither below nor above the motion's; rates, shape.

    Raises:
        ValueError: the steps are fewer than the deceleration needs, or the motion is over.
    """
    course, speed_nsps = takeover(motion, now_ns)
    if speed_nsps == 0:
        raise ValueError(f"nothing to continue from at {now_ns} ns: the motion ended at {motion.end_ns} ns")
    target, base_nsps = motion.steps_at(now_ns) + steps, NANO * profile.base_sps
    stopping_steps = course.steps_to_stop(speed_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    if target < stopping_steps:
        raise ValueError(
            f"{steps} steps are too few to stop in: must be {stopping_steps - target + steps} or more"
        )
    peak_nsps = max(speed_nsps, _peak_from(speed_nsps, course.steps_left(target), profile))
    course.ramp(speed_nsps, peak_nsps, profile.acceleration_spmss, profile.shape)
    course.arrive(target, peak_nsps, base_nsps, profile.deceleration_spmss, profile.shape)
    return course.ended(motion.direction, motion.origin)


def _peak_from(speed_nsps: int, steps: Rate, profile: Profile) -> int:
    """Return the peak speed on the way from a speed v to rest, in 1e-9 step/s, rounded down.

    It is the programmed speed, or the speed that a triangular profile reaches in the distance N:

        Vp^2 = (2*N*a*d/k + d*v^2 + a*Vo^2) / (a + d)

    from equating chapter 2's two distances with N [calculation note 2].
    """
    shape = profile.shape
    if isinstance(shape, Jerk):
        return _peak_with_jerk(speed_nsps, Fraction(steps), profile)
    up_rate, down_rate = 1000 * profile.acceleration_spmss, 1000 * profile.deceleration_spmss
    travel_made = 2 * steps * up_rate * down_rate * NANO**2 * shape.denominator
    speed_squares = (down_rate * speed_nsps**2 + up_rate * (NANO * profile.base_sps) ** 2) * shape.numerator
    return min(
        NANO * profile.speed_sps,
        isqrt(int((travel_made + speed_squares) // ((up_rate + down_rate) * shape.numerator))),
    )


def _peak_with_jerk(from_nsps: int, steps: Fraction, profile: Profile) -> int:
    """Return the peak speed on the way from a speed to rest, in 1e-9 step/s, rounded down.

    Both ramps grow with the peak, so the greatest one whose ramps fit is found by halving.
    """
    base_nsps, room = NANO * profile.base_sps, steps * PICO * FINE
    rates = profile.acceleration_spmss, profile.deceleration_spmss

    def fits(peak_nsps: int) -> bool:
        end_speeds = zip((from_nsps, base_nsps), rates, strict=True)
        return room >= sum(
            ramp_time(abs(peak_nsps - end), rate, profile.shape) * (peak_nsps + end) / 2
            for end, rate in end_speeds
        )

    low_nsps, high_nsps = max(from_nsps, base_nsps), NANO * profile.speed_sps
    if low_nsps >= high_nsps or fits(high_nsps):
        return high_nsps
    while high_nsps - low_nsps > 1:
        middle_nsps = (low_nsps + high_nsps) // 2
        low_nsps, high_nsps = (middle_nsps, high_nsps) if fits(middle_nsps) else (low_nsps, middle_nsps)
    return low_nsps


def creep(motion: Motion, now_ns: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape) -> Motion:
    """Plan the rest of a motion at the starting speed: down to it now, then on to the same end.

    A motion already on its last ramp stays as it is.

    >>> from scanrack.runtime.kinematics import Shape
    >>> slow = creep(move(0, 0, 4000, Profile(500, 2000, 1, 1)), 1_000_000_000, 500, 1, Shape.CONSTANT)
    >>> slow.position_at(2_000_000_000), slow.final_steps, slow.end_ns  # 1000 up, 1000 down, 2000 at 500/s
    (2000, 4000, 6000000000)

    Args:
        motion: the present one, with an end.
        now_ns: when it takes over, not before the motion's `start_ns`.
        start_sps: starting speed in steps/s, not above the motion's.
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
    """Return a course that continues a motion at `now_ns`, and its speed there in 1e-9 step/s."""
    segment = motion.segment_at(now_ns)
    travel = segment.exact_travel_at(now_ns) * FINE
    if travel.denominator > FINEST:
        travel = Fraction(travel // 1)
    return Course(now_ns, travel), int(segment.exact_speed_at(now_ns) * FINE)
