r"""Finds occurrences in a trace, such as the duration of a condition or the delay of a response.

runs(A)             A   __/‾‾‾‾\____    from the scan in which A becomes true
                          |<-->|        to the scan in which A becomes false

response(A, B)      A   __/‾‾\______    from the scan in which A becomes true
                    B   _______/‾‾‾‾    to the first later scan in which B is true
                          |<-->|

silence(A, B, 5 ms) as `response`, but B becomes true after more than 5 ms, or never
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from .columns import Condition
from .rows import RowIndex

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Occurrences:
    """Occurrences, in the order in which they begin."""

    first: Rows  # row of the first scan of each occurrence
    last: Rows  # row of the last scan of each occurrence
    end: Rows  # row of the scan whose time is the end of each occurrence
    open: Condition  # whether each occurrence lasted beyond the trace

    def __len__(self) -> int:
        return len(self.first)

    def some(self, rows: Rows | slice) -> Occurrences:
        """Return the occurrences with the given indexes."""
        return Occurrences(self.first[rows], self.last[rows], self.end[rows], self.open[rows])


class Stretches:
    """The stretches of rows in which a condition is true, collected block by block.

    >>> stretches = Stretches()
    >>> for block in ([False, True, True], [True, False, True]):
    ...     begins = stretches.add(np.array(block))
    >>> stretches.first.tolist(), stretches.end.tolist()
    ([1, 5], [4])
    """

    def __init__(self) -> None:
        self.rows = 0  # number of rows added
        self._changes: list[Rows] = []  # rows in which the condition changes, first to true
        self._was_true = False  # in the last row added

    def add(self, condition: Condition) -> Rows:
        """Add a block; return the rows of the block in which the condition becomes true."""
        is_change = np.empty(len(condition), bool)
        is_change[:1] = condition[:1] != self._was_true
        np.not_equal(condition[1:], condition[:-1], out=is_change[1:])
        changes = np.flatnonzero(is_change)
        self._changes.append(changes + self.rows)
        self._was_true = bool(condition[-1]) if len(condition) else self._was_true
        self.rows += len(condition)
        return changes[condition[changes]]

    @property
    def first(self) -> Rows:
        """The first row of each stretch."""
        return self._all_changes[::2]

    @property
    def end(self) -> Rows:
        """The row after each stretch, except for a stretch that lasts until the end of the trace."""
        return self._all_changes[1::2]

    @property
    def _all_changes(self) -> Rows:
        self._changes = [np.concatenate(self._changes)] if self._changes else [np.zeros(0, np.int64)]
        return self._changes[0]


Pattern = Callable[[Sequence[Stretches], RowIndex], Occurrences]
"""Function that finds occurrences from the stretches of a query's conditions."""


def runs(conditions: Sequence[Stretches], _rows: RowIndex) -> Occurrences:
    """Find the stretches in which a condition is true."""
    (condition,) = conditions
    open_count = len(condition.first) - len(condition.end)  # 1 if it is true in the last scan, else 0
    last_scan = np.full(open_count, condition.rows - 1)
    is_open = np.arange(len(condition.first)) >= len(condition.end)
    last_rows = np.concatenate((condition.end - 1, last_scan))
    return Occurrences(condition.first, last_rows, np.concatenate((condition.end, last_scan)), is_open)


def response(within_ns: int | None, conditions: Sequence[Stretches], rows: RowIndex) -> Occurrences:
    """Find each start of a cause with an effect in a later scan within the time; None = no time limit."""
    pairs = _causes_with_effects(*conditions)
    has_effect = ~pairs.open
    if within_ns is not None:
        has_effect &= lengths(pairs, rows) <= within_ns
    return pairs.some(np.flatnonzero(has_effect))


def silence(within_ns: int, conditions: Sequence[Stretches], rows: RowIndex) -> Occurrences:
    """Find each start of a cause that has no effect within the time.

    A cause is not counted if the trace ends before this time has elapsed.
    """
    pairs = _causes_with_effects(*conditions)
    return pairs.some(np.flatnonzero(lengths(pairs, rows) > within_ns))


def _causes_with_effects(cause: Stretches, effect: Stretches) -> Occurrences:
    """Find each start of a cause, and the first later scan with the effect, or else the last scan."""
    rows_after, count = cause.first + 1, cause.rows
    effect_ends = np.append(effect.end, [count] * (len(effect.first) - len(effect.end)))
    effect_begins = np.append(effect.first, count)
    # the stretch of the effect that is true in the row after the cause, or the next stretch
    stretches = np.searchsorted(effect_ends, rows_after, "right")
    effect_rows = np.maximum(rows_after, effect_begins[stretches])
    is_open = effect_rows >= count
    last_rows = np.where(is_open, count - 1, effect_rows)
    return Occurrences(cause.first, last_rows, last_rows, is_open)


def lengths(occurrences: Occurrences, rows: RowIndex) -> Rows:
    """Return the durations of occurrences, ns."""
    lengths_ns: Rows = rows.time_ns(occurrences.end) - rows.time_ns(occurrences.first)
    return lengths_ns
