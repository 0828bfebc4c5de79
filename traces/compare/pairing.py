"""Which scan of one trace is set against which of the other.

by number    scan n of one against scan n of the other
by time      each scan against the one in force in the other trace at its time, and against
             all that are in force there within the tolerance:

    one      |     |     |     x     |     |
    other       |  o  |  o  |  o  |  o  |
                   <-- tolerance -->
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Rows = NDArray[np.intp]
Times = NDArray[np.int64]


class Pairs(NamedTuple):
    """Rows of either trace, paired, and how many rows of either have no partner.

    Attributes:
        a: rows of the first trace, ascending.
        b: the rows of the second that they are paired with.
        only_a: scans of the first without a partner.
        only_b: scans of the second without one.
    """

    a: Rows
    b: Rows
    only_a: int
    only_b: int


class Windows(NamedTuple):
    """What rows of one trace are set against in the other.

    Attributes:
        rows: the rows that have anything to be set against.
        held: for each of them the row of the other trace that is in force at its time.
        first: the first row of the other trace that is in force within the tolerance.
        end: the row after the last one.
        whole: whether the other trace goes on to the end of the tolerance, and began before it.
    """

    rows: Rows
    held: Rows
    first: Rows
    end: Rows
    whole: NDArray[np.bool_]


def by_number(a: NDArray[np.int64], b: NDArray[np.int64]) -> Pairs:
    """Pair scans by their numbers.

    >>> pairs = by_number(np.array([0, 1, 2, 4]), np.array([1, 2, 3]))
    >>> pairs.a.tolist(), pairs.b.tolist(), pairs.only_a, pairs.only_b
    ([1, 2], [0, 1], 2, 1)
    """
    if len(a) == len(b) and np.array_equal(a, b):
        every = np.arange(len(a))
        return Pairs(every, every, 0, 0)
    _, in_a, in_b = np.intersect1d(a, b, return_indices=True)
    return Pairs(in_a, in_b, len(a) - len(in_a), len(b) - len(in_b))


class Ends(NamedTuple):
    """Between which times the scans of a trace show what was in force.

    Attributes:
        first_ns: time of the first scan.
        last_ns: time of the last scan; or of any later than all windows, if there are more.
        period_ns: how long the last scan is in force.
        begun: whether the first scan is the first of all, before which nothing was.
    """

    first_ns: int
    last_ns: int
    period_ns: int
    begun: bool

    def reach_ns(self, tolerance_ns: int) -> int:
        """Return the last time at which anything can be compared with the trace."""
        return self.last_ns + max(self.period_ns, tolerance_ns)


def by_time(own: Times, other: Times, tolerance_ns: int, ends: Ends | None) -> Windows:
    """Set the rows of one trace against those of another by time.

    A scan is in force until the next one; the last one for as long as scans last on the average.
    Rows beyond the other trace's ends by more than that and the tolerance are left out. What is
    known of the other trace must not end within a row's window: `whole` tells where it does not.

    >>> ends = Ends(first_ns=1, last_ns=21, period_ns=10, begun=True)
    >>> windows = by_time(np.array([0, 10, 20]), np.array([1, 11, 21]), 2, ends)
    >>> windows.rows.tolist(), windows.held.tolist(), windows.first.tolist(), windows.end.tolist()
    ([0, 1, 2], [0, 0, 1], [0, 0, 1], [1, 2, 3])
    >>> windows.whole.tolist()
    [True, True, True]

    Args:
        own: times of the rows, ns, ascending.
        other: times of the other trace's rows: all that can be in force within the tolerance.
        tolerance_ns: either way, ns.
        ends: those of the other trace; None if it has no scans.
    """
    if ends is None:
        none = np.zeros(0, np.intp)
        return Windows(none, none, none, none, np.zeros(0, bool))
    after_start = own >= ends.first_ns - tolerance_ns
    rows = np.flatnonzero(after_start & (own <= ends.reach_ns(tolerance_ns)))
    times = own[rows]
    early, late = times - tolerance_ns, times + tolerance_ns
    held, first = (np.maximum(_in_force(other, at), 0) for at in (times, early))
    whole = late < ends.last_ns + ends.period_ns
    if not ends.begun:
        whole &= early >= ends.first_ns
    return Windows(rows, held, first, _in_force(other, late) + 1, whole)


def _in_force(times: NDArray[np.int64], at: NDArray[np.int64]) -> Rows:
    """Return the row that is in force at each time, -1 before the first."""
    return np.searchsorted(times, at, "right") - 1


def over_windows(values: NDArray[Any], first: Rows, end: Rows, join: np.ufunc) -> NDArray[Any]:
    """Return what `join` makes of each window of some values, such as its least or greatest.

    A window of any length is covered by two of a power of two that may overlap, and the values of
    these are made of those half as long:

    >>> values = np.array([5, 3, 8, 1])
    >>> over_windows(values, np.array([0, 1, 0]), np.array([2, 4, 4]), np.minimum).tolist()
    [3, 1, 1]

    Args:
        values: the values.
        first: first row of each window.
        end: the row after its last; more than `first`.
        join: of two values; the same value twice must make that value.
    """
    result = values[first]
    width = end - first
    step, level = 1, values
    while 2 * step <= width.max(initial=1):
        level = join(level[:-step], level[step:])  # of windows 2 * step long
        step *= 2
        fits = np.flatnonzero((width >= step) & (width < 2 * step))
        result[fits] = join(level[first[fits]], level[end[fits] - step])
    return result


def occurs(wanted: NDArray[Any], values: NDArray[Any], first: Rows, end: Rows) -> NDArray[np.bool_]:
    """Return for each window of some values whether the wanted value is in it.

    >>> occurs(np.array([8, 8]), np.array([5, 3, 8, 1]), np.array([0, 1]), np.array([2, 4])).tolist()
    [False, True]
    """
    order = np.argsort(values, kind="stable")  # by value, then by row
    ranked = values[order]
    start, stop = (np.searchsorted(ranked, wanted, side) for side in ("left", "right"))
    rows = len(values) + 1
    group = np.searchsorted(np.unique(values), values[order])
    keys = group * rows + order  # ascending, as both parts of it are
    known = stop > start
    asked = group[np.minimum(start, len(values) - 1)] * rows
    found = np.searchsorted(keys, asked + end) > np.searchsorted(keys, asked + first)
    return known & found
