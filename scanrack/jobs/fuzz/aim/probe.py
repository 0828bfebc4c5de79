"""A listener that records the changes in a run, and their scans.

    group      a change of
    status     status bits of a 3601, input words of a card
    command    the first two output words of a 3601, output words of a card
    together   several output words
    number     the upper word of a number in two words, such as a position
    path       the power in a rung; the branches that a Python program takes in one scan
    state      a tag or a field: a flag, a text, a small integer; the line where a sequence waits
    size       the size of a larger integer
    pair       a status bit changes under a command
    under      a flag changes while the program is at certain steps

Each group is first compared as a whole: a scan without changes costs one comparison per group.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from hashlib import blake2b
from types import CellType
from typing import Any

from scanrack.io_images.amci3601.words import may_be_stepper
from scanrack.ladder.compiler import ObservedScanner, observed_scanner_of
from scanrack.ladder.compiler.observed import NOTED, Observation, lines_of
from scanrack.ladder.python.sequences import Sequence as LogicSequence
from scanrack.ladder.run.engine import Engine
from scanrack.ladder.state.lowered import LoweredProgram
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ...record.logic_wrapper import unwrapped
from ...record.sequence_watch import sequences_in
from ..last_program import remember_last
from .branches import NAME
from .edges import COMMAND, PAIR, SIZE, STATE, TOGETHER, UNDER, Edges
from .python_state import fields_reader, namespace_of

SMALL = range(-1, 33)
"""Integers that are recorded by value; of all others only the size is."""

MOST_TAGS = 1_000
"""Largest number of watched tags."""

Values = list[Hashable] | dict[Hashable, Hashable]
"""Values of a group, by place or name."""


class Probe(QuietListener):
    """Records the changes in one run in `edges`: call `prepared` and `watch` before the run."""

    def __init__(self, edges: Edges) -> None:
        self.edges = edges
        self._notes: list[Any] = []
        self._branches = bytearray()
        self._values: list[tuple[str, Callable[[], Values]]] = []
        self._last: list[Values] = []
        self._taken = self._none = b""

    def prepared(self, logic: ScanLogic) -> ScanLogic:
        """Return the logic; if it is compiled, make its new engine record the power in its rungs."""
        if type(logic) is Engine:
            scanner = noting(logic.lowered)
            notes = self._notes = [None] * scanner.note_count
            logic.compiled_as(lambda engine: scanner.bind(engine, {NOTED: notes}))
        return logic

    def watch(self, logic: ScanLogic, rack: Rack) -> None:
        """Watch a rack and its logic; call this before the first scan."""
        self._slots = [
            (slot, 2, 2) if may_be_stepper(slot.words) else (slot, len(slot.inputs), len(slot.outputs))
            for slot in rack.slots.values()
        ]
        self._memory = rack.memory
        self._watched = [
            (places.outputs.start, places.inputs.start + 2 * min(known + 1, len(slot.inputs)))
            for (slot, known, _), places in zip(self._slots, rack.layout.places.values(), strict=True)
        ]
        self._seen = [bytearray(end - begin) for begin, end in self._watched]
        self._words = [((0,) * len(slot.inputs), (0,) * len(slot.outputs)) for slot, *_ in self._slots]
        self.logic = logic
        program, notes = unwrapped(logic), self._notes
        if isinstance(program, Engine):
            self._values = [("path", lambda: notes), (STATE, _tags(program))]
        else:
            module = namespace_of(program)
            self._branches = module.get(NAME, self._branches)
            self._none = bytes(len(self._branches))
            self._branches[:] = self._none  # clear the notes of the previous run
            self._values = [(STATE, fields_reader(program, module))]
            if sequences := sequences_in(logic):
                self._values.append((STATE, _Lines(sequences)))
        self._last = [[] for _ in self._values]
        self._is_fresh = [group != "path" for group, _ in self._values]  # the notes are always the same list

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record the differences from the previous scan."""
        memory = self._memory
        for place, (begin, end) in enumerate(self._watched):
            if memory[begin:end] != self._seen[place]:
                self._seen[place] = memory[begin:end]
                self._note_words(place, scan)
        for place, (group, read) in enumerate(self._values):
            now, last = read(), self._last[place]
            if now is not last and now != last:
                self._note(group, place, now, last, scan)
                self._last[place] = now if self._is_fresh[place] else now.copy()
        if self._branches:
            self._note_branches(scan)

    def state(self, conditions: str) -> bytes:
        """Return a digest of the current state of program and modules: steps, flags, commands, status."""
        words = [
            (slot.fault, tuple(slot.inputs.words[:inputs]), tuple(slot.outputs.words[:outputs]))
            for slot, inputs, outputs in self._slots
        ]
        kinds = [
            [(name, kind.__class__.__name__, kind) for name, kind in _kinds(last)]
            for (group, _), last in zip(self._values, self._last, strict=True)
            if group == STATE
        ]
        return blake2b(repr((conditions, words, kinds)).encode(), digest_size=16).digest()

    def _note_words(self, place: int, scan: int) -> None:
        """Record the words of a slot that have changed."""
        add = self.edges.add
        slot, known, commanding = self._slots[place]
        inputs, outputs = tuple(slot.inputs.words), tuple(slot.outputs.words)
        inputs_before, outputs_before = self._words[place]
        self._words[place] = inputs, outputs
        if outputs != outputs_before:
            words = tuple(word for word, output in enumerate(outputs) if output != outputs_before[word])
            if len(words) > 1:
                add(TOGETHER, (place, words), scan)
        for word in range(max(known, commanding)):
            if word < commanding and outputs[word] != outputs_before[word]:
                add(COMMAND, (place, word, outputs[word]), scan)
            if word < known and (changed := (inputs[word] ^ inputs_before[word]) & 0xFFFF):
                add("status", (place, word, changed), scan)
                add(PAIR, (place, word, changed, outputs_before[0]), scan)
        if known < len(inputs) and inputs[2] != inputs_before[2]:
            add("number", place, scan)

    def _note(self, group: str, place: int, now: Values, last: Values, scan: int) -> None:
        """Record the values that have changed."""
        add, steps = self.edges.add, None
        before: Mapping[Hashable, Hashable] = last if isinstance(last, dict) else dict(enumerate(last))
        for name, value in _named(now):
            old = before.get(name)
            if old is value or (old == value and old.__class__ is value.__class__):
                continue
            kind = _kind(value)
            add(SIZE if kind.__class__ is _Size else group, (place, name, kind), scan)
            if value.__class__ is bool and group is STATE:
                steps = _steps(now) if steps is None else steps
                if steps:
                    add(UNDER, (place, name, value, steps), scan)

    def _note_branches(self, scan: int) -> None:
        branches = self._branches
        if branches != self._taken:
            if not any(branches):
                return  # the program was not called, or took no branch
            self._taken = bytes(branches)
            self.edges.add("path", self._taken, scan)
        branches[:] = self._none


