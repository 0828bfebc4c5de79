"""A running rack, which is a session of `scanrack watch` with an editor in addition to its pages.

after a scan              then
a breakpoint is met       pause, stopped
a request has arrived     it is carried out before the next scan
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import FrameType
from typing import Protocol

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.run.running import JobRun
from scanrack.jobs.why.journal import Journal
from scanrack.jobs.why.traced_run import Load
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger, journal
from scanrack.ladder.debug.replay import Replayer
from scanrack.ladder.python.line_marks import WATCH, Observer
from scanrack.ladder.python.online.fields import Fields
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live import actions
from scanrack.runtime.live.session import Inbox, Session
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.replay import PackedTrace
from scanrack.watch.online import ASSEMBLED, NOTHING, TESTING
from scanrack.watch.panels.kept_panel import KeptPanel
from scanrack.watch.python_stops import PythonStops
from typing_extensions import override

from .adapter import Adapter, Driver
from .breakpoints import Breakpoint, Event, Hit, LinePoints, Looker, RungValues, described
from .capture import ProgramValues
from .conditions import ScanContext
from .places import Places, RungPlaces, TextPlaces
from .protocol import DebugError
from .subject import RungSubject, Subject
from .text_subject import TextSubject, files_of, lines_of
from .together import from_page, on_page

REMEMBERED = 8_000
"""Number of program snapshots, one per 64 scans, so that a session can step back 512,000 scans."""

WAIT_S = 0.02
"""Longest single wait for requests during a pause, s. It is short because pages also send actions."""


EDITS = {
    TESTING: "the saved rungs run from the next scan on: `accept` keeps them, `cancel` restores the old ones",
    ASSEMBLED: "the saved program is accepted, and runs from the next scan on",
    NOTHING: "the program before the edit runs from the next scan on",
}
"""Messages about an edit, by stage."""


class Program(Protocol):
    """The program of a session, or of a bench."""

    debugger: Debugger | None

    @property
    def logic(self) -> ScanLogic:
        """The logic that the CPU calls."""

    @property
    def edits(self) -> int:
        """Number of edits."""

    @property
    def operated(self) -> Debugger | Fields | None:
        """The program's values that can be set and forced."""


class LiveSubject(Subject):
    """The scans of a session so far.

    Attributes:
        first: the first scan after the latest edit; earlier scans can't be viewed.
        last: the latest scan.
        edits: number of edits that the debugger has applied.
    """

    live = True

    def __init__(self, cpu: Cpu, program: Program) -> None:
        self.cpu, self.program = cpu, program
        self.words = {slot.number: slot.words for slot in cpu.rack.slots.values()}
        self.first, self.last, self.edits = 0, -1, 0
        self.journal = Journal(cpu.rack)
        self._events: dict[int, list[Event]] = {}

    def note_event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Record an event of a scan."""
        self.journal.event(scan, now_ns, topic, fields)
        if topic in ("/events", "/faults"):
            self._events.setdefault(scan, []).append((topic, dict(fields)))

    def note_scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Record the latest scan."""
        self.journal.scan(scan, now_ns, flags)
        self.last = scan

    def is_edited(self) -> bool:
        """Return, before the next scan, whether the program was edited since the last call."""
        is_edited = self.edits != self.program.edits
        if is_edited:
            self.edits, self.first = self.program.edits, self.last + 1
        return is_edited

    def page_routine(self, routine: str) -> str:
        """Return the name of a routine on pages, or "" if they have no name for it."""
        raise NotImplementedError

    def step(self, *, on: bool) -> None:
        """Start or stop waiting for the next line that runs; for rungs, a step runs to the next scan."""

    @property
    def extent(self) -> tuple[int, int]:
        """The first and the last scan that can be viewed."""
        return self.first, self.last

    def looker(self, requested: list[Breakpoint]) -> Looker:
        """Return the object that checks breakpoints; raise ExpressionError for an invalid condition."""
        raise NotImplementedError

    def now(self) -> ScanContext:
        """Return the context for expressions about the latest scan."""
        memory = self.cpu.rack.memory
        return self.around(lambda: self.last, self.words_in(lambda: memory))

    @override
    def memory(self, scan: int) -> bytes:
        recording = self.journal.recording()
        return recording.memory[scan] if 0 <= scan < len(recording.scans) else b""

    @override
    def events(self, scan: int) -> Sequence[Event]:
        return self._events.get(scan, ())

    @override
    def now_ns(self, scan: int) -> int:
        return scan * self.cpu.period_ns

    @override
    def forced(self, scan: int) -> Mapping[str, object]:
        operated = self.program.operated
        return {**({} if operated is None else operated.forces), **self.cpu.forces.active}


