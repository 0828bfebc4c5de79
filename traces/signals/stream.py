"""A trace as a stream of blocks of columns: memory stays flat however long the trace is.

A block comes with some scans before and after it, so that a change since the
scan before, or a mean over some scans, does not depend on where a block ends:

    wide    . . . . o o o o o o o o o o . . . .
    inner           |<- the block's ->|
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...io_images.image import WORDS
from ..layout import SLOT_BYTES
from ..reader import Trace

SPEED_WINDOW_NS = 20_000_000
"""Time over which a speed is the mean of; less and the whole steps of a position show as noise."""


class Columns(NamedTuple):
    """Columns of scans, a row per scan.

    Attributes:
        scan: number of the scan, int64.
        time_ns: virtual time of its input latch, int64.
        flags: what the CPU was doing, uint32.
        words: the memory block as int16: per slot eight output words, then eight input words.
    """

    scan: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    flags: NDArray[np.uint32]
    words: NDArray[np.int16]

    def rows(self, start: int, stop: int) -> Columns:
        """Return some of the rows."""
        return Columns(
            self.scan[start:stop], self.time_ns[start:stop], self.flags[start:stop], self.words[start:stop]
        )

    def at(self, rows: NDArray[np.intp]) -> Columns:
        """Return some of the rows, by number."""
        return Columns(self.scan[rows], self.time_ns[rows], self.flags[rows], self.words[rows])

    def followed_by(self, other: Columns) -> Columns:
        """Return these rows and then those of another."""
        return Columns(
            np.concatenate((self.scan, other.scan)),
            np.concatenate((self.time_ns, other.time_ns)),
            np.concatenate((self.flags, other.flags)),
            np.concatenate((self.words, other.words)),
        )


@dataclass(frozen=True, slots=True)
class Block:
    """Some scans in a row.

    Attributes:
        wide: their columns, with up to `margin` more scans either side where the trace has them.
        start: first row of `wide` that belongs to the block.
        stop: the row after its last.
        margin: scans in half of `SPEED_WINDOW_NS`, 1 or more.
        places: slot number -> first column of its output words.
    """

    wide: Columns
    start: int
    stop: int
    margin: int
    places: Mapping[int, int]

    def __len__(self) -> int:
        return self.stop - self.start

    @property
    def scan(self) -> NDArray[np.int64]:
        """Numbers of the scans."""
        return self.wide.scan[self.start : self.stop]

    @property
    def time_ns(self) -> NDArray[np.int64]:
        """Virtual times of the scans."""
        return self.wide.time_ns[self.start : self.stop]

    @property
    def flags(self) -> NDArray[np.uint32]:
        """The CPU's flags in the scans."""
        return self.wide.flags[self.start : self.stop]

    def image(self, slot: int, direction: str) -> NDArray[np.int16]:
        """Return an image's eight words in every scan; `direction` is "in" or "out"."""
        return self.wide_image(slot, direction)[self.start : self.stop]

    def wide_image(self, slot: int, direction: str) -> NDArray[np.int16]:
        """Return the same in every row of `wide`."""
        first = self.places[slot] + (WORDS if direction == "in" else 0)
        return self.wide.words[:, first : first + WORDS]


@dataclass(frozen=True, slots=True)
class Selection:
    """Which scans are wanted: those within both ranges, ends included.

    Attributes:
        first: lowest scan number.
        last: highest scan number; None = to the end.
        start_ns: earliest virtual time.
        end_ns: latest virtual time; None = to the end.
    """

    first: int = 0
    last: int | None = None
    start_ns: int = 0
    end_ns: int | None = None

    def rows(self, columns: Columns) -> tuple[int, int]:
        """Return first row and end of the wanted rows."""
        return (
            max(_at_least(columns.scan, self.first), _at_least(columns.time_ns, self.start_ns)),
            min(_beyond(columns.scan, self.last), _beyond(columns.time_ns, self.end_ns)),
        )

    def says(self) -> str:
        """Tell it in words, for a message.

        >>> Selection(first=5, end_ns=2_500_000_000).says()
        'scans from 5, time up to 2.5 s'
        """
        parts = [
            _range("scans", self.first, self.last, 1, ""),
            _range("time", self.start_ns, self.end_ns, 1e9, " s"),
        ]
        return ", ".join(part for part in parts if part) or "all scans"


