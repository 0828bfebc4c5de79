"""Two traces in memory, as far as it takes; and where the words of a slot are in the columns."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from ..arrays import column_chunks
from ..columns import SLOT_WORDS, Columns, join, no_columns
from ..layout import SlotInfo
from ..reader import Trace

Progress = Callable[[int], None]
"""Told how many more scans have been read."""


def slot_places(slots: Sequence[SlotInfo]) -> Mapping[int, int]:
    """Return for each slot the first column of its output words."""
    return {slot.number: SLOT_WORDS * place for place, slot in enumerate(slots)}


def read_all(trace: Trace, progress: Progress) -> Columns:
    """Read all scans of a trace, telling how many with each chunk."""
    return join([no_columns(len(trace.head.slots)), *_told(trace, progress)])


def read_from_where_they_part(one: Trace, other: Trace, progress: Progress) -> tuple[Columns, Columns, int]:
    """Read two traces without the chunks in which both are the same, but for the last of those.

    Two equal traces of any length so take no more memory than a chunk of each.

    Args:
        one: the first trace.
        other: the second, with the same slots.
        progress: told how many scans of the first have been read.

    Returns:
        The scans of each, and how many scans of both have been left out before them.
    """
    parts = _told(one, progress), column_chunks(other)
    none = no_columns(len(one.head.slots)), no_columns(len(other.head.slots))
    held, left_out = none, 0
    while True:
        pair = next(parts[0], none[0]), next(parts[1], none[1])
        if not len(pair[0].scan) or not same_columns(*pair):
            a, b = (
                join([before, first, *rest]) for before, first, rest in zip(held, pair, parts, strict=True)
            )
            return a, b, left_out
        left_out += len(held[0].scan)
        held = pair


def _told(trace: Trace, progress: Progress) -> Iterator[Columns]:
    for columns in column_chunks(trace):
        progress(len(columns.scan))
        yield columns


def same_columns(a: Columns, b: Columns) -> bool:
    """Return whether two stretches of scans are the same, bit for bit."""
    return (
        np.array_equal(a.scan, b.scan)
        and np.array_equal(a.time_ns, b.time_ns)
        and np.array_equal(a.flags, b.flags)
        and np.array_equal(a.words, b.words)
    )
