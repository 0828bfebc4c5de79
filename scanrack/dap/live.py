"""A rack that runs: a session of `scanrack watch`, with an editor beside its pages.

after a scan          then
a breakpoint is met   pause, stopped
a request waits       carried out before the next scan
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from scanrack.jobs.run.running import JobRun
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.journal import Journal
from scanrack.ladder.debug.replay import Replayer
from scanrack.runtime.live import actions
from scanrack.runtime.live.session import Inbox, Session
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import QuietListener
from typing_extensions import override

from .adapter import Adapter, Driver
from .breakpoints import Breakpoint, Event, Hit, Looker, described
from .conditions import ExpressionError, Surroundings
from .places import Places
from .protocol import DebugError
from .subject import Images, Subject
from .together import foreign, of_page

REMEMBERED = 8_000
"""Snapshots of the program, one per 64 scans: half a million scans can be stepped back to."""

WAIT_S = 0.02
"""Longest single wait for requests during a pause: pages have orders, too."""


class LiveSubject(Subject):
    """The scans of a session so far."""

    live = True

    def __init__(self, run: JobRun) -> None:
        debugger = run.program.debugger
        if debugger is None:
            raise DebugError("this program has no rungs")
        self._run, self._debugger = run, debugger
        self.words = {slot.number: slot.words for slot in run.rack.slots.values()}
        self._period_ns = run.cpu.period_ns
        self._memories: deque[bytes] = deque(maxlen=REMEMBERED * 64)
        self._events: dict[int, list[Event]] = {}
        self._places: tuple[LadderLogic, Places] | None = None

    @property
    def debugger(self) -> Debugger:
        """The program."""
        return self._debugger

    def note_event(self, scan: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Note an event of a scan."""
        if topic in ("/events", "/faults"):
            self._events.setdefault(scan, []).append((topic, dict(fields)))

    def note_scan(self, memory: bytes) -> None:
        """Note the images after the latest scan."""
        self._memories.append(memory)

    @property
    def extent(self) -> tuple[int, int]:
        """The scans that can be looked at."""
        source = self._debugger.replayer.source
        assert isinstance(source, Journal)
        return source.first, self._last

    @property
    def _last(self) -> int:
        return self._debugger.scans - 1

    def program(self, scan: int) -> LadderLogic:
        """Return the program that runs: an edit forgets the scans before."""
        return self._debugger.program

    def places(self, scan: int) -> Places:
        """Return its lines."""
        program = self._debugger.program
        if self._places is None or self._places[0] is not program:
            self._places = program, Places(program)
        return self._places[1]

    def replayer(self, scan: int) -> Replayer:
        """Return what runs a scan again."""
        return self._debugger.replayer

    def memory(self, scan: int) -> bytes:
        """Return the images after a scan."""
        place = scan - (self._last + 1 - len(self._memories))
        return self._memories[place] if 0 <= place < len(self._memories) else b""

    def events(self, scan: int) -> Sequence[Event]:
        """Return the events of a scan."""
        return self._events.get(scan, ())

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""
        return scan * self._period_ns

    def forced(self, scan: int) -> Mapping[str, object]:
        """Return the present forces."""
        return {**self._debugger.forces, **self._run.cpu.forces.active}


