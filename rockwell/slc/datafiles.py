"""Data files as tags: types, lengths and values [1747-RM001, "Data files"].

A file extends to the last of its values and of the elements in rungs; with indirect addresses it has all 256
elements. A slot has at least as many words as its SLOT line states.

Elements have the values in DATA. Without readable values, a timer, counter or control has the values in its
rung, and any other element is 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from scanrack.ladder.instructions.slc.status import STATUS, WORDS
from scanrack.ladder.model.predefined.slc_types import SLC_CONTROL, SLC_COUNTER, SLC_TIMER
from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.spec import Spec, Use
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import (
    Address,
    Instruction,
    MemberStep,
    Number,
    Operand,
    SubscriptStep,
    WordStep,
    addresses_in,
    instructions_of,
)
from scanrack.ladder.model.types import BOOL, DINT, INT, MESSAGE, REAL, STRING, DataType, Member, Structure

from .addresses import IMAGES, STRUCTURED
from .datavalues import placed_rows, value_of
from .records import DataRecord

MOST = 256
"""Maximum elements of a file."""

TYPES: Mapping[str, DataType] = {
    **dict.fromkeys(("S", "B", "N", "A", "D"), INT),
    "F": REAL,
    "L": DINT,
    "ST": STRING,
    "T": SLC_TIMER,
    "C": SLC_COUNTER,
    "R": SLC_CONTROL,
    "MG": MESSAGE,
    "I": INT,
    "O": INT,
}
"""Element type by the letters of the file."""

UNREAD = frozenset({"MG"})
"""Files that have values in another order than their elements here."""

_LONG = frozenset(("COP", "FLL", "SQO", "SQC", "SQL", "FFL", "FFU", "LFL", "LFU"))  # with a length
_BITS = frozenset({Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE})  # uses of a bit


def letters_of(name: str) -> str:
    """Return the letters of a file's name.

    >>> letters_of("N7"), letters_of("ST10"), letters_of("I:1")
    ('N', 'ST', 'I')
    """
    return name.split(":")[0].rstrip("0123456789").upper()


@dataclass
class _File:
    """What data and rungs show about a file."""

    name: str
    length: int = 0
    values: dict[int, Any] = field(default_factory=dict)
    members: dict[str, bool] = field(default_factory=dict)
    shown: dict[int, dict[str, int]] = field(default_factory=dict)

    def need(self, length: int) -> None:
        self.length = max(self.length, length)


class DataFiles:
    """Collects the data files from data and rungs."""

    def __init__(self, specs: Mapping[str, Spec]) -> None:
        self._specs = specs
        self._files: dict[str, _File] = {}
        self._file(STATUS).need(WORDS)

    def _file(self, name: str) -> _File:
        return self._files.setdefault(name.upper(), _File(name.upper()))

    # --- values

    def image(self, name: str, words: int) -> None:
        """Set the minimum number of words of a slot."""
        if words:
            self._file(name).need(words)

    def has(self, name: str) -> bool:
        """Return whether data or a rung names a file; rungs call the file PTOX0 PTO."""
        letters = name.rstrip("0123456789")
        return not self._files.keys().isdisjoint((name, letters, letters.removesuffix("X")))

    def data(self, record: DataRecord) -> Iterator[tuple[str, str, int]]:
        """Add the values of a data file; yield the place, text and line of each error."""
        letters = letters_of(record.file)
        if letters not in TYPES or letters in UNREAD:
            if record.rows:
                yield record.file, f"values of files {letters} are left out", record.line
            return
        file = self._file(STATUS if letters == "S" else record.file)
        words = 3 if letters in STRUCTURED else 1
        for place, row in placed_rows(record, words):
            if len(row.values) % words:
                text = f"elements of {letters} have three words, {len(row.values)} values are given"
                yield f"{record.file}:{place}", text, row.line
            end = place + len(row.values) // words
            for index, element in enumerate(range(place, end)):
                where = f"{record.file}{'.' if letters in IMAGES else ':'}{element}"
                if element >= MOST:
                    yield where, f"a file has up to {MOST} elements, these are {end}", row.line
                    return
                try:
                    file.values[element] = value_of(letters, row.values[index * words : (index + 1) * words])
                except ValueError as error:
                    yield where, str(error), row.line
            file.need(end)

    # --- uses

    def routine(self, routine: Routine) -> None:
        """Note the elements that a routine uses."""
        for rung in routine.rungs:
            for instruction in instructions_of(rung.series):
                spec = self._specs.get(instruction.name)
                for place, operand in enumerate(instruction.operands):
                    use = spec.use_at(place) if spec else None
                    for address in addresses_in(operand):
                        self._address(address, is_bit=address is operand and use in _BITS)
                self._show(instruction)
                self._length(instruction)

    def _address(self, address: Address, *, is_bit: bool) -> None:
        file = self._file(address.name)
        for number, step in enumerate(address.steps):
            if isinstance(step, WordStep) and (number == 0 or step.mark == ":"):
                file.need(step.index + 1)
            elif isinstance(step, SubscriptStep):
                file.need(MOST)
            elif isinstance(step, MemberStep):
                file.members[step.name] = is_bit or file.members.get(step.name, False)

    def _show(self, instruction: Instruction) -> None:
        """Note the preset and accumulator that a rung shows."""
        spec = self._specs.get(instruction.name)
        for place, (structure, name) in spec.members.items() if spec else ():
            address, word = instruction.operands[structure], instruction.operands[place : place + 1]
            element = _element(address)
            if element is None or not isinstance(address, Address):
                continue
            shown = self._file(address.name).shown.setdefault(element, {})
            shown.update((name, int(operand.value)) for operand in word if isinstance(operand, Number))

    def _length(self, instruction: Instruction) -> None:
        """Extend a file by the length of a COP, FLL or sequencer instruction."""
        spec = self._specs.get(instruction.name)
        if spec is None or instruction.name not in _LONG:
            return
        count = _count(instruction)
        for use, operand in zip(spec.operands, instruction.operands, strict=False):
            element = _element(operand)
            reaches = use in (Use.SOURCE, Use.DESTINATION, Use.TABLE, Use.ARRAY)
            if reaches and element is not None and isinstance(operand, Address):
                self._file(operand.name).need(min(element + count, MOST))

    # --- tags

    def tags(self, bound: Iterable[str]) -> Iterator[Tag]:
        """Yield a tag per file, except `bound` images of the rack."""
        without = set(bound)
        for file in self._files.values():
            if file.name not in without and file.length:
                yield Tag(file.name, self._type(file), (min(file.length, MOST),), self._initial(file))

    @property
    def images(self) -> list[str]:
        """Return the images in use, such as `I:1` and `O:1`."""
        return [name for name in self._files if name.startswith(("I:", "O:"))]

    def _type(self, file: _File) -> DataType:
        kind = TYPES.get(letters_of(file.name))
        if kind is not None:
            return kind
        members = tuple(Member(name, BOOL if bit else INT) for name, bit in file.members.items())
        return Structure(f"{file.name}_type", members) if members else INT

    def _initial(self, file: _File) -> list[Any] | None:
        values: dict[int, Any] = {**file.shown, **file.values}
        if not values:
            return None
        kind = self._type(file)
        empty: Any = "" if kind is STRING else {} if isinstance(kind, Structure) else 0
        return [values.get(place, empty) for place in range(min(max(values) + 1, file.length, MOST))]


def _count(instruction: Instruction) -> int:
    """Return the number of elements that an instruction uses, from its length operand."""
    name = instruction.name
    numbers = [int(operand.value) for operand in instruction.operands if isinstance(operand, Number)]
    if name in ("COP", "FLL"):
        return numbers[-1] if numbers else 0
    if len(numbers) < 2:
        return 0
    if name.startswith("SQ"):
        return numbers[-2] + 1  # position 0 is the start
    return numbers[-2] if name[1] == "F" else 0


def _element(operand: Operand) -> int | None:
    if isinstance(operand, Address) and operand.steps and isinstance(operand.steps[0], WordStep):
        return operand.steps[0].index
    return None
