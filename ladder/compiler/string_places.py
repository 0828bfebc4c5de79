"""Strings in bytes, as Python code that reads and writes them without a call."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass

from ..state.tag_bytes import PUT_TEXT


@dataclass(frozen=True, slots=True)
class StringPlace:
    """Text that reads or writes a STRING in bytes."""

    tag: str  # variable of the bytes
    byte: str  # text for its first byte
    capacity: int  # size of DATA

    def __str__(self) -> str:
        """Return the arguments of a call."""
        return f"{self.tag}, {self.byte}, {self.capacity}"

    @property
    def is_fixed(self) -> bool:
        """Whether the byte is a number or a variable."""
        return self.byte.isdigit() or self.byte.isidentifier()

    def read(self, length: str, otherwise: str) -> str:
        """Return text for its characters, or `otherwise` if LEN is out of range; `length` is a new name."""
        if self.byte.isdigit():
            index, begin = str(int(self.byte) // 4), str(int(self.byte) + 4)
        else:
            index, begin = f"{self.byte} >> 2", f"{self.byte} + 4"
        valid = f"0 <= ({length} := {self.tag}.i[{index}]) <= {self.capacity}"
        return f"({self.tag}.bits[{begin}:{begin} + {length}] if {valid} else {otherwise})"

    def store(self, value: str, length: str) -> str:
        """Return a line that stores the characters in the variable `value`, truncated to the size of DATA."""
        return f"{PUT_TEXT}{self.capacity}({self.tag}.bits, {self.byte}, {length}, {value})"
