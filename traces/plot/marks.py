"""Converts events to marks on the time axis: rules that fired, moves that ended, stimuli, the controller.

A trace has no event for a broken invariant; the caller adds a mark of kind "broken" for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ..read.event_text import describe
from ..read.reader import TraceEvent

KINDS = ("broken", "rule", "stimulus", "move", "cpu")
"""Kinds of marks, the most important first; marks get their labels in this order."""


@dataclass(frozen=True, slots=True)
class Mark:
    """An event on the time axis."""

    time_ns: int  # virtual time of the event
    slot: int | None  # number of the slot; None for the rack
    kind: str  # one of KINDS
    label: str  # text beside the mark, if it fits
    text: str  # description of the event
    of_tags: bool = False  # whether it concerns tags of the program


def marks(events: Iterable[TraceEvent], start_ns: int, end_ns: int) -> list[Mark]:
    """Return the marks of the events between two times, inclusive, ordered by time and then by kind."""
    shown_marks: list[Mark] = []
    forced_tags: object = None
    for event in events:
        mark = _mark(event, forced_tags) if start_ns <= event.now_ns <= end_ns else None
        if mark is not None:
            shown_marks.append(mark)
        if event.topic == "/forces":
            forced_tags = event.fields.get("tags")
    return sorted(shown_marks, key=lambda mark: (mark.time_ns, KINDS.index(mark.kind)))


def _mark(event: TraceEvent, forced_tags: object) -> Mark | None:
    """Return the mark of an event; None for an event without a mark.

    Args:
        forced_tags: the tags that were forced before the event, with their values; None = no tags.
    """
    fields = event.fields
    slot = fields.get("slot")
    kind, label = _kind_and_label(event)
    if not kind:
        return None
    text = describe(event.topic, event.scan, fields)
    of_tags = event.topic == "/forces" and fields.get("tags") != forced_tags
    label = f"{label} over" if of_tags and "tags" not in fields else label
    return Mark(event.now_ns, slot if isinstance(slot, int) else None, kind, label, text, of_tags)


def _kind_and_label(event: TraceEvent) -> tuple[str, str]:
    """Return the kind and label of an event; both are empty for events that the lanes show."""
    name = str(event.fields.get("name", ""))
    if event.topic == "/cpu":
        return "cpu", str(event.fields.get("mode", "CPU"))
    if event.topic == "/forces":
        return "cpu", _force(event.fields)
    if event.topic == "/faults":
        return "cpu", "fault"
    if event.topic == "/stimuli":
        return "stimulus", _stimulus(name, event.fields)
    if event.topic == "/events" and event.fields.get("kind") == "rule":
        return "rule", name
    if event.topic == "/events":
        outcome = event.fields.get("outcome", "")
        return "move", "home found" if name == outcome == "home" else f"{name} {outcome}".strip()
    return "", ""


def _force(fields: Mapping[str, object]) -> str:
    """Return the label for forces, which names the tag if only one tag is forced."""
    tags = fields.get("tags")
    if isinstance(tags, Mapping) and len(tags) == len(fields) == 1:
        return f"force {next(iter(tags))}"
    return "force"


def _stimulus(name: str, fields: Mapping[str, object]) -> str:
    """Return the label of a stimulus, or of the beginning or end of an injected fault."""
    if fields.get("begins") is False:
        return _END_LABELS.get(name, f"{name} over")
    energized = fields.get("energized")
    return f"{name} {'on' if energized else 'off'}".strip() if isinstance(energized, bool) else name


_END_LABELS: Mapping[str, str] = {
    "link-lost": "link back",
    "asic-lost": "link back",
    "removed": "inserted",
    "line-down": "line back",
}
"""Labels of the ends of injected faults, by the name of the fault."""