ALL = Selection()


class EmptySelectionError(ValueError):
    """No scan of the trace is in the wanted range."""


def blocks(
    trace: Trace, selection: Selection = ALL, *, progress: Callable[[int], None] = lambda scans: None
) -> Iterator[Block]:
    """Iterate over the wanted scans of a trace, block by block, in order.

    Args:
        trace: the open trace.
        selection: which scans.
        progress: told how many scans of the trace have been gone through with each block.

    Raises:
        EmptySelectionError: the trace has no such scan.
        TraceError: the file is damaged beyond what can be left out.
    """
    margin = half_window(trace)
    places = {slot.number: SLOT_BYTES // 2 * place for place, slot in enumerate(trace.head.slots)}
    seen: Columns | None = None
    found = False
    for wide, start, stop in _with_margins(_columns(trace), margin):
        progress(stop - start)
        ends = wide.rows(start, start + 1) if seen is None else seen.rows(0, 1)
        seen = ends.followed_by(wide.rows(stop - 1, stop))
        low, high = selection.rows(wide)
        low, high = max(low, start), min(high, stop)
        if low < high:
            found = True
            yield Block(wide, low, high, margin, places)
    if not found:
        raise EmptySelectionError(_nothing(selection, seen))


def _nothing(selection: Selection, ends: Columns | None) -> str:
    """Say that no scan is wanted of those from the first to the last of `ends`."""
    if ends is None:
        return "the trace has no scans"
    start, end = (f"{time_ns / 1e9:.10g}" for time_ns in ends.time_ns.tolist())
    held = f"scans {ends.scan[0]} to {ends.scan[1]}, time {start} s to {end} s"
    return f"the trace has no scan in {selection.says()}; it holds {held}"


def half_window(trace: Trace) -> int:
    """Return how many scans make half of `SPEED_WINDOW_NS`, 1 or more."""
    period_ns = int(trace.head.metadata.get("scan_period_ns", 0)) or SPEED_WINDOW_NS
    return max(1, round(SPEED_WINDOW_NS / 2 / period_ns))


def _with_margins(stream: Iterator[Columns], margin: int) -> Iterator[tuple[Columns, int, int]]:
    """Yield each stretch of columns with `margin` rows before and after it: columns, first row, end."""
    before = 0
    held: Columns | None = None
    for columns in stream:
        if held is None:
            held = columns
            continue
        whole = held.followed_by(columns)
        ready = len(whole.scan) - margin
        if ready <= before:
            held = whole
            continue
        yield whole, before, ready
        keep = max(0, ready - margin)
        held, before = whole.rows(keep, len(whole.scan)), ready - keep
    if held is not None and len(held.scan) > before:
        yield held, before, len(held.scan)


def _at_least(column: NDArray[np.int64], value: int) -> int:
    return int(np.searchsorted(column, value, "left"))


def _beyond(column: NDArray[np.int64], value: int | None) -> int:
    return len(column) if value is None else int(np.searchsorted(column, value, "right"))


def _range(what: str, low: int, high: int | None, unit: float, suffix: str) -> str:
    if not low and high is None:
        return ""
    since, until = (f"{value / unit:.12g}{suffix}" for value in (low, high or 0))
    if high is None:
        return f"{what} from {since}"
    return f"{what} {since} to {until}" if low else f"{what} up to {until}"


def _columns(trace: Trace) -> Iterator[Columns]:
    """Yield the columns of the scans as they come."""
    scans = trace.scans()
    while batch := list(islice(scans, 4096)):
        words = np.frombuffer(b"".join(scan.memory for scan in batch), np.int16).reshape(len(batch), -1)
        yield Columns(
            np.array([scan.scan for scan in batch], np.int64),
            np.array([scan.now_ns for scan in batch], np.int64),
            np.array([scan.flags for scan in batch], np.uint32),
            words,
        )
