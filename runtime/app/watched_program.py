"""Notes with which a monitor runs the scans of a program again: their inputs, and values now and then.

    scan          n         n+1       n+2  ...  n+255
    notes         values    -         writes    -          values before n, writes before n+2

Everything else that goes into a scan is in the ring: images, times and flags.
"""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...ladder.compiler.observed import LineKey
from ...ladder.debug import Debugger
from ...ladder.debug.journal import Entry, snapshot
from ..live.ring import Records
from ..loop.pace import wall_ns

EVERY = 256
"""Scans between values."""

IMPURE_NS = 30_000_000
"""Time between values of a program with routines in Python, whose scans can't be run again."""


@dataclass(frozen=True, slots=True)
class Values:
    """The values of a program before a scan.

    Attributes:
        scan: number of the scan.
        values: by identifier of the variable, see `ladder.debug.journal`.
        program: number of edits before it.
        truths: power of the scan before, of a program with routines in Python, which is always interpreted.
    """

    scan: int
    values: dict[str, Any]
    program: int
    truths: Mapping[LineKey, tuple[bool, ...]] | None = None


@dataclass(frozen=True, slots=True)
class Inputs:
    """Inputs of a scan beside its images and its time.

    Attributes:
        scan: number of the scan.
        writes: values set from outside since the scan before: identifier, element, value.
        forces: what is forced from this scan on.
        images: the input images as the program read them; None = those of the rack.
        program: how often the program had been edited.
    """

    scan: int
    writes: tuple[tuple[str, int, Any], ...]
    forces: Mapping[tuple[str, int], tuple[int | None, Any]]
    images: tuple[bytes, ...] | None
    program: int


class LadderNotes:
    """Writes what a monitor needs of a ladder program; see `runtime.live.tap.Notes`.

    Args:
        debugger: runs the program.
        records: where to.
    """

    def __init__(self, debugger: Debugger, records: Records) -> None:
        self._debugger, self._records = debugger, records
        self._entry: Entry | None = None
        self._forces: object = None
        self._due_ns = 0

    def note(self, scan: int) -> None:
        """Write what went into a scan, if it is more than images; now and then the values after it."""
        entry = self._debugger.latest
        if entry is not None and entry is not self._entry:
            self._entry = entry
            if entry.writes or entry.forces is not self._forces or self._debugger.engine.memory.copies_inputs:
                self._forces = entry.forces
                self._write(inputs_of(self._debugger, entry, scan))
        if scan % EVERY == EVERY - 1 or (self._debugger.interpreted and wall_ns() >= self._due_ns):
            self._due_ns = wall_ns() + IMPURE_NS
            self.give(scan + 1)

    def give(self, scan: int) -> None:
        """Write the values before a scan."""
        self._write(values_of(self._debugger, scan))
        self._forces = None

    def _write(self, record: Values | Inputs) -> None:
        self._records.write(pickle.dumps(record, pickle.HIGHEST_PROTOCOL))


def values_of(debugger: Debugger, scan: int) -> Values:
    """Return the values of a program before a scan."""
    engine = debugger.engine
    truths = engine.truths if debugger.interpreted else None
    return Values(scan, snapshot(engine.memory), len(debugger.edits), truths)


def inputs_of(debugger: Debugger, entry: Entry, scan: int) -> Inputs:
    """Return the inputs of a scan beside its images."""
    writes = tuple((leaf.ident, index, value) for leaf, index, value in entry.writes)
    images = entry.images if debugger.engine.memory.copies_inputs else None
    return Inputs(scan, writes, dict(entry.forces), images, len(debugger.edits))
