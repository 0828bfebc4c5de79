"""The parts of status file S that instructions use [1747-RM001, appendix "System status file"].

| word | content |
|---|---|
| S:0/0 to 3 | carry, overflow, zero, sign of the last result |
| S:2/14 | a result that does not fit becomes the nearest limit (0) or its low bits (1) |
| S:5/0 | overflow trap: a major fault at the end of the scan, unless the program clears it |
| S:13, S:14 | math register: low and high word |
| S:24 | offset of indexed addresses |
"""

from __future__ import annotations

from ...interpreter import Interpreter
from ...model.arithmetic import wrap

STATUS = "S"
"""Tag of the status file, an array of INT."""

CARRY, OVERFLOW, ZERO, SIGN = 0, 1, 2, 3
"""Bits of S:0."""

FLAGS, SELECTION, MINOR, LOW, HIGH, INDEX = 0, 2, 5, 13, 14, 24
"""Numbers of words in the status file."""

WORDS = 84
"""Minimum length of S."""


class Status:
    """The status file in a scan."""

    def __init__(self, machine: Interpreter) -> None:
        self._machine, self._memory = machine, machine.memory
        self._leaf = machine.memory.layout.leaf(STATUS)

    def __getitem__(self, word: int) -> int:
        """Return a word."""
        return self._machine.whole(self._memory.read(self._leaf, word))

    def __setitem__(self, word: int, value: int) -> None:
        """Set a word to the low 16 bits of a number."""
        self._memory.write(self._leaf, word, wrap(value, 16))

    def set_bit(self, word: int, bit: int, value: bool) -> None:
        """Set a bit."""
        self[word] = self[word] & ~(1 << bit) | value << bit

    @property
    def keeps_low_bits(self) -> bool:
        """Whether an overflow stores the low bits (S:2/14)."""
        return bool(self[SELECTION] >> 14 & 1)

    def set_flags(self, stored: float, *, carry: bool = False, overflow: bool = False) -> None:
        """Set the arithmetic flags from a result; an overflow also sets the trap."""
        others = self[FLAGS] & ~0xF
        bits = carry << CARRY | overflow << OVERFLOW | (stored == 0) << ZERO | (stored < 0) << SIGN
        self[FLAGS] = others | bits
        self[MINOR] = self[MINOR] | overflow

    @property
    def register(self) -> int:
        """The math register as a signed 32-bit number."""
        return wrap((self[HIGH] & 0xFFFF) << 16 | self[LOW] & 0xFFFF, 32)

    @register.setter
    def register(self, value: int) -> None:
        self[LOW], self[HIGH] = value & 0xFFFF, value >> 16 & 0xFFFF
