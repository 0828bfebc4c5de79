"""The values of a 3601's eight output words when a program in any language sends a command.

A collector notes each write of a word with its condition. This module combines the writes into the images
that send commands, with the value of each word if the text determines it.

    EQU(Step,10)MOV(4,O.Data[2])MOV(500,O.Data[3])    step 10: word 2 is 4, word 3 is 500
    EQU(Step,20)OTL(O.Data[0].0)                      step 20: the words of step 10, and ABSOLUTE_MOVE

A word is unknown after a step if only some scans of the step write it. It is unknown in a step if two paths
to the step give it different values. Once a write sets a command bit, the bit stays on until a write may
clear it.
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
    """The value of a word, and the line that wrote it."""

    value: Choices = UNKNOWN_CHOICES
    place: FileLine | None = None


@dataclass(frozen=True, slots=True)
class SentImage:
    """The output words that send a command.

    Attributes:
        place: the line that sets the command bit.
        command: bits of word 0 that are on.
        fresh: the bits of `command` that this line sets.
        cells: the eight words.
    """

    place: FileLine
    slot: int
    command: int
    fresh: int
    cells: tuple[Cell, ...]
    text: str = ""

    def variants(self) -> Iterator[tuple[tuple[int | None, ...], str]]:
        """Yield the words for each option of each source, with the option's name. Unknown words are None."""
        sources = dict.fromkeys(cell.value.source for cell in self.cells if len(cell.value.options) > 1)
        yield self._words("", 0), ""
        for source in sources:
            values = [cell.value for cell in self.cells if cell.value.source == source]
            for row in range(min(len(value.options) for value in values)):
                name = values[0].names[row] if row < len(values[0].names) else ""
                yield self._words(source, row), name

    def _words(self, source: str, row: int) -> tuple[int | None, ...]:
        parameters = (_option(cell.value, source, row) for cell in self.cells[1:])
        return (signed_word(self.command), *parameters)


def _option(value: Choices, source: str, row: int) -> int | None:
    """Return a word's value for a row of a source; None if it is unknown or from a different source."""
    options: tuple[int, ...] = value.options
    if len(options) == 1:
        return options[0]
    return options[row] if options and value.source == source else None


class _Words(NamedTuple):
    """The output words at one point of the program."""

    bits_on: int = 0  # bits of word 0 that are on
    cells: tuple[Cell, ...] = (Cell(),) * WORDS


def sent_images(writes: Sequence[WordWrite], actions: Sequence[StepAction]) -> Iterator[SentImage]:
    """Yield the images that send commands."""
    by_machine = grouped(actions, lambda action: action.machine)
    for slot_writes in grouped(writes, lambda write: write.slot).values():
        steps_by_machine = (pair for write in slot_writes for pair in write.steps.items())
        machines = dict.fromkeys(machine for machine, (steps, _) in steps_by_machine if steps is not None)
        for machine in machines or ("",):
            yield from _Flow(slot_writes, machine, by_machine.get(machine, ())).images()


