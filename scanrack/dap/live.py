"""A running rack: a session of `scanrack watch`, with an editor in addition to its pages.

after a scan          then
a breakpoint is met   pause, stopped
a request waits       carried out before the next scan
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
from scanrack.runtime.loop.rack import Rack
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
from .together import foreign, of_page

REMEMBERED = 8_000
"""Snapshots of the program, one per 64 scans: half a million scans can be stepped back to."""

WAIT_S = 0.02
"""Longest single wait for requests during a pause: pages also give orders."""


EDITS = {
    TESTING: "the saved rungs run from the next scan on: `accept` keeps them, `cancel` runs those before",
    ASSEMBLED: "the saved program is accepted, and runs from the next scan on",
    NOTHING: "the program before the edit runs from the next scan on",
}
"""The effect of an edit in words, by its stage."""


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


class ScanRun(Protocol):
    """A running rack, of a session or of a bench."""

    rack: Rack
    cpu: Cpu

    @property
    def program(self) -> Program:
        """Its program."""


class LiveSubject(Subject):
    """The scans of a session so far."""

    live = True

    def __init__(self, run: ScanRun) -> None:
        self.run = run
        self.words = {slot.number: slot.words for slot in run.rack.slots.values()}
        self.last = -1
        self.first = 0
        self.edits = 0
        self.journal = Journal(run.rack)
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
        """Return whether the program was edited since the last call, before the next scan."""
        is_edited = self.edits != self.run.program.edits
        if is_edited:
            self.edits, self.first = self.run.program.edits, self.last + 1
        return is_edited

    def spelled(self, routine: str) -> str:
        """Return the name of a routine on pages, "" if they have no name for it."""
        raise NotImplementedError

    def step(self, *, on: bool) -> None:
        """Start or stop waiting for the next line that runs; for rungs, a step is the next scan."""

    @property
    def extent(self) -> tuple[int, int]:
        """The scans that can be looked at."""
        return self.first, self.last

    def looker(self, requested: list[Breakpoint]) -> Looker:
        """Return the looker for breakpoints in the session; an ExpressionError for an invalid condition."""
        raise NotImplementedError

    def now(self) -> ScanContext:
        """Return the context of expressions about the latest scan."""
        memory = self.run.rack.memory
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
        return scan * self.run.cpu.period_ns

    @override
    def forced(self, scan: int) -> Mapping[str, object]:
        operated = self.run.program.operated
        return {**({} if operated is None else operated.forces), **self.run.cpu.forces.active}


class LiveRungs(RungSubject, LiveSubject):
    """A running ladder program."""

    def __init__(self, run: ScanRun) -> None:
        super().__init__(run)
        assert run.program.debugger is not None
        self._debugger = run.program.debugger
        self._places: tuple[LadderLogic, Places] | None = None

    @property
    def extent(self) -> tuple[int, int]:
        """The scans that can be looked at; an edit drops the scans before it."""
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
    def spelled(self, routine: str) -> str:
        lowered = self._debugger.engine.lowered.routines[routine]
        return "" if lowered.frame else lowered.name


class LiveText(TextSubject, LiveSubject):
    """A running program without rungs."""

    def __init__(self, run: ScanRun, load: Load, spec: RackSpec) -> None:
        LiveSubject.__init__(self, run)
        TextSubject.__init__(self, load, spec, run.program.logic)
        self._program = load.program
        self._watch, self._points = WATCH.get(), LinePoints({}, in_frames=False)
        self._stepping: _AnyLine | None = None
        self._texts: tuple[int, Places] | None = None

    @override
    def recording(self) -> PackedTrace:
        return self.journal.recording()

    @override
    def places(self, scan: int) -> Places:
        if self._texts is None or self._texts[0] != self.edits:
            self._texts = self.edits, TextPlaces(files_of(self._program), lines_of(self.run.program.logic))
        return self._texts[1]

    @override
    def looker(self, requested: list[Breakpoint]) -> Looker:
        program = self.run.program
        points = LinePoints(ProgramValues(lambda: program.logic), in_frames=self._in_python)
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
    def spelled(self, routine: str) -> str:
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
    """Checks for breakpoints after each scan of a running rack; a listener after all others.

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
        """Record a scan; return the breakpoints at which it stops."""
        self.subject.note_scan(scan, now_ns, flags)
        self.follow_edit()
        return [] if self._looker is None else self._looker.stops(scan, self._say)

    def _say(self, one: Breakpoint, text: str) -> None:
        source = {"source": {"path": one.path}, "line": one.line} if one.line else {}
        self._adapter.output(f"{text}\n", more=source)

    def follow_edit(self) -> None:
        """Continue with an edited program, if there is one."""
        if self.subject.is_edited():
            self._adapter.output("the program was edited; the scans before can't be stepped back to\n")
            self.place_again()

    def place_again(self) -> None:
        """Set the breakpoints of lines in another program; one without its line waits for a later program."""
        adapter, places = self._adapter, self.subject.places(0)
        adapter.forget_views()
        for point in (point for kind in adapter.breakpoints.values() for point in kind if point.path):
            was = described(point)
            try:
                point.line, keys = places.at(point.path, point.line)
                point.keys = tuple(keys)
                now = described(point)
            except DebugError as error:
                point.keys = ()
                now = {"id": point.number, "verified": False, "message": str(error)}
            if now != was:
                adapter.event("breakpoint", reason="changed", breakpoint=now)
        self.set_breakpoints(adapter.all_breakpoints())

    @override
    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        looker = self.subject.looker(requested)
        if self.subject.last >= 0:
            looker.prime(self.subject.last)
        self._looker = looker if requested else None


