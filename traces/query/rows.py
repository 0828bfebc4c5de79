"""Numbers and times of scans by row. A block with evenly spaced scans is stored as three numbers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Column = NDArray[np.int64]


class EvenSteps:
    """A column whose values usually increase by a constant step within a block.

    >>> column = EvenSteps()
    >>> for values in ([5, 7, 9], [9, 10, 20]):
    ...     column.add(np.array(values))
    >>> column.at(np.array([2, 3, 5])).tolist()
    [9, 9, 20]
    """

    def __init__(self) -> None:
        self.rows = 0  # number of rows added
        self._first_rows: list[int] = []  # of each block
        self._first_values: list[int] = []  # of each block
        self._steps: list[int] = []  # of each block; without meaning for an uneven block
        self._uneven: dict[int, Column] = {}  # all values of each uneven block, by block index

    def add(self, values: Column) -> None:
        """Add the values of a block."""
        if not len(values):
            return
        step = int(values[1]) - int(values[0]) if len(values) > 1 else 0
        if not (values[1:] - values[:-1] == step).all():
            self._uneven[len(self._first_rows)] = values.copy()
        self._first_rows.append(self.rows)
        self._first_values.append(int(values[0]))
        self._steps.append(step)
        self.rows += len(values)

    def at(self, rows: Column) -> Column:
        """Return the values in the given rows, which must be in order."""
        first_rows, first_values, steps = (
            np.array(column, np.int64) for column in (self._first_rows, self._first_values, self._steps)
        )
        block_indexes = np.searchsorted(first_rows, rows, "right") - 1
        rows_in_block = rows - first_rows[block_indexes]
        values: Column = first_values[block_indexes] + rows_in_block * steps[block_indexes]
        for index, block_values in self._uneven.items():
            part = slice(*np.searchsorted(block_indexes, (index, index + 1)))
            values[part] = block_values[rows_in_block[part]]
        return values


class RowIndex:
    """Numbers and times of all scans."""

    def __init__(self) -> None:
        self._scans, self._times = EvenSteps(), EvenSteps()

    def add(self, scan: Column, time_ns: Column) -> None:
        """Add a block."""
        self._scans.add(scan)
        self._times.add(time_ns)

    def scan(self, rows: Column) -> Column:
        """Return the scan numbers in the given rows, which must be in order."""
        return self._scans.at(rows)

    def time_ns(self, rows: Column) -> Column:
        """Return the scan times in the given rows, which must be in order."""
        return self._times.at(rows)
