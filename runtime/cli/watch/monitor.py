"""The monitor: rows of the scan process in, pictures and answers for pages out.

It runs in a process of its own, one thing after the other; `server` calls `tick` thirty times a second.
"""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from multiprocessing.connection import Connection
from typing import Any

from ....ladder import LadderLogic
from ....ladder.debug.inquiry import Inquiry
from ...app.loading import Job, load_job
from ...live.orders import ORDERS, order_of, said_of
from ...live.ring import Ring, Row, Shape
from ...loop.scan import ScanFlag
from .catalog import COLUMNS, Catalog, python_routines, python_source, shown_value
from .hello import incidents_of, is_stepper, slots_of
from .page import Page
from .picture import Places, changed, late_scans, mode_of, speed_reached
from .recent import Recent
from .shadow import Kept, Shadow
from .strip import edges, envelopes, signals_of

Json = dict[str, Any]

EVENTS_KEPT = 2000
EVENTS_FIRST = 200
"""Events of the past that a page is told of first."""

MOST_WATCHED = 500
"""Tags that a page may watch."""

ENVELOPE_STEPS = 500
"""Points of a position in a window of the past."""

STRIP_FIRST = 2048
"""Rows that the first strip of a page begins with."""


@dataclass(frozen=True, slots=True)
class Setup:
    """What the scan process gives a monitor.

    Attributes:
        shape: of the ring.
        rack: path of the rack file.
        name: of the rack.
        key: that pages have to give.
        host: what the server listens on.
        port: and its port.
        read_only: orders are refused.
        live: there are real ports.
        record: path of the recording; None if it is not kept.
        machines: the slots with figures in the ring's rows.
        version: of scanrack.
        started: how often a monitor was started before.
    """

    shape: Shape
    rack: str
    name: str
    key: str
    host: str
    port: int
    read_only: bool
    live: bool
    record: str | None
    machines: tuple[int, ...]
    version: str
    started: int = 0


