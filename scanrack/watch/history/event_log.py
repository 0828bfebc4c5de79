"""Keeps the events of a session or recording, and the states of each scan.

events    all events, in order; the latest are kept
faults    of the CPU
forces    by the first scan in which they were in effect
lines     by the first scan in which a sequence waited there
pressed   by the first scan after an order that set an input or a tag
rules     the rule that last set each bit
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
"""Number of past events for a new page."""

LAST_SCAN = 1 << 32
"""More than the number of any scan."""

STATED = frozenset(topic.name for topic in TOPICS if topic.state)

STATES = 10_000
"""Least number of kept changes for each kind of state: forces, lines, rules."""

STORED, NAMES_MOST = 500, 100
"""Least number of kept changes for tags that clients write, and largest number of these tags."""

SEQUENCES, FORCES, FAULTS, INDICATORS = "/sequences", "/forces", "/faults", "/indicators"

_NOT_FORCED = ("scan", "t", "topic", "tags")


class States(Protocol):
    """The states as of a given scan."""

    @property
    def formats(self) -> NumberFormats:
        """The number formats of modules whose configuration selects them."""

    @property
    def version(self) -> tuple[int, ...]:
        """A value that changes with each newly known event."""

    def forces_at(self, scan: int | None) -> Json:
        """Return the forces in effect in a scan; None = the latest."""

    def lines_at(self, scan: int | None) -> Json:
        """Return the waiting lines of the sequences in a scan, by name."""

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the rule that last set each bit, up to a scan."""

    def pressed_at(self, scan: int | None) -> Json:
        """Return what orders last set up to a scan, and by whom: `{"Start": [true, "panel, page 1"]}`."""

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the CPU's faults up to the end of a scan."""

    def up_to(self, scan: int, most: int) -> list[Json]:
        """Return the latest events up to a scan, in order."""

    def missing(self) -> int:
        """Return the number of unread chunks of a recording, or of events that are no longer kept."""


class EventLog:
    """The events, in the order in which they were reported.

    Attributes:
        begin: number of the first kept event.
        formats: number formats of modules whose configuration selects them, as far as events report them.
        earlier: the states before the first event, or None.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._kept = kept
        self.clear()

    def clear(self) -> None:
        """Drop all events: another session begins."""
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
        """Return the kept events from the given number."""
        return self._events[max(0, number - self.begin) :]

    def take_all(self, events: Iterable[TraceEvent]) -> None:
        """Add the events of a recording."""
        for event in events:
            self.take({**event.fields, "scan": event.scan, "t": event.now_ns, "topic": event.topic})

    def take(self, event: Mapping[str, Any]) -> None:
        """Add an event: scan, t, topic and its fields."""
        topic, scan = event["topic"], event["scan"]
        self._first = min(self._first, scan)
        if topic == FORCES:
            self.forced(scan, event)
        if topic in STATED and not self._is_news(topic, event):
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
        if len(self._events) > 2 * self._kept:
            self.begin += self._kept
            del self._events[: self._kept]

    def _is_news(self, topic: str, event: Mapping[str, Any]) -> bool:
        """Return whether a state has changed; a recording has only changes."""
        fields = {key: value for key, value in event.items() if key not in ("scan", "t", "topic")}
        before, self._stated[topic] = self._stated.get(topic), fields
        return before != fields

    def forced(self, scan: int, forces: Mapping[str, Any]) -> None:
        """Record the forces that are in effect from a scan."""
        images = {key: value for key, value in forces.items() if key not in _NOT_FORCED}
        self._forces.note(scan, {**images, **forces.get("tags", {})})

    def _take_line(self, event: Mapping[str, Any]) -> None:
        place = {"file": event["file"], "line": event["line"], "text": event["wait"], "since": event["t"]}
        self._lines.note(event["scan"], {**self._lines.latest, event["sequence"]: place})

    def _take_press(self, scan: int, text: str) -> None:
        try:
            order = action_of(parsed(text), RECORDED)
        except ValueError:
            return  # from a recording of another source
        match order:
            case Press(slot, name, on, by):
                self._pressed.put(scan, f"{slot}.input.{name}", [on, by])
            case Write(tag, value, by):
                self._pressed.put(scan, tag, [value, by])
            case Store(tag=tag, client=client, part=part):
                store = self._pressed if tag + part in self._pressed.latest else self._stored
                store.put(scan, tag + part, [None, client])

    def _take_rule(self, event: Mapping[str, Any]) -> None:
        for bit in event.get("bits") or ():
            rule = {"slot": event.get("slot", 0), "bit": bit, "rule": event.get("name", "")}
            details = {
                "text": event.get("text", ""),
                "section": event.get("section", ""),
                "scan": event["scan"],
            }
            self._rules.append(rule | details)
            self._latest_rules[rule["slot"], bit] = rule | details
        if len(self._rules) > 2 * STATES:
            del self._rules[:STATES]

    # --- states of a scan

    def up_to(self, scan: int, most: int) -> list[Json]:
        """Return the latest known events up to a scan, in order."""
        own_events = self._events[: bisect_right(self._events, scan, key=itemgetter("scan"))][-most:]
        if len(own_events) == most or self.earlier is None or self.begin:
            return own_events
        before = min(scan, self._events[0]["scan"] - 1) if self._events else scan
        return [*self.earlier.up_to(before, most - len(own_events)), *own_events]

    def missing(self) -> int:
        """Return how many events are no longer kept, or chunks of an earlier recording not read yet."""
        return self.begin or (0 if self.earlier is None else self.earlier.missing())

    def _before(self, scan: int | None) -> int:
        """Return the scan up to which earlier states apply: a growing recording repeats our events."""
        return self._first if scan is None else min(scan, self._first)

    def faults_at(self, scan: int | None) -> list[Fault]:
        """Return the CPU's faults up to the end of a scan; None = the latest."""
        earlier = [] if self.earlier is None or self._faults else self.earlier.faults_at(scan)
        return earlier + [fault for fault in self._faults if scan is None or fault.scan <= scan]

    def forces_at(self, scan: int | None) -> Json:
        """Return the forces in effect in a scan; None = the latest."""
        forces = self._forces.at(LAST_SCAN if scan is None else scan)
        if forces is None and self.earlier is not None:
            return self.earlier.forces_at(self._before(scan))
        return forces or {}

    def reported_forces(self, scan: int) -> Json | None:
        """Return the last reported forces up to a scan; None if there are none."""
        return self._forces.at(scan)

    def lines_at(self, scan: int | None) -> Json:
        """Return the waiting lines of the sequences in a scan, by name."""
        earlier = {} if self.earlier is None else self.earlier.lines_at(self._before(scan))
        return earlier | (self._lines.at(LAST_SCAN if scan is None else scan) or {})

    def pressed_at(self, scan: int | None) -> Json:
        """Return the values that orders last set up to a scan, and by whom."""
        earlier = {} if self.earlier is None else self.earlier.pressed_at(self._before(scan))
        until = LAST_SCAN if scan is None else scan
        return earlier | (self._stored.at(until) or {}) | (self._pressed.at(until) or {})

    def rules_at(self, scan: int | None) -> list[Json]:
        """Return the rule that last set each bit, up to a scan."""
        earlier = [] if self.earlier is None else self.earlier.rules_at(self._before(scan))
        if scan is None:
            own_rules: Iterable[Json] = self._latest_rules.values()
        else:
            own_rules = (rule for rule in self._rules if rule["scan"] <= scan)
        return list({(rule["slot"], rule["bit"]): rule for rule in (*earlier, *own_rules)}.values())


