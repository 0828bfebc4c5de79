"""The latest rows of a session, by scan number."""

from __future__ import annotations

from typing import Any

import numpy as np
from scanrack.runtime.live.ring import Rows

KEPT = 1 << 16
"""Minimum number of rows to keep in a long session."""


class RecentRows:
    """The latest rows in scan order, at most twice `KEPT`."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self._rows = np.zeros(0, dtype)  # allocated with the first rows; a trace has none
        self._length = 0
        self.count = 0
        """Number of rows added so far; positions count from the first row ever added."""

    @property
    def rows(self) -> Rows:
        """The kept rows."""
        return self._rows[: self._length]

    @property
    def begin(self) -> int:
        """Position of the first kept row."""
        return self.count - self._length

    def add(self, rows: Rows) -> None:
        """Add rows; keep only the last row of a scan, since a pause writes its scan again."""
        if not len(rows):
            return
        rows = rows[np.append(rows["scan"][1:] != rows["scan"][:-1], True)]
        if not len(self._rows):
            self._rows = np.zeros(2 * KEPT, self.dtype)
        if self._length and rows["scan"][0] == self._rows["scan"][self._length - 1]:
            self._rows[self._length - 1] = rows[0]
            rows = rows[1:]
        if self._length + len(rows) > len(self._rows):
            keep = self._rows[max(0, self._length - KEPT) : self._length].copy()
            self._rows[: len(keep)] = keep
            self._length = len(keep)
        rows = rows[-KEPT:]
        self._rows[self._length : self._length + len(rows)] = rows
        self._length += len(rows)
        self.count += len(rows)

    def clear(self) -> None:
        """Drop all rows, since another session begins."""
        self._length = 0
        self.count += 1  # so that earlier positions are no longer valid

    def since(self, position: int) -> Rows:
        """Return the kept rows from a position on."""
        return self.rows[max(0, position - self.begin) :]

    def find(self, scan: int) -> int | None:
        """Return the index of a scan in `rows`, or None."""
        numbers = self.rows["scan"]
        index = int(np.searchsorted(numbers, scan))
        return index if index < len(numbers) and numbers[index] == scan else None

    def between(self, first: int, last: int) -> Rows:
        """Return the kept rows from scan `first` to scan `last`, inclusive."""
        numbers = self.rows["scan"]
        low, high = np.searchsorted(numbers, [first, last + 1])
        return self.rows[int(low) : int(high)]
