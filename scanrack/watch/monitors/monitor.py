"""The contents of pages: a rack's rows, program and events, from a running session or a trace.

A monitor runs in one thread, and `server` calls `tick` 30 times per second. `Subject` has the contents of
pages; `session_monitor` and `trace_monitor` create it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.ring import Row

from ..history.catalog import NOTHING_SHOWN, shown_value, value_of
from ..history.event_log import LAST_SCAN, States
from ..history.event_table import EventTable, table_of
from ..history.lanes import ValueHistory
from ..history.recent import RecentRows
from ..history.stretch import Stretch, Stretches
from ..history.strip import piece_of, signals_of
from ..history.timeline import Timeline
from ..history.watched_program import Inputs, Values
from ..panels.bindings import Bindings
from ..panels.kept_panel import KeptPanel
from .hello import incidents_of, slots_of
from .marks import Marks
from .page import Page
from .picture import RowLayout, changes_since, mode_of
from .question_process import QuestionProcesses
from .stretched import SessionProgram

Json = dict[str, Any]

ENVELOPE_ROWS, ENVELOPE_MOST = 16, 128
"""Rows per point of a position in a frame, and maximum number of points, since a fast rack has many rows."""

BACK = 16_384
"""Number of scans before a scan to search in images and recorded values for a question."""

ALL_EVENTS = 1 << 40
"""Greater than any number of events."""

SPEED_SCANS = 50
"""Number of scans over which the speed of an axis is measured."""

STRIP_FIRST = 2048
"""Number of rows in the first strip of a page."""


@dataclass(frozen=True, slots=True)
class SessionFacts:
    """Data about a session or trace, in addition to its rack."""

    version: str
    name: str
    path: str  # path of the rack file or of the trace
    kind: str  # "rack" or "trace"
    read_only: bool
    live: bool  # whether the rack has real ports
    record: str | None  # path of the trace that the user keeps, or None
    branches: bool = False  # whether a page may begin a branch


class Subject:
    """A rack and its programs for pages.

    Args:
        machines: the slots with a machine whose figures are in the rows.
        dtype: type of the rows.
        trace: path of the recording; None without one.

    Attributes:
        programs: the programs by scan, at least one before a page joins.
    """

    def __init__(
        self,
        spec: RackSpec,
        machines: tuple[int, ...],
        dtype: np.dtype[Any],
        trace: Path | None,
    ) -> None:
        self.spec = spec
        self.words = spec.words
        self.row_layout = RowLayout(self.words, machines)
        self.signals = signals_of(self.words)
        self.recent = RecentRows(dtype)
        self.timeline = Timeline(self.recent, trace)
        self.history = ValueHistory(spec.scan_ns)
        self.programs = Stretches(self.words, self.timeline, self.history)
        self.values: Json = {}
        """Values of a Python program from the latest message."""

    def keep(self, record: Values | Inputs) -> None:
        """Store the notes of a program."""
        self.programs.store(record.program).take(record)

    def lanes(self, names: Sequence[str], first: int, last: int) -> tuple[Json, int | None]:
        """Return a piece of the lanes of tags in past scans, and the first scan of the next piece or None."""
        program = self.programs.at(first)
        program_end = self.programs.end_of(program)
        piece, following = program.lanes.past(names, first, min(last, program_end))
        if following is None and program_end < last:
            following = program_end + 1
        return piece, following

    def bindings(self, program: Stretch) -> Bindings:
        """Return the names to which the items of a panel can be bound."""
        return Bindings(program, slots_of(self.spec), program.described(self.values)["tags"])

    def described(self, about: SessionFacts, program: Stretch) -> Json:
        """Return the first message to a page."""
        return {
            "version": about.version,
            "rack": about.name,
            "path": about.path,
            "kind": about.kind,
            "read_only": about.read_only,
            "live_ports": about.live,
            "period_ns": self.spec.scan_ns,
            "record": about.record,
            "branches": about.branches,
            "slots": slots_of(self.spec),
            **program.described(self.values),
            "incidents": [] if about.live or about.read_only else incidents_of(self.spec),
            "sequences": [],
        }


class Monitor(ABC):
    """The data of pages, and the answers to their requests.

    Args:
        panel: the operator panel of the rack.
    """

    def __init__(self, about: SessionFacts, subject: Subject, states: States, panel: KeptPanel) -> None:
        self.about, self.subject, self.states, self.panel = about, subject, states, panel
        self.pages: list[Page] = []
        self._joined = 0
        self.processes = QuestionProcesses()
        self.opener: Callable[[Path], Any] | None = None  # opens another trace, see `open_beside`
        self.marks: Marks | None = None  # the marks of a trace
        self._table: EventTable | None = None
        self.latest: Row | None = None  # the row of the latest scan; None before the first
        self.ran: SessionProgram | None = None  # the files of the running program; None for a trace
        self.over = False  # whether the server should end

    # --- differences between a session and a trace

    @abstractmethod
    def tick(self) -> bool:
        """Do some of the due work; return whether more work is due now."""

    def latest_actions(self, scan: int) -> list[tuple[int, str]]:
        """Return the known actions up to a scan; the latest ones may not be in the trace yet."""
        return []

    @abstractmethod
    def act(self, page: Page, number: object, message: Mapping[str, Any]) -> None:
        """Carry out an action from a page; raise ValueError if it is not an action or is not allowed."""

    @abstractmethod
    def state(self, *, past: bool) -> Json:
        """Return the parts of a frame that are not about a scan: state, speed, late scans, breakpoints."""

    @abstractmethod
    def events(self, page: Page) -> Sequence[Json]:
        """Return the new events for a page."""

    # --- pages

    def wake(self) -> None:
        """Wake all pages to check for changes."""
        for page in self.pages:
            self.exchange_program(page)
            page.due.set()

    def send_all(self, message: Json) -> None:
        """Send a message to all pages."""
        for page in self.pages:
            page.send(message)

    def join(self, page: Page) -> None:
        """Add a page."""
        self._joined += 1
        page.number = self._joined
        self.greet(page)
        self.pages.append(page)

    def greet(self, page: Page) -> None:
        """Send a page its first message, and make its next frame contain everything."""
        page.program = self.subject.programs.at(page.past)
        page.show(NOTHING_SHOWN)
        page.send({"hello": self.subject.described(self.about, page.program)})
        page.events = None
        page.start_over()

    def leave(self, page: Page) -> None:
        """Remove a page, and release its presses."""
        self.release_presses(page)
        if page in self.pages:
            self.pages.remove(page)
        page.compare(None)

    def release_presses(self, page: Page) -> None:
        """Carry out the actions that release a page's presses."""
        releases, page.releases = page.releases, []
        for action in releases:
            self.act(page, None, action)

    def tick_compared(self) -> bool:
        """Do some work on the traces to which pages are compared; return whether more work is due now."""
        busy_pages = [page for page in self.pages if page.compared is not None and page.compared.tick()]
        for page in busy_pages:
            page.due.set()
        return bool(busy_pages)

    def picture(self, page: Page) -> Json:
        """Return the picture of a page's scan; empty before the first scan."""
        row = self.row_of(page)
        return {} if row is None else self._picture(page, row)

    def frame(self, page: Page) -> Json:
        """Return the changes for a page since its last frame."""
        row = self.row_of(page)
        picture = self._picture(page, row) if row is not None else self._before_the_first_scan()
        if page.compared is not None and row is not None:
            picture["other"] = page.compared.differences(page, picture)
        frame = changes_since(page.last, picture)
        if row is not None and page.past is None:
            frame |= self._strip(page) | self._lanes(page, int(row["scan"]))
        if new_events := self.events(page):
            frame["events"] = list(new_events)
        return frame

    def exchange_program(self, page: Page) -> None:
        """Send a page the program of the scan it shows if the program has changed.

        The message precedes the next frame, which has the power and the tags of the new program.
        """
        program = self.subject.programs.at(page.past)
        if program is not page.program:
            page.program = program
            page.show(NOTHING_SHOWN)
            page.send({"program": program.described(self.subject.values)})

    def event_table(self, scan: int) -> EventTable:
        """Return a table of the known events, at least up to a scan."""
        states = self.states
        if states.missing():
            return table_of((), states.up_to(scan, ALL_EVENTS), self.subject.words)
        if self._table is None or self._table.version != states.version:
            self._table = table_of(states.version, self.all_events(), self.subject.words)
        return self._table

    def all_events(self) -> Sequence[Json]:
        """Return all events, in order."""
        return self.states.up_to(LAST_SCAN, ALL_EVENTS)

    def _before_the_first_scan(self) -> Json:
        """Return the picture of a page before the first scan: mode, forces, and values that were set."""
        return {
            "mode": self.subject.spec.mode,
            "forced": self.states.forces_at(None),
            "pressed": self.states.pressed_at(None),
            **self.state(past=False),
        }

    def row_of(self, page: Page) -> Row | None:
        """Return the row of a page's scan."""
        if page.past is None:
            return self.latest
        if page.row is None or int(page.row["scan"]) != page.past:
            page.row = self.subject.timeline.row(page.past)
        return page.row if page.row is not None else self.latest

    def _picture(self, page: Page, row: Row) -> Json:
        """Return the parts of a scan that a page shows: session states, images, machines and program."""
        past = page.past
        scan, timeline = int(row["scan"]), self.subject.timeline
        extent, earlier_row = timeline.extent, timeline.between(scan - SPEED_SCANS, scan)[:1]
        return {
            "scan": scan,
            "t": int(row["now_ns"]),
            "mode": mode_of(int(row["flags"])),
            "range": list(extent) if extent is not None else [scan, scan],
            "record": self.about.record,
            "forced": self.states.forces_at(past),
            "lines": self.states.lines_at(past),
            "rules": self.states.rules_at(past),
            "pressed": self.states.pressed_at(past),
            "faults": self.faults(past),
            **self.state(past=past is not None),
            **self.subject.row_layout.picture_of(
                row,
                earlier_row,
                self.states.formats,
                past=past is not None,
            ),
            **self._program(page, scan),
        }

    def faults(self, past: int | None) -> list[Json]:
        """Return the controller's faults up to a scan, with their rungs or lines and their tags."""
        program = self.subject.programs.at(past)
        return [
            {
                "text": str(fault),
                "at": program.place_of_fault(fault),
                "scan": fault.scan,
                "tags": program.tags_of_fault(fault, self.subject.values),
            }
            for fault in self.states.faults_at(past)
        ]

    def _program(self, page: Page, scan: int) -> Json:
        """Return the power and the tags that a page shows in a scan.

        `known` is False if the scan of a ladder program can't be shown yet.
        """
        subject = self.subject
        program = subject.programs.at(page.past)
        replica = program.live if page.past is None else program.past
        if replica is None:
            values = subject.values if page.past is None else subject.timeline.values(scan)
            return {"tags": {name: shown_value(value) for name, value in values.items()}}
        tags = replica.engine.tags
        names = [name for name in dict.fromkeys((*page.shown.names, *page.watched)) if name in tags]
        if not replica.show(scan):
            page.show(page.shown)  # so that a later frame contains all power and tags
            return {"known": False}
        return {
            "known": True,
            "power": page.shown.power(replica.truths),
            "tags": {name: shown_value(value_of(tags, name)) for name in names},
        }

    def _strip(self, page: Page) -> Json:
        """Return the strip since the last frame; for the first frame, return the strip of the latest rows."""
        recent, start = self.subject.recent, page.strip_position
        page.strip_position = recent.count
        if start is None:
            rows = recent.since(max(recent.begin, recent.count - STRIP_FIRST))
            previous = rows[:0]
        else:
            rows = recent.since(start)
            previous = recent.since(max(start - 1, recent.begin))[:1]
        most_points = min(-(-len(rows) // ENVELOPE_ROWS), ENVELOPE_MOST)
        piece = piece_of(
            rows,
            previous,
            self.subject.signals,
            self.subject.spec.scan_ns,
            most_points,
            formats=self.states.formats,
        )
        return {"strip": piece} if piece else {}

    def _lanes(self, page: Page, scan: int) -> Json:
        """Return the points of the tags in a page's strip since its last frame."""
        program = self.subject.programs.latest
        first = scan if page.lanes_scan is None else max(page.lanes_scan + 1, program.first)
        page.lanes_scan = scan
        if not page.lanes or first > scan:
            return {}
        all_names = [name for open_page in self.pages for name in open_page.lanes]
        return {"lanes": program.lanes.live(page.lanes, all_names, first, scan)}
