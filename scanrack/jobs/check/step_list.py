"""Facts of a list of steps. Each step writes known words and waits for a condition.

ABSOLUTE_MOVE target 4000 speed 5000 acceleration 10 deceleration 10    until MOVE_COMPLETE
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from scanrack.io_images.amci3601 import CommandLsw
from scanrack.io_images.image import UNSIGNED_MAX, WORDS, WORDS_MAX, Image
from scanrack.ladder.files.steps import Step, Steps

from .choices import Choices
from .facts import Command, Facts, FileLine, SentCommand, StepAction
from .module_kinds import MODE_CONFIG, MOVING, OFF_AT_END, SEARCHES, action_fields, kinds_of
from .written import WordWrite

MACHINE = "step"
"""Name of the number that contains the step."""

BLEND_PROGRAM = CommandLsw.BLEND_PROGRAM.value


def step_facts(path: Path, program: Steps) -> Facts:
    """Return the facts of a list of steps."""
    facts = Facts()
    image = Image(size=WORDS_MAX)  # large enough for any module
    next_lines = [*(step.line for step in program.steps[1:]), 0]
    for step, next_line in zip(program.steps, next_lines, strict=True):
        step.write(image)
        words = image.words.tolist()[:WORDS]
        place = FileLine(str(path), step.line)
        _note_words(facts, program.slot, place, words)
        facts.actions += _actions(program.slot, place, step, next_line, words)
    return facts


def _note_words(facts: Facts, slot: int, place: FileLine, words: Sequence[int]) -> None:
    """Note the writes of a step's words, and the commands in the words."""
    first = words[0] & UNSIGNED_MAX
    if first & MODE_CONFIG:
        facts.configurations.append(SentCommand(place, slot, tuple(words)))
    elif first & SEARCHES:
        facts.searches.append(SentCommand(place, slot))
    programs = ["program_blend"] if words[1] & BLEND_PROGRAM else []
    for kind in ["configure"] if first & MODE_CONFIG else [*kinds_of(first), *programs]:
        command = Command(kind, f"slot {slot}", slot, place, f"the command {kind}")
        facts.commands.append(replace(command, order=place.line, owner=MACHINE, sure=True, words=True))
    steps = {MACHINE: (frozenset((float(place.line),)), True)}
    for word in range(WORDS):
        bits = first if word == 0 else 0
        value = Choices((words[word],))
        clears = ~bits & UNSIGNED_MAX
        facts.writes.append(WordWrite(place, slot, word, value, sets=bits, clears=clears, steps=steps))


def _actions(
    slot: int, place: FileLine, step: Step, next_line: int, words: Sequence[int]
) -> Iterator[StepAction]:
    """Yield a step's write of the command word, and its change to the next step.

    Args:
        next_line: line of the next step; 0 for the last step.
    """
    first = words[0] & UNSIGNED_MAX
    steps = frozenset((float(step.line),))
    yield StepAction(
        MACHINE, steps, place, axis=f"slot {slot}", **action_fields(first, ~first & UNSIGNED_MAX)
    )
    ends = bool(step.rise - MOVING or step.fall & OFF_AT_END or step.for_ns is not None)
    if next_line and (step.rise or step.fall or step.for_ns is not None):
        yield StepAction(MACHINE, steps, place, float(next_line), ends)