class LiveRungs(RungSubject, LiveSubject):
    """A running ladder program."""

    def __init__(self, cpu: Cpu, program: Program) -> None:
        super().__init__(cpu, program)
        assert program.debugger is not None
        self._debugger = program.debugger
        self._places: tuple[LadderLogic, Places] | None = None

    @property
    def extent(self) -> tuple[int, int]:
        """The first and the last scan that can be viewed; an edit drops earlier scans."""
        source = self._debugger.replayer.source
        assert isinstance(source, journal.Journal)
        return source.first, self.last

    @override
    def places(self, scan: int) -> Places:
        program = self._debugger.program
        if self._places is None or self._places[0] is not program:
            self._places = program, RungPlaces(program)
        return self._places[1]

    @override
    def replayer(self, scan: int) -> Replayer:
        return self._debugger.replayer

    @override
    def looker(self, requested: list[Breakpoint]) -> Looker:
        looker = Looker(requested, RungValues(self._debugger.engine), self.now(), self.events)
        self._debugger.note_lines(looker.lines)
        return looker

    @override
    def page_routine(self, routine: str) -> str:
        lowered = self._debugger.engine.lowered.routines[routine]
        return "" if lowered.frame else lowered.name


class LiveText(TextSubject, LiveSubject):
    """A running program without rungs."""

    def __init__(self, cpu: Cpu, program: Program, load: Load, spec: RackSpec) -> None:
        LiveSubject.__init__(self, cpu, program)
        TextSubject.__init__(self, load, spec, program.logic)
        self._file = load.program
        self._watch, self._points = WATCH.get(), LinePoints({}, in_frames=False)
        self._stepping: _AnyLine | None = None  # during a step
        self._places: tuple[int, Places] | None = None  # with the number of edits

    @override
    def recording(self) -> PackedTrace:
        return self.journal.recording()

    @override
    def places(self, scan: int) -> Places:
        if self._places is None or self._places[0] != self.edits:
            self._places = self.edits, TextPlaces(files_of(self._file), lines_of(self.program.logic))
        return self._places[1]

    @override
    def looker(self, requested: list[Breakpoint]) -> Looker:
        """See `LiveSubject`; these breakpoints now observe the lines, instead of the previous ones."""
        points = LinePoints(ProgramValues(lambda: self.program.logic), in_frames=self._in_python)
        looker = Looker(requested, points, self.now(), self.events)
        self._watch.remove(self._points)
        self._points = points
        self._watch.add(points)
        return looker

    @override
    def step(self, *, on: bool) -> None:
        if self._stepping is not None:
            self._watch.remove(self._stepping)
        self._stepping = _AnyLine() if on else None
        if self._stepping is not None:
            self._watch.add(self._stepping)

    @override
    def page_routine(self, routine: str) -> str:
        return routine

    @property
    def arrived(self) -> bool:
        """Whether a line has run since `step`."""
        return self._stepping is not None and self._stepping.ran


class _AnyLine(Observer):
    """Detects whether any line runs."""

    ran = False

    @override
    def begins(self, file: str, line: int, frame: FrameType | None) -> None:
        self.ran = True


class ScanDriver(QuietListener, Driver):
    """A listener, called after all others, that checks for breakpoints after each scan of a running rack.

    Attributes:
        subject: the scans so far.
    """

    def __init__(self, adapter: Adapter, subject: LiveRungs | LiveText) -> None:
        self._adapter, self.subject = adapter, subject
        self._looker: Looker | None = None

    @override
    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        self.subject.note_event(scan, now_ns, topic, fields)

    def look(self, scan: int, now_ns: int, flags: int) -> list[Hit]:
        """Record a scan; return the breakpoints that stop the rack in it."""
        self.subject.note_scan(scan, now_ns, flags)
        self.follow_edit()
        return [] if self._looker is None else self._looker.stops(scan, self._print_log_point)

    def _print_log_point(self, point: Breakpoint, text: str) -> None:
        source = {"source": {"path": point.path}, "line": point.line} if point.line else {}
        self._adapter.output(f"{text}\n", more=source)

    def follow_edit(self) -> None:
        """Continue with an edited program, if there is one."""
        if self.subject.is_edited():
            self._adapter.output("the program was edited; you can't step back to earlier scans\n")
            self.place_again()

    def place_again(self) -> None:
        """Set the line breakpoints in an edited program; those without a line stay unverified."""
        adapter, places = self._adapter, self.subject.places(0)
        adapter.forget_views()
        line_points = [point for points in adapter.breakpoints.values() for point in points if point.path]
        for point in line_points:
            old_row = described(point)
            try:
                point.line, keys = places.first_line_from(point.path, point.line)
                point.keys = tuple(keys)
                row = described(point)
            except DebugError as error:
                point.keys = ()
                row = {"id": point.number, "verified": False, "message": str(error)}
            if row != old_row:
                adapter.event("breakpoint", reason="changed", breakpoint=row)
        self.set_breakpoints(adapter.all_breakpoints())

    @override
    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        looker = self.subject.looker(requested)
        if self.subject.last >= 0:
            looker.note_values(self.subject.last)
        self._looker = looker if requested else None