class Live(QuietListener, Driver):
    """Drives a session for an adapter: a listener after its other listeners."""

    def __init__(self, adapter: Adapter, session: Session, run: JobRun) -> None:
        self._adapter, self._session, self._run = adapter, session, run
        self._subject = LiveSubject(run)
        self._images = Images(self._subject.words)
        self._looker: Looker | None = None
        self._hits: list[Hit] = []
        self._wanted: list[Breakpoint] = []
        self._program = self._subject.debugger.program
        self._stepping = False
        self._seen: list[str] = []  # breakpoints of the session, as the editor knows them
        self._attend, session.attend = session.attend, self._rest
        session.inbox = _PatientInbox(session.inbox)
        run.cpu.add_listener(self)
        adapter.begin(self._subject, self)
        adapter.running = session.live  # a real controller does not wait

    # --- after a scan

    @override
    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        self._subject.note_event(scan, topic, fields)

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        self._subject.note_scan(bytes(self._run.rack.memory))
        if self._subject.debugger.program is not self._program:
            self._follow_edit()
        if self._looker is not None:
            self._look(self._looker, scan)
        adapter = self._adapter
        if self._session.state.breakpoints != self._seen:
            self._take_breakpoints()
        if adapter.wire.waiting:
            adapter.serve(0)
        if not adapter.running and not self._session.state.paused:
            adapter.leave()
            adapter.running = True  # a page has let it go on
            adapter.event("continued", threadId=1, allThreadsContinued=True)

    def _look(self, looker: Looker, scan: int) -> None:
        hits = looker.stops(scan, self._say)
        if hits and not self._session.repeats:
            self._hits = hits
            if not self._session.state.paused:
                self._order(actions.Pause())

    def _say(self, one: Breakpoint, text: str) -> None:
        where = {"source": {"path": one.path}, "line": one.line} if one.line else {}
        self._adapter.output(f"{text}\n", more=where)

    def _order(self, order: actions.Action) -> None:
        cpu, subject = self._run.cpu, self._subject
        scan = subject.extent[1] + 1
        self._session.obey(order, scan * cpu.period_ns, scan)

    def _follow_edit(self) -> None:
        """Set the breakpoints in the edited program; one whose line has gone is taken from the editor."""
        adapter, self._program = self._adapter, self._subject.debugger.program
        places, self._wanted = self._subject.places(0), []
        adapter.output("the program was edited; the scans before can't be stepped back to\n")
        for kind in adapter.breakpoints.values():
            for each in [each for each in kind if each.path]:
                try:
                    each.line, keys = places.at(each.path, each.line)
                    each.keys = tuple(keys)
                except DebugError as error:
                    kind.remove(each)
                    gone = {"id": each.number, "verified": False, "message": str(error)}
                    adapter.event("breakpoint", reason="changed", breakpoint=gone)
        self.set_breakpoints(adapter.all_breakpoints())

    # --- breakpoints of pages

    def _share_breakpoints(self, wanted: list[Breakpoint]) -> None:
        """Set the editor's breakpoints on the pages, too, as far as pages have such."""
        there = self._session.state.breakpoints
        lowered = self._subject.debugger.engine.lowered
        _others, before = foreign(there, self._wanted, lowered)
        _others, names = foreign(there, wanted, lowered)
        for name in before.keys() - names.keys() & set(there):
            self._order(actions.RemoveBreakpoint(name))
        for name in names.keys() - set(there):
            self._order(actions.Breakpoint(name))
        self._seen = list(self._session.state.breakpoints)

    def _take_breakpoints(self) -> None:
        """Follow pages: tell the editor what they have set and removed."""
        adapter, there = self._adapter, self._session.state.breakpoints
        lowered, places = self._subject.debugger.engine.lowered, self._subject.places(0)
        others, names = foreign(there, self._wanted, lowered)
        for name in names.keys() - set(there):
            gone = names[name]
            for kind in adapter.breakpoints.values():
                kind[:] = [each for each in kind if each is not gone]
            adapter.event("breakpoint", reason="removed", breakpoint={"id": gone.number, "verified": False})
        for name in others:
            adapter.numbers += 1
            made = of_page(name, adapter.numbers, places)
            adapter.breakpoints.setdefault(f"line {made.path}" if made.path else "page", []).append(made)
            adapter.event("breakpoint", reason="new", breakpoint=described(made))
        self._seen = list(there)
        self.set_breakpoints(adapter.all_breakpoints())

    # --- during a pause

    def _rest(self) -> None:
        self._attend()
        adapter = self._adapter
        if self._subject.debugger.program is not self._program:
            self._follow_edit()
        if self._session.state.breakpoints != self._seen and adapter.configured:
            self._take_breakpoints()
        if adapter.running:
            self._tell_stop()
        adapter.serve(WAIT_S if not self._session.inbox.pending() else 0)

    def _tell_stop(self) -> None:
        adapter, scan = self._adapter, self._subject.extent[1]
        hits, self._hits = [(each.breakpoint, each.text) for each in self._hits], []
        stepping, self._stepping = self._stepping, False
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
        self._order(actions.Step(1))
        self._adapter.leave()
        self._adapter.running = self._stepping = True

    @override
    def set_breakpoints(self, wanted: list[Breakpoint]) -> None:
        if self._session.live and not all(each.log for each in wanted):
            raise DebugError("a real controller does not wait: on a real port only log points are possible")
        debugger, subject, images = self._subject.debugger, self._subject, self._images
        memory = self._run.rack.memory
        around = Surroundings(
            subject.words,
            lambda slot, image, number: images.word(memory, slot, image, number),
            lambda: debugger.now_ns,
            lambda: debugger.scans - 1,
        )
        try:
            looker = Looker(wanted, debugger.engine, around, subject.events) if wanted else None
        except ExpressionError as error:
            raise DebugError(str(error)) from error
        if looker is not None and debugger.scans:
            looker.prime(debugger.scans - 1)
        if not self._session.live:
            self._share_breakpoints(wanted)
        self._looker, self._wanted, self._program = looker, wanted, debugger.program
        debugger.note_lines(() if looker is None else looker.lines)

    @override
    def give(self, order: actions.Action) -> None:
        self._order(order)

    @override
    def branch(self, scan: int) -> None:
        self._order(actions.Branch(scan, paused=True))
        self._adapter.leave()

    @override
    def end(self) -> None:
        self._session.end()


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
