"""Runs the scans of a ladder program again, in the monitor: tags and power of any of them.

    values      before scan 512                          before scan 768
    rows        512  513  514  ...  600  (601)           images, times, flags: from the ring
    engine      512 ... 600 compiled, 601 noted          tags and power of scan 601

Most questions are about the latest scan: the engine goes on from its present scan.
"""

from __future__ import annotations

import pickle
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from ...io_images.image import IMAGE_BYTES
from ...ladder import LadderLogic
from ...ladder.compiler.observed import LineKey
from ...ladder.debug.journal import restore
from ...ladder.debug.watching import WatchedEngine
from ...ladder.model.errors import LadderFault
from ...runtime.live.ring import Rows
from ...runtime.loop.phases import IDLE_PHASES
from ...runtime.loop.rack import SLOT_BYTES
from ...runtime.loop.scan import MODE_MASK, CpuMode, ScanFlag
from .timeline import Timeline
from .watched_program import Inputs, Values

MOST_VALUES = 4096
"""Values that are kept: of a million scans; then fewer of the older ones."""

MOST_INPUTS = 50_000
"""Notes of what went into scans beside images; a program that writes its inputs has one per scan."""

THINNED = 4096
"""Scans between values among the older ones."""

MOST_REPEATED = 2 * THINNED
"""Scans that are repeated at once to get to one; a tenth of a second of most programs."""

CHAPTERS = 15
"""Stretches of scans that are searched for a change: half a minute at 2 ms."""

Truths = Mapping[LineKey, tuple[bool, ...]]


class SnapshotStore:
    """What the scan process has noted of one program, see `app.watched_program`."""

    def __init__(self) -> None:
        self.scans: list[int] = []
        self._values: list[bytes] = []
        self.inputs: dict[int, Inputs] = {}
        self._forced: list[int] = []

    def take(self, record: Values | Inputs) -> None:
        """Remember a note."""
        if isinstance(record, Inputs):
            if record.scan not in self.inputs:
                self._forced.insert(bisect_right(self._forced, record.scan), record.scan)
            self.inputs[record.scan] = record
            if len(self._forced) > 2 * MOST_INPUTS:
                for scan in self._forced[:MOST_INPUTS]:
                    del self.inputs[scan]
                del self._forced[:MOST_INPUTS]
        else:
            at = bisect_right(self.scans, record.scan)
            self.scans.insert(at, record.scan)
            self._values.insert(at, pickle.dumps((record.values, record.truths), pickle.HIGHEST_PROTOCOL))
            if len(self.scans) > MOST_VALUES:
                self._thin_out()

    def _thin_out(self) -> None:
        """Keep fewer of the older values: the shadow may take a moment from one to the next."""
        old = MOST_VALUES // 2
        keep = [at for at, scan in enumerate(self.scans) if at >= old or scan % THINNED == 0]
        self.scans = [self.scans[at] for at in keep]
        self._values = [self._values[at] for at in keep]

    def place(self, scan: int) -> int | None:
        """Return the place of the last values before a scan, or of an earlier one; None without any."""
        place = bisect_right(self.scans, scan) - 1
        return None if place < 0 else place

    def values(self, place: int) -> dict[str, Any]:
        """Return the values at a place."""
        values: dict[str, Any] = pickle.loads(self._values[place])[0]
        return values

    def truths(self, place: int) -> Truths:
        """Return the power of the scan before, where it was noted with the values."""
        truths: Truths | None = pickle.loads(self._values[place])[1]
        return truths or {}

    def forces(self, scan: int) -> Mapping[tuple[str, int], tuple[int | None, Any]]:
        """Return what was forced before a scan."""
        place = bisect_left(self._forced, scan) - 1
        return self.inputs[self._forced[place]].forces if place >= 0 else {}


