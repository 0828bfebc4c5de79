"""Reads the events of a recording, first around a page's scan, then backwards in the background.

chunks     0    1    2    3    4    5    6    7
read                      *    *    *              a page shows a scan of chunk 5
background           <----                         older states are known a moment later
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Any

from scanrack.jobs.record.edits_and_forces import is_edit
from scanrack.jobs.record.link_losses import INDICATORS, LinkChange, link_changes
from scanrack.jobs.record.order_repeater import RecordedOrder, orders_of
from scanrack.runtime.loop.faults import Fault
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.traces.read.reader import Trace, TraceEvent

from .event_log import FIRST, FORCES, LAST_SCAN, EventLog

Json = dict[str, Any]

AT_ONCE = 4
"""Number of chunks read at once for a new scan; further chunks are read between frames."""

MOST_EVENTS = 200_000
"""Largest number of events read in the background."""


class RecordedEvents:
    """The events of a recording.

    Args:
        trace: the recording; if it is growing, its owner follows it.
    """

    def __init__(self, trace: Trace) -> None:
        self._trace = trace
        self._known: dict[int, EventLog] = {}
        self._last_scan = -1
        self._latest: tuple[int | None, int, Json, list[Json], Json] = (None, 0, {}, [], {})
        self.read = 0
        self.formats = NumberFormats.of(trace)
        self.edits: set[int] = set()  # known scans before which the program was edited
        self._find()

    def _find(self) -> None:
        sections = self._trace.sections
        self._sections = len(sections)
        self._telling = [place for place, section in enumerate(sections) if self._trace.may_contain(section)]
        self._forcing = [
            place for place in self._telling if self._trace.may_contain(sections[place], {FORCES})
        ]

    def tick(self) -> bool:
        """Read one more chunk; return whether there may be more."""
        self._go_on()
        missing = self._missing()
        if not missing or self.read >= MOST_EVENTS:
            return False
        before = bisect_right(missing, self._trace.place_of(self._last_scan))
        self._log(missing[before - 1])
        return len(missing) > 1

    def _missing(self) -> list[int]:
        return [place for place in self._telling if place not in self._known]

    def missing(self) -> int:
        """Return how many chunks with events are not read yet."""
        return len(self._missing())

    @property
    def version(self) -> tuple[int, ...]:
        """A value that changes with each chunk that is read."""
        return len(self._known), self.read

    def known(self) -> Iterator[Json]:
        """Yield the known events, in order."""
        return (event for place in sorted(self._known) for event in self._known[place].since(0))

    # --- states of a scan

    def up_to(self, scan: int, most: int = FIRST) -> list[Json]:
        """Return the latest known events up to a scan, in order."""
        events: list[Json] = []
        for log in self._back_from(scan):
            events[:0] = [event for event in log.since(0) if event["scan"] <= scan]
            if len(events) >= most:
                break
        return events[-most:]

    def forces_at(self, scan: int | None) -> Json:
        """Return the forces in effect in a scan, from the last message up to it."""
        self._go_on()
        scan = LAST_SCAN if scan is None else scan
        for place in reversed(self._up_to(self._forcing, scan)):
            forces = self._log(place).reported_forces(scan)
            if forces is not None:
                return forces
        return {}

    def lines_at(self, scan: int | None) -> Json:
        """Return the known waiting lines of the sequences in a scan, by name."""
        return self._stood(scan)[0]

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the known rules that last set each bit, up to a scan."""
        return self._stood(scan)[1]

    def pressed_at(self, scan: int | None) -> Json:
        """Return the values that known orders last set up to a scan, and by whom."""
        return self._stood(scan)[2]

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the known faults of the CPU up to the end of a scan."""
        logs = self._back_from(LAST_SCAN if scan is None else scan)
        return [fault for log in logs for fault in log.faults_at(scan)]

    def _stood(self, scan: int | None) -> tuple[Json, list[Json], Json]:
        """Return lines, rules and presses in a scan, from the known chunks up to its own."""
        logs = list(self._back_from(LAST_SCAN if scan is None else scan))
        if self._latest[:2] != (scan, len(logs)):
            lines: Json = {}
            pressed: Json = {}
            rules: dict[tuple[int, str], Json] = {}
            for log in logs:
                lines = log.lines_at(scan) | lines
                pressed = log.pressed_at(scan) | pressed
                for rule in log.rules_at(scan):
                    rules.setdefault((rule["slot"], rule["bit"]), rule)
            self._latest = scan, len(logs), lines, list(rules.values()), pressed
        return self._latest[2:]

    def orders(self, first: int, last: int) -> list[RecordedOrder]:
        """Return the orders of a session before the scans from `first` to `last`, inclusive."""
        return orders_of(self._between(first, last, ORDERS.name))

    def links(self, slot: int, first: int, last: int) -> list[LinkChange]:
        """Return the changes of the link to a module from scan `first` to scan `last`, inclusive."""
        return link_changes(self._between(first, last, INDICATORS), slot)

    def _between(self, first: int, last: int, topic: str) -> Iterator[TraceEvent]:
        trace, topics = self._trace, {topic}
        begin, end = max(0, trace.place_of(first) - 1), trace.place_of(last)
        sections = [
            section for section in trace.sections[begin : end + 1] if trace.may_contain(section, topics)
        ]
        matches = (event for section in sections for event in trace.events_in(section, topics))
        return (event for event in matches if first <= event.scan <= last)

    def _go_on(self) -> None:
        if len(self._trace.sections) != self._sections:
            self._find()

    def _up_to(self, places: list[int], scan: int) -> list[int]:
        return places[: bisect_right(places, self._trace.place_of(scan))]

    def _back_from(self, scan: int) -> Iterator[EventLog]:
        """Yield the events of a scan's chunk and of earlier ones; stop after a few that have to be read."""
        self._go_on()
        budget = 0 if scan == self._last_scan else AT_ONCE
        self._last_scan = scan
        for place in reversed(self._up_to(self._telling, scan)):
            budget -= place not in self._known
            if budget < 0:
                return
            yield self._log(place)

    def _log(self, place: int) -> EventLog:
        if place not in self._known:
            events = list(self._trace.events_in(self._trace.sections[place]))
            log = self._known[place] = EventLog(kept=MOST_EVENTS)
            log.take_all(events)
            self.read += log.end
            self.edits.update(event.scan for event in events if is_edit(event))
            for event in events:
                self.formats.note(event.scan, event.fields)
        return self._known[place]
