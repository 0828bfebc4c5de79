"""Keeps every peak of a curve of any length, in bounded memory.

Scans are combined into groups. A group stores the least and the greatest value of its scans. Pairs of groups
are merged when there are more than `GROUPS_MAX`:

    scans     o o o o o o o o o o o o
    groups    |----|----|----|----|      least, greatest; then |---------|---------|
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Times = NDArray[np.int64]
Values = NDArray[np.float64]

GROUPS_MAX = 16_384
"""Maximum number of groups, which is several per pixel of the widest picture."""


@dataclass(frozen=True, slots=True)
class Curve:
    """Groups of scans in order."""

    time_ns: Times  # virtual time of the first scan in each group
    low: Values  # least value in each group; NaN if it has no values
    high: Values  # greatest value in each group; NaN if it has no values

    def line(self) -> tuple[Values, Values]:
        """Return the points of a line through the curve: times in ns, alternating low and high values."""
        if np.array_equal(self.low, self.high, equal_nan=True):
            return self.time_ns.astype(np.float64), self.low
        return np.repeat(self.time_ns.astype(np.float64), 2), np.column_stack((self.low, self.high)).ravel()


class Envelope:
    """Receives values block by block, and keeps a bounded number of groups."""

    def __init__(self) -> None:
        self._per_group = 1  # scans in a group
        self._groups = _empty()
        self._rest = _empty()  # last scans, too few for a group

    def add(self, time_ns: Times, values: NDArray[Any]) -> None:
        """Add the values of a block; a value that is not finite counts as missing."""
        values = np.where(np.isfinite(values), values, np.nan).astype(np.float64, copy=False)
        ungrouped = _stack(self._rest, (time_ns, values, values))
        grouped_rows = len(ungrouped[0]) // self._per_group * self._per_group
        self._rest = tuple(column[grouped_rows:] for column in ungrouped)
        self._groups = _stack(
            self._groups, _grouped(tuple(column[:grouped_rows] for column in ungrouped), self._per_group)
        )
        while len(self._groups[0]) > GROUPS_MAX:
            self._double()

    def curve(self) -> Curve:
        """Return the curve of the added values."""
        groups = self._groups
        if len(self._rest[0]):
            groups = _stack(groups, _grouped(self._rest, len(self._rest[0])))
        return Curve(*groups)

    def _double(self) -> None:
        """Merge pairs of groups, so that each group has twice as many scans."""
        odd = len(self._groups[0]) % 2
        last_group = tuple(column[len(column) - odd :] for column in self._groups)
        self._groups = _grouped(tuple(column[: len(column) - odd] for column in self._groups), 2)
        # a last group without a partner becomes part of the scans that are too few for a group
        self._rest = _stack(last_group, self._rest)
        self._per_group *= 2


Columns = tuple[Any, ...]


def _empty() -> Columns:
    return np.empty(0, np.int64), np.empty(0), np.empty(0)


def _stack(earlier: Columns, later: Columns) -> Columns:
    return tuple(np.concatenate(column_pair) for column_pair in zip(earlier, later, strict=True))


def _grouped(columns: Columns, size: int) -> Columns:
    """Return the first time, the least value and the greatest value of each group of `size` rows.

    Args:
        columns: times, least values and greatest values; their length is a multiple of `size`.
    """
    time_ns, low, high = (column.reshape(-1, size) for column in columns)
    return time_ns[:, 0], np.fmin.reduce(low, axis=1), np.fmax.reduce(high, axis=1)
