"""The eight output words of a 3601 as a program in any language writes them: their values and their flow.

A collector notes each write of a word with its condition. This module combines the writes into the images
that give commands, with the value of each word as far as the text determines it.

    EQU(Step,10)MOV(4,O.Data[2])MOV(500,O.Data[3])    step 10: word 2 is 4, word 3 is 500
    EQU(Step,20)OTL(O.Data[0].0)                      step 20: the words of step 10, and ABSOLUTE_MOVE

A word that only some scans of a step write is unknown after the step. So is a word with different values on
two paths to a step. A bit in the command word is on after a write that sets it, until something may clear it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from scanrack.io_images.image import UNSIGNED_MAX, WORDS, signed_word

from .choices import UNKNOWN_CHOICES, Choices
from .facts import StepAction
from .groups import grouped
from .logic import TRUE, AllOf, Condition, never
from .written import FileLine, Step, WordWrite

PASSES = 4
"""Maximum number of visits to a step while the words of all paths to it are collected."""


class Cell(NamedTuple):
    """The value of a word, and where it was written."""

    value: Choices = UNKNOWN_CHOICES
    place: FileLine | None = None


@dataclass(frozen=True, slots=True)
class SentImage:
    """The output words that give a command.

    Attributes:
        place: where the command bit is set.
        command: bits of word 0 that are on; those in `fresh` are set here.
    """

    place: FileLine
    slot: int
    command: int
    fresh: int
    cells: tuple[Cell, ...]
    text: str = ""

    def variants(self) -> Iterator[tuple[tuple[int | None, ...], str]]:
        """Yield the words for each option of each source (None for unknown words), with the option's name."""
        sources = dict.fromkeys(cell.value.source for cell in self.cells if len(cell.value.options) > 1)
        yield self._words("", 0), ""
        for source in sources:
            values = [cell.value for cell in self.cells if cell.value.source == source]
            for row in range(min(len(value.options) for value in values)):
                name = values[0].names[row] if row < len(values[0].names) else ""
                yield self._words(source, row), name

    def _words(self, source: str, at: int) -> tuple[int | None, ...]:
        parameters = (_option(cell.value, source, at) for cell in self.cells[1:])
        return (signed_word(self.command), *parameters)


def _option(value: Choices, source: str, at: int) -> int | None:
    options: tuple[int, ...] = value.options
    if len(options) == 1:
        return options[0]
    return options[at] if options and value.source == source else None


class _Words(NamedTuple):
    """The words at a place: the bits of word 0 that are on, and all eight words."""

    on: int = 0
    cells: tuple[Cell, ...] = (Cell(),) * WORDS


def sent_images(writes: Sequence[WordWrite], actions: Sequence[StepAction]) -> Iterator[SentImage]:
    """Yield the images that give commands."""
    by_machine = grouped(actions, lambda each: each.machine)
    for own in grouped(writes, lambda each: each.slot).values():
        steps = (pair for action in own for pair in action.steps.items())
        machines = dict.fromkeys(
            machine for machine, (possible_steps, _) in steps if possible_steps is not None
        )
        for machine in machines or ("",):
            yield from _Flow(own, machine, by_machine.get(machine, ())).images()


