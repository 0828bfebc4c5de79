"""Data files to tags: their types, lengths and values [1747-RM001, "Data files"].

A file is as long as its values, and as the highest element that a rung names; one that is addressed
indirectly has all its 256 elements.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from ..instructions.slc.status import STATUS, WORDS
from ..slc_types import SLC_CONTROL, SLC_COUNTER, SLC_TIMER
from ..spec import Spec, Use
from ..tags import Tag
from ..tree import (
    Address,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Routine,
    SubscriptStep,
    WordStep,
    addresses_in,
    instructions_of,
)
from ..types import BOOL, DINT, INT, MESSAGE, REAL, STRING, DataType, Member, Structure
from .addresses import STRUCTURED
from .addresses import WORDS as INNER
from .document import DataRecord

MOST = 256
"""Elements of a file."""

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
"""Type of an element by the letters of the file."""

_SHOWN = {
    Use.SLC_TIMER: (2, "PRE", "ACC"),
    Use.SLC_COUNTER: (1, "PRE", "ACC"),
    Use.SLC_CONTROL: (1, "LEN", "POS"),
}
"""By the use of an element: how far after it a rung shows its words, and their names."""


_BITS = frozenset({Use.BIT, Use.COIL, Use.LATCH, Use.STORAGE})
"""Uses of a bit."""


def letters_of(name: str) -> str:
    """Return the letters of a file's name.

    >>> letters_of("N7"), letters_of("ST10"), letters_of("I:1")
    ('N', 'ST', 'I')
    """
    return name.split(":")[0].rstrip("0123456789").upper()


@dataclass
class _File:
    """What data and rungs show of a file."""

    name: str
    length: int = 0
    values: dict[int, Any] = field(default_factory=dict)
    members: dict[str, bool] = field(default_factory=dict)
    shown: dict[int, dict[str, int]] = field(default_factory=dict)
    given: bool = False

    def need(self, length: int) -> None:
        self.length = max(self.length, length)


class DataFiles:
    """Collects what data and rungs say of the data files.

    Args:
        specs: the instructions, by name in capitals.
    """

    def __init__(self, specs: Mapping[str, Spec]) -> None:
        self._specs = specs
        self._files: dict[str, _File] = {}
        self._file(STATUS).need(WORDS)

    def _file(self, name: str) -> _File:
        return self._files.setdefault(name.upper(), _File(name.upper()))

    # --- values

    def data(self, record: DataRecord) -> str:
        """Take the values of a data file; return what is wrong with them, "" if nothing is."""
        name, _, first = record.address.partition(":")
        letters = letters_of(name)
        place, _, word = first.partition(".")
        kind = TYPES.get(letters)
        if kind is None:
            return f"values of files {letters} are left out"
        if letters in ("I", "O"):
            name, place = f"{letters}:{int(place)}", word or "0"
        file = self._file(STATUS if letters == "S" else name)
        try:
            values = list(_elements(letters, record.values))
        except ValueError as error:
            return str(error)
        if int(place) + len(values) > MOST:
            return f"a file has up to {MOST} elements, these are {int(place) + len(values)}"
        file.given = True
        file.values.update(enumerate(values, int(place)))
        file.need(int(place) + len(values))
        return ""

    # --- uses

    def routine(self, routine: Routine) -> None:
        """Note the elements that rungs name."""
        for rung in routine.rungs:
            for instruction in instructions_of(rung.series):
                uses = self._uses(instruction)
                for use, operand in zip(uses, instruction.operands, strict=False):
                    for address in addresses_in(operand):
                        self._address(address, is_bit=address is operand and use in _BITS)
                self._show(instruction)
                self._length(instruction)

    def _uses(self, instruction: Instruction) -> list[Use]:
        """Return the use of each operand."""
        spec = self._specs.get(instruction.name)
        uses = list(spec.operands) if spec else []
        return [*uses, *[uses[-1] if uses else Use.ANYTHING] * len(instruction.operands)]

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
        """Keep what a rung shows of a timer, a counter or a control."""
        spec = self._specs.get(instruction.name)
        for place, use in enumerate(spec.operands if spec else ()):
            if use not in _SHOWN or place >= len(instruction.operands):
                continue
            skipped, *names = _SHOWN[use]
            address = instruction.operands[place]
            element = _element(address)
            if element is None or not isinstance(address, Address):
                continue
            words = instruction.operands[place + skipped :]
            if instruction.name in ("BSL", "BSR"):
                words = words[1:]
            given = {
                str(name): int(word.value)
                for name, word in zip(names, words, strict=False)
                if isinstance(word, Number)
            }
            self._file(address.name).shown.setdefault(element, {}).update(given)

    def _length(self, instruction: Instruction) -> None:
        """COP, FLL and sequencers reach as far as their length says."""
        spec = self._specs.get(instruction.name)
        numbers = [each for each in instruction.operands if isinstance(each, Number)]
        if spec is None or instruction.name not in (
            "COP",
            "FLL",
            "SQO",
            "SQC",
            "SQL",
            "FFL",
            "FFU",
            "LFL",
            "LFU",
        ):
            return
        count = numbers[-1].value if instruction.name in ("COP", "FLL") and numbers else 0
        if instruction.name.startswith("SQ") and len(numbers) >= 2:
            count = int(numbers[-2].value) + 1
        elif instruction.name[1] == "F" and len(numbers) >= 2:
            count = numbers[-2].value
        for use, operand in zip(spec.operands, instruction.operands, strict=False):
            element = _element(operand)
            reaches = use in (Use.SOURCE, Use.DESTINATION, Use.TABLE, Use.ARRAY)
            if reaches and element is not None and isinstance(operand, Address):
                self._file(operand.name).need(min(element + int(count), MOST))

    # --- tags

    def tags(self, bound: Iterable[str]) -> Iterator[Tag]:
        """Yield a tag per file.

        Args:
            bound: names of the images that are the rack's, which are not tags.
        """
        without = set(bound)
        for file in self._files.values():
            if file.name not in without and file.length:
                yield Tag(file.name, self._type(file), (min(file.length, MOST),), self._initial(file))

    @property
    def images(self) -> list[str]:
        """The images that are used: `I:1`, `O:1`."""
        return [name for name in self._files if name.startswith(("I:", "O:"))]

    def _type(self, file: _File) -> DataType:
        kind = TYPES.get(letters_of(file.name))
        if kind is not None:
            return kind
        members = tuple(Member(name, BOOL if bit else INT) for name, bit in file.members.items())
        return Structure(f"{file.name}_type", members) if members else INT

    def _initial(self, file: _File) -> list[Any] | None:
        if letters_of(file.name) in STRUCTURED and not file.given:
            values: dict[int, Any] = {place: dict(words) for place, words in file.shown.items()}
        else:
            values = file.values
        if not values:
            return None
        empty: Any = {} if isinstance(self._type(file), Structure) and letters_of(file.name) != "ST" else 0
        empty = "" if letters_of(file.name) == "ST" else empty
        return [values.get(place, empty) for place in range(min(max(values) + 1, file.length, MOST))]


def _element(operand: Operand) -> int | None:
    """Return the number of the element that an address names, None if it is computed."""
    if isinstance(operand, Address) and operand.steps and isinstance(operand.steps[0], WordStep):
        return operand.steps[0].index
    return None


def _elements(letters: str, values: list[str]) -> Iterator[Any]:
    """Yield the elements of a data file from its values.

    Raises:
        ValueError: they are not those of such a file.
    """
    if letters in STRUCTURED:
        if len(values) % 3:
            raise ValueError(f"elements of {letters} have three words, {len(values)} values are given")
        for at in range(0, len(values), 3):
            yield _three_words(letters, *map(_integer, values[at : at + 3]))
    elif letters == "ST":
        yield from (each.strip('"') for each in values)
    elif letters == "F":
        yield from map(float, values)
    else:
        yield from map(_integer, values)


def _three_words(letters: str, flags: int, first: int, second: int) -> dict[str, Any]:
    bits = {name: True for bit, name in STRUCTURED[letters].items() if flags >> bit & 1}
    return {**bits, **dict(zip(INNER[letters], (first, second), strict=True))}


def _integer(text: str) -> int:
    """Return a value: decimal, hexadecimal with h or 16#, or sixteen binary digits."""
    if len(text) == 16 and set(text) <= {"0", "1"}:
        value = int(text, 2)
    elif text.upper().endswith("H"):
        value = int(text[:-1], 16)
    elif text.startswith("16#"):
        value = int(text[3:], 16)
    else:
        return int(text)
    return value - (1 << 16) if 1 << 15 <= value < 1 << 16 else value
