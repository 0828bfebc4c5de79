"""Two traces cut into blocks that can be compared one after the other.

    one     | o  o  o  o | o  o  o  o | o  o        a block: some scans of one, and those of the
    other      o  o  o    o  o  o  o    o  o  o     other that are set against them

By time, a block of one trace needs the scans of the other within the tolerance as well, and
the other way round: these stay in memory, and so do as many scans as a report looks back.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .before import LOOKED_AT
from .differing import Side
from .pairing import Ends, Pairs, Windows, by_number, by_time
from .streaming import Keys, Stream

BLOCK_SCANS = 1 << 14
"""How many scans of a trace are compared at once, at most, where neither has a gap."""


class NumberedBlock(NamedTuple):
    """Scans that are paired by number; all rows are those of the sides.

    Attributes:
        one: what is in memory of the first trace.
        other: what is in memory of the second.
        pairs: the rows that have a partner.
    """

    one: Side
    other: Side
    pairs: Pairs


def blocks_by_number(a: Stream, b: Stream, block_scans: int) -> Iterator[NumberedBlock]:
    """Yield two traces block by block, their scans paired by number."""
    while _read_rows(a, b, block_scans):
        ends = _cut(a, b, block_scans)
        own, others = a.keys[a.row : ends[0]], b.keys[b.row : ends[1]]
        pairs = by_number(own, others)
        yield NumberedBlock(a.side, b.side, pairs._replace(a=pairs.a + a.row, b=pairs.b + b.row))
        for stream, end in ((a, ends[0]), (b, ends[1])):
            stream.go_to(end, end - 1 - LOOKED_AT)


def _read_rows(a: Stream, b: Stream, block_scans: int) -> bool:
    """Have more than a block of both traces in memory; return whether there is anything left of either."""
    for stream in (a, b):
        stream.read_rows(block_scans)
    return a.row < len(a) or b.row < len(b)


def _cut(a: Stream, b: Stream, block_scans: int) -> tuple[int, int]:
    """Return the rows at which the next block ends: before the same key in both."""
    streams = a, b
    ends = [int(each.keys[each.row + block_scans]) for each in streams if len(each) > each.row + block_scans]
    if not ends:
        return len(a), len(b)
    least = min(int(each.keys[each.row]) for each in streams if each.row < len(each))
    end = max(min(ends), least + 1)  # it goes on, even if a whole block has one key
    for each in streams:
        each.read_beyond(end)
    return _row(a.keys, end), _row(b.keys, end)


def _row(keys: Keys, key: int) -> int:
    """Return the first row with this key or a greater one."""
    return int(np.searchsorted(keys, key, "left"))


class TimedBlock(NamedTuple):
    """Scans that are paired by time; all rows are those of the sides.

    Attributes:
        one: what is in memory of the first trace.
        other: what is in memory of the second.
        there: what the scans of the first are set against.
        back: what those of the second are set against: scans of the block, in force at their times.
    """

    one: Side
    other: Side
    there: Windows
    back: Windows


def blocks_by_time(a: Stream, b: Stream, tolerance_ns: int, block_scans: int) -> Iterator[TimedBlock]:
    """Yield two traces block by block, their scans paired by time.

    A scan of the second trace belongs to the block of the scan of the first that is in force at
    its time. So a block is longer than it should be where the first trace has a gap.
    """
    _skip_to(b, a, tolerance_ns)
    while _read_rows(a, b, block_scans) and a.row < len(a):
        end_a = _end_by_time(a, b, block_scans)
        end_b = _others_until(a, b, end_a, tolerance_ns)
        b.read_beyond(int(a.keys[end_a - 1]) + tolerance_ns)
        if end_b > b.row:
            a.read_beyond(int(b.keys[end_b - 1]) + tolerance_ns)
        there = by_time(a.keys[a.row : end_a], b.keys, tolerance_ns, _ends(b))
        back = by_time(b.keys[b.row : end_b], a.keys, tolerance_ns, _ends(a))
        yield TimedBlock(
            a.side,
            b.side,
            there._replace(rows=there.rows + a.row),
            back._replace(rows=back.rows + b.row),
        )
        _go_on(a, b, (end_a, end_b), tolerance_ns)
    while not b.ended:
        b.read_rows(0)
        b.go_to(len(b), len(b))


def _ends(stream: Stream) -> Ends | None:
    """Return the ends of a trace as far as it has been read, None if it has no scans."""
    if stream.first_key is None:
        return None
    period = (stream.last_key - stream.first_key) // (stream.scans - 1) if stream.scans > 1 else 0
    return Ends(stream.first_key, stream.last_key, period, begun=not stream.first_scan)


def _skip_to(stream: Stream, other: Stream, tolerance_ns: int) -> None:
    """Leave out the scans of a trace that are too early to be set against anything in the other."""
    other.read_rows(0)
    if other.first_key is None:
        return
    earliest = other.first_key - tolerance_ns
    stream.read_rows(0)
    while len(stream) and stream.keys[-1] < earliest and not stream.ended:
        stream.go_to(len(stream), len(stream) - 1 - LOOKED_AT)
        stream.read_rows(0)
    row = _row(stream.keys, earliest)
    stream.go_to(row, row - 1 - LOOKED_AT)


def _end_by_time(a: Stream, b: Stream, block_scans: int) -> int:
    """Return the row of the first trace at which the next block ends: one or more, no block of either."""
    end = min(len(a), a.row + block_scans)
    if len(b) > b.row + block_scans:
        end = min(end, _row(a.keys, int(b.keys[b.row + block_scans])))
    return max(end, a.row + 1)


def _others_until(a: Stream, b: Stream, end: int, tolerance_ns: int) -> int:
    """Return the row of the second trace at which a block ends that ends so in the first."""
    ends = _ends(a)
    assert ends is not None, "there is a block of it"
    until = int(a.keys[end]) if end < len(a) else ends.reach_ns(tolerance_ns) + 1
    b.read_beyond(until)
    return _row(b.keys, until)


def _go_on(a: Stream, b: Stream, ends: tuple[int, int], tolerance_ns: int) -> None:
    """Begin the next block; forget what neither its windows nor a report of it look back at."""
    if ends[0] == len(a):
        a.row, b.row = ends
        return
    early = int(a.keys[ends[0]]) - tolerance_ns
    for stream, end in ((a, ends[0]), (b, ends[1])):
        in_force = int(np.searchsorted(stream.keys, early, "right")) - 1
        stream.go_to(end, min(end - 1 - LOOKED_AT, in_force))
