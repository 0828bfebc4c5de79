"""Positions and speeds in two registers [SMD p. 25, p. 67, p. 81; SD p. 51, p. 55].

    THOUSANDS     upper word: 1000s places, lower word: the rest; both negative for a negative value
    BINARY        one signed 32-bit value, the high word first
    BINARY_LOW    the same, the low word first

What the host writes and what it reads are configured apart [SMD p. 13].
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from ..image import signed_word
from ..thousands import is_legal_pair, split_reported, split_reported_all

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

TARGET_MIN, TARGET_MAX = -8_388_608, 8_388_607
"""Range of positions and distances that the host writes, in each format [SD p. 55; reading R-12]."""


class DriveFormat(Enum):
    """How a value stands in two registers."""

    THOUSANDS = "thousands"
    BINARY = "binary"
    BINARY_LOW = "binary, low word first"

    def join(self, first: int, second: int) -> int | None:
        """Return the value of two registers, signed or unsigned; None for words that are no value.

        >>> DriveFormat.THOUSANDS.join(12, 345), DriveFormat.THOUSANDS.join(1, 1000)
        (12345, None)
        >>> DriveFormat.BINARY.join(0xFFFF, 0xFEA7), DriveFormat.BINARY_LOW.join(0x1170, 1)
        (-345, 70000)
        """
        if self is DriveFormat.THOUSANDS:
            upper, lower = signed_word(first), signed_word(second)
            return 1000 * upper + lower if is_legal_pair(upper, lower) else None
        high, low = (first, second) if self is DriveFormat.BINARY else (second, first)
        value = (high & 0xFFFF) << 16 | low & 0xFFFF
        return value - (value >> 31 << 32)

    def split(self, value: int) -> tuple[int, int]:
        """Return the two registers of a value, signed; a value beyond them wraps [reading R-12].

        >>> DriveFormat.THOUSANDS.split(-12345), DriveFormat.BINARY.split(70000)
        ((-12, -345), (1, 4464))
        """
        if self is DriveFormat.THOUSANDS:
            return split_reported(value)
        high, low = signed_word(value >> 16 & 0xFFFF), signed_word(value & 0xFFFF)
        return (high, low) if self is DriveFormat.BINARY else (low, high)

    def split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Split many values as `split` does; only the low 16 bits of each word count."""
        if self is DriveFormat.THOUSANDS:
            return split_reported_all(values)
        high = values >> 16
        return (high, values) if self is DriveFormat.BINARY else (values, high)
