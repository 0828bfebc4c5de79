"""Strings in bytes as Python text that reads and writes them without a call."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass

from ..state.tag_bytes import PUT_TEXT


@dataclass(frozen=True, slots=True)
class StringPlace:
    """A STRING in bytes as text for a call: tag, byte, room for characters."""

    tag: str
    at: str
    room: int

    def __str__(self) -> str:
        return f"{self.tag}, {self.at}, {self.room}"

    @property
    def is_fixed(self) -> bool:
        """Whether the byte is a number or a variable."""
        return self.at.isdigit() or self.at.isidentifier()

    def read(self, length: str, otherwise: str) -> str:
        """Return text for its characters, or `otherwise` if LEN is out of range; `length` is a new name."""
        if self.at.isdigit():
            index, begin = str(int(self.at) // 4), str(int(self.at) + 4)
        else:
            index, begin = f"{self.at} >> 2", f"{self.at} + 4"
        valid = f"0 <= ({length} := {self.tag}.i[{index}]) <= {self.room}"
        return f"({self.tag}.bits[{begin}:{begin} + {length}] if {valid} else {otherwise})"

    def store(self, value: str, length: str) -> str:
        """Return a line that stores the characters in the variable `value`, truncated to its room."""
        return f"{PUT_TEXT}{self.room}({self.tag}.bits, {self.at}, {length}, {value})"