class Shadow:
    """A ladder program that repeats scans of a session.

    Args:
        program: the program.
        slots: numbers of the slots, in the order of the rack's memory.
        timeline: the rows.
        kept: the values.

    Attributes:
        engine: the engine after scan `at`.
        at: the last scan that was repeated; None before the first.
        truths: power of that scan, by routine in capitals and rung.
        is_impure: there are routines in Python, so that no scan can be repeated.
    """

    def __init__(
        self, program: LadderLogic, slots: list[int], timeline: Timeline, kept: SnapshotStore
    ) -> None:
        self.program = program
        self.engine = WatchedEngine(program.build(), program.scanner)
        self.at: int | None = None
        self.truths: Truths = {}
        self.is_impure = bool(program.functions)
        self._timeline = timeline
        self._kept = kept
        places = {number: place * SLOT_BYTES + IMAGE_BYTES for place, number in enumerate(slots)}
        self._images = [
            (places[int(leaf.slot or 0)], self.engine.memory.cells[leaf.ident].cell_contents.cast("B"))
            for leaf in self.engine.lowered.layout.images
            if not leaf.output
        ]
        self._leaves = {leaf.ident: leaf for leaf in self.engine.lowered.layout.leaves.values()}

    def show(self, scan: int) -> bool:
        """Repeat a scan, so that engine and truths are those after it; return whether that was possible."""
        if self.is_impure:
            return self._show_values(scan)
        start = self._start(scan)
        if start is None:
            return False
        rows = self._timeline.between(start, scan)
        if len(rows) != scan - start + 1:
            self.at = None
            return False
        if len(rows):
            self._repeat(rows)
        self.at = scan
        return True

    def walk(self, first: int, last: int) -> Iterator[int]:
        """Repeat scans in turn; after each yield its time, ns, while the engine is at its end.

        It ends before the first scan that can't be repeated.
        """
        start = self._start(first)
        rows = self._timeline.between(first if start is None else start, last)
        if start is None or not len(rows) or rows[0]["scan"] != start:
            self.at = None
            return
        self.engine.watching = False
        self.engine.note(())
        gaps = np.flatnonzero(np.diff(rows["scan"]) != 1)
        for each in _scans_in(rows[: int(gaps[0]) + 1] if len(gaps) else rows):
            self._do(*each)
            self.at = each[0]
            if each[0] >= first:
                yield each[2]

    # --- looking back: see `ladder.debug.inquiry.Past`

    def again(self, scan: int) -> WatchedEngine:
        """Repeat a scan, watched; return the engine after it.

        Raises:
            ValueError: it can't be repeated.
        """
        self.at = None  # from values before it
        start = self._start(scan)
        rows = self._timeline.between(scan if start is None else start, scan)
        if start is None or len(rows) != scan - start + 1:
            raise ValueError(f"scan {scan} can't be repeated any more")
        self._repeat(rows, watched=True)
        self.at = scan
        return self.engine

    def last_change(self, read: Callable[[WatchedEngine], Any]) -> int | None:
        """Return the last scan, up to the one shown, that changed a value."""
        end = self.at
        if end is None or self.is_impure:
            return None
        try:
            for start, last in self._chapters(end):
                found = self._change_in(start, last, read)
                if found is not None:
                    return found
            return None
        finally:
            self.show(end)

    def _chapters(self, end: int) -> Iterator[tuple[int, int]]:
        """Yield the latest stretches of scans that begin with values, the last one first."""
        place = self._kept.place(end)
        for _ in range(CHAPTERS):
            if place is None or place < 0:
                return
            start = self._kept.scans[place]
            if start <= end:
                yield start, end
            end = start - 1
            place -= 1

    def _change_in(self, start: int, last: int, read: Callable[[WatchedEngine], Any]) -> int | None:
        """Return the last change of a value in a stretch of scans."""
        rows = self._timeline.between(start, last)
        place = self._kept.place(start)
        if len(rows) != last - start + 1 or place is None:
            return None
        self._restore(place)
        found, before = None, read(self.engine)
        for each in _scans_in(rows):
            self._do(*each)
            value = read(self.engine)
            if value != before:
                found, before = each[0], value
        return found

    def _start(self, scan: int) -> int | None:
        """Return the first scan to repeat, and set the engine to it; None without values near it."""
        place, at = self._kept.place(scan), self.at
        begins = None if place is None else self._kept.scans[place]
        if at is not None and at <= scan <= at + MOST_REPEATED and (begins is None or begins <= at + 1):
            return at + 1
        if place is None or begins is None or begins < scan - MOST_REPEATED:
            return None
        self._restore(place)
        return begins

    def _restore(self, place: int) -> None:
        engine, scan = self.engine, self._kept.scans[place]
        engine.hold({})
        engine.note(())
        restore(engine.memory, self._kept.values(place))
        engine.scans = scan
        engine.hold(self._kept.forces(scan))
        self.at = scan - 1

    def _repeat(self, rows: Rows, *, watched: bool = False) -> None:
        """Repeat scans, the last one with power, or watched."""
        engine = self.engine
        engine.watching = False
        engine.note(())
        *before, last = _scans_in(rows)
        for each in before:
            self._do(*each)
        if watched:
            engine.watching = True
        else:
            engine.note_all()
        if self._do(*last):
            self.truths = engine.truths
        engine.watching = False

    def _do(self, scan: int, flags: int, now_ns: int, memory: bytes) -> bool:
        """Repeat one scan; return whether logic ran in it."""
        engine = self.engine
        known = self._kept.inputs.get(scan)
        if known is not None:
            engine.hold(known.forces)
            engine.outside = tuple(
                (self._leaves[ident], index, value)
                for ident, index, value in known.writes
                if ident in self._leaves  # not so of a program that was edited since
            )
        if "logic" in IDLE_PHASES[CpuMode(flags & MODE_MASK)]:
            return False
        for number, (at, cell) in enumerate(self._images):
            if known is not None and known.images is not None:
                cell[:] = known.images[number]
            else:
                cell[:] = memory[at : at + len(cell)]
        with suppress(LadderFault):  # it has stopped that scan then, too
            engine.do(now_ns, first=bool(flags & ScanFlag.FIRST_SCAN))
        return True

    def _show_values(self, scan: int) -> bool:
        """Show values and power of a program with routines in Python, not repeated: the nearest ones."""
        place = self._kept.place(scan + 1)
        if place is None:
            return False
        restore(self.engine.memory, self._kept.values(place))
        self.truths = self._kept.truths(place)
        self.at = scan
        return True


def _scans_in(rows: Rows) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield the number, flags, time and memory of each row."""
    memory, size = rows["words"].tobytes(), rows.dtype["words"].itemsize
    columns = (rows[name].tolist() for name in ("scan", "flags", "now_ns"))
    for place, (scan, flags, now_ns) in enumerate(zip(*columns, strict=True)):
        yield scan, flags, now_ns, memory[place * size : place * size + size]
