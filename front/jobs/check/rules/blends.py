"""Rules about blend profiles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from ....io_images.amci3601 import Configuration, Limits
from ....io_images.amci3601.blend import SEGMENTS_MAX, SEGMENTS_MIN
from ....io_images.amci3601.rules import RULES
from ....io_images.thousands import PARAMETER_MAX
from ....runtime.kinematics import MILLI, PICO
from ....runtime.kinematics.shape import Shape, ramp_distance
from ..ranges import Range
from ..subject import Subject, Violation
from .motion import is_open


def blends(subject: Subject) -> Iterator[Violation]:
    """Find blend profiles that the module refuses."""
    for each in subject.facts.commands:
        if each.kind != "program_blend":
            continue
        count = each.value("segments")
        if count.outside(SEGMENTS_MIN, SEGMENTS_MAX):
            text = f"{each.text}: {count} segments: must be {SEGMENTS_MIN} to {SEGMENTS_MAX}"
            yield Violation(each.place, text)
        elif each.segments:
            rule = _wrong_segment(
                each.segments, subject.configurations(each.slot), subject.profile(each.slot).limits
            )
            if rule:
                yield Violation(each.place, f"{each.text}: {rule}")


def _wrong_segment(
    segments: Sequence[tuple[Range, Range, Range]], configurations: Sequence[Configuration], limits: Limits
) -> str:
    """Return what is wrong with a segment; "" if nothing is, or if it is unknown."""
    least = min((each.starting_speed for each in configurations), default=0)
    for number, (length, speed, rate) in enumerate(segments, 1):
        for name, found, most in (
            ("length", length, PARAMETER_MAX),
            ("speed", speed, limits.speed),
            ("rate", rate, limits.rate),
        ):
            if found.outside(1, most):
                return f"{name} {found} of segment {number}: must be 1 to {most}"
        if speed.most < least:
            return f"speed {speed} of segment {number} is below the starting speed, {least}"
    known = [each for each in segments if all(part.is_constant for part in each)]
    if len(known) < len(segments):
        return ""
    for number, (one, other) in enumerate(pairwise(segments), 1):
        if one[1] == other[1]:
            return f"segments {number} and {number + 1}: {RULES['PRF-06'].text}"
    before = least
    for number, (length, speed, rate) in enumerate(segments if configurations else (), 1):
        ramp = ramp_distance(MILLI * before, MILLI * int(speed.least), int(rate.least), Shape.CONSTANT)
        if length.least * PICO < ramp:
            return f"segment {number}: {RULES['PRF-05'].text}"
        before = int(speed.least)
    return ""


def without_blend(subject: Subject) -> Iterator[Violation]:
    """Find blends that run and that nothing programs."""
    for commands in subject.by_axis():
        runs = [each for each in commands if each.kind == "run_blend"]
        if (
            runs
            and not any(each.kind == "program_blend" for each in commands)
            and not is_open(subject, runs[0])
        ):
            yield Violation(runs[0].place, f"{runs[0].text}: {RULES['CMD-16'].text}")
