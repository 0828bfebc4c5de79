"""Scans of one trace, which are read in parts and dropped in blocks.

    dropped          in memory                         not read yet
    . . . . . . | o o o o o o o o o o o o o o o o o | . . . . . .
                          ^ `row`: the first row
                            of the next block

Scans are ordered by a key: their time, or their number. Row 0 is the first scan
in memory, so row numbers change when scans are dropped.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.memory_layout import ImagePlaces

from ..format.layout import SlotInfo, block_layout
from ..read.columns import Columns, join, no_columns
from .alignment import TimeMap
from .fields import TIME, Array, Field, FieldKind

Rows = NDArray[np.intp]
Keys = NDArray[np.int64]
Keyed = Iterator[tuple[Columns, Keys]]
"""Parts of a trace, each with a key per scan; keys never decrease."""


def keyed_by_time(parts: Iterable[Columns], clock: TimeMap) -> Keyed:
    """Yield the parts of a trace with the times of their scans, converted by a clock.

    Raises:
        ValueError: time goes backwards from one scan to the next.
    """
    last_time = np.zeros(0, np.int64)
    for columns in parts:
        backward = np.flatnonzero(np.diff(np.concatenate((last_time, columns.time_ns))) < 0)
        if len(backward):
            scan = columns.scan[backward[0] + 1 - len(last_time)]
            raise ValueError(f"time goes back in scan {scan}: this trace can only be compared by scan number")
        last_time = columns.time_ns[-1:] if len(columns.scan) else last_time
        yield columns, clock(columns.time_ns)


_RUN = 1 << 32  # a scan number has 32 bits


def keyed_by_number(parts: Iterable[Columns]) -> Keyed:
    """Yield the parts of a trace with the numbers of their scans.

    If a number is less than the number before it, a new run begins, with keys greater than all earlier keys.

    >>> numbers = np.array([7, 8, 0, 1])
    >>> part = Columns(numbers, numbers, numbers.astype(np.uint32), np.zeros((4, 0), np.int16))
    >>> [keys.tolist() for _, keys in keyed_by_number([part])]
    [[7, 8, 4294967296, 4294967297]]
    """
    last_scan, run_before = np.zeros(0, np.int64), 0
    for columns in parts:
        steps = np.diff(np.concatenate((last_scan, columns.scan)))
        is_run_begin = np.concatenate((np.zeros(1 - len(last_scan), bool), steps < 0))
        runs = run_before + np.cumsum(is_run_begin)
        if len(columns.scan):
            last_scan, run_before = columns.scan[-1:], int(runs[-1])
            yield columns, columns.scan + _RUN * runs


class Side(NamedTuple):
    """Scans of one trace in memory, with their columns and the locations of each slot's images."""

    columns: Columns
    places: Mapping[int, ImagePlaces]

    def images(self, field: Field, rows: Rows | None = None) -> Array:
        """Return a field's image in the given rows; None = in all rows."""
        if field.kind is FieldKind.TAG:
            assert self.columns.tags is not None, "tags are compared"
            images: Array = self.columns.tags
        elif field.slot is None:
            images = self.columns.time_ns if field is TIME else self.columns.flags
        else:
            images = self.columns.words[:, self.places[field.slot].columns(field.direction)]
        return images if rows is None else images[rows]


class Stream:
    """Scans of one trace, in blocks: the scans of the current block, and some before and after it.

    Args:
        slots: the slots of the trace.
        numbers: numbers of the slots whose words are needed.
        parts: the scans of the trace, in parts.
        tags: type of a row of tags, or None.

    Attributes:
        row: the row at which the next block begins.
        scans: number of scans read.
        ended: whether all scans have been read.
        first_scan: number of the trace's first scan.
        first_key: key of the first scan; None before it is read.
        last_key: key of the last scan read.
    """

    def __init__(
        self,
        slots: Sequence[SlotInfo],
        numbers: set[int],
        parts: Keyed,
        tags: np.dtype[np.void] | None = None,
    ) -> None:
        full_layout, read_slots = block_layout(slots), [slot for slot in slots if slot.number in numbers]
        layout = block_layout(read_slots)
        self._places = layout.places
        self._word_columns = None  # columns of the trace's words to keep; None = all
        if len(read_slots) < len(slots):
            columns = np.arange(full_layout.words)
            kept_columns = [columns[full_layout.places[slot.number].words] for slot in read_slots]
            # padding may come from any column; here from the first
            self._word_columns = np.concatenate([*kept_columns, np.zeros(layout.padding, int)])
        self._parts = parts
        self._columns = [no_columns(layout.words, tags)]
        self._keys = [np.zeros(0, np.int64)]
        self._rows = 0
        self.row = self.scans = self.first_scan = self.last_key = 0
        self.first_key: int | None = None
        self.ended = False

    def __len__(self) -> int:
        """Return the number of rows in memory."""
        return self._rows

    @property
    def side(self) -> Side:
        """The scans in memory."""
        if len(self._columns) > 1:
            self._columns = [join(self._columns)]
        return Side(self._columns[0], self._places)

    @property
    def keys(self) -> Keys:
        """The keys of the scans in memory."""
        if len(self._keys) > 1:
            self._keys = [np.concatenate(self._keys)]
        return self._keys[0]

    def row_of(self, key: int) -> int:
        """Return the first row with this key or a greater key."""
        return int(np.searchsorted(self.keys, key, "left"))

    def in_force(self, times_ns: Keys | int) -> Rows:
        """Return the row in force at each time; -1 before the first row."""
        return np.searchsorted(self.keys, times_ns, "right") - 1

    def reach_ns(self, tolerance_ns: int) -> int:
        """Return the latest time that can be compared with the scans read so far."""
        return self.last_key + max(self.period_ns, tolerance_ns)

    @property
    def period_ns(self) -> int:
        """The estimated duration of the last scan, which is the average duration of a scan, ns."""
        assert self.first_key is not None, "scans have been read"
        return (self.last_key - self.first_key) // (self.scans - 1) if self.scans > 1 else 0

    def read_rows(self, count: int) -> None:
        """Read until more than `count` rows of the next block are in memory, or the trace ends."""
        while len(self) - self.row <= count and not self.ended:
            self._read_part()

    def read_beyond(self, key: int) -> None:
        """Read all scans with keys up to this key, and the next scan unless the trace ends."""
        while (self.first_key is None or self.last_key <= key) and not self.ended:
            self._read_part()

    def go_to(self, row: int, keep: int) -> None:
        """Begin the next block at row `row`, and drop the rows before row `keep`."""
        keep = max(0, keep)
        if keep:
            columns = self.side.columns
            self._columns = [columns.each(lambda column: column[keep:].copy())]
            self._keys = [self.keys[keep:].copy()]
            self._rows -= keep
        self.row = row - keep

    def _read_part(self) -> None:
        """Read the next part of the trace into memory; set `ended` if there is none."""
        columns, keys = next(self._parts, (None, np.zeros(0, np.int64)))
        self.ended = columns is None
        if columns is None or not len(keys):
            return
        if self.first_key is None:
            self.first_key, self.first_scan = int(keys[0]), int(columns.scan[0])
        if self._word_columns is not None:
            columns = columns._replace(words=columns.words.take(self._word_columns, axis=1))
        self._columns.append(columns)
        self._keys.append(keys)
        self._rows += len(keys)
        self.scans += len(keys)
        self.last_key = int(keys[-1])