class _StateHistory:
    """States by the first scan in which they were in effect."""

    def __init__(self, kept: int = STATES, names_most: int | None = None) -> None:
        self._kept, self._names_most = kept, names_most
        self._scans: list[int] = []
        self._states: list[Json] = []

    @property
    def latest(self) -> Json:
        return self._states[-1] if self._states else {}

    def note(self, scan: int, state: Json) -> None:
        self._scans.append(scan)
        self._states.append(state)
        if len(self._scans) > 2 * self._kept:
            del self._scans[: self._kept], self._states[: self._kept]

    def put(self, scan: int, name: str, value: Any) -> None:
        """Record a name's value if it has changed; if there are too many names, drop the one set first."""
        if self.latest.get(name) != value:
            values = {key: kept_value for key, kept_value in self.latest.items() if key != name} | {
                name: value
            }
            if self._names_most is not None and len(values) > self._names_most:
                del values[next(iter(values))]
            self.note(scan, values)

    def at(self, scan: int) -> Json | None:
        place = bisect_right(self._scans, scan) - 1
        return self._states[place] if place >= 0 else None


def _fault_of(event: Mapping[str, Any]) -> Fault:
    cause = next((candidate for candidate in Cause if candidate.value == event.get("cause")), Cause.PROGRAM)
    place, text = str(event.get("where", "")), str(event.get("text", ""))
    site = Site(routine=event.get("routine", ""), rung=event.get("rung"))
    return Fault(event["scan"], event["t"], cause, place, text, site)


def _row_of(event: Mapping[str, Any]) -> Json:
    """Return an event as the page lists it."""
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
    if event.get("topic") == FORCES:
        return _forces_text(event)
    skipped = ("scan", "t", "topic", "kind", "slot")
    return ", ".join(f"{key} {value}" for key, value in event.items() if key not in skipped) or "none"


def _forces_text(event: Mapping[str, Any]) -> str:
    images = {key: value for key, value in event.items() if key not in _NOT_FORCED}
    forces = {**images, **event.get("tags", {})}
    numbers = {name: int(value) if isinstance(value, bool) else value for name, value in forces.items()}
    values = ", ".join(f"{name} {value}" for name, value in numbers.items())
    return f"Forced: {values}" if values else "Nothing is forced."
