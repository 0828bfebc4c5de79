"""The monitor of a session, which gets rows, notes and messages from the scan process and sends actions."""

from __future__ import annotations

import json
import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from scanrack.jobs.load.loading import LoadedRack, load_job
from scanrack.jobs.record.program_versions import folders_of, forget
from scanrack.jobs.trust.attachments import load_files
from scanrack.runtime.live.actions import Action, Online, Press, Write, action_of, message_of
from scanrack.runtime.live.ring import ORDERS, REQUESTS, Ring, RingShape, Rows
from scanrack.runtime.live.session import PAGE_ACTIONS, SessionState
from scanrack.runtime.loop.pace import wall_ns
from scanrack.runtime.loop.scan import ScanFlag
from typing_extensions import override

from ..history.event_log import EventLog
from ..history.indexer import SLICE, Indexer, indexable
from ..history.recorded_events import RecordedEvents
from ..panels.kept_panel import KeptPanel
from .monitor import Json, Monitor, SessionFacts, Subject
from .page import Page
from .panel_questions import left_pressed, show_panel
from .picture import count_flag, speed_reached
from .questions import QUESTIONS
from .stretched import SessionProgram
from .troubles import ErrorBit, ErrorWatch

SPEED_ROWS = 512
"""Number of rows over which the speed of a session is measured."""


PANEL_TICKS = 15
"""Number of frames between two checks of the panel's file."""


@dataclass(frozen=True, slots=True)
class Setup:
    """Data that the scan process passes to a new monitor."""

    shape: RingShape
    about: SessionFacts
    key: str
    host: str
    port: int
    machines: tuple[int, ...]
    trace: str  # path of the trace, which may be temporary
    programs: tuple[SessionProgram, ...]  # programs that have run so far, in order
    started: int = 0  # number of earlier monitors of the session


class Loader:
    """The loaded programs of a session.

    Args:
        rack: path of the rack file, which is used for a program whose copy is incomplete.
    """

    def __init__(self, rack: str) -> None:
        self._rack = rack
        self._jobs: dict[SessionProgram, LoadedRack] = {}
        self._folders: set[Path] = set()

    def job(self, ran: SessionProgram) -> LoadedRack:
        """Return a program, which the first call loads; raise ValueError if it can't be loaded."""
        if ran not in self._jobs:
            forget(self._folders)
            try:
                job = load_files(Path(ran.place), ran.rack, ran.program)
            except ValueError:  # the program may open files that were not copied
                job = load_job(self._rack)
            self._jobs[ran] = job
            self._folders |= folders_of(job)
        return self._jobs[ran]


