"""The context of a scan: the changes before it, and the rules that fired in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set

import numpy as np

from ..format.flags import flag_names
from ..format.layout import SlotInfo
from ..read.changes import Changes, Row
from ..read.event_text import describe
from ..read.reader import Scan, Trace
from .differing import Side

SCANS_BEFORE = 5
"""How many scans with changes a report lists."""

LOOKED_AT = 4096
"""How far back these are looked for, scans."""


def changes_before(side: Side, slots: Sequence[SlotInfo], row: int) -> tuple[Row, ...]:
    """Return what changed in the last scans before a row, and in it."""
    begin = max(0, row - LOOKED_AT)
    words, flags = side.columns.words[begin : row + 1], side.columns.flags[begin : row + 1]
    changed = (words[1:] != words[:-1]).any(axis=1) | (flags[1:] != flags[:-1])
    rows = begin + 1 + np.flatnonzero(changed)
    told = [each for each in rows.tolist() if each < row][-SCANS_BEFORE:]
    return tuple(line for each in [*told, row] for line in _rows(side, slots, each))


def _rows(side: Side, slots: Sequence[SlotInfo], row: int) -> Iterator[Row]:
    changes = Changes(slots, flag_names, every=True)
    if row:
        changes.skip(_scan(side, row - 1))
    return changes.rows(_scan(side, row))


def _scan(side: Side, row: int) -> Scan:
    columns = side.columns
    places = {slot: 2 * place for slot, place in side.places.items()}
    memory = columns.words[row].tobytes()
    return Scan(int(columns.scan[row]), int(columns.time_ns[row]), int(columns.flags[row]), memory, places)


_TOLD_WITHIN_NS = 2_000_000_000
"""Longest time from an event to the scan that it is known in: two exchanges of the slowest rack."""


def rules_in(trace: Trace, scan: int, time_ns: int, slots: Set[int | None]) -> tuple[str, ...]:
    """Return the rules that fired in a scan in any of some slots, in words."""
    return tuple(
        describe(event.topic, event.scan, event.fields)
        for event in trace.events(time_ns - _TOLD_WITHIN_NS, time_ns)
        if event.scan == scan and event.fields.get("kind") == "rule" and event.fields.get("slot") in slots
    )