class Live(ScanDriver):
    """Drives a session for an adapter: a listener after its other listeners."""

    def __init__(
        self, adapter: Adapter, session: Session, run: JobRun, job: LoadedRack, *, page: bool
    ) -> None:
        super().__init__(adapter, _subject_of(session, run, job))
        self.subject.units = KeptPanel(str(job.rack_file)).units
        self._session, self._run, self._page = session, run, page
        self._hits: list[Hit] = []
        self._requested: list[Breakpoint] = []
        self._stepping = False
        self._seen: list[str] = []  # breakpoints of the session that the editor has
        self._attend, session.attend = session.attend, self._rest
        session.inbox = _PatientInbox(session.inbox)
        run.cpu.add_listener(self)
        adapter.begin(self.subject, self)
        adapter.running = session.live  # a real controller can't be paused
        self._placed = (
            not adapter.configured
        )  # otherwise a branch begins, and has the breakpoints in its first scan

    # --- after a scan

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        if not self._placed and not self._session.repeats:
            self._place()
        hits, adapter = self.look(scan, now_ns, flags), self._adapter
        if not self._session.repeats:
            self._pause_at(hits)
        if self._session.state.breakpoints != self._seen:
            self._take_breakpoints()
        if adapter.wire.waiting:
            adapter.serve(0)
        if not adapter.running and not self._session.state.paused:
            adapter.leave()
            adapter.running = True  # a page has let it continue
            adapter.event("continued", threadId=1, allThreadsContinued=True)

    def _pause_at(self, hits: list[Hit]) -> None:
        """Pause at breakpoints, or where a step ends."""
        arrived = isinstance(self.subject, LiveText) and self.subject.arrived
        if hits or arrived:
            self._hits = hits
            if not self._session.state.paused:
                self._order(actions.Pause())

    def _order(self, order: actions.Action) -> None:
        cpu, subject = self._run.cpu, self.subject
        scan = subject.extent[1] + 1
        self._session.obey(order, scan * cpu.period_ns, scan)

    def _place(self) -> None:
        self._placed = True
        self.place_again()

    # --- breakpoints of pages

    def _share_breakpoints(self, requested: list[Breakpoint]) -> None:
        """Also set the editor's breakpoints on the pages, if pages support their kind."""
        shared = self._session.state.breakpoints
        spelled = self.subject.spelled
        _others, before = foreign(shared, self._requested, spelled)
        _others, names = foreign(shared, requested, spelled)
        for name in before.keys() - names.keys() & set(shared):
            self._order(actions.RemoveBreakpoint(name))
        for name in names.keys() - set(shared):
            with suppress(ValueError):  # in a body of a chart, for which pages have no name
                self._order(actions.Breakpoint(name))
        self._seen = list(self._session.state.breakpoints)

    def _take_breakpoints(self) -> None:
        """Notify the editor of breakpoints that pages have set or removed."""
        adapter, shared = self._adapter, self._session.state.breakpoints
        spelled, places = self.subject.spelled, self.subject.places(0)
        others, names = foreign(shared, self._requested, spelled)
        for name in names.keys() - set(shared):
            removed = names[name]
            for kind in adapter.breakpoints.values():
                kind[:] = [point for point in kind if point is not removed]
            adapter.event(
                "breakpoint", reason="removed", breakpoint={"id": removed.number, "verified": False}
            )
        for name in others:
            adapter.numbers += 1
            made = of_page(name, adapter.numbers, places)
            adapter.breakpoints.setdefault(f"line {made.path}" if made.path else "page", []).append(made)
            adapter.event("breakpoint", reason="new", breakpoint=described(made))
        self._seen = list(shared)
        self.set_breakpoints(adapter.all_breakpoints())

    # --- during a pause

    def _rest(self) -> None:
        self._attend()
        adapter = self._adapter
        if not self._placed:
            self._place()
        self.follow_edit()
        if self._session.state.breakpoints != self._seen and adapter.configured:
            self._take_breakpoints()
        if adapter.running:
            self._tell_stop()
        if not adapter.serve(WAIT_S if not self._session.inbox.pending() else 0):
            self.subject.prepare()

    def _tell_stop(self) -> None:
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
        adapter = self._adapter
        if self._session.live:
            return
        if stop:
            self.step()
        else:
            adapter.running = True
            self._order(actions.Continue())

    @override
    def go(self) -> None:
        self._adapter.leave()
        self._adapter.running = True
        self._order(actions.Continue())

    @override
    def pause(self) -> None:
        self._order(actions.Pause())

    @override
    def step(self) -> None:
        if isinstance(self.subject, LiveText):
            self.subject.step(on=True)
            self._order(actions.Continue())
        else:
            self._order(actions.Step(1))
        self._adapter.leave()
        self._adapter.running = self._stepping = True

    @override
    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        if self._session.live and not all(request.log for request in requested):
            raise DebugError("a real controller does not wait: on a real port only log points are possible")
        super().set_breakpoints(requested)
        if self._page and not self._session.live:
            self._share_breakpoints(requested)
        self._requested = requested

    @override
    def give(self, order: actions.Action) -> None:
        self._order(order)

    @override
    def edit(self, step: str) -> None:
        self._session.ask_editor(actions.Online(step, by="the debugger"), self._tell_edit)

    def _tell_edit(self, result: Mapping[str, object]) -> None:
        refusal = result.get("refused")
        text = EDITS[str(result["stage"])] if refusal is None else refusal
        self._adapter.output(f"{text}\n", "console" if refusal is None else "stderr")

    @override
    def branch(self, scan: int) -> None:
        self._order(actions.Branch(scan, paused=True))
        self._adapter.leave()

    @override
    def end(self) -> None:
        self._session.end()


def _subject_of(session: Session, run: JobRun, job: LoadedRack) -> LiveRungs | LiveText:
    stops, editions = session.stops, run.program.editions
    if not isinstance(stops, PythonStops):
        return LiveRungs(run)
    assert editions is not None
    load = Load(job.program, lambda: editions.again(0).logic, lambda number: editions.again(number).logic)
    return LiveText(run, load, job.spec)


class _PatientInbox(Inbox):
    """The orders of pages; `Live` has waited for them already."""

    def __init__(self, pages: Inbox) -> None:
        self._pages = pages

    def pending(self) -> bool:
        return self._pages.pending()

    def take(self) -> bytes:
        return self._pages.take()

    def wait(self, seconds: float) -> None:
        pass
