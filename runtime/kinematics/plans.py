"""Plans: every way a motion can begin, and every way it can be changed while it runs.

    move            a distance: up, constant, down; exact
    run             no distance: up, then constant without end
    single_step     one step
    stop            down from any point to the starting speed, onto a whole step
    change_speed    from any point to another speed, then constant without end
    register        so many steps more, the deceleration included

A change takes over at an instant: travel goes on from where it is, the speed
from what it is; inside an S-curve the shape starts anew.
"""

from __future__ import annotations

from math import isqrt

from .course import Course
from .motion import Motion
from .profile import Profile
from .shape import MILLI, PICO, Shape, stopping_distance

SLACK_NS = 4
"""By how many ns of motion a stop may miss a whole step and still end on it.

Ramps are up to 4 ns short of the manual's arithmetic, so travel is ahead of it by as little. Where
the arithmetic stops on a step, this stops on the same one and not on the next.
"""


def move(now_ns: int, origin: int, distance: int, profile: Profile) -> Motion:
    """Plan a move over a distance, ending exactly on it [chapter 2, Calculating Move Profiles].

    >>> example = move(0, 0, 10_000, Profile(1000, 5000, 20, 10))
    >>> example.end_ns, example.position_at(200_000_000), example.position_at(example.end_ns)
    (2240000000, 600, 10000)

    Args:
        now_ns: when it begins.
        origin: step count at which it begins.
        distance: in steps, its sign the direction, not 0.
        profile: speeds, rates, shape.

    Raises:
        ValueError: the distance is 0.
    """
    if distance == 0:
        raise ValueError("distance 0 is no move: allowed is any other number of steps")
    travel = abs(distance) * PICO
    base_msps, peak_msps = profile.base_msps, peak_speed(travel, profile)
    course = Course(now_ns)
    if profile.has_ramps:
        course.ramp(base_msps, peak_msps, profile.acceleration_spmss, profile.shape)
    course.arrive(travel, peak_msps, base_msps, profile.deceleration_spmss, profile.shape)
    return course.ended(1 if distance > 0 else -1, origin)


def peak_speed(travel: int, profile: Profile) -> int:
    """Return the speed that a move reaches, in 1e-3 step/s, rounded down.

    It is the programmed speed, or what a triangular profile reaches in the distance:

        Vp^2 = Vo^2 + 2*N / (k * (1/a + 1/d))

    from equating chapter 2's two distances with N [calculation note 2].

    Args:
        travel: the distance N in picosteps.
        profile: speeds, rates, shape.
    """
    if not profile.has_ramps:
        return profile.speed_msps
    up, down, shape = profile.acceleration_spmss, profile.deceleration_spmss, profile.shape
    gain = 2 * travel * up * down * shape.denominator // (1000 * (up + down) * shape.numerator)
    return min(profile.speed_msps, isqrt(profile.base_msps**2 + gain))


def run(now_ns: int, origin: int, direction: int, profile: Profile) -> Motion:
    """Plan a motion without end: accelerate, then constant speed [chapter 4, Manual Move].

    >>> endless = run(0, 0, -1, Profile(1000, 5000, 20, 10))
    >>> endless.position_at(1_200_000_000), endless.end_ns
    (-5600, None)

    Args:
        now_ns: when it begins.
        origin: step count at which it begins.
        direction: +1 or -1.
        profile: speeds, acceleration, shape; at or below the starting speed there is no ramp.

    Raises:
        ValueError: no such direction.
    """
    course = Course(now_ns)
    if profile.has_ramps:
        course.ramp(profile.base_msps, profile.speed_msps, profile.acceleration_spmss, profile.shape)
    return course.endless(direction, origin, profile.speed_msps)


def single_step(now_ns: int, origin: int, direction: int, speed_sps: int) -> Motion:
    """Plan one step, made one period of the speed from now [chapter 4, One Shot Manual Move].

    >>> single_step(0, 7, +1, 1000).instant_of(1)
    1000000

    Args:
        now_ns: when it begins.
        origin: step count at which it begins.
        direction: +1 or -1.
        speed_sps: in steps/s, from 1.

    Raises:
        ValueError: no such direction, or a speed below 1.
    """
    return move(now_ns, origin, direction, Profile(speed_sps, speed_sps, 0, 0))


