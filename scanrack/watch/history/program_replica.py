"""A replica of a ladder program in the monitor, which repeats scans to show tags and power in any of them.

    values      before scan 512                          before scan 768
    rows        512  513  514  ...  600  (601)           images, times, flags: from the ring
    engine      512 ... 600 compiled, 601 traced          tags and power of scan 601

Most requests are about the latest scan, so the engine continues from the scan it has reached.
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
"""Minimum number of notes to keep about other inputs; a program that writes its inputs adds one per scan.
"""

MOST_REPEATED = 8192
"""Maximum number of scans to repeat to reach a scan, which takes about 0.1 s for most programs."""

CHAPTERS = 120
"""Number of stretches between snapshots to search for a change: half a minute at 2 ms per scan."""

_SIZE_BYTES = 4
_FIRST = int(ScanFlag.FIRST_SCAN)


class ValueFile:
    """An unnamed file for values of programs, which is deleted when the process ends."""

    def __init__(self) -> None:
        self._file: IO[bytes] | None = None

    def add(self, values: object) -> int | None:
        """Write values; return their offset, or None if the disk is full."""
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

    def read(self, offset: int) -> Any:
        """Return the values at an offset."""
        assert self._file is not None
        self._file.seek(offset)
        size = int.from_bytes(self._file.read(_SIZE_BYTES), "little")
        return pickle.loads(zstandard.decompress(self._file.read(size)))


class SnapshotStore:
    """The notes from the scan process about one program, see `watched_program`.

    Values are in a file, so that even a long session has a snapshot shortly before any scan.
    """

    def __init__(self, file: ValueFile | None = None) -> None:
        self.scans = array("q")
        self._file, self._offsets = file or ValueFile(), array("q")  # an offset for each of `scans`
        self.inputs: dict[int, Inputs] = {}
        self._input_scans: list[int] = []  # the scans of `inputs`, in order

    def take(self, record: Values | Inputs) -> None:
        """Store a note, unless it has no new information."""
        scan = record.scan
        if isinstance(record, Values):
            offset = self._file.add((record.values, record.truths))
            if offset is not None:
                index = bisect_right(self.scans, scan)
                self.scans.insert(index, scan)
                self._offsets.insert(index, offset)
        elif scan in self.inputs:
            self.inputs[scan] = record
        elif record.writes or record.images is not None or record.forces != self._known_forces(scan):
            self._input_scans.insert(bisect_right(self._input_scans, scan), scan)
            self.inputs[scan] = record
            if len(self._input_scans) > 2 * MOST_INPUTS:
                for old_scan in self._input_scans[:MOST_INPUTS]:
                    del self.inputs[old_scan]
                del self._input_scans[:MOST_INPUTS]

    def index_for(self, scan: int) -> int | None:
        """Return the index in `scans` of the latest values up to a scan; None if there are none."""
        index = bisect_right(self.scans, scan) - 1
        return None if index < 0 else index

    def values(self, index: int) -> dict[str, Any]:
        """Return the values at an index in `scans`."""
        values: dict[str, Any] = self._file.read(self._offsets[index])[0]
        return values

    def truths(self, index: int) -> Truths:
        """Return the power of the previous scan that was stored with the values; {} if there is none."""
        truths: Truths | None = self._file.read(self._offsets[index])[1]
        return truths or {}

    def forces(self, scan: int) -> Forces:
        """Return the forces before a scan."""
        return self._known_forces(scan) or {}

    def _known_forces(self, scan: int) -> Forces | None:
        index = bisect_left(self._input_scans, scan) - 1
        return self.inputs[self._input_scans[index]].forces if index >= 0 else None


class SessionScans(Source):
    """Snapshots and inputs of a program in a session; see `ladder.debug.replay.Source`."""

    def __init__(
        self, program: LadderLogic, rack: MemoryLayout, timeline: Timeline | RecentRows, store: SnapshotStore
    ) -> None:
        self._timeline, self._store = timeline, store
        self._is_impure = bool(program.functions)
        layout = program.build().layout
        images = [int(leaf.slot or 0) for leaf in layout.images if not leaf.output]
        self._images = [rack.places[slot].inputs for slot in images]
        self._leaves = {leaf.ident: leaf for leaf in layout.leaves.values()}

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the scans with stored values, backwards from a scan; nothing if scans can't be repeated."""
        latest = None if self._is_impure else self._store.index_for(scan)
        return iter(()) if latest is None else (self._store.scans[index] for index in range(latest, -1, -1))

    def snapshot(self, scan: int) -> tuple[dict[str, Any], Forces]:
        """Return the values before a scan, and the forces in it."""
        index = self._store.index_for(scan)
        assert index is not None
        return self._store.values(index), self._store.forces(scan)

    def inputs(self, first: int, last: int) -> tuple[int, Iterator[ScanInputs]]:
        """Return the number of successive rows from the first scan, and their inputs."""
        rows = self._timeline.between(first, last)
        if not len(rows) or rows[0]["scan"] != first:
            return 0, iter(())
        gaps = np.flatnonzero(np.diff(rows["scan"]) != 1)
        rows = rows[: int(gaps[0]) + 1] if len(gaps) else rows
        return len(rows), map(self._inputs, scans_in(rows))

    def _inputs(self, scan: RecordedScan) -> ScanInputs:
        """Return the inputs of a scan: its images, and the writes and forces that were noted about it."""
        noted = self._store.inputs.get(scan.number)
        images: Sequence[bytes] | None = None
        if runs_logic(scan.flags):
            images = None if noted is None else noted.images
            images = images or [scan.memory[image] for image in self._images]
        is_first = bool(scan.flags & _FIRST)
        if noted is None:
            return ScanInputs(scan.now_ns, is_first, images)
        writes = tuple(
            (self._leaves[ident], index, value)
            for ident, index, value in noted.writes
            if ident in self._leaves  # may be missing after an edit
        )
        return ScanInputs(scan.now_ns, is_first, images, writes, noted.forces)


