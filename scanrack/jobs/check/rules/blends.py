"""Rules about blend profiles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise

from scanrack.io_images.amci3601 import CommandLsw, Configuration, Limits
from scanrack.io_images.amci3601.blend import SEGMENTS_MAX, SEGMENTS_MIN
from scanrack.io_images.amci3601.rules import RULES
from scanrack.io_images.thousands import PARAMETER_MAX
from scanrack.runtime.kinematics import MILLI, PICO
from scanrack.runtime.kinematics.shape import Shape, ramp_distance

from ..facts import Command, FileLine, Step, StepAction
from ..logic import AllOf, Bit, Condition, all_of, needed, negated, never
from ..ranges import Range
from ..subject import Subject, Violation
from ..written import WordWrite
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
    """Find blends that run and that nothing programs, or that nothing has programmed before."""
    for commands in subject.by_axis():
        runs = [each for each in commands if each.kind == "run_blend"]
        programs = [each for each in commands if each.kind == "program_blend"]
        if not runs or is_open(subject, runs[0]):
            continue
        if not programs:
            yield Violation(runs[0].place, f"{runs[0].text}: {RULES['CMD-16'].text}")
            continue
        early = _in_order(runs, programs) or _at_once(runs, programs) or _in_steps(subject, runs[0].axis)
        if early is not None:
            place, text, line = early
            what = f"{text} comes before the blend is programmed in line {line}"
            yield Violation(place, f"{what}: {RULES['CMD-16'].text}")


Early = tuple[FileLine, str, int]
"""A run that comes too early: its place and words, and the line that programs the blend."""


def _in_order(runs: Sequence[Command], programs: Sequence[Command]) -> Early | None:
    """Return a run before all programming in the same sequence."""
    if any(each.execute for each in (*runs, *programs)) or len({each.owner for each in programs}) > 1:
        return None
    first = min(programs, key=lambda each: each.order)
    for each in runs:
        if each.sure and each.owner == first.owner and 0 < each.order < first.order:
            return each.place, each.text, first.place.line
    return None


def _at_once(runs: Sequence[Command], programs: Sequence[Command]) -> Early | None:
    """Return a block that runs when the one that programs starts, or that has to be done before."""
    for run in runs:
        name = run.text.rpartition(" ")[2].upper()
        is_early = [
            never(AllOf((each.implies, negated(_first_time(run.on, name)))))
            or Bit(f"{name}.DONE") in needed(each.implies)
            for each in programs
        ]
        if run.execute and all(each.execute for each in programs) and all(is_early):
            return run.place, run.text, programs[0].place.line
    return None


def _first_time(on: Condition, name: str) -> Condition:
    """Return the condition of a block's Execute before its first run: its own results are off."""
    parts = on.parts if isinstance(on, AllOf) else (on,)
    own = (isinstance(each, Bit) and not each.on and each.name.startswith(f"{name}.") for each in parts)
    return all_of(*(each for each, is_own in zip(parts, own, strict=True) if not is_own))


def _in_steps(subject: Subject, axis: str) -> Early | None:
    """Return a run in a step that is reached without a step that programs the blend."""
    facts = subject.facts
    for machine in {each.machine: None for each in facts.actions}:
        own = [each for each in facts.actions if each.machine == machine]
        runs = [each for each in own if each.axis == axis and each.kind == "run_blend"]
        programs = [(each.steps, each.place) for each in own if each.axis == axis and each.kind == PROGRAM]
        programs += [
            (each.steps.get(machine, (None, False))[0], each.place)
            for each in facts.writes
            if f"slot {each.slot}" == axis and each.word == 1 and _programs(each)
        ]
        first = facts.first_steps(machine)
        if not first or not programs or not runs or any(steps is None for steps, _ in programs):
            continue
        programming = frozenset().union(*(steps for steps, _ in programs if steps is not None))
        reached = _without(programming, first, [each for each in own if each.goes is not None])
        for each in runs:
            if each.steps is not None and each.steps <= reached:
                return each.place, each.text, programs[0][1].line
    return None


PROGRAM = "program_blend"


def _programs(write: WordWrite) -> bool:
    """Whether a write of output word 1 may program a blend."""
    options = write.value.options if write.value is not None else (write.sets,)
    return not options or any(each & CommandLsw.BLEND_PROGRAM.value for each in options)


def _without(
    programming: frozenset[Step], first: frozenset[Step], goes: Sequence[StepAction]
) -> frozenset[Step]:
    """Return the steps that are reached from the first ones without one that programs."""
    found = set(first - programming)
    todo = list(found)
    while todo:
        step = todo.pop()
        for each in goes:
            is_new = each.goes is not None and each.goes not in found | programming
            if is_new and each.goes is not None and each.steps is not None and each.happens_in(step):
                found.add(each.goes)
                todo.append(each.goes)
    return frozenset(found)
