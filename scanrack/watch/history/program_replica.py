"""Repeats the scans of a ladder program in the monitor, to show tags and power in any scan.

    values      before scan 512                          before scan 768
    rows        512  513  514  ...  600  (601)           images, times, flags: from the ring
    engine      512 ... 600 compiled, 601 traced          tags and power of scan 601

Most questions are about the latest scan, so the engine continues from its current scan.
"""

from __future__ import annotations

import pickle
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from contextlib import suppress
from os import SEEK_END
from tempfile import TemporaryFile
from typing import IO, Any
from weakref import finalize

import numpy as np
import zstandard
from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.jobs.load.recorded_scans import RecordedScan, as_scan
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.executed import TracedEngine
from scanrack.ladder.debug.forces import Forces
from scanrack.ladder.debug.replay import Replayer, Source, Truths
from scanrack.ladder.debug.stretch import ScanInputs
from scanrack.ladder.state.snapshots import restore, snapshot
from scanrack.runtime.live.ring import Rows
from scanrack.runtime.loop.phases import runs_logic
from scanrack.runtime.loop.scan import ScanFlag
from typing_extensions import override

from .recent import RecentRows
from .timeline import Timeline
from .watched_program import Inputs, Values

MOST_INPUTS = 50_000
"""Largest number of notes about other inputs; a program that writes its inputs has one per scan."""

MOST_REPEATED = 8192
"""Largest number of scans repeated to reach a scan; this takes a tenth of a second for most programs."""

CHAPTERS = 120
"""Number of stretches that are searched for a change: half a minute at 2 ms per scan."""

_SIZE_BYTES = 4
_FIRST = int(ScanFlag.FIRST_SCAN)


class ValueFile:
    """Stores values of programs in an unnamed file, which disappears with the process."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None

    def add(self, values: object) -> int | None:
        """Write values; return their place, or None if the disk is full."""
        data = zstandard.compress(pickle.dumps(values, pickle.HIGHEST_PROTOCOL), 1)
        data = len(data).to_bytes(_SIZE_BYTES, "little") + data
        with suppress(OSError):
            if self._file is None:
                self._file = TemporaryFile(buffering=0)  # noqa: SIM115 - closed with this object
                finalize(self, self._file.close)
            offset = self._file.seek(0, SEEK_END)
            if self._file.write(data) == len(data):
                return offset
        return None

    def read(self, at: int) -> Any:
        """Return the values at a place."""
        assert self._file is not None
        self._file.seek(at)
        size = int.from_bytes(self._file.read(_SIZE_BYTES), "little")
        return pickle.loads(zstandard.decompress(self._file.read(size)))


class SnapshotStore:
    """The scan process's notes about one program, see `watched_program`.

    The values are kept in a file, so that even in a long session there is a snapshot shortly before any scan.
    """

    def __init__(self, file: ValueFile | None = None) -> None:
        self.scans = array("q")
        self._file, self._places = file or ValueFile(), array("q")
        self.inputs: dict[int, Inputs] = {}
        self._forced: list[int] = []

    def take(self, record: Values | Inputs) -> None:
        """Store a note unless it contains nothing new."""
        scan = record.scan
        if isinstance(record, Values):
            place = self._file.add((record.values, record.truths))
            if place is not None:
                position = bisect_right(self.scans, scan)
                self.scans.insert(position, scan)
                self._places.insert(position, place)
        elif scan in self.inputs:
            self.inputs[scan] = record
        elif record.writes or record.images is not None or record.forces != self._known_forces(scan):
            self._forced.insert(bisect_right(self._forced, scan), scan)
            self.inputs[scan] = record
            if len(self._forced) > 2 * MOST_INPUTS:
                for old_scan in self._forced[:MOST_INPUTS]:
                    del self.inputs[old_scan]
                del self._forced[:MOST_INPUTS]

    def place(self, scan: int) -> int | None:
        """Return the place of the last values for a scan or an earlier one; None if there are none."""
        place = bisect_right(self.scans, scan) - 1
        return None if place < 0 else place

    def values(self, place: int) -> dict[str, Any]:
        """Return the values at a place."""
        values: dict[str, Any] = self._file.read(self._places[place])[0]
        return values

    def truths(self, place: int) -> Truths:
        """Return the power in the previous scan, if it was stored with the values."""
        truths: Truths | None = self._file.read(self._places[place])[1]
        return truths or {}

    def forces(self, scan: int) -> Forces:
        """Return the forces before a scan."""
        return self._known_forces(scan) or {}

    def _known_forces(self, scan: int) -> Forces | None:
        place = bisect_left(self._forced, scan) - 1
        return self.inputs[self._forced[place]].forces if place >= 0 else None


class SessionScans(Source):
    """Snapshots and inputs of a program, from the rows of a session; see `ladder.debug.replay.Source`."""

    def __init__(
        self, program: LadderLogic, rack: MemoryLayout, timeline: Timeline | RecentRows, kept: SnapshotStore
    ) -> None:
        self._timeline, self._kept = timeline, kept
        self._is_impure = bool(program.functions)
        layout = program.build().layout
        images = [int(leaf.slot or 0) for leaf in layout.images if not leaf.output]
        self._images = [rack.places[slot].inputs for slot in images]
        self._leaves = {leaf.ident: leaf for leaf in layout.leaves.values()}

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the scans with values, backwards from a scan; none if scans can't be repeated."""
        place = None if self._is_impure else self._kept.place(scan)
        return iter(()) if place is None else (self._kept.scans[index] for index in range(place, -1, -1))

    def snapshot(self, scan: int) -> tuple[dict[str, Any], Forces]:
        """Return the values before a scan, and the forces in it."""
        place = self._kept.place(scan)
        assert place is not None
        return self._kept.values(place), self._kept.forces(scan)

    def inputs(self, first: int, last: int) -> tuple[int, Iterator[ScanInputs]]:
        """Return the number of successive rows from the first scan, and their inputs."""
        rows = self._timeline.between(first, last)
        if not len(rows) or rows[0]["scan"] != first:
            return 0, iter(())
        gaps = np.flatnonzero(np.diff(rows["scan"]) != 1)
        rows = rows[: int(gaps[0]) + 1] if len(gaps) else rows
        return len(rows), map(self._inputs, scans_in(rows))

    def _inputs(self, scan: RecordedScan) -> ScanInputs:
        known_inputs = self._kept.inputs.get(scan.number)
        images: Sequence[bytes] | None = None
        if runs_logic(scan.flags):
            images = None if known_inputs is None else known_inputs.images
            images = images or [scan.memory[image] for image in self._images]
        first = bool(scan.flags & _FIRST)
        if known_inputs is None:
            return ScanInputs(scan.now_ns, first, images)
        writes = tuple(
            (self._leaves[ident], index, value)
            for ident, index, value in known_inputs.writes
            if ident in self._leaves  # may be missing after an edit
        )
        return ScanInputs(scan.now_ns, first, images, writes, known_inputs.forces)


