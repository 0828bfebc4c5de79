"""Formats of numbers in two registers.

    THOUSANDS        upper word: thousands, lower word: remainder; both are negative for a negative value
    SIGN_MAGNITUDE   the same, but bit 15 of the upper word is the sign [3502 manual 1.0, page 1]
    BINARY           one signed 32-bit value, the high word first
    BINARY_LOW       the same, the low word first

A networked drive uses one format for numbers that the host writes and another for numbers that the host reads
[SMD p. 13, p. 25, p. 67, p. 81].
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING

from .image import signed_word
from .thousands import (
    LSW_MAX,
    is_legal_pair,
    join_reported,
    join_reported_all,
    split_reported,
    split_reported_all,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_MAGNITUDE = 0x7FFF


class NumberFormat(Enum):
    """The format of a value in two registers."""

    THOUSANDS = "thousands"
    SIGN_MAGNITUDE = "sign and magnitude"
    BINARY = "binary"
    BINARY_LOW = "binary, low word first"

    def join(self, first: int, second: int) -> int | None:
        """Return the value in two registers, signed or unsigned; None if the words are not a number.

        >>> NumberFormat.THOUSANDS.join(12, 345), NumberFormat.THOUSANDS.join(1, 1000)
        (12345, None)
        >>> NumberFormat.BINARY.join(0xFFFF, 0xFEA7), NumberFormat.BINARY_LOW.join(0x1170, 1)
        (-345, 70000)
        """
        if self in _IN_THOUSANDS:
            upper, lower = self._pair(signed_word(first), signed_word(second))
            return 1000 * upper + lower if is_legal_pair(upper, lower) else None
        return self._binary(first, second)

    def reported(self, first: int, second: int) -> int:
        """Return the value in two signed registers that a module reports; see `join_reported`.

        >>> NumberFormat.SIGN_MAGNITUDE.reported(-32768, 345), NumberFormat.BINARY.reported(1, 4464)
        (-345, 70000)
        """
        if self in _IN_THOUSANDS:
            return join_reported(*self._pair(first, second))
        return self._binary(first, second)

    def reported_all(self, first: NDArray[np.int16], second: NDArray[np.int16]) -> NDArray[np.float64]:
        """Return the values in columns of signed registers; see `reported`."""
        if self is NumberFormat.THOUSANDS:
            return join_reported_all(first, second)
        if self is NumberFormat.SIGN_MAGNITUDE:
            magnitudes: NDArray[np.float64] = (first & _MAGNITUDE).astype(float) * 1000 + second
            magnitudes[first < 0] *= -1
            return magnitudes
        high_words, low_words = (first, second) if self is NumberFormat.BINARY else (second, first)
        values: NDArray[np.float64] = high_words.astype(float) * 65536
        return values + (low_words.astype(int) & 0xFFFF)

    def split(self, value: int) -> tuple[int, int]:
        """Split a value into two signed registers; a value beyond their range wraps [reading R-12].

        >>> NumberFormat.THOUSANDS.split(-12345), NumberFormat.BINARY.split(70000)
        ((-12, -345), (1, 4464))
        """
        if self is NumberFormat.THOUSANDS:
            return split_reported(value)
        if self is NumberFormat.SIGN_MAGNITUDE:
            return to_sign_magnitude(value)
        high_word, low_word = signed_word(value >> 16 & 0xFFFF), signed_word(value & 0xFFFF)
        return (high_word, low_word) if self is NumberFormat.BINARY else (low_word, high_word)

    def split_all(self, values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Split many values, see `split`; the results may have more than the 16 bits of a word.

        SIGN_MAGNITUDE is not supported, since no drive has it.
        """
        if self is NumberFormat.THOUSANDS:
            return split_reported_all(values)
        high_words = values >> 16
        return (high_words, values) if self is NumberFormat.BINARY else (values, high_words)

    def _pair(self, upper: int, lower: int) -> tuple[int, int]:
        """Return two registers in the format THOUSANDS."""
        return from_sign_magnitude(upper, lower) if self is NumberFormat.SIGN_MAGNITUDE else (upper, lower)

    def _binary(self, first: int, second: int) -> int:
        high_word, low_word = (first, second) if self is NumberFormat.BINARY else (second, first)
        value = (high_word & 0xFFFF) << 16 | low_word & 0xFFFF
        return value - (value >> 31 << 32)


_IN_THOUSANDS = (NumberFormat.THOUSANDS, NumberFormat.SIGN_MAGNITUDE)


def from_sign_magnitude(msw: int, lsw: int) -> tuple[int, int]:
    """Convert a sign-and-magnitude pair to a 3601's pair, which is illegal unless the LSW is 0 to 999.

    >>> [from_sign_magnitude(signed_word(0x8000), 345), from_sign_magnitude(signed_word(0x800C), 345)]
    [(0, -345), (-12, -345)]
    """
    thousands = msw & _MAGNITUDE
    if not 0 <= lsw <= LSW_MAX:
        return thousands, LSW_MAX + 1
    return (-thousands, -lsw) if msw < 0 else (thousands, lsw)


def to_sign_magnitude(value: int) -> tuple[int, int]:
    """Return a value as a sign-and-magnitude pair; beyond 32,767,999 the thousands wrap.

    >>> to_sign_magnitude(-345) == (signed_word(0x8000), 345), to_sign_magnitude(12_000)
    (True, (12, 0))
    """
    thousands, units = divmod(abs(value), 1000)
    return signed_word(thousands & _MAGNITUDE | (0x8000 if value < 0 else 0)), units