class SessionMonitor(Monitor):
    """The monitor of a running rack."""

    def __init__(self, setup: Setup, ring: Ring, pipe: Connection) -> None:
        self._loader = Loader(setup.about.path)
        spec = self._loader.job(setup.programs[0]).spec
        self.log = EventLog()
        subject = Subject(spec, setup.machines, ring.dtype, Path(setup.trace))
        super().__init__(setup.about, subject, self.log, KeptPanel(setup.about.path))
        for program in setup.programs:
            self._add(program)
        self._setup, self._ring, self._pipe = setup, ring, pipe
        self._errors = ErrorWatch(self.subject.words)
        self._latest_error: tuple[ErrorBit, Json] | None = None  # the latest error bit, and its message
        # positions of the next reads in the ring
        self._rows_at = max(0, ring.written - ring.shape.rows)
        self._messages_at = ring.messages.oldest
        self._snapshots_at = ring.snapshots.oldest

        self.session: Json = asdict(SessionState())
        self._late = self._missed = 0  # number of late scans, and of lost rows
        self._reached: float | None = None  # speed, times real time
        self._actions_sent = 0
        self._unanswered: dict[int, tuple[Page, object]] = {}  # by action number: page, id of its message
        # the mistake of the program, the preview of a saved file that waits, the state of edited rungs
        self._lasting: dict[str, Json | None] = dict.fromkeys(("mistake", "preview", "online"))
        self._ticks = 0

        # scans and events from before a restart
        self._indexer: Indexer | None = None
        self._earlier: RecordedEvents | None = None  # until all events are read
        self._indexed = False  # whether `_indexer` has been created, or is not needed
        self._index_to = 0  # the last scan of the indexer
        self._may_be_pressed = setup.started > 0  # pages of an earlier monitor may have left buttons pressed
        self._releases: list[Json] = []  # actions that have released such buttons
        ring.head[REQUESTS] += 1  # request initial values and the state

    def _add(self, ran: SessionProgram) -> None:
        self.ran = ran
        job = self._loader.job(ran)
        self.subject.programs.add(ran.first, job.logic, job.program)

    @override
    def state(self, *, past: bool) -> Json:
        """Return the state of the session, with speed 0 while it is paused; see `Monitor.state`."""
        session = self.session
        paused = bool(session["paused"])
        present = "paused" if paused else "live"
        fields: Json = {
            "state": "past" if past else present,
            "paused": paused,
            "speed": {"requested": session["speed"], "reached": 0 if paused else self._reached},
            "late": self._late,
            "missed": self._missed,
            "breakpoints": session["breakpoints"],
            "met": session["met"],
            "ran": session["ran"] if paused and not past else [],
        }
        return fields | ({"mode": "fault"} if session["fault"] and not past else {})

    @override
    def events(self, page: Page) -> Sequence[Json]:
        new_events = self.log.since(self.log.first_of_page if page.events is None else page.events)
        page.events = self.log.end
        return new_events

    @override
    def join(self, page: Page) -> None:
        """Add a page; send it a pending error bit, mistake, preview and edited rungs."""
        super().join(page)
        self._report_present_error(page)
        for kind, content in self._lasting.items():
            if content is not None:
                page.send({kind: content})
        if self._setup.started:
            page.send({"note": "The monitor was started again; the scans continued without it."})

    # --- time

    @override
    def tick(self) -> bool:
        """Read the output of the scan process, and wake the pages."""
        batches, was_paused = [self._take_rows()], self.session["paused"]
        self._take_messages()
        if self.session["paused"] and not was_paused:
            batches.append(self._take_rows())  # the last scans before the pause
        self._take_notes()
        for rows in batches:
            self._report_errors(rows)
        self.wake()
        self._attend_panels()
        return self._index() | self._read_earlier()

    def _attend_panels(self) -> None:
        """Release the presses of unresponsive pages; send the panel to pages if its file has changed."""
        for page in self.pages:
            if page.releases and wall_ns() > page.releases_due_ns:
                self.release_presses(page)
                page.send({"note": "The connection is slow: the panel's buttons were released."})
        self._ticks += 1
        if self._ticks % PANEL_TICKS == 0 and self.panel.changed():
            show_panel(self)

    def _take_rows(self) -> Rows:
        """Add the new rows of the ring and return them; count late scans and lost rows."""
        batch = self._ring.take(self._rows_at)
        self._rows_at = batch.end
        if self.latest is not None:  # rows from before this monitor are not missed
            self._missed += max(0, batch.lost)
        self._late += count_flag(batch.rows, ScanFlag.OVERRUN)
        self.subject.recent.add(batch.rows)
        if len(batch.rows):
            self.latest = batch.rows[-1]
            self._reached = speed_reached(self.subject.recent.rows[-SPEED_ROWS:])
        return batch.rows

    def _report_errors(self, rows: Rows) -> None:
        """Report the first new error bit to pages at the latest scan; some pages stop there."""
        first_error = self._errors.first(rows)
        if first_error is None:
            return
        index, bit = first_error
        row, scan = rows[index], int(rows[index]["scan"])
        rules = {(rule["slot"], rule["bit"]): rule for rule in self.log.rules_at(scan)}
        rule = rules.get((bit.slot, bit.name), {"text": "", "rule": ""})
        report = {"scan": scan, "t": int(row["now_ns"]), "slot": bit.slot, "bit": bit.name}
        report |= {"tag": bit.address, "text": rule["text"], "rule": rule["rule"]}
        self._latest_error = bit, report
        for page in [page for page in self.pages if page.past is None]:
            page.past = scan if page.stops else None
            page.send({"error": {**report, "stopped": page.stops}})

    def _report_present_error(self, page: Page) -> None:
        """Report the latest error bit to a new page if it is still on."""
        if self._latest_error is not None and self.latest is not None:
            bit, report = self._latest_error
            if self._errors.is_on(self.latest, bit):
                page.send({"error": {**report, "stopped": False}})

    def _take_notes(self) -> None:
        records, self._snapshots_at, _lost = self._ring.snapshots.read(self._snapshots_at)
        for record in records:
            self.subject.keep(pickle.loads(record))

    def _take_messages(self) -> None:
        """Handle the new messages from the scan process; keep lasting messages for new pages."""
        messages, self._messages_at, lost = self._ring.messages.read(self._messages_at)
        if lost:
            self._ring.head[REQUESTS] += 1  # request the state, which may have been in a lost message
        for message in messages:
            for kind, content in json.loads(message).items():
                if kind in self._lasting:
                    self._lasting[kind] = content
                    self.send_all({kind: content})
                else:
                    _MESSAGE_HANDLERS[kind](self, content)

    # --- messages of the scan process

    def _take_answer(self, answer: Json) -> None:
        page, number = self._unanswered.pop(answer["id"], (None, None))
        if page is not None:
            page.send({"answer": {**answer, "id": number}})

    def _take_values(self, message: Json) -> None:
        self.subject.values.update(message["values"])
        self.subject.history.take(message["scan"], message["values"])

    def _take_edit(self, message: Json) -> None:
        """Show the edited program in later scans."""
        if message["number"] < len(self.subject.programs.all):
            return  # a restarted monitor already has it
        self._add(SessionProgram(*message["program"]))
        self.subject.values.clear()
        self._lasting |= {"mistake": None, "preview": None}
        if message["again"]:
            return  # a branch repeats the edits of its parent
        self.send_all({"edited": {key: message[key] for key in ("text", "new", "changed", "dropped")}})

    def _take_branch(self, message: Json) -> None:
        """Start over for a branch, in which the rack continues differently after a past scan."""
        self._setup = replace(
            self._setup,
            about=replace(self.about, record=message["record"]),
            trace=message["trace"],
        )
        self.about = self._setup.about
        subject = self.subject
        subject.recent.clear()
        self._errors.clear()
        self._latest_error = None
        subject.timeline.forget(Path(message["trace"]))
        subject.programs.clear()
        subject.history.clear()
        for fields in message["programs"]:
            self._add(SessionProgram(*fields))
        self.log.clear()
        self._indexer, self._earlier, self._indexed = None, None, False
        self.latest, self._late, self._missed = None, 0, 0
        self._rows_at, self._snapshots_at = message["rows"], message["snapshots"]
        self._lasting["online"] = None
        for page in self.pages:
            self.release_presses(page)  # the page forgets its presses when it is greeted
            page.past = None
            self.greet(page)

    # --- earlier scans

    def _index(self) -> bool:
        """Repeat some of the scans from before this monitor started; return whether more scans remain."""
        if not self._indexed:
            self._begin_index()
        indexer = self._indexer
        if indexer is None:
            return False
        rows = self.subject.timeline.between(indexer.next, min(indexer.next + SLICE - 1, self._index_to))
        if not len(rows):
            return False  # the scans are not written yet
        indexer.run(rows)
        if indexer.next > self._index_to:
            self._indexer = None
        return self._indexer is not None

    def _begin_index(self) -> None:
        """Start repeating the scans before the first values from the scan process."""
        subject = self.subject
        programs, end = indexable(subject.programs.all)
        first_values = [min(program.store.scans) for program in subject.programs.all if program.store.scans]
        if programs and not first_values:
            return  # no values have arrived yet
        self._index_to = min(first_values[0] - 1, end) if programs else -1
        if self._index_to < 0 and not self._setup.started:
            self._indexed = True
            return
        trace = subject.timeline.opened()
        if trace is None:
            return  # no chunk has been written yet
        self._indexed = True
        recorded_events = self.log.earlier = self._earlier = RecordedEvents(trace)
        self.log.formats = recorded_events.formats
        self._release_left_presses()
        if self._index_to < 0:
            return
        self._indexer = Indexer(programs, subject.words, subject.spec, recorded_events, subject.keep)

    def _read_earlier(self) -> bool:
        """Read some of the events from before this monitor started; return whether more events remain."""
        if self._earlier is None:
            return False
        if not self._earlier.tick():
            self._earlier = None
            self._release_left_presses()  # including buttons that were pressed long ago
            self._may_be_pressed = False
        return self._earlier is not None

    def _release_left_presses(self) -> None:
        """Release buttons that pages of an earlier monitor left pressed, since that monitor has ended."""
        if self._may_be_pressed and not self.about.read_only:
            for release in left_pressed(self):
                if release not in self._releases:
                    self._releases.append(release)
                    self._send_action(action_of({**release, "by": "panel, after a restart"}))

    # --- actions

    @override
    def latest_actions(self, scan: int) -> list[tuple[int, str]]:
        events = self.log.since(self.log.begin)
        return [
            (event["scan"], event["order"]) for event in events if "order" in event and event["scan"] <= scan
        ]

    @override
    def act(self, page: Page, number: object, message: Mapping[str, Any]) -> None:
        """Send an action to the scan process; the page gets its answer later, see `_take_answer`."""
        if message.get("do") not in PAGE_ACTIONS:
            names = ", ".join((*PAGE_ACTIONS, *QUESTIONS))
            raise ValueError(f"no action {str(message.get('do'))[:60]!r}; choose from {names}")
        action = action_of({key: value for key, value in message.items() if key != "id"}, PAGE_ACTIONS)
        if self.about.read_only:
            raise ValueError("this session is read-only: it accepts no actions")
        if isinstance(action, Online) or (isinstance(action, Press | Write) and action.by):
            # name the page, in addition to the control that the page has named
            action = replace(action, by=", ".join(filter(None, (action.by, f"page {page.number}"))))
        self._unanswered[self._actions_sent + 1] = page, number
        self._send_action(action)

    def _send_action(self, action: Action) -> None:
        """Send an action with the next number, and tell the scan process that one is waiting."""
        self._actions_sent += 1
        message = {"id": self._actions_sent, "order": message_of(action)}
        self._pipe.send_bytes(json.dumps(message, ensure_ascii=False, allow_nan=False).encode())
        self._ring.head[ORDERS] += 1


_MESSAGE_HANDLERS: Mapping[str, Callable[[SessionMonitor, Any], None]] = {
    "event": lambda monitor, event: monitor.log.take(event),
    "answer": SessionMonitor._take_answer,
    "state": lambda monitor, state: setattr(monitor, "session", state),
    "forces": lambda monitor, message: monitor.log.add_forces(message["scan"], message["forces"]),
    "values": SessionMonitor._take_values,
    "branch": SessionMonitor._take_branch,
    "edited": SessionMonitor._take_edit,
    "note": lambda monitor, text: monitor.send_all({"note": text}),
}
"""Handlers of messages from the scan process, by key."""