class ProgramReplica(Replayer):
    """A ladder program that repeats scans of a session."""

    def __init__(
        self, program: LadderLogic, rack: MemoryLayout, timeline: Timeline | RecentRows, kept: SnapshotStore
    ) -> None:
        engine = TracedEngine(program.build(), program.scanner)
        super().__init__(engine, SessionScans(program, rack, timeline, kept), MOST_REPEATED, CHAPTERS)
        self.is_impure = bool(program.functions)  # whether routines in Python prevent repetition of scans
        self._kept = kept

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the scans with values, backwards from a scan."""
        return (
            iter(())
            if self.is_impure
            else (snapshot_scan for snapshot_scan in self.source.snapshots(scan) if snapshot_scan <= scan)
        )

    def keep(self, scan: int) -> None:
        """Store the current values as a snapshot before a scan, from which the scan is repeated."""
        place = self._kept.place(scan)
        if not self.is_impure and (place is None or self._kept.scans[place] < scan):
            self._kept.take(Values(scan, snapshot(self.engine.memory), 0))

    @override
    def show(self, scan: int) -> bool:
        return self._show_values(scan) if self.is_impure else super().show(scan)

    def _show_values(self, scan: int) -> bool:
        """Show the latest stored values and power of a program that can't be repeated."""
        place = self._kept.place(scan + 1)
        if place is None:
            return False
        restore(self.engine.memory, self._kept.values(place))
        self.truths = self._kept.truths(place)
        self.at = scan
        return True


def scans_in(rows: Rows) -> Iterator[RecordedScan]:
    """Return a scan for each row."""
    memory, size = rows["words"].tobytes(), rows.dtype["words"].itemsize
    blocks = (memory[place : place + size] for place in range(0, len(memory), size))
    columns = (rows[name].tolist() for name in ("scan", "now_ns", "flags"))
    return map(as_scan, zip(*columns, blocks, strict=True))
