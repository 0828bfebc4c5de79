"""A listener that records the changes in a run, and their scans.

    group      change of
    status     status bits of a 3601, input words of a card
    command    first two output words of a 3601, output words of a card
    together   several output words in the same scan
    number     upper word of a two-word number, such as a position
    path       power in a rung, or the branches that a Python program takes in one scan
    state      tag or field with a flag, text or small integer, or the line where a sequence waits
    size       size of a larger integer
    pair       status bit under a command
    under      flag while the program is at certain steps

Each group is first compared as a whole. A scan without changes therefore costs only one comparison per group.
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
"""Integers that are recorded by value; other integers are recorded by size."""

MOST_TAGS = 1_000
"""Maximum number of watched tags."""

Values = list[Hashable] | dict[Hashable, Hashable]
"""Values of a group, by place or name."""


class Probe(QuietListener):
    """Records the changes in one run in `edges`. Call `prepared` and `watch` before the run."""

    def __init__(self, edges: Edges) -> None:
        self.edges = edges
        self._notes: list[Any] = []  # power in the rungs of a ladder program
        self._branches = bytearray()  # branches that a Python program has taken in this scan
        self._last_branches = self._no_branches = b""
        self._readers: list[tuple[str, Callable[[], Values]]] = []  # with their groups
        self._last_values: list[Values] = []  # for each reader

    def prepared(self, logic: ScanLogic) -> ScanLogic:
        """Compile an engine's code so that it records the power in its rungs; return the logic."""
        if type(logic) is Engine:
            scanner = noting(logic.lowered)
            notes = self._notes = [None] * scanner.note_count
            logic.compiled_as(lambda engine: scanner.bind(engine, {NOTED: notes}))
        return logic

    def watch(self, logic: ScanLogic, rack: Rack) -> None:
        """Watch a rack and its logic, and clear the records of the previous run.

        Call this before the first scan.
        """
        self._slots = [  # with the numbers of recorded input and output words
            (slot, 2, 2) if may_be_stepper(slot.words) else (slot, len(slot.inputs), len(slot.outputs))
            for slot in rack.slots.values()
        ]
        self._memory = rack.memory
        self._image_ranges = [  # bytes of the recorded words and of a number's upper word, by slot
            (places.outputs.start, places.inputs.start + 2 * min(input_count + 1, len(slot.inputs)))
            for (slot, input_count, _), places in zip(self._slots, rack.layout.places.values(), strict=True)
        ]
        self._last_images = [bytearray(end - begin) for begin, end in self._image_ranges]
        self._words = [((0,) * len(slot.inputs), (0,) * len(slot.outputs)) for slot, *_ in self._slots]
        self.logic = logic
        program, notes = unwrapped(logic), self._notes
        if isinstance(program, Engine):
            self._readers = [("path", lambda: notes), (STATE, _tags_reader(program))]
        else:
            module = namespace_of(program)
            self._branches = module.get(NAME, self._branches)
            self._no_branches = bytes(len(self._branches))
            self._branches[:] = self._no_branches  # clear the notes of the previous run
            self._readers = [(STATE, fields_reader(program, module))]
            if sequences := sequences_in(logic):
                self._readers.append((STATE, _LinesReader(sequences)))
        self._last_values = [[] for _ in self._readers]
        self._is_fresh = [group != "path" for group, _ in self._readers]  # the notes are always the same list

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record what differs from the previous scan: words, the values of each reader, and branches."""
        memory = self._memory
        for index, (begin, end) in enumerate(self._image_ranges):
            if memory[begin:end] != self._last_images[index]:
                self._last_images[index] = memory[begin:end]
                self._note_words(index, scan)
        for index, (group, read) in enumerate(self._readers):
            values, last_values = read(), self._last_values[index]
            if values is not last_values and values != last_values:
                self._note(group, index, values, last_values, scan)
                self._last_values[index] = values if self._is_fresh[index] else values.copy()
        if self._branches:
            self._note_branches(scan)

    def state(self, conditions: str) -> bytes:
        """Return a digest of the program's steps and flags and of the modules' commands and status."""
        words = [
            (slot.fault, tuple(slot.inputs.words[:input_count]), tuple(slot.outputs.words[:output_count]))
            for slot, input_count, output_count in self._slots
        ]
        kinds = [
            [(name, kind.__class__.__name__, kind) for name, kind in _kinds(values)]
            for (group, _), values in zip(self._readers, self._last_values, strict=True)
            if group == STATE
        ]
        return blake2b(repr((conditions, words, kinds)).encode(), digest_size=16).digest()

    def _note_words(self, slot_index: int, scan: int) -> None:
        """Record the words of a slot that have changed, one by one and together.

        Changes of status bits are also recorded under the previous command.
        """
        add = self.edges.add
        slot, input_count, output_count = self._slots[slot_index]
        inputs, outputs = tuple(slot.inputs.words), tuple(slot.outputs.words)
        inputs_before, outputs_before = self._words[slot_index]
        self._words[slot_index] = inputs, outputs
        if outputs != outputs_before:
            words = tuple(word for word, output in enumerate(outputs) if output != outputs_before[word])
            if len(words) > 1:
                add(TOGETHER, (slot_index, words), scan)
        for word in range(max(input_count, output_count)):
            if word < output_count and outputs[word] != outputs_before[word]:
                add(COMMAND, (slot_index, word, outputs[word]), scan)
            if word < input_count and (changed_bits := (inputs[word] ^ inputs_before[word]) & 0xFFFF):
                add("status", (slot_index, word, changed_bits), scan)
                add(PAIR, (slot_index, word, changed_bits, outputs_before[0]), scan)
        # only a 3601 has more input words than recorded ones; word 2 is the upper word of its position
        if input_count < len(inputs) and inputs[2] != inputs_before[2]:
            add("number", slot_index, scan)

    def _note(self, group: str, reader_index: int, values: Values, last_values: Values, scan: int) -> None:
        """Record the values of a reader that have changed; for a flag, also the current steps."""
        add, steps = self.edges.add, None
        last_by_name: Mapping[Hashable, Hashable] = dict(_named(last_values))
        for name, value in _named(values):
            last_value = last_by_name.get(name)
            if last_value is value or (last_value == value and last_value.__class__ is value.__class__):
                continue
            kind = _kind(value)
            add(SIZE if kind.__class__ is _Size else group, (reader_index, name, kind), scan)
            if value.__class__ is bool and group is STATE:
                steps = _steps(values) if steps is None else steps
                if steps:
                    add(UNDER, (reader_index, name, value, steps), scan)

    def _note_branches(self, scan: int) -> None:
        """Record the branches of this scan unless they equal the latest record, and clear them."""
        branches = self._branches
        if branches != self._last_branches:
            if not any(branches):
                return  # the program was not called, or took no branch
            self._last_branches = bytes(branches)
            self.edges.add("path", self._last_branches, scan)
        branches[:] = self._no_branches


def _steps(values: Values) -> tuple[Hashable, ...]:
    """Return the texts and small integers among values: the steps of a program."""
    return tuple(
        value
        for _, value in _named(values)
        if value.__class__ is str or (value.__class__ is int and value in SMALL)
    )


def _named(values: Values) -> Iterable[tuple[Hashable, Hashable]]:
    """Return values with their names or indices."""
    return values.items() if isinstance(values, dict) else enumerate(values)


def _kinds(values: Values) -> Iterator[tuple[Hashable, Hashable]]:
    return ((name, _kind(value)) for name, value in _named(values))


class _Size(int):
    """Signed size of a large integer: eight times its bit length, plus its three leading bits."""


def _kind(value: Hashable) -> Hashable:
    """Return the compared part of a value: the size of a large integer, otherwise the value itself.

    >>> _kind(32), _kind(33), _kind(-2), _kind(-40_000), _kind("go")
    (32, 52, -18, -132, 'go')
    """
    if isinstance(value, Enum):
        return str(value.name)  # other processes may lack the program's class
    if value.__class__ is not int or value in SMALL:
        return value
    assert isinstance(value, int)
    bits = value.bit_length()
    size = 8 * bits + (abs(value) >> max(0, bits - 3))
    return _Size(size if value > 0 else -size)


class _LinesReader:
    """Returns the lines where sequences wait. Reads them again after a sequence has continued."""

    def __init__(self, sequences: Sequence[LogicSequence]) -> None:
        self._sequences = sequences
        self._resumed: list[Any] = []
        self._lines: Values = []

    def __call__(self) -> Values:
        """Return the line of each sequence; None for a finished sequence."""
        resumed = [sequence.resumed for sequence in self._sequences]
        if resumed != self._resumed:
            self._resumed = resumed
            self._lines = [("line", sequence.line) for sequence in self._sequences]
        return self._lines


def _tags_reader(engine: Engine) -> Callable[[], Values]:
    """Return a function that reads the flags and integers of a program, without times and images."""
    cells = list(_tag_cells(engine))[:MOST_TAGS]
    return lambda: [cell.cell_contents for cell in cells]


def _tag_cells(engine: Engine) -> Iterator[CellType]:
    """Yield the cells of flags and of integers outside structures; no arrays, images or system tags."""
    cells = engine.memory.cells
    for leaf in engine.lowered.layout.leaves.values():
        is_state = leaf.type.is_bool or (leaf.type.is_integer and "." not in leaf.path)
        is_tag = leaf.slot is None and not leaf.dims and not leaf.path.startswith(("S:", "~"))
        if is_state and is_tag:
            cell = cells.get(leaf.ident)
            if cell is not None and cell.cell_contents.__class__ in (bool, int):
                yield cell


@remember_last
def noting(lowered: LoweredProgram) -> ObservedScanner:
    """Return a program compiled with code that records the power in all rungs."""
    return observed_scanner_of(lowered, Observation(noted=lines_of(lowered)))