class Live(ScanDriver):
    """A driver of a session for an adapter; its listener is called after the session's others.

    Args:
        page: whether a page also shows the session, so that breakpoints are shared with the page.
    """

    def __init__(
        self, adapter: Adapter, session: Session, run: JobRun, job: LoadedRack, *, page: bool
    ) -> None:
        super().__init__(adapter, _subject_of(session, run, job))
        self.subject.units = KeptPanel(str(job.rack_file)).units
        self._session, self._run, self._page = session, run, page
        # the state of the editor's requests
        self._hits: list[Hit] = []  # breakpoints that caused the latest pause
        self._stepping = False
        self._requested: list[Breakpoint] = []
        self._shared_names: list[str] = []  # breakpoints of the session that the editor also has
        # the session waits for requests of the editor, too
        self._attend_pages, session.attend = session.attend, self._wait_during_pause
        session.inbox = _PatientInbox(session.inbox)
        run.cpu.add_listener(self)
        adapter.begin(self.subject, self)
        adapter.running = session.live  # a real controller can't be paused
        # a branch has its breakpoints at once, and sets them when it no longer repeats scans
        self._placed = not adapter.configured

    # --- after a scan

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Pause at breakpoints, adopt the pages' breakpoints, answer requests, and obey a continue."""
        if not self._placed and not self._session.repeats:
            self._place()
        hits, adapter = self.look(scan, now_ns, flags), self._adapter
        if not self._session.repeats:
            self._pause_at(hits)
        if self._session.state.breakpoints != self._shared_names:
            self._take_breakpoints()
        if adapter.wire.waiting:
            adapter.serve(0)
        if not adapter.running and not self._session.state.paused:
            adapter.leave()
            adapter.running = True  # the page has continued
            adapter.event("continued", threadId=1, allThreadsContinued=True)

    def _pause_at(self, hits: list[Hit]) -> None:
        """Pause at breakpoints, or at the end of a step."""
        arrived = isinstance(self.subject, LiveText) and self.subject.arrived
        if hits or arrived:
            self._hits = hits
            if not self._session.state.paused:
                self.apply(actions.Pause())

    @override
    def apply(self, action: actions.Action) -> None:
        scan = self.subject.extent[1] + 1
        self._session.obey(action, scan * self._run.cpu.period_ns, scan)

    def _place(self) -> None:
        self._placed = True
        self.place_again()

    # --- breakpoints of pages

    def _share_breakpoints(self, requested: list[Breakpoint]) -> None:
        """Also set the editor's breakpoints on the pages, if pages support their kind."""
        session_names = set(self._session.state.breakpoints)
        old_names = on_page(self._requested, self.subject.page_routine).keys()
        names = on_page(requested, self.subject.page_routine).keys()
        for name in old_names - names & session_names:
            self.apply(actions.RemoveBreakpoint(name))
        for name in names - session_names:
            with suppress(ValueError):  # in a body of a chart, for which pages have no name
                self.apply(actions.Breakpoint(name))
        self._shared_names = list(self._session.state.breakpoints)

    def _take_breakpoints(self) -> None:
        """Notify the editor of breakpoints that pages have set or removed."""
        adapter, session_names = self._adapter, self._session.state.breakpoints
        points = on_page(self._requested, self.subject.page_routine)
        for name in points.keys() - set(session_names):
            removed = points[name]
            for kind in adapter.breakpoints.values():
                kind[:] = [point for point in kind if point is not removed]
            row = {"id": removed.number, "verified": False}
            adapter.event("breakpoint", reason="removed", breakpoint=row)
        for name in session_names:
            if name not in points:
                adapter.breakpoint_count += 1
                new = from_page(name, adapter.breakpoint_count, self.subject.places(0))
                adapter.breakpoints.setdefault(f"line {new.path}" if new.path else "page", []).append(new)
                adapter.event("breakpoint", reason="new", breakpoint=described(new))
        self._shared_names = list(session_names)
        self.set_breakpoints(adapter.all_breakpoints())

    # --- during a pause

    def _wait_during_pause(self) -> None:
        """While paused, report the stop once, answer pages and editor, and prepare backward steps."""
        self._attend_pages()
        adapter = self._adapter
        if not self._placed:
            self._place()
        self.follow_edit()
        if self._session.state.breakpoints != self._shared_names and adapter.configured:
            self._take_breakpoints()
        if adapter.running:
            self._report_stop()
        if not adapter.serve(0 if self._session.inbox.pending() else WAIT_S):
            self.subject.prepare()

    def _report_stop(self) -> None:
        """Tell the editor where and why the session has paused: entry, fault, step, breakpoint or pause."""
        adapter, scan = self._adapter, self.subject.extent[1]
        hits, self._hits = self._hits, []
        stepping, self._stepping = self._stepping, False
        self.subject.step(on=False)
        fault = self._session.state.fault
        if scan < 0:
            adapter.stopped("entry")
        elif fault and not hits:
            adapter.look_at(scan, "end")
            adapter.stopped("exception", fault)
        elif stepping:
            adapter.look_at(scan)
            adapter.stopped("step")
        elif hits:
            adapter.stop_at_hit(scan, hits)
        else:
            adapter.look_at(scan, "end")
            met = "; ".join(self._session.state.met)  # breakpoints of a page
            adapter.stopped("breakpoint" if met else "pause", met)

    # --- as the adapter's driver

    @override
    def begin(self, *, stop: bool) -> None:
        """See `Driver`; a real controller is already running."""
        adapter = self._adapter
        if self._session.live:
            return
        if stop:
            self.step()
        else:
            adapter.running = True
            self.apply(actions.Continue())

    @override
    def go(self) -> None:
        self._adapter.leave()
        self._adapter.running = True
        self.apply(actions.Continue())

    @override
    def pause(self) -> None:
        self.apply(actions.Pause())

    @override
    def step(self) -> None:
        if isinstance(self.subject, LiveText):
            self.subject.step(on=True)
            self.apply(actions.Continue())
        else:
            self.apply(actions.Step(1))
        self._adapter.leave()
        self._adapter.running = self._stepping = True

    @override
    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        """Set breakpoints in the session and on the pages; on a real port, refuse all except log points."""
        if self._session.live and not all(request.log for request in requested):
            raise DebugError("a real controller does not wait: only log points are possible on a real port")
        super().set_breakpoints(requested)
        if self._page and not self._session.live:
            self._share_breakpoints(requested)
        self._requested = requested

    @override
    def edit(self, step: str) -> None:
        self._session.ask_editor(actions.Online(step, by="the debugger"), self._report_edit)

    def _report_edit(self, result: Mapping[str, object]) -> None:
        refusal = result.get("refused")
        text = EDITS[str(result["stage"])] if refusal is None else refusal
        self._adapter.output(f"{text}\n", "console" if refusal is None else "stderr")

    @override
    def branch(self, scan: int) -> None:
        self.apply(actions.Branch(scan, paused=True))
        self._adapter.leave()

    @override
    def end(self) -> None:
        self._session.end()


def _subject_of(session: Session, run: JobRun, job: LoadedRack) -> LiveRungs | LiveText:
    """Return the scans of a session, as the class that fits the kind of program."""
    versions = run.program.editions
    if not isinstance(session.stops, PythonStops):
        return LiveRungs(run.cpu, run.program)
    assert versions is not None
    load = Load(job.program, lambda: versions.again(0).logic, lambda number: versions.again(number).logic)
    return LiveText(run.cpu, run.program, load, job.spec)


class _PatientInbox(Inbox):
    """An inbox that returns the actions of pages without waiting, because `Live` waits for them."""

    def __init__(self, pages: Inbox) -> None:
        self._pages = pages

    def pending(self) -> bool:
        return self._pages.pending()

    def take(self) -> bytes:
        return self._pages.take()

    def wait(self, seconds: float) -> None:
        pass