def _steps(values: Values) -> tuple[Hashable, ...]:
    """Return the small numbers and texts among values: the steps of a program."""
    flat_values = values.values() if isinstance(values, dict) else values
    return tuple(
        value
        for value in flat_values
        if value.__class__ is str or (value.__class__ is int and value in SMALL)
    )


def _named(values: Values) -> Iterable[tuple[Hashable, Hashable]]:
    return values.items() if isinstance(values, dict) else enumerate(values)


def _kinds(values: Values) -> Iterator[tuple[Hashable, Hashable]]:
    return ((name, _kind(value)) for name, value in _named(values))


class _Size(int):
    """Signed size of a large integer: eight times its bit length, plus its three leading bits."""


def _kind(value: Hashable) -> Hashable:
    """Return the part of a value that is compared.

    >>> _kind(32), _kind(33), _kind(-2), _kind(-40_000), _kind("go")
    (32, 52, -18, -132, 'go')
    """
    if isinstance(value, Enum):
        return str(value.name)  # the class may belong to the program, which other processes lack
    if value.__class__ is not int or value in SMALL:
        return value
    assert isinstance(value, int)
    bits = value.bit_length()
    size = 8 * bits + (abs(value) >> max(0, bits - 3))
    return _Size(size if value > 0 else -size)


class _Lines:
    """Returns the lines where sequences wait; reads them again after one of them has continued."""

    def __init__(self, sequences: Sequence[LogicSequence]) -> None:
        self._sequences = sequences
        self._resumed: list[Any] = []
        self._lines: Values = []

    def __call__(self) -> Values:
        """Return the line of each sequence, None for a finished one."""
        resumed = [sequence.resumed for sequence in self._sequences]
        if resumed != self._resumed:
            self._resumed = resumed
            self._lines = [("line", sequence.line) for sequence in self._sequences]
        return self._lines


def _tags(engine: Engine) -> Callable[[], Values]:
    """Return a function that reads the flags and integers of a program, except times and images."""
    cells = list(_tag_cells(engine))[:MOST_TAGS]
    return lambda: [cell.cell_contents for cell in cells]


def _tag_cells(engine: Engine) -> Iterator[CellType]:
    cells = engine.memory.cells
    for leaf in engine.lowered.layout.leaves.values():
        counts = leaf.type.is_bool or (leaf.type.is_integer and "." not in leaf.path)
        if counts and leaf.slot is None and not leaf.dims and not leaf.path.startswith(("S:", "~")):
            cell = cells.get(leaf.ident)
            if cell is not None and cell.cell_contents.__class__ in (bool, int):
                yield cell


@remember_last
def noting(lowered: LoweredProgram) -> ObservedScanner:
    """Return the program, compiled once, with code that records the power in all rungs."""
    return observed_scanner_of(lowered, Observation(noted=lines_of(lowered)))
