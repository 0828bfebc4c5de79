r"""Finds occurrences in a trace: the duration of a condition, and the delay of a response.

runs(A)             A   __/‾‾‾‾\____    from the scan in which A begins to hold
                          |<-->|        to the first in which it no longer does

response(A, B)      A   __/‾‾\______    from the scan in which A begins to hold
                    B   _______/‾‾‾‾    to the first later scan in which B holds
                          |<-->|

silence(A, B, 5 ms) the same, if B comes later than 5 ms, or never
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
    """Occurrences, in the order of their beginnings."""

    first: Rows  # row of the first scan of each occurrence
    last: Rows  # row of the last scan of each occurrence
    end: Rows  # row of the scan whose time is the end of each occurrence
    open: Condition  # whether each occurrence lasted beyond the trace

    def __len__(self) -> int:
        return len(self.first)

    def some(self, rows: Rows | slice) -> Occurrences:
        """Return some of the occurrences."""
        return Occurrences(self.first[rows], self.last[rows], self.end[rows], self.open[rows])


class Stretches:
    """The stretches of rows in which a condition holds, collected block by block.

    >>> found = Stretches()
    >>> for block in ([False, True, True], [True, False, True]):
    ...     begun = found.add(np.array(block))
    >>> found.first.tolist(), found.end.tolist()
    ([1, 5], [4])
    """

    def __init__(self) -> None:
        self.rows = 0
        self._changes: list[Rows] = []
        self._holds = False

    def add(self, condition: Condition) -> Rows:
        """Add a block; return the rows of the block in which the condition begins to hold."""
        is_different = np.empty(len(condition), bool)
        is_different[:1] = condition[:1] != self._holds
        np.not_equal(condition[1:], condition[:-1], out=is_different[1:])
        changes = np.flatnonzero(is_different)
        self._changes.append(changes + self.rows)
        self._holds = bool(condition[-1]) if len(condition) else self._holds
        self.rows += len(condition)
        return changes[condition[changes]]

    @property
    def first(self) -> Rows:
        """The first row of each stretch."""
        return self._all[::2]

    @property
    def end(self) -> Rows:
        """The row after each stretch; none for a stretch that continues at the end of the trace."""
        return self._all[1::2]

    @property
    def _all(self) -> Rows:
        self._changes = [np.concatenate(self._changes)] if self._changes else [np.zeros(0, np.int64)]
        return self._changes[0]


Pattern = Callable[[Sequence[Stretches], RowIndex], Occurrences]
"""Function that finds occurrences from the stretches of a query's conditions."""


def runs(conditions: Sequence[Stretches], _rows: RowIndex) -> Occurrences:
    """Find the stretches in which a condition holds."""
    (condition,) = conditions
    first_rows, end = condition.first, condition.end
    open_count = len(first_rows) - len(end)  # 1 if the condition holds in the last scan, else 0
    still_rows = [condition.rows - 1] * open_count
    open_ = np.zeros(len(first_rows), bool)
    open_[len(first_rows) - open_count :] = True
    last_rows, end = (np.concatenate((rows, still_rows)).astype(np.int64) for rows in (end - 1, end))
    return Occurrences(first_rows, last_rows, end, open_)


def response(within_ns: int | None, conditions: Sequence[Stretches], rows: RowIndex) -> Occurrences:
    """Find each beginning of a cause that an effect follows in a later scan, within the time."""
    answers = _answers(*conditions)
    is_answered = ~answers.open
    if within_ns is not None:
        is_answered &= lengths(answers, rows) <= within_ns
    return answers.some(np.flatnonzero(is_answered))


def silence(within_ns: int, conditions: Sequence[Stretches], rows: RowIndex) -> Occurrences:
    """Find each beginning of a cause that no effect follows within the time.

    A cause near the end of the trace is left out if the trace ends before the time is over.
    """
    answers = _answers(*conditions)
    return answers.some(np.flatnonzero(lengths(answers, rows) > within_ns))


def _answers(cause: Stretches, effect: Stretches) -> Occurrences:
    """Find each beginning of a cause, with the first later scan with the effect, else the last scan."""
    first_rows, count = cause.first, cause.rows
    effect_ends = np.append(effect.end, [count] * (len(effect.first) - len(effect.end)))
    effect_begins = np.append(effect.first, count)
    answer = np.maximum(first_rows + 1, effect_begins[np.searchsorted(effect_ends, first_rows + 1, "right")])
    open_ = answer >= count
    last_rows = np.where(open_, count - 1, answer)
    return Occurrences(first_rows, last_rows, last_rows, open_)


def lengths(occurrences: Occurrences, rows: RowIndex) -> Rows:
    """Return the durations of occurrences, ns."""
    lengths_ns: Rows = rows.time_ns(occurrences.end) - rows.time_ns(occurrences.first)
    return lengths_ns
