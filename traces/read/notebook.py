"""A trace as a notebook shows it: name, length, the way of the first axis, rules and faults."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from ...io_images.amci3601 import StatusView
from ...io_images.amci3601.words import is_stepper
from ...io_images.static_html import card, curve, line, rows
from ...io_images.times import seconds
from .event_text import describe

if TYPE_CHECKING:
    from .reader import Trace

POINTS = 640
"""Most points of the line: one for each pixel of its width."""

EVENTS = 8
"""Most events that are shown."""


def short_text(trace: Trace) -> str:
    """Return a trace as a terminal shows it: `<Trace 'feeder': scans 0 to 19,999>`."""
    first, last = trace.edge(last=False), trace.edge(last=True)
    name = trace.head.metadata.get("name", "")
    if first is None or last is None:
        return f"<Trace {name!r}: no scan>"
    return f"<Trace {name!r}: scans {int(first['scan'][0]):,} to {int(last['scan'][0]):,}>"


def as_html(trace: Trace) -> str:
    """Return a trace as HTML of at most some 20 kB, however long it is."""
    name = trace.head.metadata.get("name") or "trace"
    first, last = trace.edge(last=False), trace.edge(last=True)
    if first is None or last is None:
        return card(name, line("no scan"))
    scans = int(last["scan"][0]) - int(first["scan"][0]) + 1
    length = seconds(int(last["log_time"][0]) - int(first["log_time"][0]))
    return card(name, line(f"{scans:,} scans, {length} s"), _way(trace), _events(trace))


def _way(trace: Trace) -> str:
    """Return the position of the first slot that has one, as a line."""
    slot = next((each.number for each in trace.head.slots if is_stepper(each.words)), None)
    values = [] if slot is None else _positions(trace, slot)
    if len(values) < 2:
        return ""
    title = f"slot {slot}: position, {min(values):,} to {max(values):,} steps"
    return line(title) + curve(title, values)


def _positions(trace: Trace, slot: int) -> Sequence[int]:
    """Return positions at even distances; of a long trace not more than a scan of each part is read."""
    parts = trace.sections[:: max(1, len(trace.sections) // POINTS)]
    each = max(1, POINTS // max(len(parts), 1))
    found: list[int] = []
    for section in parts:
        for block in trace.scan_rows(section):
            for scan in trace.as_scans(block[:: max(1, len(block) // each)]):
                view = StatusView(scan.inputs(slot))
                if not view.MODE_CONFIG:  # in that mode the words are those of the configuration
                    found.append(view.position)
    return found[:: -(-len(found) // POINTS) or 1]


def _events(trace: Trace) -> str:
    shown: list[tuple[str, str]] = []
    more = 0
    for each in trace.events():
        if each.fields.get("kind") == "rule" or each.topic == "/faults":
            more += 1
            if len(shown) < EVENTS:
                shown.append((seconds(each.now_ns), describe(each.topic, each.scan, each.fields)))
    rest = line(f"and {more - EVENTS:,} more") if more > EVENTS else ""
    return rows((text, f"{time} s") for time, text in shown) + rest if shown else line("no rule, no fault")
