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

from ..facts import Command, Facts, FileLine, Step, StepAction, Violation
from ..groups import grouped, reached
from ..logic import AllOf, Bit, Condition, all_of, needed, negated, never
from ..ranges import Range
from ..subject import Subject
from .motion import first_before, is_open

PROGRAM = "program_blend"


def blends(subject: Subject) -> Iterator[Violation]:
    """Find blend profiles that the module refuses because of a segment or the number of segments."""
    for command in subject.facts.commands:
        if command.kind != PROGRAM:
            continue
        count = command.value("segments")
        if count.outside(SEGMENTS_MIN, SEGMENTS_MAX):
            text = f"{command.text}: {count} segments: must be {SEGMENTS_MIN} to {SEGMENTS_MAX}"
            yield Violation(command.place, text)
        elif command.segments:
            rule = _wrong_segment(
                command.segments, subject.configurations(command.slot), subject.profile(command.slot).limits
            )
            if rule:
                yield Violation(command.place, f"{command.text}: {rule}")


def _wrong_segment(
    segments: Sequence[Segment], configurations: Sequence[Configuration], limits: Limits
) -> str:
    """Return the first mistake in the segments; "" if there is none, or if their values are unknown."""
    starting_speed = min((configuration.starting_speed for configuration in configurations), default=0)
    for number, segment in enumerate(segments, 1):
        problem = _out_of_range(number, segment, starting_speed, limits)
        if problem:
            return problem
    if not all(value.is_constant for segment in segments for value in segment):
        return ""
    for number, ((_, speed, _), (_, next_speed, _)) in enumerate(pairwise(segments), 1):
        if speed == next_speed:
            return f"segments {number} and {number + 1}: {RULES['PRF-06'].text}"
    return _too_short(segments, starting_speed) if configurations else ""


Segment = tuple[Range, Range, Range]
"""Length, speed and rate."""


def _out_of_range(number: int, segment: Segment, starting_speed: int, limits: Limits) -> str:
    """Return a message about a value of a segment that is out of range; "" if all are in range or unknown."""
    length, speed, rate = segment
    for name, value, most in (
        ("length", length, PARAMETER_MAX),
        ("speed", speed, limits.speed),
        ("rate", rate, limits.rate),
    ):
        if value.outside(1, most):
            return f"{name} {value} of segment {number}: must be 1 to {most}"
    if speed.most < starting_speed:
        return f"speed {speed} of segment {number} is below the starting speed, {starting_speed}"
    return ""


def _too_short(segments: Sequence[Segment], starting_speed: int) -> str:
    """Return a message about a segment that ends before its ramp; "" if none does."""
    previous_speed = starting_speed
    for number, (length, speed, rate) in enumerate(segments, 1):
        ramp = ramp_distance(
            MILLI * previous_speed, MILLI * int(speed.least), int(rate.least), Shape.CONSTANT
        )
        if length.least * PICO < ramp:
            return f"segment {number}: {RULES['PRF-05'].text}"
        previous_speed = int(speed.least)
    return ""


def without_blend(subject: Subject) -> Iterator[Violation]:
    """Find blends that run without being programmed, or before they are programmed."""
    for commands in subject.by_axis():
        runs = [command for command in commands if command.kind == "run_blend"]
        if runs and not is_open(subject, runs[0]):
            programs = [command for command in commands if command.kind == PROGRAM]
            yield from _not_programmed(subject, runs, programs)


def _not_programmed(
    subject: Subject, runs: Sequence[Command], programs: Sequence[Command]
) -> Iterator[Violation]:
    """Find the run of an axis's blend that comes too early, or that has no programmed blend."""
    if not programs:
        yield Violation(runs[0].place, f"{runs[0].text}: {RULES['CMD-16'].text}")
        return
    early = (
        _early_in_sequence(runs, programs)
        or _early_block(runs, programs)
        or _early_in_steps(subject.facts, runs[0].axis)
    )
    if early is not None:
        place, text, line = early
        mistake = f"{text} comes before the blend is programmed in line {line}"
        yield Violation(place, f"{mistake}: {RULES['CMD-16'].text}")


EarlyRun = tuple[FileLine, str, int]
"""A run that comes too early: its place and text, and the line that programs the blend."""


def _early_in_sequence(runs: Sequence[Command], programs: Sequence[Command]) -> EarlyRun | None:
    """Return a run that comes before all programming in the same sequence."""
    for run, program in first_before(programs, runs):
        return run.place, run.text, program.place.line
    return None


def _early_block(runs: Sequence[Command], programs: Sequence[Command]) -> EarlyRun | None:
    """Return a block that runs when the programming block starts, or that must be done before it starts."""
    for run in runs:
        name = run.text.rpartition(" ")[2].upper()
        is_early = [
            never(AllOf((program.implies, negated(_first_time(run.on, name)))))
            or Bit(f"{name}.DONE") in needed(program.implies)
            for program in programs
        ]
        if run.execute and all(program.execute for program in programs) and all(is_early):
            return run.place, run.text, programs[0].place.line
    return None


def _first_time(on: Condition, name: str) -> Condition:
    """Return the condition of a block's Execute before its first run, when its own result bits are off."""

    def is_own_bit_off(part: Condition) -> bool:
        return isinstance(part, Bit) and not part.on and part.name.startswith(f"{name}.")

    parts = on.parts if isinstance(on, AllOf) else (on,)
    return all_of(*(part for part in parts if not is_own_bit_off(part)))


def _early_in_steps(facts: Facts, axis: str) -> EarlyRun | None:
    """Return a run in a step that can be reached without passing a step that programs the blend."""
    for machine, actions in grouped(facts.actions, lambda action: action.machine).items():
        programs = list(_programming(facts, actions, axis, machine))
        steps_before = _steps_before(programs, facts.first_steps(machine), actions)
        for action in actions:
            is_run = action.axis == axis and action.kind == "run_blend"
            if is_run and steps_before and action.steps is not None and action.steps <= steps_before:
                _, programming_line = programs[0]
                return action.place, action.text, programming_line.line
    return None


def _programming(
    facts: Facts, actions: Sequence[StepAction], axis: str, machine: str
) -> Iterator[tuple[frozenset[Step] | None, FileLine]]:
    """Yield the actions and writes that program a blend, each as its steps (None for all) and its line."""
    for action in actions:
        if action.axis == axis and action.kind == PROGRAM:
            yield action.steps, action.place
    for write in facts.writes:
        options = write.options if write.word == 1 else (0,)
        may_program = not options or any(option & CommandLsw.BLEND_PROGRAM.value for option in options)
        if f"slot {write.slot}" == axis and may_program:
            yield write.steps.get(machine, (None, False))[0], write.place


def _steps_before(
    programs: Sequence[tuple[frozenset[Step] | None, FileLine]],
    first: frozenset[Step],
    actions: Sequence[StepAction],
) -> frozenset[Step]:
    """Return the steps that can be reached without programming; empty if programming steps are unknown."""
    known_steps = [steps for steps, _ in programs if steps is not None]
    if not known_steps or len(known_steps) < len(programs):
        return frozenset()
    programming = frozenset().union(*known_steps)

    def onward(step: Step) -> Iterator[Step]:
        for action in actions:
            if action.goes is not None and action.steps is not None and step in action.steps:
                yield from {action.goes} - programming

    starts = first - programming
    return starts | frozenset(reached(starts, onward))
