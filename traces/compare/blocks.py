"""Cuts two traces, a and b, into blocks that are compared one after the other.

    a     | o  o  o  o | o  o  o  o | o  o        a block: some scans of a, and the scans
    b        o  o  o    o  o  o  o    o  o  o     of b that are compared with them

by number    scan n of a is compared with scan n of b
by time      each scan is compared with the scan in force in the other trace at its time,
             and with all scans in force there within the tolerance:

    a      |     |     |     x     |     |
    b         |  o  |  o  |  o  |  o  |
                 <-- tolerance -->

If scans are paired by time, a block of one trace also needs the scans of the other trace within the
tolerance. These scans stay in memory, as do the scans before a difference that a report shows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..read.columns import Columns
from .findings import LOOKED_AT
from .stream import Keys, Rows, Side, Stream

BLOCK_SCANS = 1 << 14
"""Maximum number of scans of a trace in a block, if neither trace has a gap."""


class Windows(NamedTuple):
    """Rows of one trace, each with its window: the rows of the other trace to compare it with."""

    rows: Rows  # the rows that can be judged, ascending
    in_force: Rows  # for each row, the row of the other trace in force at its time
    first: Rows  # the first row of the other trace that is in force within the tolerance
    end: Rows  # the row after the last row that is in force within the tolerance
    scans: int = 0  # number of rows with a counterpart, including rows that can't be judged

    def at(self, indexes: Rows) -> Windows:
        """Return the windows with these indexes."""
        rows, in_force = self.rows[indexes], self.in_force[indexes]
        return Windows(rows, in_force, self.first[indexes], self.end[indexes])


class ComparedBlock(NamedTuple):
    """Scans that are compared at once; all row numbers refer to `side_a` and `side_b`."""

    side_a: Side  # the scans of the first trace in memory
    side_b: Side  # the scans of the second trace in memory
    windows_a: Windows  # rows of the first trace, with windows in the second
    windows_b: Windows  # rows of the second trace, with windows in the first


NO_ROWS = np.zeros(0, np.intp)


def blocks_by_number(a: Stream, b: Stream, block_scans: int) -> Iterator[ComparedBlock]:
    """Yield two traces block by block, with scans paired by number; a block has only unequal pairs."""
    while _read_rows(a, b, block_scans):
        end_a, end_b = _ends_by_number(a, b, block_scans)
        rows_a, rows_b = _pairs(a.keys[a.row : end_a], b.keys[b.row : end_b])
        rows_a, rows_b = rows_a + a.row, rows_b + b.row
        unequal = _unequal(_some_rows(a.side.columns, rows_a), _some_rows(b.side.columns, rows_b))
        partners = rows_b[unequal]
        windows_a = Windows(rows_a[unequal], partners, partners, partners + 1, len(rows_a))
        windows_b = Windows(NO_ROWS, NO_ROWS, NO_ROWS, NO_ROWS, len(rows_b))
        yield ComparedBlock(a.side, b.side, windows_a, windows_b)
        for stream, end in ((a, end_a), (b, end_b)):
            stream.go_to(end, end - 1 - LOOKED_AT)


def _read_rows(a: Stream, b: Stream, block_scans: int) -> bool:
    """Read more than a block of both traces into memory; return whether either has scans left."""
    for stream in (a, b):
        stream.read_rows(block_scans)
    return a.row < len(a) or b.row < len(b)


def _ends_by_number(a: Stream, b: Stream, block_scans: int) -> tuple[int, int]:
    """Return the row of each trace at which the next block ends; both blocks end before the same key."""
    first_keys, end_keys = list[int](), list[int]()
    for stream in (a, b):
        first_keys += stream.keys[stream.row : stream.row + 1].tolist()
        end_keys += stream.keys[stream.row + block_scans : stream.row + block_scans + 1].tolist()
    if not end_keys:
        return len(a), len(b)
    end_key = max(min(end_keys), min(first_keys) + 1)  # more than the first key: a block is never empty
    for stream in (a, b):
        stream.read_beyond(end_key)
    return a.row_of(end_key), b.row_of(end_key)


def _pairs(a: Keys, b: Keys) -> tuple[Rows, Rows]:
    """Return the rows of the keys that both traces have.

    >>> a, b = _pairs(np.array([0, 1, 2, 4]), np.array([1, 2, 3]))
    >>> a.tolist(), b.tolist()
    ([1, 2], [0, 1])
    """
    if len(a) == len(b) and np.array_equal(a, b):
        return np.arange(len(a)), np.arange(len(a))
    _, rows_a, rows_b = np.intersect1d(a, b, return_indices=True)
    return rows_a, rows_b


def _unequal(a: Columns, b: Columns) -> Rows:
    """Return the rows in which the times, flags, words or tags differ."""
    is_unequal = (a.time_ns != b.time_ns) | (a.flags != b.flags)
    if not np.array_equal(a.words, b.words):
        is_unequal |= (a.words != b.words).any(axis=1)
    if a.tags is not None and b.tags is not None and a.tags.dtype.names:
        is_unequal |= a.tags != b.tags
    return np.flatnonzero(is_unequal)


def _some_rows(columns: Columns, rows: Rows) -> Columns:
    """Return the given rows, which must be in ascending order; adjacent rows are not copied."""
    if len(rows) and rows[-1] - rows[0] + 1 == len(rows):
        return columns.rows(rows[0], rows[-1] + 1)
    return columns.at(rows)


def blocks_by_time(a: Stream, b: Stream, tolerance_ns: int, block_scans: int) -> Iterator[ComparedBlock]:
    """Yield two traces block by block, with scans paired by time.

    A scan of the second trace is in the same block as the first trace's scan that is in force at its time. A
    block is therefore longer where the first trace has a gap.
    """
    _skip_early_scans(b, a, tolerance_ns)
    while _read_rows(a, b, block_scans) and a.row < len(a):
        end_a = _end_by_time(a, b, block_scans)
        end_ns = int(a.keys[end_a]) if end_a < len(a) else a.reach_ns(tolerance_ns) + 1
        b.read_beyond(end_ns)
        end_b = b.row_of(end_ns)
        b.read_beyond(int(a.keys[end_a - 1]) + tolerance_ns)
        if end_b > b.row:
            a.read_beyond(int(b.keys[end_b - 1]) + tolerance_ns)
        windows_a, windows_b = windows(a, end_a, b, tolerance_ns), windows(b, end_b, a, tolerance_ns)
        yield ComparedBlock(a.side, b.side, windows_a, windows_b)
        _begin_next_block(a, b, end_a, end_b, tolerance_ns)
    while not b.ended:
        b.read_rows(0)
        b.go_to(len(b), len(b))


def windows(own: Stream, end: int, other: Stream, tolerance_ns: int) -> Windows:
    """Return the windows of a block's rows in the other trace, by time.

    A scan is in force until the next scan. A row has a counterpart if its time is within the other trace's
    range, extended by the tolerance. It is compared only if the other trace has all scans of its window.

    Args:
        end: the block's end row in `own`; the block starts at `own.row`.
    """
    if other.first_key is None:
        return Windows(NO_ROWS, NO_ROWS, NO_ROWS, NO_ROWS)
    times = own.keys[own.row : end]
    has_counterpart = (times >= other.first_key - tolerance_ns) & (times <= other.reach_ns(tolerance_ns))
    is_judged = has_counterpart & (times + tolerance_ns < other.last_key + other.period_ns)
    if other.first_scan:  # the other trace lacks the scans before its first one
        is_judged &= times - tolerance_ns >= other.first_key
    times = times[is_judged]
    return Windows(
        rows=own.row + np.flatnonzero(is_judged),
        in_force=np.maximum(other.in_force(times), 0),
        first=np.maximum(other.in_force(times - tolerance_ns), 0),
        end=other.in_force(times + tolerance_ns) + 1,
        scans=int(has_counterpart.sum()),
    )


def _skip_early_scans(stream: Stream, other: Stream, tolerance_ns: int) -> None:
    """Skip the scans of a trace that are earlier than the other trace's first scan minus the tolerance."""
    other.read_rows(0)
    if other.first_key is None:
        return
    earliest = other.first_key - tolerance_ns
    stream.read_rows(0)
    while len(stream) and stream.last_key < earliest and not stream.ended:
        stream.go_to(len(stream), len(stream) - 1 - LOOKED_AT)
        stream.read_rows(0)
    row = stream.row_of(earliest)
    stream.go_to(row, row - 1 - LOOKED_AT)


def _end_by_time(a: Stream, b: Stream, block_scans: int) -> int:
    """Return the row of the first trace at which the next block ends, at least one row after its start."""
    end = min(len(a), a.row + block_scans)
    if len(b) > b.row + block_scans:
        end = min(end, a.row_of(int(b.keys[b.row + block_scans])))
    return max(end, a.row + 1)


def _begin_next_block(a: Stream, b: Stream, end_a: int, end_b: int, tolerance_ns: int) -> None:
    """Begin the next block; drop rows that neither its windows nor the report need."""
    if end_a == len(a):
        a.row, b.row = end_a, end_b
        return
    earliest_ns = int(a.keys[end_a]) - tolerance_ns
    for stream, end in ((a, end_a), (b, end_b)):
        stream.go_to(end, min(end - 1 - LOOKED_AT, int(stream.in_force(earliest_ns))))
