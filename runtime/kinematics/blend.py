"""Blend moves: up to sixteen segments, each with its own speed, run as one motion.

Each segment ramps from the previous segment's speed, or the starting speed, to its own speed, and then keeps
that speed for the rest of its length. The last segment also contains the final ramp down to the starting
speed, so the lengths add up to the distance [chapter 4, Blend Move; chapter 5, blend blocks].
"""

from __future__ import annotations

from collections.abc import Sequence

from .course import Course
from .motion import Motion
from .shape import MILLI, NANO, PICO, AnyShape, ramp_distance

BlendLeg = tuple[int, int, int, AnyShape]
"""Length in steps, speed in steps/s, rate in steps/ms/s, shape of the ramp."""


def blend(
    now_ns: int,
    origin: int,
    direction: int,
    start_sps: int,
    segments: Sequence[BlendLeg],
    final_deceleration_spmss: int,
    final_shape: AnyShape,
) -> Motion:
    """Plan a blend move.

    >>> from .shape import Shape
    >>> two = [(2000, 5000, 20, Shape.CONSTANT), (3000, 3000, 20, Shape.CONSTANT)]
    >>> profile = blend(0, 0, -1, 1000, two, 10, Shape.CONSTANT)
    >>> profile.final_steps, profile.position_at(profile.end_ns)
    (5000, -5000)

    Args:
        segments: each with a length of 1 or more, a speed not below the starting speed, and a rate of 1 or
            more.

    Raises:
        ValueError: the direction is invalid, there are no segments, or a segment is too short for its ramps.
    """
    check_blend(start_sps, segments, final_deceleration_spmss, final_shape)
    course, speed_nsps, end = Course(now_ns), NANO * start_sps, 0
    for number, (length, speed_sps, rate_spmss, shape) in enumerate(segments, start=1):
        course.ramp(speed_nsps, NANO * speed_sps, rate_spmss, shape)
        speed_nsps, end = NANO * speed_sps, end + length
        if number < len(segments):
            course.cruise_to(end, speed_nsps)
    course.arrive(end, speed_nsps, NANO * start_sps, final_deceleration_spmss, final_shape)
    return course.ended(direction, origin)


def check_blend(
    start_sps: int, segments: Sequence[BlendLeg], final_deceleration_spmss: int, final_shape: AnyShape
) -> None:
    """Check that every segment is long enough for its ramps; arguments as for `blend`.

    Raises:
        ValueError: there are no segments, or a segment is shorter than its ramps according to chapter 2's
            formula.
    """
    if not segments:
        raise ValueError("a blend without segments: must be 1 or more")
    speed_msps = MILLI * start_sps
    for number, (length, speed_sps, rate_spmss, shape) in enumerate(segments, start=1):
        ramp_pico = ramp_distance(speed_msps, MILLI * speed_sps, rate_spmss, shape)
        speed_msps = MILLI * speed_sps
        if number == len(segments) and speed_sps > start_sps:
            ramp_pico += ramp_distance(speed_msps, MILLI * start_sps, final_deceleration_spmss, final_shape)
        if length < 1 or length * PICO < ramp_pico:
            steps_needed = max(1, -(-ramp_pico // PICO))
            raise ValueError(f"blend segment {number} is {length} steps long; its ramps need {steps_needed}")
