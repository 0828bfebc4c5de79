"""A recording: its scans are run again, forwards and backwards; nothing else runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from scanrack.jobs.trust.trust import address_name
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.replay import Replayer
from scanrack.traces.read.reader import Trace
from scanrack.watch.monitors.trace_monitor import TraceMonitor
from scanrack.watch.recorded_session import open_to_read
from typing_extensions import override

from .adapter import Adapter, Driver
from .breakpoints import Breakpoint, Event
from .places import Places
from .protocol import DebugError
from .subject import Past, Subject

WINDOW = 512
"""Scans whose images are read at once."""

IDLE_S = 0.2
"""Silence of a client after which a recording is run on."""

TOPICS = frozenset({"/events", "/faults"})


def debug_trace(adapter: Adapter, path: Path, scan: int | None, *, trust: bool) -> None:
    """Debug a recording until the client ends it.

    Raises:
        ValueError: it can't be used, or has no such scan.
    """
    with ExitStack() as stack:
        monitor = open_to_read(stack, path, trust=trust)
        stack.callback(monitor.elsewhere.close)
        subject = TraceSubject(monitor, path)
        first, last = subject.extent
        if scan is not None and not first <= scan <= last:
            raise ValueError(f"{path} has no scan {scan}: it has {first} to {last}")
        driver = Recorded(adapter, subject, first if scan is None else scan)
        adapter.begin(subject, driver)
        more = True  # scans whose first run is not over: it goes on while the client is silent
        while not driver.over and not adapter.over:
            served = adapter.serve(0 if adapter.running else IDLE_S if more else None)
            if not served and not adapter.running:
                more = monitor.tick()
            driver.look_on()


class TraceSubject(Subject):
    """The scans of a recording."""

    live = False

    def __init__(self, monitor: TraceMonitor, path: Path) -> None:
        self._monitor = monitor
        trace = monitor.subject.timeline.opened()
        rack = "" if trace is None else address_name(trace.head.metadata.get("rack_file", ""))
        self._folders = path.resolve().parent, Path(rack).parent  # where its files may be on this machine
        self.words = monitor.subject.words
        self._places: dict[int, Places] = {}
        self._events: dict[int, list[Event]] | None = None
        self._memories: dict[int, bytes] = {}

    @property
    def extent(self) -> tuple[int, int]:
        """Its first and its last scan."""
        found = self._monitor.subject.timeline.extent
        return (0, -1) if found is None else found

    def program(self, scan: int) -> LadderLogic:
        """Return the program of a scan."""
        stretch = self._monitor.subject.programs.at(scan)
        if not isinstance(stretch.logic, LadderLogic):
            raise DebugError(stretch.lacks or "the program of this recording has no rungs to step through")
        return stretch.logic

    def places(self, scan: int) -> Places:
        """Return its lines, in files of this machine if they are the same."""
        number = self._monitor.subject.programs.at(max(0, scan)).number
        if number not in self._places:
            self._places[number] = Places(self.program(scan), self._folders)
        return self._places[number]

    def replayer(self, scan: int) -> Replayer:
        """Return what runs a scan again."""
        self.program(scan)
        self._monitor.index_to(scan)
        found = self._monitor.subject.programs.at(scan).past
        assert found is not None
        return found

    def memory(self, scan: int) -> bytes:
        """Return the images after a scan."""
        if scan not in self._memories:  # those of the scans after it are next
            rows = self._monitor.subject.timeline.between(scan, scan + WINDOW)
            self._memories = {int(each["scan"]): each["words"].tobytes() for each in rows}
        return self._memories.get(scan, b"")

    def events(self, scan: int) -> Sequence[Event]:
        """Return the events of a scan."""
        if self._events is None:
            self._events = {}
            trace: Trace | None = self._monitor.subject.timeline.opened()
            for each in () if trace is None else trace.events(topics=TOPICS):
                self._events.setdefault(each.scan, []).append((each.topic, each.fields))
        return self._events.get(scan, ())

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""
        row: Any = self._monitor.subject.timeline.row(scan)
        return 0 if row is None else int(row["now_ns"])

    def forced(self, scan: int) -> Mapping[str, object]:
        """Return the forces in a scan."""
        forced = self._monitor.states.forces_at(scan)
        tags = forced.get("tags", {})
        return {**{name: each for name, each in forced.items() if name != "tags"}, **tags}


class Recorded(Driver):
    """Moves through a recording."""

    def __init__(self, adapter: Adapter, subject: TraceSubject, first: int) -> None:
        self._adapter, self._subject, self._first = adapter, subject, first
        self._looked = -1  # the scan up to which a search has come; -1 without one
        self.over = False

    @override
    def begin(self, *, stop: bool) -> None:
        self._adapter.look_at(self._first)
        self._adapter.stopped("entry")

    @override
    def go(self) -> None:
        self._looked = self._adapter.place().scan
        self._adapter.leave()
        self._adapter.running = True

    def look_on(self) -> None:
        """Search a slice of scans for breakpoints, while scans run."""
        adapter = self._adapter
        if not adapter.running or self._looked < 0:
            return
        wanted = [each for each in adapter.all_breakpoints() if not each.log]
        last = self._subject.extent[1]
        found, looked = Past(self._subject, wanted).first_after(self._looked) if wanted else (None, last)
        self._looked = looked
        if found is not None:
            adapter.stop_at_hit(found, adapter.hits_in(found))
        elif looked >= last:
            self._end_of_recording()

    def _end_of_recording(self) -> None:
        self._adapter.look_at(self._subject.extent[1], "end")
        self._adapter.stopped("pause", "this is the end of the recording")

    @override
    def pause(self) -> None:
        def stop() -> None:
            self._adapter.look_at(self._looked, "end")
            self._adapter.stopped("pause")

        self._adapter.after_response(stop)

    @override
    def step(self) -> None:
        self._end_of_recording()

    @override
    def set_breakpoints(self, wanted: list[Breakpoint]) -> None:
        adapter = self._adapter
        place = None if adapter.cursor is None else (adapter.cursor.scan, adapter.cursor.spot)
        scan = place[0] if place else self._first
        Past(self._subject, wanted).looker(self._subject.replayer(scan).engine)  # refuses a condition
        if place is not None:
            adapter.look_at(place[0]).go(place[1])

    @override
    def end(self) -> None:
        self.over = True
