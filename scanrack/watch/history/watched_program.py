"""Notes that let a monitor repeat the scans of a ladder program: inputs, and regular snapshots.

    scan          n         n+1       n+2  ...  n+1023
    notes         values    -         writes    -          values before n, writes before n+2

The other inputs of a scan are in the ring: images, times and flags.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from scanrack.ladder.compiler.observed import LineKey
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.forces import Forces
from scanrack.ladder.debug.stretch import ScanInputs
from scanrack.ladder.state.snapshots import snapshot
from scanrack.runtime.live.ring import Records
from scanrack.runtime.loop.pace import wall_ns

EVERY = 1024
"""Scans between two snapshots."""

IMPURE_NS = 30_000_000
"""Time between two snapshots of a program with Python routines, whose scans can't be repeated, ns."""


@dataclass(frozen=True, slots=True)
class Values:
    """The values of a program before a scan.

    Attributes:
        values: values by variable identifier, see `ladder.state.snapshots`.
        program: number of edits of the program before the scan.
        truths: power in the previous scan, only for a program with Python routines.
    """

    scan: int
    values: dict[str, Any]
    program: int
    truths: Mapping[LineKey, tuple[bool, ...]] | None = None


@dataclass(frozen=True, slots=True)
class Inputs:
    """Inputs of a scan in addition to its images and time.

    Attributes:
        writes: external writes since the previous scan: identifier, element, value.
        forces: forces in effect from this scan.
        images: the input images that the program read; None = the rack's images.
        program: number of edits of the program before the scan.
    """

    scan: int
    writes: tuple[tuple[str, int, Any], ...]
    forces: Forces
    images: Sequence[bytes] | None
    program: int


class LadderNotes:
    """The notes of a ladder program, as `runtime.live.tap.Notes`.

    Args:
        write: receives the notes.
        every: number of scans between two snapshots.

    Attributes:
        sent_scan: the scan of the latest snapshot.
    """

    def __init__(
        self, debugger: Debugger, write: Callable[[Values | Inputs], object], every: int = EVERY
    ) -> None:
        self._debugger, self._write, self._every = debugger, write, every
        self._entry: ScanInputs | None = None
        self._forces: object = None
        self._due_ns = 0  # when the next snapshot of an interpreted program is due
        self._noted_version = -1  # `Debugger.news` at the latest note
        self.sent_scan = -every

    def must_note(self) -> bool:
        """Return whether the latest scan had inputs other than its images."""
        return self._debugger.news != self._noted_version

    def note(self, scan: int) -> None:
        """Write the other inputs of a scan; at intervals, also write the values after it."""
        debugger = self._debugger
        if debugger.news != self._noted_version:
            self._note(debugger, scan)
        if scan >= self.sent_scan + self._every or (debugger.interpreted and wall_ns() >= self._due_ns):
            self._due_ns = wall_ns() + IMPURE_NS
            self.send_values(scan + 1)

    def _note(self, debugger: Debugger, scan: int) -> None:
        """Write the inputs of the latest scan if it had writes, its own images or new forces."""
        entry, forces = debugger.latest, debugger.engine.memory.forces
        fresh = None if entry is self._entry else entry
        is_written = fresh is not None and (fresh.writes or debugger.engine.memory.copies_inputs)
        if is_written or forces is not self._forces:
            self._write(_inputs_of(debugger, scan))
        self._entry, self._forces, self._noted_version = entry, forces, debugger.news

    def send_values(self, scan: int) -> None:
        """Write the values before a scan; the next note then writes its forces even if unchanged."""
        debugger, engine = self._debugger, self._debugger.engine
        truths = engine.truths if debugger.interpreted else None
        self._write(Values(scan, snapshot(engine.memory), len(debugger.edits), truths))
        self._forces, self._noted_version, self.sent_scan = None, -1, scan


def written_to(records: Records) -> Callable[[Values | Inputs], object]:
    """Return a function that writes notes for the monitor."""
    return lambda record: records.write(pickle.dumps(record, pickle.HIGHEST_PROTOCOL))


def _inputs_of(debugger: Debugger, scan: int) -> Inputs:
    """Return the inputs of the latest scan in addition to its images."""
    entry, memory = debugger.latest, debugger.engine.memory
    writes = () if entry is None else entry.writes
    images = entry.images if entry is not None and memory.copies_inputs else None
    values = tuple((leaf.ident, index, value) for leaf, index, value in writes)
    return Inputs(scan, values, dict(memory.forces), images, len(debugger.edits))
