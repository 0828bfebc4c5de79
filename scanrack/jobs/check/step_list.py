"""Facts of a list of steps, each of which writes known words and gives the condition it waits for.

ABSOLUTE_MOVE target 4000 speed 5000 acceleration 10 deceleration 10    until MOVE_COMPLETE
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from scanrack.io_images.amci3601 import CommandLsw
from scanrack.io_images.image import UNSIGNED_MAX, WORDS, WORDS_MAX, Image
from scanrack.ladder.files.steps import Step, Steps

from .choices import Choices
from .facts import Command, Facts, FileLine, SentCommand, StepAction
from .module_kinds import MODE_CONFIG, MOVING, OFF_AT_END, SEARCHES, given_by, kinds_of
from .written import WordWrite

MACHINE = "step"
"""The number that holds the step."""

BLEND_PROGRAM = CommandLsw.BLEND_PROGRAM.value


def step_facts(path: Path, program: Steps) -> Facts:
    """Return the facts of a list of steps."""
    facts = Facts()
    image = Image(size=WORDS_MAX)  # large enough for any module
    following = [*(program_step.line for program_step in program.steps[1:]), 0]
    for step, goes in zip(program.steps, following, strict=True):
        step.write(image)
        words = image.words.tolist()[:WORDS]
        place = FileLine(str(path), step.line)
        _written(facts, program.slot, place, words)
        facts.actions += _actions(program.slot, place, step, goes, words)
    return facts


def _written(facts: Facts, slot: int, place: FileLine, words: Sequence[int]) -> None:
    first = words[0] & UNSIGNED_MAX
    if first & MODE_CONFIG:
        facts.configurations.append(SentCommand(place, slot, tuple(words)))
    elif first & SEARCHES:
        facts.searches.append(SentCommand(place, slot))
    programs = ["program_blend"] if words[1] & BLEND_PROGRAM else []
    for kind in ["configure"] if first & MODE_CONFIG else [*kinds_of(first), *programs]:
        facts.commands.append(
            Command(
                *(kind, f"slot {slot}", slot, place, f"the command {kind}"),
                order=place.line,
                owner=MACHINE,
                sure=True,
                words=True,
            )
        )
    where = {MACHINE: (frozenset((float(place.line),)), True)}
    for word in range(WORDS):
        bits = first if word == 0 else 0
        value = Choices((words[word],))
        facts.writes.append(WordWrite(place, slot, word, value, bits, ~bits & UNSIGNED_MAX, steps=where))


def _actions(slot: int, place: FileLine, step: Step, goes: int, words: Sequence[int]) -> Iterator[StepAction]:
    first = words[0] & UNSIGNED_MAX
    steps = frozenset((float(step.line),))
    yield StepAction(MACHINE, steps, place, axis=f"slot {slot}", **given_by(first, ~first & UNSIGNED_MAX))
    ends = bool(step.rise - MOVING or step.fall & OFF_AT_END or step.for_ns is not None)
    if goes and (step.rise or step.fall or step.for_ns is not None):
        yield StepAction(MACHINE, steps, place, float(goes), ends)