class _Flow:
    """The words of a slot, followed through the steps of a machine.

    Args:
        machine: the variable that contains the step; "" for a program without steps.
    """

    def __init__(self, writes: Sequence[WordWrite], machine: str, actions: Sequence[StepAction]) -> None:
        self._writes, self._machine = writes, machine
        changes = [action for action in actions if action.goes is not None]
        self._changes = [change for change in changes if change.steps is not None]  # from known steps
        self._steps: list[Step] = sorted(self._all_steps(actions), key=str) if machine else [""]
        # the words on entry to each step that a path reaches
        self._on_entry: dict[Step, _Words] = {step: _Words() for step in self._first_steps(changes)}

    def _first_steps(self, changes: Iterable[StepAction]) -> list[Step]:
        """Return the steps whose words on entry are unknown: entered from any step, or from no other step."""
        entered_from_others = {
            change.goes for change in self._changes if change.steps != frozenset((change.goes,))
        }
        entered_from_anywhere = {change.goes for change in changes if change.steps is None}
        return [
            step for step in self._steps if step in entered_from_anywhere or step not in entered_from_others
        ]

    def _all_steps(self, actions: Iterable[StepAction]) -> set[Step]:
        """Return all steps that actions and writes name."""
        steps: set[Step] = set().union(*(action.steps or () for action in actions))
        steps.update(action.goes for action in actions if action.goes is not None)
        acting = (write.steps.get(self._machine, (None, False))[0] for write in self._writes)
        return steps.union(*(acting_steps or () for acting_steps in acting))

    def images(self) -> Iterator[SentImage]:
        """Yield the images of all commands in all steps."""
        todo = [*self._on_entry]
        visits: Counter[Step] = Counter()
        while todo:
            step = todo.pop(0)
            visits[step] += 1
            for next_step, words in self._next_steps(step):
                known = self._on_entry.get(next_step)
                joined = words if known is None else _joined(known, words)
                if joined != known and visits[next_step] < PASSES * len(self._steps):
                    self._on_entry[next_step] = joined
                    todo.append(next_step)
        for step in self._steps:
            yield from self._images_in(step)

    def _next_steps(self, step: Step) -> Iterator[tuple[Step, _Words]]:
        """Yield the next steps, each with the words after the scan that enters it."""
        for change in self._changes:
            if change.goes is not None and change.happens_in(step) and change.goes != step:
                words, writes = self._words_on_entry(step), self._writes_in(step)
                yield change.goes, self._words_after(words, step, change.when, writes)

    def _words_on_entry(self, step: Step) -> _Words:
        return self._on_entry.get(step, _Words())

    def _writes_in(self, step: Step) -> list[WordWrite]:
        """Return the writes that may act in a step."""
        return [write for write in self._writes if write.acts_in(self._machine, step)[0]]

    def _words_after(self, words: _Words, step: Step, when: Condition, writes: Sequence[WordWrite]) -> _Words:
        """Return the words after writes in a scan of a step while the condition `when` is true."""
        bits_on, cells = words.bits_on, list(words.cells)
        for write in writes:
            _, is_sure = write.acts_in(self._machine, step)
            acts = is_sure or implies(when, write.when)
            if write.word == 0:
                bits_on &= ~write.clears
                bits_on |= write.sets if acts else 0
            if write.value is not None:
                cells[write.word] = Cell(write.value if acts else UNKNOWN_CHOICES, write.place)
            elif write.word:
                cells[write.word] = _with_bits(cells[write.word], write, acts=acts)
        return _Words(bits_on & UNSIGNED_MAX, tuple(cells))

    def _words_with(self, step: Step, command: WordWrite) -> _Words:
        """Return the words in the scan of a step that sends a command."""
        writes = self._writes_in(step)
        image_lines = {write.place for write in writes if write.word == 0}
        of_other_scans = [write for write in writes if _is_of_another_scan(write, command, image_lines)]
        bits_on, cells = self._words_on_entry(step)
        for write in of_other_scans:  # it may have acted in an earlier scan
            if write.word == 0:
                bits_on &= ~write.clears
        of_this_scan = [write for write in writes if write not in of_other_scans]
        return self._words_after(_Words(bits_on, cells), step, command.when, of_this_scan)

    def _images_in(self, step: Step) -> Iterator[SentImage]:
        """Yield the images of the commands in a step."""
        for write in self._writes:
            may_act, _ = write.acts_in(self._machine, step)
            if may_act and write.word < 2 and write.sets:
                bits_on, cells = self._words_with(step, write)
                fresh = write.sets if write.word == 0 else 0
                if bits_on & fresh == fresh:
                    yield SentImage(write.place, write.slot, bits_on, fresh, cells, write.text)


def _is_of_another_scan(write: WordWrite, command: WordWrite, image_lines: Collection[FileLine]) -> bool:
    """Whether a write is not in a command's scan, or belongs to an image with additional conditions.

    Args:
        image_lines: lines that write word 0.
    """
    if never(AllOf((command.when, write.when))):
        return True
    return write.place in image_lines and write.when != command.when and implies(write.when, command.when)


def implies(premise: Condition, conclusion: Condition) -> bool:
    """Whether the premise contains all parts of the conclusion."""
    return premise == conclusion or _parts_of(conclusion) <= _parts_of(premise)


def _parts_of(condition: Condition) -> set[Condition]:
    """Return the parts of a condition that must all be true."""
    if isinstance(condition, AllOf):
        return set().union(*map(_parts_of, condition.parts))
    return set() if condition == TRUE else {condition}


def _with_bits(cell: Cell, write: WordWrite, *, acts: bool) -> Cell:
    """Return a word after some of its bits are written."""
    if not acts or len(cell.value.options) != 1:
        return Cell(UNKNOWN_CHOICES, write.place)
    word = (cell.value.options[0] & ~write.clears | write.sets) & UNSIGNED_MAX
    return Cell(Choices((signed_word(word),)), write.place)


def _joined(first: _Words, second: _Words) -> _Words:
    """Return the words on entry to a step that two paths reach; a cell that differs becomes unknown."""
    cells = (a if a == b else Cell() for a, b in zip(first.cells, second.cells, strict=True))
    return _Words(first.bits_on & second.bits_on, tuple(cells))
