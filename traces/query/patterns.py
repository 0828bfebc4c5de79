r"""Occurrences in a trace: the duration of a condition, the delay of an answer.

runs(A)             A   __/‾‾‾‾\____    from the scan in which A begins to hold
                          |<-->|        to the first in which it no longer does

response(A, B)      A   __/‾‾\______    from the scan in which A begins to hold
                    B   _______/‾‾‾‾    to the first later scan in which B holds
                          |<-->|

silence(A, B, 5 ms) the same, where B comes later than 5 ms, or never
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from .columns import Condition, Scans

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Occurrences:
    """Occurrences, in the order of their beginnings."""

    first: Rows  # row of the first scan of each
    last: Rows  # row of the last scan of each
    end: Rows  # row of the scan whose time is the end of each
    open: Condition  # whether each lasted beyond the last scan of the trace

    def __len__(self) -> int:
        return len(self.first)

    def some(self, rows: Rows | slice) -> Occurrences:
        """Return some of the occurrences."""
        return Occurrences(self.first[rows], self.last[rows], self.end[rows], self.open[rows])


Pattern = Callable[[Scans], Occurrences]
"""Finds the occurrences in the columns of a trace."""


def runs(condition: Condition, scans: Scans) -> Occurrences:
    """Find the stretches in which a condition holds."""
    first = _beginnings(condition)
    end = _beginnings(~condition)
    if len(end) and len(first) and end[0] < first[0]:
        end = end[1:]
    elif len(end) and not len(first):
        end = end[:0]
    still = len(first) - len(end)  # 0 or 1: holding in the last scan
    last = np.concatenate((end - 1, [len(scans) - 1] * still)).astype(np.int64)
    end = np.concatenate((end, [len(scans) - 1] * still)).astype(np.int64)
    open_ = np.zeros(len(first), bool)
    open_[len(first) - still :] = True
    return Occurrences(first, last, end, open_)


def response(cause: Condition, effect: Condition, within_ns: int | None, scans: Scans) -> Occurrences:
    """Find each beginning of a cause that an effect follows, in a later scan, and in time."""
    found = _answers(cause, effect, scans)
    answered = ~found.open
    if within_ns is not None:
        answered &= _lengths(found, scans) <= within_ns
    return found.some(np.flatnonzero(answered))


def silence(cause: Condition, effect: Condition, within_ns: int, scans: Scans) -> Occurrences:
    """Find each beginning of a cause that no effect follows in time.

    A cause shortly before the end of the trace is left out if its time is not over.
    """
    found = _answers(cause, effect, scans)
    return found.some(np.flatnonzero(_lengths(found, scans) > within_ns))


def _answers(cause: Condition, effect: Condition, scans: Scans) -> Occurrences:
    """Find each beginning of a cause, with the first later scan in which the effect holds, or the last."""
    first = _beginnings(cause)
    effects = np.append(np.flatnonzero(effect), len(scans))
    answer = effects[np.searchsorted(effects[:-1], first, "right")]
    open_ = answer == len(scans)
    last = np.where(open_, len(scans) - 1, answer)
    return Occurrences(first, last, last, open_)


def _beginnings(condition: Condition) -> Rows:
    """Return the rows in which a condition begins to hold, the first row among them if it holds there."""
    begins = condition.copy()
    begins[1:] &= ~condition[:-1]
    return np.flatnonzero(begins)


def _lengths(found: Occurrences, scans: Scans) -> Rows:
    lengths: Rows = scans.time_ns[found.end] - scans.time_ns[found.first]
    return lengths
