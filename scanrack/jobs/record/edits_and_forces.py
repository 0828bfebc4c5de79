"""Finds edits of the program, forces and set fields among the events of a recording."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.traces.read.reader import TraceEvent

Forced = Mapping[str, str | int | float | bool]
"""The forced tags with their values."""


def is_edit(event: TraceEvent) -> bool:
    """Return whether an event reports an edit of the program."""
    return event.topic == "/events" and event.fields.get("kind") == "edit"


SET = "set"
"""Kind of an event for a field that a test has set; the event contains the order."""


def is_set(event: TraceEvent) -> bool:
    """Return whether an event reports a field that a test has set."""
    return event.topic == "/events" and event.fields.get("kind") == SET and "order" in event.fields


def forced_in(event: TraceEvent) -> Forced:
    """Return the forced tags in a message on /forces, with their values."""
    tags = event.fields.get("tags")
    return tags if isinstance(tags, Mapping) else {}


def image_forces(event: TraceEvent) -> dict[str, int]:
    """Return the forces of images in a message on /forces, by address, without forces of tags."""
    return {address: int(str(value)) for address, value in event.fields.items() if address != "tags"}
