"""Ramps of a PMC006x3s [4.3.3].

    speed  0 | start | S-curve up | maximum | S-curve down | stop | 0

The S-curve is a raised cosine that takes the same time and distance as a constant-rate ramp at the
coefficient's acceleration (interpretation: the manual draws a curve without a formula). It is computed as
three parabolas of speed, so that steps occur at exact instants. The parabolas equal the cosine at 0, 1/3,
1/2, 2/3 and 1 of its time and differ from it by at most 0.6 % of the speed change.

If the ramps do not fit into the steps, both are shortened, and thus made steeper, in the same ratio [4.3.3:
"the actual acceleration and deceleration coefficient may increase automatically"]. A move of fewer than 256
steps has no S-curve: its speed changes at a constant rate from the start speed to the stop speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import ceil

from scanrack.io_images.pmc006.instructions import ACCELERATIONS_PPS2, SHORT_MOVE_STEPS

from ...kinematics import NANO, Course, Motion, Phase, takeover

RAISED_COSINE = (Phase(0, 24, 0, 0, 0, 54), Phase(24, 48, 2, 18, 54, 0), Phase(48, 72, 14, 54, 54, -54))
"""The S-curve, as phases of `kinematics.course`."""


@dataclass(frozen=True, slots=True)
class Pmc006Speeds:
    """Speeds and ramps of a motion."""

    start_sps: int  # speed immediately after the start from rest
    max_sps: int  # speed between the ramps
    stop_sps: int  # speed immediately before rest
    acceleration: int  # coefficient 1 to 8, 0 for no ramp
    deceleration: int  # coefficient 1 to 8, 0 for no ramp


def plan_move(now_ns: int, origin: int, distance: int, speeds: Pmc006Speeds) -> Motion:
    """Plan a move of exactly `distance` signed, nonzero steps from step count `origin`."""
    steps = abs(distance)
    course = Course(now_ns)
    if steps < SHORT_MOVE_STEPS:
        _append_short_move(course, steps, speeds)
    else:
        _append_long_move(course, steps, speeds)
    return course.ended(1 if distance > 0 else -1, origin)


def plan_run(now_ns: int, origin: int, direction: int, speeds: Pmc006Speeds) -> Motion:
    """Plan an endless motion [4.3.8]; arguments as for `plan_move`."""
    course = Course(now_ns)
    top_nsps = NANO * speeds.max_sps
    up_steps = ramp_steps(speeds.start_sps, speeds.max_sps, speeds.acceleration)
    _append_ramp(course, up_steps, NANO * speeds.start_sps, top_nsps)
    return course.endless(direction, origin, top_nsps)


def plan_slowing(motion: Motion, now_ns: int, stop_sps: int, coefficient: int) -> Motion:
    """Plan a motion's ramp down to its stop speed, so that it ends on a whole step [4.3.8].

    With coefficient 0, or below the stop speed, the motion ends at once.
    """
    course, speed_nsps = takeover(motion, now_ns)
    ramp = _ramp_steps_fine(speed_nsps, NANO * stop_sps, coefficient)
    if ramp > 0:
        steps_made = Fraction(course.travel, course.scale * NANO**2)
        end = ceil(steps_made + ramp)
        course.cruise_over(end - steps_made - ramp, speed_nsps)
        course.ramp_over(ramp, speed_nsps, NANO * stop_sps, RAISED_COSINE)
    return course.ended(motion.direction, motion.origin)


def ramp_steps(slow_sps: int, fast_sps: int, coefficient: int) -> Fraction:
    """Return the length of a ramp in steps, `(v1^2 - v0^2) / 2a`; 0 if there is no ramp.

    >>> ramp_steps(600, 5000, 3)  # 27170 steps/s/s
    Fraction(112000, 247)
    """
    return _ramp_steps_fine(NANO * fast_sps, NANO * slow_sps, coefficient)


def _ramp_steps_fine(fast_nsps: int, slow_nsps: int, coefficient: int) -> Fraction:
    """Return the length of a ramp in steps, see `ramp_steps`; speeds are in 1e-9 step/s."""
    if coefficient == 0 or fast_nsps <= slow_nsps:
        return Fraction(0)
    return Fraction(fast_nsps**2 - slow_nsps**2, 2 * ACCELERATIONS_PPS2[coefficient] * NANO**2)


def _append_short_move(course: Course, steps: int, speeds: Pmc006Speeds) -> None:
    """Append a move without an S-curve: the speed changes evenly from start to stop speed."""
    start_nsps, stop_nsps = NANO * speeds.start_sps, NANO * speeds.stop_sps
    if start_nsps == stop_nsps:
        course.cruise_to(steps, start_nsps)
    else:
        course.ramp_over(Fraction(steps), start_nsps, stop_nsps)


def _append_long_move(course: Course, steps: int, speeds: Pmc006Speeds) -> None:
    """Append an S-curve up, the maximum speed, and an S-curve down; ramps that do not fit are shortened."""
    top_nsps = NANO * speeds.max_sps
    up_steps = ramp_steps(speeds.start_sps, speeds.max_sps, speeds.acceleration)
    down_steps = ramp_steps(speeds.stop_sps, speeds.max_sps, speeds.deceleration)
    if up_steps + down_steps > steps:
        scale = steps / (up_steps + down_steps)
        up_steps, down_steps = up_steps * scale, down_steps * scale
    _append_ramp(course, up_steps, NANO * speeds.start_sps, top_nsps)
    course.cruise_over(steps - up_steps - down_steps, top_nsps)
    _append_ramp(course, down_steps, top_nsps, NANO * speeds.stop_sps)


def _append_ramp(course: Course, steps: Fraction, from_nsps: int, to_nsps: int) -> None:
    """Append an S-curve over a number of steps; append nothing for 0 steps."""
    if steps:
        course.ramp_over(steps, from_nsps, to_nsps, RAISED_COSINE)