class _Flow:
    """The words of a slot, followed through the steps of a machine."""

    def __init__(self, writes: Sequence[WordWrite], machine: str, actions: Sequence[StepAction]) -> None:
        self._writes, self._machine = writes, machine
        leading = [action for action in actions if action.goes is not None]
        self._goes = [action for action in leading if action.steps is not None]
        self._steps: list[Step] = sorted(self._all_steps(actions), key=str) if machine else [""]
        entered_by_others = {
            action.goes for action in self._goes if action.steps != frozenset((action.goes,))
        }
        # no word is known in a step that can be entered from anywhere, such as in the first scan
        entered_from_anywhere = {action.goes for action in leading if action.steps is None}
        firsts = entered_from_anywhere | (set(self._steps) - entered_by_others)
        self._before: dict[Step, _Words] = dict.fromkeys(filter(firsts.__contains__, self._steps), _Words())

    def _all_steps(self, actions: Iterable[StepAction]) -> set[Step]:
        steps: set[Step] = set().union(*(action.steps or () for action in actions))
        steps.update(action.goes for action in actions if action.goes is not None)
        acting = (write.steps.get(self._machine, (None, False))[0] for write in self._writes)
        return steps.union(*(acting_steps or () for acting_steps in acting))

    def images(self) -> Iterator[SentImage]:
        """Yield the images of all commands in all steps."""
        todo = [*self._before]
        visits: Counter[Step] = Counter()
        while todo:
            step = todo.pop(0)
            visits[step] += 1
            for goes, words in self._onward(step):
                before = self._before.get(goes)
                joined = words if before is None else _joined(before, words)
                if joined != before and visits[goes] < PASSES * len(self._steps):
                    self._before[goes] = joined
                    todo.append(goes)
        for step in self._steps:
            yield from self._given_in(step)

    def _onward(self, step: Step) -> Iterator[tuple[Step, _Words]]:
        """Yield the next steps, each with the words after the scan that goes to it."""
        for action in self._goes:
            if action.goes is not None and action.happens_in(step) and action.goes != step:
                yield action.goes, self._written(self._at(step), step, action.when, self._in(step))

    def _at(self, step: Step) -> _Words:
        return self._before.get(step, _Words())

    def _in(self, step: Step) -> list[WordWrite]:
        """Return the writes that may act in a step."""
        return [write for write in self._writes if write.acts_in(self._machine, step)[0]]

    def _written(self, before: _Words, step: Step, when: Condition, writes: Sequence[WordWrite]) -> _Words:
        """Return the words after writes in a scan of a step, given a condition that holds in it."""
        on, cells = before
        kept = list(cells)
        for write in writes:
            _, sure = write.acts_in(self._machine, step)
            acts = sure or implies(when, write.when)
            if write.word == 0:
                on &= ~write.clears
                on |= write.sets if acts else 0
            if write.value is not None:
                kept[write.word] = Cell(write.value if acts else UNKNOWN_CHOICES, write.place)
            elif write.word:
                kept[write.word] = _with_bits(kept[write.word], write, acts=acts)
        return _Words(on & UNSIGNED_MAX, tuple(kept))

    def _with(self, step: Step, command: WordWrite) -> _Words:
        """Return the words in the scan of a step that gives a command."""
        step_actions = self._in(step)
        images = {write.place for write in step_actions if write.word == 0}
        others = [action for action in step_actions if _is_another(action, command, images)]
        on, cells = self._at(step)
        for other in others:  # another write may have acted in an earlier scan
            on &= ~other.clears if other.word == 0 else UNSIGNED_MAX
        return self._written(
            _Words(on, cells), step, command.when, [action for action in step_actions if action not in others]
        )

    def _given_in(self, step: Step) -> Iterator[SentImage]:
        """Yield the images of the commands in a step."""
        for write in self._writes:
            may, _ = write.acts_in(self._machine, step)
            if may and write.word < 2 and write.sets:
                on, cells = self._with(step, write)
                fresh = write.sets if write.word == 0 else 0
                if on & fresh == fresh:
                    yield SentImage(write.place, write.slot, on, fresh, cells, write.text)


def _is_another(write: WordWrite, command: WordWrite, images: Collection[FileLine]) -> bool:
    """Whether a write does not happen in a command's scan, or belongs to an image with further conditions.

    Args:
        images: lines that write word 0.
    """
    if never(AllOf((command.when, write.when))):
        return True
    return write.place in images and write.when != command.when and implies(write.when, command.when)


def implies(one: Condition, other: Condition) -> bool:
    """Whether a condition contains all parts of another one."""
    return one == other or _parts(other) <= _parts(one)


def _parts(condition: Condition) -> set[Condition]:
    if isinstance(condition, AllOf):
        return {part for condition_part in condition.parts for part in _parts(condition_part)}
    return set() if condition == TRUE else {condition}


def _with_bits(cell: Cell, write: WordWrite, *, acts: bool) -> Cell:
    """Return a word after some of its bits are written."""
    if not acts or len(cell.value.options) != 1:
        return Cell(UNKNOWN_CHOICES, write.place)
    word = (cell.value.options[0] & ~write.clears | write.sets) & UNSIGNED_MAX
    return Cell(Choices((signed_word(word),)), write.place)


def _joined(one: _Words, other: _Words) -> _Words:
    """Return the words of a step that two paths lead to."""
    pairs = zip(one.cells, other.cells, strict=True)
    return _Words(
        one.on & other.on, tuple(cell if cell == other_cell else Cell() for cell, other_cell in pairs)
    )
