"""Shows a trace in a notebook, with its name, length, first axis position, rules and faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from scanrack.io_images.static_html import card, curve, line, rows
from scanrack.io_images.times import seconds

from ..format.layout import SlotInfo
from .event_text import describe
from .number_formats import NumberFormats

if TYPE_CHECKING:
    from .reader import Trace

POINTS = 640
"""Maximum number of points in the curve: one per pixel of its width."""

EVENTS = 8
"""Maximum number of events to show."""


def short_text(trace: Trace) -> str:
    """Return a trace as short text for a terminal: `<Trace 'feeder': scans 0 to 19,999>`."""
    first_row, last_row = trace.edge(last=False), trace.edge(last=True)
    name = trace.head.metadata.get("name", "")
    if first_row is None or last_row is None:
        return f"<Trace {name!r}: no scan>"
    (first_scan,), (last_scan,) = first_row["scan"], last_row["scan"]
    return f"<Trace {name!r}: scans {int(first_scan):,} to {int(last_scan):,}>"


def as_html(trace: Trace) -> str:
    """Return a trace as HTML of at most about 20 kB, regardless of the length of the trace."""
    name = trace.head.metadata.get("name") or "trace"
    first_row, last_row = trace.edge(last=False), trace.edge(last=True)
    if first_row is None or last_row is None:
        return card(name, line("no scan"))
    (first_scan,), (last_scan,) = first_row["scan"], last_row["scan"]
    (first_ns,), (last_ns,) = first_row["log_time"], last_row["log_time"]
    text = f"{int(last_scan) - int(first_scan) + 1:,} scans, {seconds(int(last_ns) - int(first_ns))} s"
    return card(name, line(text), _position_curve(trace), _events(trace))


def _position_curve(trace: Trace) -> str:
    """Return the positions of the first axis as a curve; empty if there are fewer than two positions."""
    slot = next((axis_slot for axis_slot in trace.head.slots if axis_slot.words.is_axis), None)
    values = [] if slot is None else _positions(trace, slot)
    if slot is None or len(values) < 2:
        return ""
    title = f"slot {slot.number}: position, {min(values):,} to {max(values):,} steps"
    return line(title) + curve(title, values)


def _positions(trace: Trace, slot: SlotInfo) -> Sequence[int]:
    """Return at most `POINTS` evenly spaced positions of an axis; skip sections of a long trace."""
    sections = trace.sections[:: max(1, len(trace.sections) // POINTS)]
    points_per_block = max(1, POINTS // max(len(sections), 1))
    position, formats = slot.words.quantity("position"), NumberFormats.of(trace)
    assert position is not None
    positions: list[int] = []
    for section in sections:
        for block in trace.scan_rows(section):
            for scan in trace.as_scans(block[:: max(1, len(block) // points_per_block)]):
                words = list(scan.inputs(slot.number))
                if not slot.words.configures("in", words):
                    positions.append(formats.value(slot.number, scan.scan, position, words))
    return positions[:: -(-len(positions) // POINTS) or 1]


def _events(trace: Trace) -> str:
    """Return the first rules and faults, and the number of others."""
    shown_events: list[tuple[str, str]] = []
    count = 0
    for event in trace.events():
        if event.fields.get("kind") == "rule" or event.topic == "/faults":
            count += 1
            if len(shown_events) < EVENTS:
                shown_events.append((seconds(event.now_ns), describe(event.topic, event.scan, event.fields)))
    if not shown_events:
        return line("no rule, no fault")
    ending = line(f"and {count - EVENTS:,} more") if count > EVENTS else ""
    return rows((text, f"{time} s") for time, text in shown_events) + ending
