"""Data files as tags: types, lengths and values [1747-RM001, "Data files"].

A file extends to its last value in DATA, or to the last element in rungs if that is later. A file with an
indirect address has all 256 elements. A slot has at least as many words as its SLOT line states.

Elements have the values in DATA. Without readable values, a timer, counter or control gets the values in its
rung, and any other element is 0.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
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
"""Maximum number of elements in a file."""

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
"""Files whose values are not read, since their order differs from the order of members."""

_WITH_LENGTH = frozenset(("COP", "FLL", "SQO", "SQC", "SQL", "FFL", "FFU", "LFL", "LFU"))
_BIT_USES = frozenset({Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE})


def letters_of(name: str) -> str:
    """Return the letters of a file's name.

    >>> letters_of("N7"), letters_of("ST10"), letters_of("I:1")
    ('N', 'ST', 'I')
    """
    return name.split(":")[0].rstrip("0123456789").upper()


@dataclass
class _File:
    """A data file, as collected from DATA and rungs."""

    name: str
    length: int = 0  # elements
    values: dict[int, Any] = field(default_factory=dict)  # in DATA, by element
    members: dict[str, bool] = field(default_factory=dict)  # members in rungs; whether each is a bit
    presets: dict[int, dict[str, int]] = field(default_factory=dict)  # values in rungs, by element

    def need(self, length: int) -> None:
        """Extend the file to a minimum length."""
        self.length = max(self.length, length)


class DataFiles:
    """Collects the data files of a program from DATA and rungs."""

    def __init__(self, specs: Mapping[str, Spec]) -> None:
        self._specs = specs
        self._files: dict[str, _File] = {}
        self._file(STATUS).need(WORDS)

    def _file(self, name: str) -> _File:
        """Return a file by name; add an empty one if it is new."""
        return self._files.setdefault(name.upper(), _File(name.upper()))

    # --- values

    def add_image(self, name: str, words: int) -> None:
        """Add the image of a slot with a minimum number of words; with 0 words, do nothing."""
        if words:
            self._file(name).need(words)

    def has(self, name: str) -> bool:
        """Return whether DATA or a rung names a file; a rung can call the file PTOX0 `PTO`."""
        letters = name.rstrip("0123456789")
        return not self._files.keys().isdisjoint((name, letters, letters.removesuffix("X")))

    def add_values(self, record: DataRecord) -> Iterator[tuple[str, str, int]]:
        """Add the values of a data file; yield the address, text and line of each error.

        The file is extended to its last value. Values of a type that is not read are an error.
        """
        letters = letters_of(record.file)
        if letters not in TYPES or letters in UNREAD:
            if record.rows:
                yield record.file, f"values of {letters} files are not read", record.line
            return
        file = self._file(STATUS if letters == "S" else record.file)
        words = 3 if letters in STRUCTURED else 1
        separator = "." if letters in IMAGES else ":"
        for first_element, row in placed_rows(record, words):
            if len(row.values) % words:
                text = f"elements of {letters} have three words, but the line has {len(row.values)} values"
                yield f"{record.file}:{first_element}", text, row.line
            end = first_element + len(row.values) // words
            for index, element in enumerate(range(first_element, end)):
                address = f"{record.file}{separator}{element}"
                if element >= MOST:
                    yield address, f"a file has up to {MOST} elements; this one has {end}", row.line
                    return
                try:
                    file.values[element] = value_of(letters, row.values[index * words : (index + 1) * words])
                except ValueError as error:
                    yield address, str(error), row.line
            file.need(end)

    # --- uses

    def add_uses(self, routine: Routine) -> None:
        """Add the elements that a routine uses."""
        for rung in routine.rungs:
            for instruction in instructions_of(rung.series):
                spec = self._specs.get(instruction.name)
                for index, operand in enumerate(instruction.operands):
                    use = spec.use_at(index) if spec else None
                    for address in addresses_in(operand):
                        self._add_address(address, is_bit=address is operand and use in _BIT_USES)
                if spec is not None:
                    self._add_presets(instruction, spec)
                    if instruction.name in _WITH_LENGTH:
                        self._extend_files(instruction, spec)

    def _add_address(self, address: Address, *, is_bit: bool) -> None:
        """Extend a file to the element of an address, and add the member that the address names.

        An indirect address needs all elements.

        `is_bit` is true if the instruction uses the address as a bit.
        """
        file = self._file(address.name)
        for index, step in enumerate(address.steps):
            if isinstance(step, WordStep) and (index == 0 or step.mark == ":"):
                file.need(step.index + 1)
            elif isinstance(step, SubscriptStep):
                file.need(MOST)
            elif isinstance(step, MemberStep):
                file.members[step.name] = is_bit or file.members.get(step.name, False)

    def _add_presets(self, instruction: Instruction, spec: Spec) -> None:
        """Add the preset and accumulator values in a rung."""
        for index, (structure_index, member) in spec.members.items():
            structure = instruction.operands[structure_index]
            element = _element(structure)
            if element is None or not isinstance(structure, Address):
                continue
            presets = self._file(structure.name).presets.setdefault(element, {})
            value = instruction.operands[index] if index < len(instruction.operands) else None
            if isinstance(value, Number):
                presets[member] = int(value.value)

    def _extend_files(self, instruction: Instruction, spec: Spec) -> None:
        """Extend files to the last element that a COP, FLL, sequencer or stack instruction uses."""
        count = _count(instruction)
        for use, operand in zip(spec.operands, instruction.operands, strict=False):
            element = _element(operand)
            is_file = use in (Use.SOURCE, Use.DESTINATION, Use.TABLE, Use.ARRAY)
            if is_file and element is not None and isinstance(operand, Address):
                self._file(operand.name).need(min(element + count, MOST))

    # --- tags

    def tags(self, bound: Collection[str]) -> Iterator[Tag]:
        """Yield a tag for each file, except the rack's images, which are in `bound`."""
        for file in self._files.values():
            if file.name not in bound and file.length:
                yield Tag(file.name, self._type(file), (min(file.length, MOST),), self._initial(file))

    @property
    def images(self) -> list[str]:
        """The images in use, such as `I:1` and `O:1`."""
        return [name for name in self._files if name.startswith(("I:", "O:"))]

    def _type(self, file: _File) -> DataType:
        """Return the type of an element; a function file is a structure with the members in rungs."""
        kind = TYPES.get(letters_of(file.name))
        if kind is not None:
            return kind
        members = tuple(Member(name, BOOL if bit else INT) for name, bit in file.members.items())
        return Structure(f"{file.name}_type", members) if members else INT

    def _initial(self, file: _File) -> list[Any] | None:
        """Return the elements up to the last one with a value; None without values. DATA takes precedence."""
        values: dict[int, Any] = {**file.presets, **file.values}
        if not values:
            return None
        kind = self._type(file)
        zero: Any = 0
        if isinstance(kind, Structure):
            zero = "" if kind is STRING else {}
        return [values.get(element, zero) for element in range(min(max(values) + 1, file.length, MOST))]


def _count(instruction: Instruction) -> int:
    """Return the number of elements that an instruction uses, from its length operand; 0 if unknown."""
    name = instruction.name
    numbers = [int(operand.value) for operand in instruction.operands if isinstance(operand, Number)]
    if name in ("COP", "FLL"):
        return numbers[-1] if numbers else 0
    if len(numbers) < 2:
        return 0
    if name.startswith("SQ"):
        return numbers[-2] + 1  # position 0 is the start
    return numbers[-2] if name in ("FFL", "FFU", "LFL", "LFU") else 0


def _element(operand: Operand) -> int | None:
    """Return the element of an address; None for an indirect address or another operand."""
    if isinstance(operand, Address) and operand.steps and isinstance(operand.steps[0], WordStep):
        return operand.steps[0].index
    return None
