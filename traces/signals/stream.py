"""Reads a trace as a stream of blocks, so that memory use does not depend on the trace's length.

A block has additional scans before and after it. A change since the previous scan, or a
mean over several scans, therefore does not depend on the ends of the block:

    wide    . . . . o o o o o o o o o o . . . .
    inner           |<- the block's ->|
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.memory_layout import ImagePlaces

from ..read.arrays import column_chunks, extent, scan_count
from ..read.columns import ALL, Columns, Selection, join
from ..read.reader import Trace

SPEED_WINDOW_NS = 20_000_000
"""Time over which speeds are averaged. Over a shorter time, rounding to whole steps would cause noise."""


@dataclass(frozen=True, slots=True)
class Block:
    """A block of successive scans."""

    wide: Columns  # the scans' columns, with up to `margin` more scans on either side
    start: int  # first row of `wide` that belongs to the block
    stop: int  # the row of `wide` after the block
    margin: int  # scans in half of `SPEED_WINDOW_NS`, 1 or more
    places: Mapping[int, ImagePlaces]  # slot number -> its images in the memory block

    def __len__(self) -> int:
        return self.stop - self.start

    @property
    def scan(self) -> NDArray[np.int64]:
        """Numbers of the block's scans."""
        return self.wide.scan[self.start : self.stop]

    @property
    def time_ns(self) -> NDArray[np.int64]:
        """Virtual times of the scans."""
        return self.wide.time_ns[self.start : self.stop]

    @property
    def flags(self) -> NDArray[np.uint32]:
        """The controller's flags in the scans."""
        return self.wide.flags[self.start : self.stop]

    @property
    def tags(self) -> NDArray[np.void]:
        """The recorded tags in the scans, by field."""
        assert self.wide.tags is not None, "the trace has tags"
        return self.wide.tags[self.start : self.stop]

    def image(self, slot: int, direction: str) -> NDArray[np.int16]:
        """Return an image's words in every scan; `direction` is "in" or "out"."""
        return self.wide_image(slot, direction)[self.start : self.stop]

    def wide_image(self, slot: int, direction: str) -> NDArray[np.int16]:
        """Return an image's words in every row of `wide`."""
        return self.wide.words[:, self.places[slot].columns(direction)]


class EmptySelectionError(ValueError):
    """No scan of the trace is in the requested range."""


def blocks(
    trace: Trace,
    selection: Selection = ALL,
    *,
    progress: Callable[[int], None] = lambda scans: None,
    measured: bool = True,
) -> Iterator[Block]:
    """Iterate over the selected scans of a trace, block by block, in order.

    Args:
        progress: called for each block with the number of scans read so far.
        measured: whether the caller reads signals that depend on several scans; if not, blocks have no
            additional scans.

    Raises:
        EmptySelectionError: the trace has no selected scan.
        TraceError: the file has damage that can't be skipped.
    """
    margin = half_window(trace) if measured else 0
    places = trace.head.layout.places
    is_empty = True
    columns = column_chunks(trace, selection, margin=margin, tags=True)
    for with_margins, start, stop in _with_margins(columns, margin):
        progress(stop - start)
        first_row, end_row = selection.rows(with_margins)
        first_row, end_row = max(first_row, start), min(end_row, stop)
        if first_row < end_row:
            is_empty = False
            yield Block(with_margins, first_row, end_row, margin, places)
    if is_empty:
        raise EmptySelectionError(_empty_message(selection, extent(trace)))


def count(trace: Trace, selection: Selection = ALL) -> int:
    """Return the total number of scans that `blocks` reads, using only the indexes."""
    return scan_count(trace, selection, margin=half_window(trace))


def _empty_message(selection: Selection, ends: Columns) -> str:
    """Return the message for an empty selection; `ends` has the trace's first and last scan."""
    if not len(ends.scan):
        return "the trace has no scans"
    start, end = (f"{time_ns / 1e9:.10g}" for time_ns in ends.time_ns.tolist())
    content = f"scans {ends.scan[0]} to {ends.scan[1]}, time {start} s to {end} s"
    return f"the trace has no scan in {selection.says()}; it has {content}"


def half_window(trace: Trace) -> int:
    """Return the number of scans in half of `SPEED_WINDOW_NS`, 1 or more."""
    period_ns = int(trace.head.metadata.get("scan_period_ns", 0)) or SPEED_WINDOW_NS
    return max(1, round(SPEED_WINDOW_NS / 2 / period_ns))


def _with_margins(stream: Iterator[Columns], margin: int) -> Iterator[tuple[Columns, int, int]]:
    """Yield each part of a stream with `margin` rows on either side: columns, first row, end row."""
    if not margin:
        yield from ((columns, 0, len(columns.scan)) for columns in stream)
        return
    margin_before = 0
    held_columns: Columns | None = None
    for columns in stream:
        if held_columns is None:
            held_columns = columns
            continue
        joined = join((held_columns, columns))
        rows_ready = len(joined.scan) - margin
        if rows_ready <= margin_before:
            held_columns = joined
            continue
        yield joined, margin_before, rows_ready
        first_kept = max(0, rows_ready - margin)
        held_columns, margin_before = joined.rows(first_kept, len(joined.scan)), rows_ready - first_kept
    if held_columns is not None and len(held_columns.scan) > margin_before:
        yield held_columns, margin_before, len(held_columns.scan)
