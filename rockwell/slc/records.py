"""Records of an RSLogix 500 export's parts, each with its line."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class SlcRungRecord:
    """A rung."""

    words: tuple[str, ...]  # the words between SOR and EOR
    line: int
    comment: str = ""  # the comments before it
    whole: bool = True  # whether it ends in EOR
    end: int = 0  # its last line

    @property
    def text(self) -> str:
        """Its text as exported."""
        return " ".join(("SOR", *self.words, *(["EOR"] if self.whole else [])))


@dataclass(slots=True)
class LadderRecord:
    """A ladder file; number 2 is the main one."""

    number: int
    name: str = ""
    line: int = 0  # of its heading; 0 without one
    rungs: list[SlcRungRecord] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class DataRow:
    """A line of values."""

    element: int | None  # of the first value, or the word of an image; None after the previous values
    line: int
    values: tuple[str, ...]


@dataclass(slots=True)
class DataRecord:
    """Values of a data file."""

    file: str  # `N7`, `S`, or `I:1` for the words of a slot
    element: int  # the element in its header; for an image, the word
    line: int
    first: bool = False  # whether the header can't name the last element
    rows: list[DataRow] = field(default_factory=list)

    def first_element(self, words: int) -> int:
        """Return the element of the first value; each element has `words` values."""
        count = sum(len(row.values) for row in self.rows)
        has_addresses = any(row.element is not None for row in self.rows)
        is_last = count == (self.element + 1) * words and not has_addresses
        return 0 if is_last and not self.first else self.element


@dataclass(frozen=True, slots=True)
class SlotRecord:
    """A slot."""

    number: int  # 0 is the processor
    text: str
    line: int
    comment: str = ""
    settings: str = ""  # the lines below it

    @property
    def is_3601(self) -> bool:
        """Whether it is an AMCI 3601, according to its name or its numbers (vendor 3, type 10, code 25)."""
        numbers = tuple(map(int, re.findall(r"(?<![\w.-])\d{1,9}(?![\w.-])", self.text)))
        has_numbers = any(numbers[offset : offset + 3] == (3, 10, 25) for offset in range(len(numbers)))
        return has_numbers or "3601" in self.text or "3601" in self.comment

    @property
    def catalog(self) -> str:
        """Its catalog number; "" if it has none."""
        return self.text.split()[0] if self.text else ""

    @property
    def inputs(self) -> int | None:
        """Number of its input words; None if unknown."""
        return self._size("SCAN_IN")

    @property
    def outputs(self) -> int | None:
        """Number of its output words; None if unknown."""
        return self._size("SCAN_OUT")

    def _size(self, key: str) -> int | None:
        match = re.search(rf"\b{key}\s+(\d{{1,4}})\b", f"{self.text} {self.settings}", re.IGNORECASE)
        return int(match[1]) if match else None


class Other(NamedTuple):
    """An unknown line or word."""

    line: int
    text: str
    file: str = ""  # the data file that it is in; "" outside of DATA


@dataclass(slots=True)
class SlcDocument:
    """An export."""

    file: str
    name: str
    processor: str = ""  # text of START or PROCESSOR
    ladders: dict[int, LadderRecord] = field(default_factory=dict)  # by number
    data: list[DataRecord] = field(default_factory=list)
    slots: dict[int, SlotRecord] = field(default_factory=dict)  # by number
    forces: list[tuple[int, str]] = field(default_factory=list)  # lines with forces that are on
    others: list[Other] = field(default_factory=list)  # ignored lines
    source: bytes = field(default=b"", repr=False)  # the file as it was read