def stop(motion: Motion, now_ns: int, start_sps: int, deceleration_spmss: int, shape: Shape) -> Motion:
    """Plan the controlled stop of a motion: less than one step on, then down to the starting speed.

    It ends on the first whole step that the deceleration allows (see `SLACK_NS`). Below the starting
    speed there is nothing to ramp, and it ends at once with the whole steps made.

    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> held = stop(running, 1_000_000_000, 1000, 10, Shape.CONSTANT)
    >>> held.final_steps, held.end_ns
    (5800, 1400000000)

    Args:
        motion: what is running; one that is over stays over.
        now_ns: when it takes over, not before the motion's `start_ns`.
        start_sps: starting speed in steps/s.
        deceleration_spmss: in steps/ms/s, from 1.
        shape: of the ramp.
    """
    course, speed_msps = _takeover(motion, now_ns)
    if speed_msps >= MILLI * start_sps:
        ramp = stopping_distance(speed_msps, start_sps, deceleration_spmss, shape)
        whole = -((SLACK_NS * speed_msps - course.travel - ramp) // PICO) * PICO
        if whole > course.travel:
            course.arrive(whole, speed_msps, MILLI * start_sps, deceleration_spmss, shape)
    return course.ended(motion.direction, motion.origin)


def change_speed(
    motion: Motion,
    now_ns: int,
    speed_sps: int,
    acceleration_spmss: int,
    deceleration_spmss: int,
    shape: Shape,
) -> Motion:
    """Plan a change to another speed, above or below the starting speed, then constant without end.

    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> slower = change_speed(running, 1_000_000_000, 500, 20, 10, Shape.CONSTANT)
    >>> slower.speed_at(1_450_000_000), slower.position_at(1_450_000_000)
    (500000, 5837)

    Args:
        motion: what is running.
        now_ns: when it takes over, not before the motion's `start_ns`.
        speed_sps: the new speed in steps/s, from 1.
        acceleration_spmss: used if the new speed is higher, from 1.
        deceleration_spmss: used if the new speed is lower, from 1.
        shape: of the ramp.

    Raises:
        ValueError: the motion is over, or the speed is below 1.
    """
    if speed_sps < 1:
        raise ValueError(f"speed {speed_sps} steps/s: allowed is 1 and more")
    course, from_msps = _takeover(motion, now_ns)
    if from_msps == 0:
        raise ValueError(
            f"the motion ended at {motion.end_ns} ns: at {now_ns} ns there is no speed to change"
        )
    to_msps = MILLI * speed_sps
    rate_spmss = acceleration_spmss if to_msps > from_msps else deceleration_spmss
    if to_msps != from_msps:
        course.ramp(from_msps, to_msps, rate_spmss, shape)
    return course.endless(motion.direction, motion.origin, to_msps)


def register(
    motion: Motion, now_ns: int, steps: int, start_sps: int, deceleration_spmss: int, shape: Shape
) -> Motion:
    """Plan the end of a registration move: so many whole steps more, the deceleration included.

    The present speed is kept until the deceleration is due [chapter 4, Registration Move]. Steps that
    are exactly the stopping distance suffice: if a step is under way, the ramp loses that fraction.

    >>> running = run(0, 0, +1, Profile(1000, 5000, 20, 10))
    >>> register(running, 1_000_000_000, 2000, 1000, 10, Shape.CONSTANT).final_steps
    6600

    Args:
        motion: what is running.
        now_ns: when it takes over, not before the motion's `start_ns`.
        steps: to be made from the whole steps made now, from 1.
        start_sps: starting speed in steps/s; below it there is no ramp.
        deceleration_spmss: in steps/ms/s, from 1.
        shape: of the ramp.

    Raises:
        ValueError: the steps are fewer than the deceleration needs, or the motion is over.
    """
    course, speed_msps = _takeover(motion, now_ns)
    if speed_msps == 0:
        raise ValueError(
            f"the motion ended at {motion.end_ns} ns: at {now_ns} ns there is nothing to register"
        )
    needed = stopping_distance(speed_msps, start_sps, deceleration_spmss, shape)
    if steps < 1 or steps * PICO < needed:
        least = max(1, -(-needed // PICO))
        raise ValueError(f"{steps} registration steps are too few to stop in: allowed is {least} and more")
    whole = (course.travel // PICO + steps) * PICO
    course.arrive(whole, speed_msps, min(speed_msps, MILLI * start_sps), deceleration_spmss, shape)
    return course.ended(motion.direction, motion.origin)


def _takeover(motion: Motion, now_ns: int) -> tuple[Course, int]:
    """Return a course that goes on where the motion is, and the motion's speed there."""
    return Course(now_ns, motion.travel_at(now_ns)), motion.speed_at(now_ns)
