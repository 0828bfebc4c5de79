"""The events of a session or trace, and the states in each scan.

events    the latest events, in order
faults    of the CPU
forces    by the first scan in which they were in effect
lines     by the first scan in which a sequence waited at the line
pressed   by the first scan after an action that set an input or a tag
rules     the latest rule that set each bit
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from operator import itemgetter
from typing import Any, Protocol

from scanrack.io_images.site import Site
from scanrack.runtime.live.actions import RECORDED, Press, Store, Write, action_of, parsed
from scanrack.runtime.loop.faults import Cause, Fault
from scanrack.traces.format.topics import TOPICS
from scanrack.traces.read.number_formats import NumberFormats
from scanrack.traces.read.reader import TraceEvent

Json = dict[str, Any]

KEPT = 2000
FIRST = 200
"""Number of events that a new page gets."""

LAST_SCAN = 1 << 32
"""Greater than the number of any scan."""

STATED = frozenset(topic.name for topic in TOPICS if topic.state)

STATES = 10_000
"""Minimum number of changes to keep for each kind of state: forces, lines, rules."""

STORED, NAMES_MOST = 500, 100
"""Minimum number of changes to keep for tags that clients write, and maximum number of these tags."""

SEQUENCES, FORCES, FAULTS, INDICATORS = "/sequences", "/forces", "/faults", "/indicators"

_NOT_FORCED = ("scan", "t", "topic", "tags")


class States(Protocol):
    """The states in each scan."""

    @property
    def formats(self) -> NumberFormats:
        """The number formats of modules whose configuration selects them."""

    @property
    def version(self) -> tuple[int, ...]:
        """A value that changes when more events are known."""

    def forces_at(self, scan: int | None) -> Json:
        """Return the forces in effect in a scan; None = the latest."""

    def lines_at(self, scan: int | None) -> Json:
        """Return the waiting lines of the sequences in a scan, by name."""

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the rule that last set each bit, up to a scan."""

    def pressed_at(self, scan: int | None) -> Json:
        """Return the values that actions set up to a scan, and the sources: `{"Start": [true, "panel"]}`."""

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the controller's faults up to the end of a scan."""

    def up_to(self, scan: int, most: int) -> list[Json]:
        """Return the latest events up to a scan, in order."""

    def missing(self) -> int:
        """Return the number of unread chunks of a trace, or of events that are no longer kept."""


