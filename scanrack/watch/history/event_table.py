"""Tables of events without hidden kinds, read backwards in pieces from a scan.

events     rule  move  indicator  indicator  rule  stimulus        up to the scan of the page
hidden                 x          x
piece      the remaining events, without the latest `skip`, at most `most`
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.module_words import ModuleWords

Json = dict[str, Any]

ERROR = "error"
"""Additional kind of an event that reports an error bit."""


class EventTable(NamedTuple):
    """Events with their kinds."""

    version: tuple[int, ...]  # see `States.version`
    events: Sequence[Json]
    scans: np.ndarray[Any, Any]
    kinds: Sequence[frozenset[str]]  # the distinct sets of kinds
    kind_indexes: np.ndarray[Any, Any]  # for each event the index of its kinds


def kinds_of(event: Mapping[str, Any], words: Mapping[int, ModuleWords]) -> frozenset[str]:
    """Return the kinds of an event: its own, and `ERROR` if it reports an error bit."""
    slot = words.get(event["slot"])
    is_error = slot is not None and not set(slot.errors).isdisjoint(event.get("bits", ()))
    return frozenset((event["kind"], ERROR) if is_error else (event["kind"],))


def table_of(
    version: tuple[int, ...], events: Sequence[Json], words: Mapping[int, ModuleWords]
) -> EventTable:
    """Return a table of events."""
    indexes: dict[frozenset[str], int] = {}
    kind_indexes = [indexes.setdefault(kinds_of(event, words), len(indexes)) for event in events]
    scans = np.array([event["scan"] for event in events])
    return EventTable(version, events, scans, [*indexes], np.array(kind_indexes, int))


def piece_of(
    table: EventTable, scan: int, hidden: Collection[str], skip: int, most: int
) -> tuple[list[Json], int]:
    """Return a piece of the events up to a scan, in order, and the number of all events that are not hidden.

    Args:
        hidden: hidden kinds; an event is hidden if all its kinds are.
        skip: number of latest events to skip.
        most: maximum number of events to return.
    """
    is_shown = np.array([not kinds <= set(hidden) for kinds in table.kinds], bool)
    end = int(np.searchsorted(table.scans, scan, "right"))
    indexes = np.flatnonzero(is_shown[table.kind_indexes[:end]]) if end else table.kind_indexes[:0]
    total = len(indexes)
    piece = indexes[max(0, total - skip - most) : max(0, total - skip)]
    return [table.events[index] for index in piece.tolist()], total
