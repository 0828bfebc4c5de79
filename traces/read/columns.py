"""Scans as columns, selections of scans, and words by name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from ..format.layout import SlotInfo, block_layout


class Columns(NamedTuple):
    """Columns of scans, one row per scan."""

    scan: NDArray[np.int64]  # number of the scan, int64
    time_ns: NDArray[np.int64]  # virtual time of its input latch, int64
    flags: NDArray[np.uint32]  # the controller's flags, uint32
    words: NDArray[np.int16]  # the memory block as int16: per slot its output words, then its input words
    tags: NDArray[np.void] | None = None  # recorded tags by field; None if not read, or not in the trace

    def rows(self, start: int, stop: int) -> Columns:
        """Return the rows from `start` to before `stop`."""
        return self.each(lambda column: column[start:stop])

    def at(self, rows: NDArray[np.intp]) -> Columns:
        """Return the rows with these indexes."""
        return self.each(lambda column: column[rows])

    def images(self) -> tuple[NDArray[Any], ...]:
        """Return the columns of the images, which are all except the tags."""
        return self[:4]

    def each(self, change: Callable[[NDArray[Any]], NDArray[Any]]) -> Columns:
        """Apply a function to each column; return the changed columns."""
        return Columns._make(None if column is None else change(column) for column in self)


def join(blocks: Sequence[Columns]) -> Columns:
    """Join the rows of one or more blocks of scans."""
    return Columns._make(
        None if arrays[0] is None else np.concatenate(arrays) for arrays in zip(*blocks, strict=True)
    )


def no_columns(words: int, tags: np.dtype[np.void] | None = None) -> Columns:
    """Return columns without scans.

    Args:
        words: number of words in the memory block.
        tags: type of the row of tags, or None.
    """
    return Columns(
        np.zeros(0, np.int64),
        np.zeros(0, np.int64),
        np.zeros(0, np.uint32),
        np.zeros((0, words), np.int16),
        None if tags is None else np.zeros(0, tags),
    )


def by_name(words: NDArray[np.int16], slots: Sequence[SlotInfo]) -> NDArray[np.void]:
    """Return the words of scans as an array with named fields, without copying the words.

    >>> slots = [SlotInfo(1, "amci3601"), SlotInfo(2, "a toy")]
    >>> named = by_name(np.arange(2 * 32, dtype=np.int16).reshape(2, 32), slots)
    >>> named["slot1"]["in"]["position_lsw"].tolist(), named["slot2"]["out"]["word0"].tolist()
    ([11, 43], [16, 48])

    Args:
        words: `words` of `Columns`, with contiguous rows in memory.
        slots: the slots of the trace, `head.slots`.
    """
    fields = {f"slot{slot.number}": _slot_layout(slot) for slot in slots}
    layout = block_layout(slots)
    table = {
        "names": list(fields),
        "formats": list(fields.values()),
        "offsets": [slot_places.whole.start for slot_places in layout.places.values()],
        "itemsize": layout.size,
    }
    return words.view(np.dtype(table))[:, 0]  # type: ignore[call-overload]


def _slot_layout(slot: SlotInfo) -> np.dtype[np.void]:
    outputs = [(word, "<i2") for word in slot.words.outputs]
    inputs = [(word, "<i2") for word in slot.words.inputs]
    return np.dtype([("out", outputs), ("in", inputs)])


@dataclass(frozen=True, slots=True)
class Selection:
    """A selection of the scans within a range of numbers and a range of times, inclusive."""

    first: int = 0  # lowest scan number
    last: int | None = None  # highest scan number; None = to the end
    start_ns: int = 0
    end_ns: int | None = None  # latest virtual time; None = to the end

    def rows(self, columns: Columns) -> tuple[int, int]:
        """Return the first selected row, and the row after the last selected row."""
        return (
            max(_at_least(columns.scan, self.first), _at_least(columns.time_ns, self.start_ns)),
            min(_beyond(columns.scan, self.last), _beyond(columns.time_ns, self.end_ns)),
        )

    def has(self, scan: Any, time_ns: Any) -> Any:
        """Return whether the selection includes a scan; for columns, a mask."""
        after_start = (scan >= self.first) & (time_ns >= self.start_ns)
        until_end = (self.last is None or scan <= self.last) & (self.end_ns is None or time_ns <= self.end_ns)
        return after_start & until_end

    def says(self) -> str:
        """Return the selection as text, for a message.

        >>> Selection(first=5, end_ns=2_500_000_000).says()
        'scans from 5, time up to 2.5 s'
        """
        phrases = [
            _range("scans", self.first, self.last, unit=1, suffix=""),
            _range("time", self.start_ns, self.end_ns, unit=1e9, suffix=" s"),
        ]
        return ", ".join(phrase for phrase in phrases if phrase) or "all scans"


ALL = Selection()


def _at_least(column: NDArray[np.int64], value: int) -> int:
    return int(np.searchsorted(column, value, "left"))


def _beyond(column: NDArray[np.int64], value: int | None) -> int:
    return len(column) if value is None else int(np.searchsorted(column, value, "right"))


def _range(kind: str, low: int, high: int | None, unit: float, suffix: str) -> str:
    """Return a range as text, divided by a unit and with its suffix; "" if it has no limits."""
    if not low and high is None:
        return ""
    low_text, high_text = (f"{value / unit:.12g}{suffix}" for value in (low, high or 0))
    if high is None:
        return f"{kind} from {low_text}"
    return f"{kind} {low_text} to {high_text}" if low else f"{kind} up to {high_text}"
