"""Returns the events up to a scan, without hidden kinds, in pieces from the latest backwards.

events     rule  move  indicator  indicator  rule  stimulus        up to the scan of the page
hidden                 x          x
piece      <- skip + most ......................... skip, most     from the remaining events
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
    """Events, with their kinds as numbers."""

    version: tuple[int, ...]  # version of the events in the table
    events: Sequence[Json]
    scans: np.ndarray[Any, Any]
    kinds: Sequence[frozenset[str]]  # the distinct sets of kinds
    of: np.ndarray[Any, Any]  # number of the set of kinds, for each event


def kinds_of(event: Mapping[str, Any], words: Mapping[int, ModuleWords]) -> frozenset[str]:
    """Return the kinds of an event: its own, and `ERROR` if it reports an error bit."""
    slot = words.get(event["slot"])
    is_error = slot is not None and not set(slot.errors).isdisjoint(event.get("bits", ()))
    return frozenset((event["kind"], ERROR) if is_error else (event["kind"],))


def table_of(
    version: tuple[int, ...], events: Sequence[Json], words: Mapping[int, ModuleWords]
) -> EventTable:
    """Return a table of events."""
    numbers: dict[frozenset[str], int] = {}
    of = [numbers.setdefault(kinds_of(event, words), len(numbers)) for event in events]
    return EventTable(
        version, events, np.array([event["scan"] for event in events]), [*numbers], np.array(of, int)
    )


def piece_of(
    table: EventTable, scan: int, hidden: Collection[str], skip: int, most: int
) -> tuple[list[Json], int]:
    """Return a piece of the events up to a scan, in order, and the total number.

    Args:
        hidden: hidden kinds; an event is left out if all its kinds are hidden.
        skip: number of latest events to skip.
        most: largest number of events to return.
    """
    is_shown = np.array([not kinds <= set(hidden) for kinds in table.kinds], bool)
    end = int(np.searchsorted(table.scans, scan, "right"))
    places = np.flatnonzero(is_shown[table.of[:end]]) if end else table.of[:0]
    total = len(places)
    piece_places = places[max(0, total - skip - most) : max(0, total - skip)]
    return [table.events[place] for place in piece_places.tolist()], total