class ProgramReplica(Replayer):
    """A ladder program that repeats scans of a session."""

    def __init__(
        self, program: LadderLogic, rack: MemoryLayout, timeline: Timeline | RecentRows, store: SnapshotStore
    ) -> None:
        engine = TracedEngine(program.build(), program.scanner)
        super().__init__(engine, SessionScans(program, rack, timeline, store), MOST_REPEATED, CHAPTERS)
        self.is_impure = bool(program.functions)  # routines in Python: scans can't be repeated
        self._store = store

    def snapshots(self, scan: int) -> Iterator[int]:
        """Yield the scans with values, backwards from a scan."""
        scans = iter(()) if self.is_impure else self.source.snapshots(scan)
        return (snapshot_scan for snapshot_scan in scans if snapshot_scan <= scan)

    def keep(self, scan: int) -> None:
        """Store the present values as a snapshot before a scan."""
        index = self._store.index_for(scan)
        if not self.is_impure and (index is None or self._store.scans[index] < scan):
            self._store.take(Values(scan, snapshot(self.engine.memory), 0))

    @override
    def show(self, scan: int) -> bool:
        return self._show_values(scan) if self.is_impure else super().show(scan)

    def _show_values(self, scan: int) -> bool:
        """Show the latest stored values and power up to a scan; return False if there are none."""
        index = self._store.index_for(scan + 1)
        if index is None:
            return False
        restore(self.engine.memory, self._store.values(index))
        self.truths = self._store.truths(index)
        self.at = scan
        return True


def scans_in(rows: Rows) -> Iterator[RecordedScan]:
    """Yield a scan for each row."""
    memory, size = rows["words"].tobytes(), rows.dtype["words"].itemsize
    blocks = (memory[offset : offset + size] for offset in range(0, len(memory), size))
    columns = (rows[name].tolist() for name in ("scan", "now_ns", "flags"))
    return map(as_scan, zip(*columns, blocks, strict=True))