class Monitor:
    """What pages look at.

    Args:
        setup: what the scan process says.
        ring: its ring.
        pipe: orders go through it.
    """

    def __init__(self, setup: Setup, ring: Ring, pipe: Connection) -> None:
        self._setup, self._ring, self._pipe = setup, ring, pipe
        self._job: Job = load_job(setup.rack)
        spec = self._job.spec
        words = {slot.number: slot.words for slot in sorted(spec.slot, key=lambda each: each.number)}
        self._places = Places(words, setup.machines)
        self._signals = signals_of(words, [slot for slot, each in words.items() if is_stepper(each)])
        self._recent = Recent(ring.take(ring.written).rows)
        self._kept = Kept()
        self._catalog: Catalog | None = None
        self._live: Shadow | None = None
        self._past: Shadow | None = None
        logic = self._job.logic
        if isinstance(logic, LadderLogic):
            self._catalog = Catalog(logic)
            self._live, self._past = (Shadow(logic, list(words), self._recent, self._kept) for _ in range(2))
        self.pages: list[Page] = []
        self._rows_at = max(0, ring.written - ring.shape.rows)
        self._messages_at = ring.messages.end
        self._snapshots_at = ring.snapshots.end
        self._state: Json = {"paused": False, "speed": 1.0, "breakpoints": [], "met": [], "fault": ""}
        self._forced: Json = {}
        self._events: list[Json] = []
        self._events_dropped = 0
        self._values: Json = {}
        self._lines: Json = {}
        self._rules: dict[tuple[int, str], Json] = {}
        self._late = self._missed = 0
        self._reached: float | None = None
        self._picture: Json = {}
        self._orders = 0
        self._asked: dict[int, tuple[Page, object]] = {}
        self._row: Row | None = None
        ring.asked += 1  # values to begin with, and the state

    # --- time

    def tick(self) -> None:
        """Take what the scan process has written, and let pages know."""
        taken = self._ring.take(self._rows_at)
        self._rows_at = taken.end
        self._missed += max(0, taken.lost) if self._row is not None else 0
        self._late += late_scans(taken.rows, ScanFlag.OVERRUN)
        self._recent.add(taken.rows)
        self._take_notes()
        self._take_messages()
        if len(taken.rows):
            self._row = taken.rows[-1]
            latest = self._recent.rows[-512:]
            self._reached = speed_reached(latest)
        if self._row is not None:
            self._picture = self._picture_of(self._row)
        for page in self.pages:
            page.due.set()

    def _take_notes(self) -> None:
        records, self._snapshots_at, _lost = self._ring.snapshots.read(self._snapshots_at)
        for record in records:
            self._kept.take(pickle.loads(record))

    def _take_messages(self) -> None:
        messages, self._messages_at, lost = self._ring.messages.read(self._messages_at)
        if lost:
            self._ring.asked += 1  # the state may have been among them
        for message in messages:
            for kind, content in json.loads(message).items():
                _TAKE[kind](self, content)

    def _take_event(self, event: Json) -> None:
        topic = event["topic"]
        if topic == "/forces":
            self._take_forces(
                {key: value for key, value in event.items() if key not in ("scan", "t", "topic")}
            )
        if topic == "/sequences":
            self._lines[event["sequence"]] = {
                "file": event["file"],
                "line": event["line"],
                "text": event["wait"],
                "since": event["t"],
            }
            return
        told = {
            "scan": event["scan"],
            "t": event["t"],
            "slot": event.get("slot", 0),
            "kind": event.get("kind", topic.strip("/")),
            "name": event.get("name", ""),
            "text": event.get("text") or _spoken(event),
        }
        self._events.append(told)
        if event.get("kind") == "rule":
            self._note_rule(event)
        if len(self._events) > 2 * EVENTS_KEPT:
            self._events_dropped += EVENTS_KEPT
            del self._events[:EVENTS_KEPT]

    def _take_forces(self, forces: Json) -> None:
        self._forced = {key: value for key, value in forces.items() if key != "tags"} | forces.get("tags", {})

    def _note_rule(self, event: Json) -> None:
        """Remember the rule that last set each bit."""
        for bit in event.get("bits") or ():
            self._rules[event.get("slot", 0), bit] = {
                "slot": event.get("slot", 0),
                "bit": bit,
                "rule": event.get("name", ""),
                "text": event.get("text", ""),
                "section": event.get("section", ""),
                "scan": event["scan"],
            }

    def _take_answer(self, answer: Json) -> None:
        page, number = self._asked.pop(answer["id"], (None, None))
        if page is not None:
            page.send({"answer": {**answer, "id": number}})

    def _take_values(self, told: Json) -> None:
        self._values.update(told["values"])

    def _take_state(self, state: Json) -> None:
        self._state = state

    # --- pages

    def hello(self) -> Json:
        """Return what a page is told once."""
        setup, spec = self._setup, self._job.spec
        return {
            "hello": {
                "version": setup.version,
                "rack": setup.name,
                "path": setup.rack,
                "kind": "rack",
                "read_only": setup.read_only,
                "live_ports": setup.live,
                "period_ns": spec.scan_ns,
                "record": setup.record,
                "slots": slots_of(spec),
                "routines": self._catalog.routines() if self._catalog else python_routines(self._job.program),
                "tags": self._catalog.tags() if self._catalog else self._python_tags(),
                "incidents": [] if setup.live else incidents_of(spec),
                "sequences": [],
            }
        }

    def _python_tags(self) -> list[Json]:
        """Return the values of a program in Python, as far as they have been told."""
        kinds = {bool: "BOOL", int: "LINT", str: "TEXT"}
        return [
            {"name": name, "type": kinds.get(type(value), "LREAL"), "description": "", "writable": False}
            for name, value in self._values.items()
        ]

    def join(self, page: Page) -> None:
        """Let a page in."""
        page.send(self.hello())
        if self._setup.started:
            page.send({"note": "The monitor was started again; the scans went on without it."})
        page.events = max(self._events_dropped, self._events_dropped + len(self._events) - EVENTS_FIRST)
        self.pages.append(page)

    def leave(self, page: Page) -> None:
        """Let a page go."""
        if page in self.pages:
            self.pages.remove(page)

    def frame(self, page: Page) -> Json | None:
        """Return what has changed for a page since its last frame; None if nothing has."""
        row = self._row_of(page)
        if row is None:
            return None
        picture = self._picture if page.past is None else self._picture_of(row, past=True)
        frame = changed(picture | self._program(page, int(row["scan"])), page.last)
        if page.past is None:
            frame |= self._strip(page)
        start = page.events - self._events_dropped
        new = list(islice(self._events, max(0, start), None))
        page.events = self._events_dropped + len(self._events)
        if new:
            frame["events"] = new
        return frame or None

    def _row_of(self, page: Page) -> Row | None:
        if page.past is None:
            return self._row
        at = self._recent.find(page.past)
        return self._row if at is None else self._recent.rows[at]

    def _picture_of(self, row: Row, *, past: bool = False) -> Json:
        state = self._state
        rows = self._recent.rows
        paused = bool(state["paused"])
        return {
            "scan": int(row["scan"]),
            "t": int(row["now_ns"]),
            "mode": "fault" if state["fault"] and not past else mode_of(int(row["flags"])),
            "state": "past" if past else "paused" if paused else "live",
            "speed": {"wanted": state["speed"], "reached": 0 if paused else self._reached},
            "late": self._late,
            "missed": self._missed,
            "range": [int(rows["scan"][0]), int(rows["scan"][-1])] if len(rows) else [0, 0],
            "record": self._setup.record,
            "forced": self._forced,
            "breakpoints": state["breakpoints"],
            "met": state["met"],
            "lines": dict(self._lines),
            "rules": list(self._rules.values()),
            "faults": [{"text": state["fault"], "at": None}] if state["fault"] else [],
            **self._places.of(row),
        }

    def _program(self, page: Page, scan: int) -> Json:
        """Return power and tags of what a page shows."""
        shadow = self._live if page.past is None else self._past
        if shadow is None:
            return {} if page.past is not None else {"tags": dict(self._values)}
        if not shadow.show(scan):
            return {}
        tags = shadow.engine.tags
        names = dict.fromkeys((*page.shown.names, *page.watched))
        return {
            "power": page.shown.power(shadow.truths),
            "tags": {name: shown_value(tags[name]) for name in names if name in tags},
        }

    def _strip(self, page: Page) -> Json:
        """Return edges and envelopes since the last frame; at first the latest rows."""
        recent = self._recent
        first = page.place is None
        place = max(recent.begin, recent.count - STRIP_FIRST) if page.place is None else page.place
        page.place = recent.count
        rows = recent.since(place)
        if not len(rows):
            return {}
        before = rows[:0] if first else recent.since(max(place - 1, recent.begin))[:1]
        found: Json = {}
        bits = edges(rows, before, self._signals)
        if bits:
            found["strip"] = bits
        positions = envelopes(rows, self._signals)
        if positions:
            found["env"] = positions
        return found

    # --- what pages ask

    def ask(self, page: Page, said: object) -> None:
        """Take an order or a question of a page; the answer goes to the page.

        Nothing that a page sends raises: what is wrong with it is the answer.
        """
        number = said.get("id") if isinstance(said, Mapping) else None
        if not isinstance(number, int | str) or isinstance(number, bool):
            number = None
        try:
            if not isinstance(said, Mapping):
                raise ValueError("a message is an object with the keys id and do")
            name = said.get("do")
            question = _QUESTIONS.get(name) if isinstance(name, str) else None
            if question is not None:
                page.send({"answer": {"id": number, "ok": True, **question(self, page, said)}})
            else:
                self._order(page, number, said)
        except ValueError as error:
            page.send({"answer": {"id": number, "refused": str(error)}})

    def _order(self, page: Page, number: object, said: Mapping[str, Any]) -> None:
        if said.get("do") not in ORDERS:
            known = ", ".join((*ORDERS, *_QUESTIONS))
            raise ValueError(f"there is nothing to do called {str(said.get('do'))[:60]!r}: there are {known}")
        order = order_of({key: value for key, value in said.items() if key != "id"})
        if self._setup.read_only:
            raise ValueError("this session is read-only: it takes no orders")
        self._orders += 1
        self._asked[self._orders] = page, number
        message = json.dumps({"id": self._orders, "order": said_of(order)}, allow_nan=False)
        self._pipe.send_bytes(message.encode())
        self._ring.orders += 1

    def _show(self, page: Page, said: Mapping[str, Any]) -> Json:
        if self._catalog is None:
            shown, answer = python_source(self._job.program, tuple(self._values))
            page.show(shown)
            return answer
        columns = said.get("columns", 88)
        if type(columns) is not int or columns not in COLUMNS:
            raise ValueError(f"columns {columns!r}: allowed are {COLUMNS[0]} to {COLUMNS[-1]}")
        shown, answer = self._catalog.show(_text(said, "routine"), columns)
        page.show(shown)
        return answer

    def _watch(self, page: Page, said: Mapping[str, Any]) -> Json:
        tags = said.get("tags")
        if not isinstance(tags, list) or len(tags) > MOST_WATCHED or not all(map(_is_name, tags)):
            raise ValueError(f"tags is a list of up to {MOST_WATCHED} names")
        known = self._values.__contains__ if self._catalog is None else self._catalog.has
        unknown = [name for name in tags if not known(name)]
        page.watch(tuple(name for name in tags if name not in unknown))
        return {"unknown": unknown}

    def _why(self, page: Page, said: Mapping[str, Any]) -> Json:
        """Say why a tag is as it is in the scan that the page shows."""
        tag = _text(said, "tag")
        shadow, row = self._past, self._row_of(page)
        if shadow is None or self._catalog is None or row is None:
            raise ValueError(f"{tag}: the program is in Python: scanrack why tells of a recording")
        scan = int(row["scan"])
        if not shadow.show(scan):
            raise ValueError(f"scan {scan} can't be repeated: ask again in a moment")
        try:
            text = Inquiry(shadow.engine, shadow, self._forced, self._catalog.cross_reference).why(tag)
        finally:
            shadow.show(scan)
        return {"text": text, "scan": scan}

    def _xref(self, _page: Page, said: Mapping[str, Any]) -> Json:
        """List where a tag is read and written."""
        tag = _text(said, "tag")
        if self._catalog is None:
            raise ValueError(f"{tag}: the program is in Python: it has no rungs")
        return {"hits": self._catalog.mentions(tag)}

    def _find(self, _page: Page, said: Mapping[str, Any]) -> Json:
        """List the tags and rungs in which a text stands."""
        text = _text(said, "text")
        return {"hits": [] if self._catalog is None else self._catalog.find(text)}

    def _window(self, page: Page, said: Mapping[str, Any]) -> Json:
        """Return edges and envelopes of past scans."""
        first, last = said.get("from"), said.get("to")
        if type(first) is not int or type(last) is not int or not 0 <= first <= last:
            raise ValueError("from and to are numbers of scans, the first one not behind the other")
        rows = self._recent.between(first, last)
        bits = edges(rows, rows[:0], self._signals)
        wanted = said.get("signals")
        if isinstance(wanted, list):
            bits = {name: each for name, each in bits.items() if name in wanted}
        return {"strip": bits, "env": envelopes(rows, self._signals, ENVELOPE_STEPS)}

    def _look(self, page: Page, said: Mapping[str, Any]) -> Json:
        scan = said.get("scan")
        if scan == "live":
            page.past = None
            page.begin_anew()
            return {"scan": "live"}
        if type(scan) is not int:
            raise ValueError('scan is the number of a scan, or "live"')
        if self._recent.find(scan) is None:
            rows = self._recent.rows["scan"]
            held = f"{rows[0]} to {rows[-1]}" if len(rows) else "none"
            raise ValueError(f"scan {scan} is not there any more, or not yet: there are {held}")
        page.past = scan
        return {"scan": scan}


def _text(said: Mapping[str, Any], key: str) -> str:
    value = said.get(key)
    if not _is_name(value):
        raise ValueError(f"{key} is text of 1 to 400 characters")
    return str(value)


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= 400


def _spoken(event: Json) -> str:
    skipped = ("scan", "t", "topic", "kind", "slot")
    return ", ".join(f"{key} {value}" for key, value in event.items() if key not in skipped) or "none"


_TAKE: Mapping[str, Callable[[Monitor, Json], None]] = {
    "event": Monitor._take_event,
    "answer": Monitor._take_answer,
    "state": Monitor._take_state,
    "forces": Monitor._take_forces,
    "values": Monitor._take_values,
}
"""Messages of the scan process by their key."""

_QUESTIONS: Mapping[str, Callable[[Monitor, Page, Mapping[str, Any]], Json]] = {
    "show": Monitor._show,
    "watch": Monitor._watch,
    "look": Monitor._look,
    "window": Monitor._window,
    "why": Monitor._why,
    "xref": Monitor._xref,
    "find": Monitor._find,
}
"""What a page may ask."""
