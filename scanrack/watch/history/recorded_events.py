"""The events of a trace, read first near a page's scan, then backwards in the background.

chunks     0    1    2    3    4    5    6    7
read                      *    *    *              a page shows a scan of chunk 5
background           <----                         older states are known later
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from typing import Any, NamedTuple

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
"""Number of chunks to read at once for a new scan. Other chunks are read between frames."""

MOST_EVENTS = 200_000
"""Maximum number of events to read in the background."""


class _LatestStates(NamedTuple):
    """The states in the scan of the latest request."""

    scan: int | None
    log_count: int  # number of known chunks up to the scan
    lines: Json
    rules: list[Json]
    pressed: Json


class RecordedEvents:
    """The events of a trace.

    Args:
        trace: the trace; its owner follows it while it grows.
    """

    def __init__(self, trace: Trace) -> None:
        self._trace = trace
        self._logs: dict[int, EventLog] = {}  # the events that were read, by index of their chunk
        self._last_scan = -1
        self._latest_states = _LatestStates(None, log_count=0, lines={}, rules=[], pressed={})
        self.read = 0  # number of events that were read
        self.formats = NumberFormats.of(trace)
        self.edits: set[int] = set()  # known scans before which the program was edited
        self._find_chunks()

    def _find_chunks(self) -> None:
        """Find the indexes of the chunks with events and of the chunks with forces."""
        chunks = self._trace.sections
        self._chunk_count = len(chunks)
        self._with_events = [index for index, chunk in enumerate(chunks) if self._trace.may_contain(chunk)]
        self._with_forces = [
            index for index in self._with_events if self._trace.may_contain(chunks[index], {FORCES})
        ]

    def tick(self) -> bool:
        """Read one more chunk; return whether there may be more."""
        self._follow_trace()
        missing = self._missing()
        if not missing or self.read >= MOST_EVENTS:
            return False
        next_after = bisect_right(missing, self._trace.place_of(self._last_scan))
        self._log(missing[next_after - 1])  # the one before it, or the last one if there is none
        return len(missing) > 1

    def _missing(self) -> list[int]:
        return [index for index in self._with_events if index not in self._logs]

    def missing(self) -> int:
        """Return how many chunks with events have not been read yet."""
        return len(self._missing())

    @property
    def version(self) -> tuple[int, ...]:
        """A value that changes with each chunk that is read."""
        return len(self._logs), self.read

    def known_events(self) -> Iterator[Json]:
        """Yield the events that were read, in order."""
        return (event for index in sorted(self._logs) for event in self._logs[index].since(0))

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
        """Return the forces in effect in a scan, from the latest message up to that scan."""
        self._follow_trace()
        scan = LAST_SCAN if scan is None else scan
        for index in reversed(self._up_to(self._with_forces, scan)):
            forces = self._log(index).reported_forces(scan)
            if forces is not None:
                return forces
        return {}

    def lines_at(self, scan: int | None) -> Json:
        """Return the known waiting lines of the sequences in a scan, by name."""
        return self._states_in(scan).lines

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the known rules that last set each bit, up to a scan."""
        return self._states_in(scan).rules

    def pressed_at(self, scan: int | None) -> Json:
        """Return the values that known actions last set up to a scan, and the sources."""
        return self._states_in(scan).pressed

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the known faults of the controller up to the end of a scan."""
        logs = self._back_from(LAST_SCAN if scan is None else scan)
        return [fault for log in logs for fault in log.faults_at(scan)]

    def _states_in(self, scan: int | None) -> _LatestStates:
        """Return the states in a scan, from the known chunks up to the one that contains the scan."""
        logs = list(self._back_from(LAST_SCAN if scan is None else scan))
        latest = self._latest_states
        if (latest.scan, latest.log_count) != (scan, len(logs)):
            lines: Json = {}
            pressed: Json = {}
            rules: dict[tuple[int, str], Json] = {}
            for log in logs:
                lines = log.lines_at(scan) | lines
                pressed = log.pressed_at(scan) | pressed
                for rule in log.rules_at(scan):
                    rules.setdefault((rule["slot"], rule["bit"]), rule)
            self._latest_states = _LatestStates(scan, len(logs), lines, list(rules.values()), pressed)
        return self._latest_states

    def orders(self, first: int, last: int) -> list[RecordedOrder]:
        """Return the actions before the scans from `first` to `last`, inclusive."""
        return orders_of(self._between(first, last, ORDERS.name))

    def links(self, slot: int, first: int, last: int) -> list[LinkChange]:
        """Return the changes in the connection to a module from scan `first` to scan `last`, inclusive."""
        return link_changes(self._between(first, last, INDICATORS), slot)

    def _between(self, first: int, last: int, topic: str) -> Iterator[TraceEvent]:
        """Return the events of a topic in the scans from `first` to `last`, inclusive."""
        trace, topics = self._trace, {topic}
        begin, end = max(0, trace.place_of(first) - 1), trace.place_of(last)
        chunks = [chunk for chunk in trace.sections[begin : end + 1] if trace.may_contain(chunk, topics)]
        events = (event for chunk in chunks for event in trace.events_in(chunk, topics))
        return (event for event in events if first <= event.scan <= last)

    def _follow_trace(self) -> None:
        if len(self._trace.sections) != self._chunk_count:
            self._find_chunks()

    def _up_to(self, indexes: list[int], scan: int) -> list[int]:
        """Return the chunk indexes up to the chunk of a scan."""
        return indexes[: bisect_right(indexes, self._trace.place_of(scan))]

    def _back_from(self, scan: int) -> Iterator[EventLog]:
        """Yield the events of a scan's chunk, then of earlier chunks; read at most `AT_ONCE` chunks."""
        self._follow_trace()
        unread_most = 0 if scan == self._last_scan else AT_ONCE
        self._last_scan = scan
        for index in reversed(self._up_to(self._with_events, scan)):
            if index not in self._logs:
                if not unread_most:
                    return
                unread_most -= 1
            yield self._log(index)

    def _log(self, index: int) -> EventLog:
        """Return the events of a chunk; read it if necessary."""
        if index not in self._logs:
            events = list(self._trace.events_in(self._trace.sections[index]))
            log = self._logs[index] = EventLog(keep=MOST_EVENTS)
            log.take_all(events)
            self.read += log.end
            self.edits.update(event.scan for event in events if is_edit(event))
            for event in events:
                self.formats.note(event.scan, event.fields)
        return self._logs[index]
