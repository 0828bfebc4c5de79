"""Numbers and times of scans by row; a block with evenly spaced scans takes only a few numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.int64]


class EvenSteps:
    """A column that rises evenly within most blocks.

    >>> column = EvenSteps()
    >>> for values in ([5, 7, 9], [9, 10, 20]):
    ...     column.add(np.array(values))
    >>> column.at(np.array([2, 3, 5])).tolist()
    [9, 9, 20]
    """

    def __init__(self) -> None:
        self.rows = 0
        self._begins: list[int] = []  # first row, first value and step of each block
        self._values: list[int] = []
        self._steps: list[int] = []
        self._uneven: dict[int, Column] = {}  # all values of other blocks, by block number

    def add(self, values: Column) -> None:
        """Add the values of a block."""
        if not len(values):
            return
        step = int(values[1]) - int(values[0]) if len(values) > 1 else 0
        if not (values[1:] - values[:-1] == step).all():
            self._uneven[len(self._begins)] = values.copy()
        self._begins.append(self.rows)
        self._values.append(int(values[0]))
        self._steps.append(step)
        self.rows += len(values)

    def at(self, rows: Column) -> Column:
        """Return the values in some rows, given in order."""
        block_begins, values, steps = (
            np.array(column, np.int64) for column in (self._begins, self._values, self._steps)
        )
        block = np.searchsorted(block_begins, rows, "right") - 1
        row_values: Column = values[block] + (rows - block_begins[block]) * steps[block]
        for number, uneven in self._uneven.items():
            own_rows = slice(*np.searchsorted(block, (number, number + 1)))
            row_values[own_rows] = uneven[rows[own_rows] - block_begins[number]]
        return row_values


class RowIndex:
    """Numbers and times of all scans."""

    def __init__(self) -> None:
        self._scans, self._times = EvenSteps(), EvenSteps()

    def add(self, scan: Column, time_ns: Column) -> None:
        """Add a block."""
        self._scans.add(scan)
        self._times.add(time_ns)

    def scan(self, rows: Column) -> Column:
        """Return the numbers of the scans in some rows, given in order."""
        return self._scans.at(rows)

    def time_ns(self, rows: Column) -> Column:
        """Return the times of the scans in some rows, given in order."""
        return self._times.at(rows)
