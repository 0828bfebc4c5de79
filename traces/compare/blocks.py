"""Cuts two traces into blocks that are compared one after the other.

    one     | o  o  o  o | o  o  o  o | o  o        a block: some scans of one, and those of the
    other      o  o  o    o  o  o  o    o  o  o     other that they are compared with

by number    scan n of one with scan n of the other
by time      each scan with the one in force in the other trace at its time, and with
             all that are in force there within the tolerance:

    one      |     |     |     x     |     |
    other       |  o  |  o  |  o  |  o  |
                   <-- tolerance -->

By time, a block of one trace also needs the scans of the other within the tolerance, and
vice versa: these stay in memory, and so do the scans before a difference that a report shows.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..read.columns import Columns
from .findings import LOOKED_AT
from .stream import Keys, Rows, Side, Stream

BLOCK_SCANS = 1 << 14
"""Maximum scans of a trace in a block, where neither trace has a gap."""


class Windows(NamedTuple):
    """The windows in the other trace for rows of one trace."""

    rows: Rows  # the rows that can be judged, ascending
    held: Rows  # for each row, the row of the other trace in force at its time
    first: Rows  # the first row of the other trace that is in force within the tolerance
    end: Rows  # the row after the last one
    scans: int = 0  # rows with a counterpart, including rows that can't be judged

    def at(self, places: Rows) -> Windows:
        """Return some of the rows."""
        rows, held_rows, first_rows, end, _ = self
        return Windows(rows[places], held_rows[places], first_rows[places], end[places])


class ComparedBlock(NamedTuple):
    """Scans that are compared at once; all row numbers refer to `one` and `other`."""

    one: Side  # the scans of the first trace in memory
    other: Side  # the scans of the second trace in memory
    there: Windows  # the windows with which scans of the first trace are compared
    back: Windows  # the same for the second trace: scans of the block in force at their times


NONE = np.zeros(0, np.intp)


def blocks_by_number(a: Stream, b: Stream, block_scans: int) -> Iterator[ComparedBlock]:
    """Yield two traces block by block, with scans paired by number; only pairs that differ are yielded."""
    while _read_rows(a, b, block_scans):
        end_rows = _cut(a, b, block_scans)
        rows_a, rows_b = _pairs(a.keys[a.row : end_rows[0]], b.keys[b.row : end_rows[1]])
        rows_a, rows_b = rows_a + a.row, rows_b + b.row
        unequal = _unequal(_at(a.side.columns, rows_a), _at(b.side.columns, rows_b))
        held_rows = rows_b[unequal]
        unequal_rows = Windows(rows_a[unequal], held_rows, held_rows, held_rows + 1, len(rows_a))
        yield ComparedBlock(a.side, b.side, unequal_rows, Windows(NONE, NONE, NONE, NONE, len(rows_b)))
        for stream, end in ((a, end_rows[0]), (b, end_rows[1])):
            stream.go_to(end, end - 1 - LOOKED_AT)


def _read_rows(a: Stream, b: Stream, block_scans: int) -> bool:
    """Read more than a block of both traces into memory; return whether either has scans left."""
    for stream in (a, b):
        stream.read_rows(block_scans)
    return a.row < len(a) or b.row < len(b)


def _cut(a: Stream, b: Stream, block_scans: int) -> tuple[int, int]:
    """Return the rows at which the next block ends, before the same key in both traces."""
    streams = a, b
    end_keys = [
        int(longer.keys[longer.row + block_scans])
        for longer in streams
        if len(longer) > longer.row + block_scans
    ]
    if not end_keys:
        return len(a), len(b)
    first_key = min(int(unread.keys[unread.row]) for unread in streams if unread.row < len(unread))
    end = max(min(end_keys), first_key + 1)  # ends past the key, even if a whole block has the same key
    for stream in streams:
        stream.read_beyond(end)
    return a.row_of(end), b.row_of(end)


def _pairs(a: Keys, b: Keys) -> tuple[Rows, Rows]:
    """Return the rows of equal keys.

    >>> a, b = _pairs(np.array([0, 1, 2, 4]), np.array([1, 2, 3]))
    >>> a.tolist(), b.tolist()
    ([1, 2], [0, 1])
    """
    if len(a) == len(b) and np.array_equal(a, b):
        return np.arange(len(a)), np.arange(len(a))
    _, in_a, in_b = np.intersect1d(a, b, return_indices=True)
    return in_a, in_b


def _unequal(a: Columns, b: Columns) -> Rows:
    is_unequal = (a.time_ns != b.time_ns) | (a.flags != b.flags)
    if not np.array_equal(a.words, b.words):
        is_unequal |= (a.words != b.words).any(axis=1)
    if a.tags is not None and b.tags is not None and a.tags.dtype.names:
        is_unequal |= a.tags != b.tags
    return np.flatnonzero(is_unequal)


def _at(columns: Columns, rows: Rows) -> Columns:
    """Return some rows, ascending; adjacent rows are not copied."""
    if len(rows) and rows[-1] - rows[0] + 1 == len(rows):
        return columns.rows(rows[0], rows[-1] + 1)
    return columns.at(rows)


def blocks_by_time(a: Stream, b: Stream, tolerance_ns: int, block_scans: int) -> Iterator[ComparedBlock]:
    """Yield two traces block by block, with scans paired by time.

    A scan of the second trace belongs to the block of the first trace's scan in force at
    its time. A block is therefore longer where the first trace has a gap.
    """
    _skip_to(b, a, tolerance_ns)
    while _read_rows(a, b, block_scans) and a.row < len(a):
        end_a = _end_by_time(a, b, block_scans)
        until = int(a.keys[end_a]) if end_a < len(a) else a.reach_ns(tolerance_ns) + 1
        b.read_beyond(until)
        end_b = b.row_of(until)
        b.read_beyond(int(a.keys[end_a - 1]) + tolerance_ns)
        if end_b > b.row:
            a.read_beyond(int(b.keys[end_b - 1]) + tolerance_ns)
        there_windows, back_windows = windows(a, end_a, b, tolerance_ns), windows(b, end_b, a, tolerance_ns)
        yield ComparedBlock(a.side, b.side, there_windows, back_windows)
        _go_on(a, b, (end_a, end_b), tolerance_ns)
    while not b.ended:
        b.read_rows(0)
        b.go_to(len(b), len(b))


def windows(own: Stream, end: int, other: Stream, tolerance_ns: int) -> Windows:
    """Return the windows of a block's rows in the other trace, by time.

    A scan is in force until the next one. Rows that are beyond the other trace's ends by more than the
    tolerance are left out; rows whose window the other trace does not fill are not judged.
    """
    if other.first_key is None:
        return Windows(NONE, NONE, NONE, NONE)
    times = own.keys[own.row : end]
    is_met = (times >= other.first_key - tolerance_ns) & (times <= other.reach_ns(tolerance_ns))
    is_judged = is_met & (times + tolerance_ns < other.last_key + other.period_ns)
    if other.first_scan:  # scans preceded it
        is_judged &= times - tolerance_ns >= other.first_key
    times = times[is_judged]
    held_rows, first_rows = (
        np.maximum(other.in_force(instants), 0) for instants in (times, times - tolerance_ns)
    )
    last_rows = other.in_force(times + tolerance_ns)
    return Windows(
        own.row + np.flatnonzero(is_judged), held_rows, first_rows, last_rows + 1, int(is_met.sum())
    )


def _skip_to(stream: Stream, other: Stream, tolerance_ns: int) -> None:
    """Skip the scans of a trace that are too early for a window in the other."""
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
    """Return the row of the first trace at which the next block ends: after 1 row to a block of either."""
    end = min(len(a), a.row + block_scans)
    if len(b) > b.row + block_scans:
        end = min(end, a.row_of(int(b.keys[b.row + block_scans])))
    return max(end, a.row + 1)


def _go_on(a: Stream, b: Stream, ends: tuple[int, int], tolerance_ns: int) -> None:
    """Begin the next block; drop rows that neither its windows nor a report need."""
    if ends[0] == len(a):
        a.row, b.row = ends
        return
    early_key = int(a.keys[ends[0]]) - tolerance_ns
    for stream, end in ((a, ends[0]), (b, ends[1])):
        stream.go_to(end, min(end - 1 - LOOKED_AT, int(stream.in_force(early_key))))
