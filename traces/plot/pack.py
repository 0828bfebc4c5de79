"""Packs columns of any length into a page as scan-to-scan differences, deflated and base64-encoded.

At constant speed, the position changes by the same number of steps in each scan, and the time
by the same number of nanoseconds. Such differences compress well.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

MISSING = -(2**31)
"""Code of a missing value in a column of int32."""


class Packer:
    """Packs one column, block by block.

    Args:
        kind: numpy type of the values. Differences of int32 wrap around, as do the sums in the page.
        differences: whether to pack differences; False = pack the values themselves, for floats.
    """

    def __init__(self, kind: DTypeLike, *, differences: bool = True) -> None:
        self._kind = np.dtype(kind)
        self._differences = differences
        self._last = np.zeros(1, self._kind)
        self._deflate = zlib.compressobj(6)
        self._packed: list[bytes] = []

    def add(self, values: NDArray[Any]) -> None:
        """Add the values of a block."""
        column = values.astype(self._kind)
        if self._differences:
            last_value, column = column[-1:], np.diff(column, prepend=self._last)
            self._last = last_value
        self._packed.append(self._deflate.compress(column.tobytes()))

    def text(self) -> str:
        """Return the packed column. No more blocks can be added afterwards."""
        self._packed.append(self._deflate.flush())
        return base64.b64encode(b"".join(self._packed)).decode("ascii")


def whole(values: NDArray[np.float64]) -> NDArray[np.int32]:
    """Round values to int32; a missing value becomes MISSING.

    >>> whole(np.array([1.6, np.nan])).tolist()
    [2, -2147483648]
    """
    limit = 2**31 - 1
    rounded = np.clip(np.rint(values), -limit, limit)
    return np.where(np.isnan(values), MISSING, rounded).astype(np.int32)
