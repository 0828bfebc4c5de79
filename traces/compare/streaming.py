"""Scans of one trace, read part by part and forgotten block by block.

    forgotten        in memory                         not read yet
    . . . . . . | o o o o o o o o o o o o o o o o o | . . . . . .
                  before  ^ `row`, where the next
                            block begins

Scans lie in the order of a key: their time, or their number. Rows count from the
first scan in memory, so they change when scans are forgotten.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..format.layout import SlotInfo
from ..read.columns import SLOT_WORDS, Columns, join, no_columns
from .alignment import Clock
from .differing import Side

Keys = NDArray[np.int64]
Keyed = Iterator[tuple[Columns, Keys]]
"""Parts of a trace, each with a key for every scan; the keys of a trace never descend."""


def keyed_by_time(parts: Iterable[Columns], clock: Clock) -> Keyed:
    """Yield the parts of a trace with the times of their scans.

    Args:
        parts: scans of the trace, part by part.
        clock: turns the times of the scans into those that are wanted.

    Raises:
        ValueError: time goes back from one scan to the next.
    """
    last = np.zeros(0, np.int64)
    for columns in parts:
        back = np.flatnonzero(np.diff(np.concatenate((last, columns.time_ns))) < 0)
        if len(back):
            scan = columns.scan[back[0] + 1 - len(last)]
            raise ValueError(f"time goes back in scan {scan}: such a trace can't be compared by time")
        last = columns.time_ns[-1:] if len(columns.scan) else last
        yield columns, clock(columns.time_ns)


_RUN = 1 << 32  # a scan number has 32 bits


def keyed_by_number(parts: Iterable[Columns]) -> Keyed:
    """Yield the parts of a trace with the numbers of their scans.

    Where the numbers go back they count as those of another run, beyond all numbers before.

    >>> numbers = np.array([7, 8, 0, 1])
    >>> part = Columns(numbers, numbers, numbers.astype(np.uint32), np.zeros((4, 0), np.int16))
    >>> [keys.tolist() for _, keys in keyed_by_number([part])]
    [[7, 8, 4294967296, 4294967297]]
    """
    last, run = np.zeros(0, np.int64), 0
    for columns in parts:
        steps = np.diff(np.concatenate((last, columns.scan)))
        begins = np.concatenate((np.zeros(1 - len(last), bool), steps < 0))
        runs = run + np.cumsum(begins)
        if len(columns.scan):
            last, run = columns.scan[-1:], int(runs[-1])
            yield columns, columns.scan + _RUN * runs


class Stream:
    """Scans of one trace in blocks: those of the present block, some before it and some after it.

    Args:
        slots: the slots of the trace.
        wanted: numbers of the slots whose words are wanted.
        parts: its scans.
        tags: a row of their tags, None without any.

    Attributes:
        row: the row at which the next block begins.
        scans: how many scans have been read.
        ended: whether all have been read.
        first_scan: number of the first scan of all.
        first_key: its key; None if there is none, or it has not been read.
    """

    def __init__(
        self, slots: Sequence[SlotInfo], wanted: set[int], parts: Keyed, tags: np.dtype[np.void] | None = None
    ) -> None:
        self._columns_of = [
            slice(SLOT_WORDS * place, SLOT_WORDS * (place + 1))
            for place, slot in enumerate(slots)
            if slot.number in wanted
        ]
        self._all = len(self._columns_of) == len(slots)
        numbers = [slot.number for slot in slots if slot.number in wanted]
        self._places = {number: SLOT_WORDS * place for place, number in enumerate(numbers)}
        self._parts = parts
        self._held = [no_columns(len(numbers), tags)]
        self._held_keys = [np.zeros(0, np.int64)]
        self._rows = 0
        self._last_key: int | None = None
        self.row = 0
        self.scans = 0
        self.ended = False
        self.first_key: int | None = None
        self.first_scan = 0

    def __len__(self) -> int:
        """How many rows are in memory."""
        return self._rows

    @property
    def side(self) -> Side:
        """What is in memory."""
        if len(self._held) > 1:
            self._held = [join(self._held)]
        return Side(self._held[0], self._places)

    @property
    def keys(self) -> Keys:
        """The keys of what is in memory."""
        if len(self._held_keys) > 1:
            self._held_keys = [np.concatenate(self._held_keys)]
        return self._held_keys[0]

    @property
    def last_key(self) -> int:
        """The key of the last scan read; there has to be one."""
        assert self._last_key is not None
        return self._last_key

    def read_rows(self, count: int) -> None:
        """Have more than so many rows of the next block in memory, if there are."""
        while len(self) - self.row <= count and not self.ended:
            self._read_on()

    def read_beyond(self, key: int) -> None:
        """Have the scans with keys up to this one in memory, and one after them, if there is any."""
        while (self._last_key is None or self._last_key <= key) and not self.ended:
            self._read_on()

    def go_to(self, row: int, keep: int) -> None:
        """Begin the next block at a row, and forget the rows before another one."""
        keep = max(0, keep)
        if keep:
            columns = self.side.columns
            self._held = [columns.each(lambda column: column[keep:].copy())]
            self._held_keys = [self.keys[keep:].copy()]
            self._rows -= keep
        self.row = row - keep

    def _read_on(self) -> None:
        part = next(self._parts, None)
        if part is None:
            self.ended = True
            return
        columns, keys = part
        if not len(keys):
            return
        if self.first_key is None:
            self.first_key, self.first_scan = int(keys[0]), int(columns.scan[0])
        self._held.append(self._wanted(columns))
        self._held_keys.append(keys)
        self._rows += len(keys)
        self.scans += len(keys)
        self._last_key = int(keys[-1])

    def _wanted(self, columns: Columns) -> Columns:
        """Return the columns without the words of other slots."""
        if self._all:
            return columns
        none = np.zeros((len(columns.scan), 0), np.int16)
        return columns._replace(
            words=np.hstack([none, *(columns.words[:, each] for each in self._columns_of)])
        )