class EventLog:
    """The events, in the order in which they were reported.

    Attributes:
        begin: number of the first event that is kept.
        formats: number formats of modules whose configuration selects them, from the events.
        earlier: the states before the first event, or None.
    """

    def __init__(self, keep: int = KEPT) -> None:
        self._keep = keep
        self.clear()

    def clear(self) -> None:
        """Drop all events when another session begins."""
        self.begin = 0
        self.earlier: States | None = None
        self._first = LAST_SCAN  # scan of the first event
        self._events: list[Json] = []
        self._forces = _StateHistory()
        self._lines = _StateHistory()
        self._pressed = _StateHistory()
        self._stored = _StateHistory(STORED, NAMES_MOST)  # by clients, who write often
        self._faults: list[Fault] = []
        self._stated: dict[str, Json] = {}
        self._rules: list[Json] = []
        self._latest_rules: dict[tuple[int, str], Json] = {}
        self.formats = NumberFormats()

    @property
    def end(self) -> int:
        """Number of the next event."""
        return self.begin + len(self._events)

    @property
    def version(self) -> tuple[int, ...]:
        """A value that changes with each new event."""
        return self.begin, self.end, *(() if self.earlier is None else self.earlier.version)

    @property
    def first_of_page(self) -> int:
        """Number of the first event for a new page."""
        return max(self.begin, self.end - FIRST)

    def since(self, number: int) -> Sequence[Json]:
        """Return the kept events from a number on."""
        return self._events[max(0, number - self.begin) :]

    def take_all(self, events: Iterable[TraceEvent]) -> None:
        """Add the events of a trace."""
        for event in events:
            self.take({**event.fields, "scan": event.scan, "t": event.now_ns, "topic": event.topic})

    def take(self, event: Mapping[str, Any]) -> None:
        """Add an event whose fields include its scan, t and topic."""
        topic, scan = event["topic"], event["scan"]
        self._first = min(self._first, scan)
        if topic == FORCES:
            self.add_forces(scan, event)
        if topic in STATED and not self._is_change(topic, event):
            return
        if topic == SEQUENCES:
            self._take_line(event)
            return
        if event.get("kind") == "rule":
            self._take_rule(event)
        self.formats.note(scan, event)
        if "order" in event:
            self._take_press(scan, str(event["order"]))
        if topic == FAULTS:
            self._faults.append(_fault_of(event))
        self._events.append(_row_of(event))
        if len(self._events) > 2 * self._keep:
            self.begin += self._keep
            del self._events[: self._keep]

    def _is_change(self, topic: str, event: Mapping[str, Any]) -> bool:
        """Return whether an event changes a state; sessions also repeat states that have not changed."""
        fields = {key: value for key, value in event.items() if key not in ("scan", "t", "topic")}
        previous, self._stated[topic] = self._stated.get(topic), fields
        return previous != fields

    def add_forces(self, scan: int, forces: Mapping[str, Any]) -> None:
        """Add the forces that are in effect from a scan on."""
        images = {key: value for key, value in forces.items() if key not in _NOT_FORCED}
        self._forces.add(scan, {**images, **forces.get("tags", {})})

    def _take_line(self, event: Mapping[str, Any]) -> None:
        wait = {"file": event["file"], "line": event["line"], "text": event["wait"], "since": event["t"]}
        self._lines.add(event["scan"], {**self._lines.latest, event["sequence"]: wait})

    def _take_press(self, scan: int, text: str) -> None:
        """Note the value that an action has set, and its source; ignore text that is not a known action."""
        try:
            action = action_of(parsed(text), RECORDED)
        except ValueError:
            return  # a trace from elsewhere
        match action:
            case Press(slot, name, on, by):
                self._pressed.set_value(scan, f"{slot}.input.{name}", [on, by])
            case Write(tag, value, by):
                self._pressed.set_value(scan, tag, [value, by])
            case Store(tag=tag, client=client, part=part):
                # `pressed_at` prefers values in `_pressed`, so a later write must replace them there
                history = self._pressed if tag + part in self._pressed.latest else self._stored
                history.set_value(scan, tag + part, [None, client])

    def _take_rule(self, event: Mapping[str, Any]) -> None:
        """Note a rule as the latest one for each bit that it set; drop the oldest if there are too many."""
        for bit in event.get("bits") or ():
            rule = {
                "slot": event.get("slot", 0),
                "bit": bit,
                "rule": event.get("name", ""),
                "text": event.get("text", ""),
                "section": event.get("section", ""),
                "scan": event["scan"],
            }
            self._rules.append(rule)
            self._latest_rules[rule["slot"], bit] = rule
        if len(self._rules) > 2 * STATES:
            del self._rules[:STATES]

    # --- states of a scan

    def up_to(self, scan: int, most: int) -> list[Json]:
        """Return the latest known events up to a scan, in order."""
        own_events = self._events[: bisect_right(self._events, scan, key=itemgetter("scan"))][-most:]
        if len(own_events) == most or self.earlier is None or self.begin:
            return own_events
        earlier_scan = min(scan, self._events[0]["scan"] - 1) if self._events else scan
        return [*self.earlier.up_to(earlier_scan, most - len(own_events)), *own_events]

    def missing(self) -> int:
        """Return how many events are no longer kept, or how many chunks of the trace are not read yet."""
        return self.begin or (0 if self.earlier is None else self.earlier.missing())

    def _earlier_scan(self, scan: int | None) -> int:
        """Return a scan for `earlier`, at most this log's first, since a growing trace repeats its events."""
        return self._first if scan is None else min(scan, self._first)

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the controller's faults up to the end of a scan; None = the latest."""
        earlier = [] if self.earlier is None or self._faults else self.earlier.faults_at(scan)
        return earlier + [fault for fault in self._faults if scan is None or fault.scan <= scan]

    def forces_at(self, scan: int | None) -> Json:
        """Return the forces in effect in a scan; None = the latest."""
        forces = self._forces.state_in(LAST_SCAN if scan is None else scan)
        if forces is None and self.earlier is not None:
            return self.earlier.forces_at(self._earlier_scan(scan))
        return forces or {}

    def reported_forces(self, scan: int) -> Json | None:
        """Return the latest reported forces up to a scan, or None."""
        return self._forces.state_in(scan)

    def lines_at(self, scan: int | None) -> Json:
        """Return the waiting lines of the sequences in a scan, by name."""
        earlier = {} if self.earlier is None else self.earlier.lines_at(self._earlier_scan(scan))
        return earlier | (self._lines.state_in(LAST_SCAN if scan is None else scan) or {})

    def pressed_at(self, scan: int | None) -> Json:
        """Return the values that actions last set up to a scan, and the sources."""
        earlier = {} if self.earlier is None else self.earlier.pressed_at(self._earlier_scan(scan))
        until = LAST_SCAN if scan is None else scan
        return earlier | (self._stored.state_in(until) or {}) | (self._pressed.state_in(until) or {})

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the rule that last set each bit, up to a scan."""
        earlier = [] if self.earlier is None else self.earlier.rules_at(self._earlier_scan(scan))
        if scan is None:
            own_rules: Iterable[Json] = self._latest_rules.values()
        else:
            own_rules = (rule for rule in self._rules if rule["scan"] <= scan)
        return list({(rule["slot"], rule["bit"]): rule for rule in (*earlier, *own_rules)}.values())


class _StateHistory:
    """States by the first scan in which they were in effect."""

    def __init__(self, keep: int = STATES, names_most: int | None = None) -> None:
        self._keep, self._names_most = keep, names_most
        self._scans: list[int] = []
        self._states: list[Json] = []

    @property
    def latest(self) -> Json:
        return self._states[-1] if self._states else {}

    def add(self, scan: int, state: Json) -> None:
        self._scans.append(scan)
        self._states.append(state)
        if len(self._scans) > 2 * self._keep:
            del self._scans[: self._keep], self._states[: self._keep]

    def set_value(self, scan: int, name: str, value: Any) -> None:
        """Add a state in which a name has a new value; if there are too many names, drop the oldest one."""
        if self.latest.get(name) != value:
            values = dict(self.latest)
            values.pop(name, None)  # the latest name comes last
            values[name] = value
            if self._names_most is not None and len(values) > self._names_most:
                del values[next(iter(values))]
            self.add(scan, values)

    def state_in(self, scan: int) -> Json | None:
        index = bisect_right(self._scans, scan) - 1
        return self._states[index] if index >= 0 else None


def _fault_of(event: Mapping[str, Any]) -> Fault:
    """Return the fault that an event of /faults describes."""
    cause = next((candidate for candidate in Cause if candidate.value == event.get("cause")), Cause.PROGRAM)
    where, text = str(event.get("where", "")), str(event.get("text", ""))
    site = Site(routine=event.get("routine", ""), rung=event.get("rung"))
    return Fault(event["scan"], event["t"], cause, where, text, site)


def _row_of(event: Mapping[str, Any]) -> Json:
    """Return the row of an event in the page."""
    return {
        "scan": event["scan"],
        "t": event["t"],
        "slot": event.get("slot", 0),
        "kind": event.get("kind", event["topic"].strip("/")),
        "name": event.get("name", ""),
        "text": event.get("text") or _event_text(event),
        **({"module": event.get("module")} if event["topic"] == INDICATORS else {}),
        **({"bits": event["bits"]} if event.get("bits") else {}),
        **({"order": event["order"]} if "order" in event else {}),
    }


def _event_text(event: Mapping[str, Any]) -> str:
    """Format the fields of an event that has no text."""
    if event.get("topic") == FORCES:
        return _forces_text(event)
    skipped = ("scan", "t", "topic", "kind", "slot")
    return ", ".join(f"{key} {value}" for key, value in event.items() if key not in skipped) or "none"


def _forces_text(event: Mapping[str, Any]) -> str:
    """Return the forced addresses and tags with their values, bits as 0 or 1."""
    images = {key: value for key, value in event.items() if key not in _NOT_FORCED}
    forces = {**images, **event.get("tags", {})}
    numbers = {name: int(value) if isinstance(value, bool) else value for name, value in forces.items()}
    values = ", ".join(f"{name} {value}" for name, value in numbers.items())
    return f"Forced: {values}" if values else "Nothing is forced."
