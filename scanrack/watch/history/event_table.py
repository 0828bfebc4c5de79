"""The list of events: all up to a scan, without hidden kinds, a piece at a time from the latest one back.

events     rule  move  indicator  indicator  rule  stimulus        up to the scan of the page
hidden                 x          x
piece      <- skip + most ......................... skip, most     of those that are left
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.module_words import ModuleWords

Json = dict[str, Any]

ERROR = "error"
"""The second kind of an event that reports an error bit."""


class EventTable(NamedTuple):
    """Events with their kinds as numbers."""

    version: tuple[int, ...]  # of what it was made of
    events: Sequence[Json]
    scans: np.ndarray[Any, Any]
    kinds: Sequence[frozenset[str]]  # the sets of kinds
    of: np.ndarray[Any, Any]  # of each event the number of its set


def kinds_of(event: Mapping[str, Any], words: Mapping[int, ModuleWords]) -> frozenset[str]:
    """Return the kinds of an event: its own, and whether it reports an error."""
    slot = words.get(event["slot"])
    is_error = slot is not None and not set(slot.errors).isdisjoint(event.get("bits", ()))
    return frozenset((event["kind"], ERROR) if is_error else (event["kind"],))


def table_of(
    version: tuple[int, ...], events: Sequence[Json], words: Mapping[int, ModuleWords]
) -> EventTable:
    """Return a table of events."""
    numbers: dict[frozenset[str], int] = {}
    of = [numbers.setdefault(kinds_of(each, words), len(numbers)) for each in events]
    return EventTable(
        version, events, np.array([each["scan"] for each in events]), [*numbers], np.array(of, int)
    )


def piece_of(
    table: EventTable, scan: int, hidden: Collection[str], skip: int, most: int
) -> tuple[list[Json], int]:
    """Return events up to a scan, in order, and how many there are.

    Args:
        hidden: an event is left out if all its kinds are among these.
        skip: number of latest events that are left out, and `most` of those that are returned.
    """
    shown = np.array([not kinds <= set(hidden) for kinds in table.kinds], bool)
    end = int(np.searchsorted(table.scans, scan, "right"))
    places = np.flatnonzero(shown[table.of[:end]]) if end else table.of[:0]
    total = len(places)
    chosen = places[max(0, total - skip - most) : max(0, total - skip)]
    return [table.events[place] for place in chosen.tolist()], total
