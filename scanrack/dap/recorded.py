"""Debugging of a recording by running its scans again."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from scanrack.jobs.trust.trust import address_name
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.replay import Replayer
from scanrack.traces.read.reader import Trace
from scanrack.traces.replay import PackedTrace
from scanrack.watch.gate import listen
from scanrack.watch.history.stretch import Stretch
from scanrack.watch.monitors.trace_monitor import TraceMonitor
from scanrack.watch.play import Play
from scanrack.watch.recorded_session import open_to_read
from scanrack.watch.watch_options import WatchArguments, WatchOptions
from typing_extensions import override

from .adapter import Adapter, Driver
from .breakpoints import Breakpoint, Event
from .live import REMEMBERED, Live
from .places import Places, RungPlaces, TextPlaces
from .protocol import DebugError
from .subject import RungSubject, Subject
from .text_subject import TextSubject, files_of, lines_of

READ = 512
"""Number of scans for which images are read at once."""

IDLE_S = 0.2
"""Time without requests after which the first run of a recording continues, s."""

TOPICS = frozenset({"/events", "/faults"})


def debug_trace(adapter: Adapter, path: Path, scan: int | None, *, trust: bool) -> None:
    """Debug a recording until the client ends it.

    Raises:
        ValueError: the recording can't be used, or does not have the scan.
    """
    with ExitStack() as stack:
        branches: list[Play] = []

        def prepare(*arguments: Any, **options: Any) -> None:
            branches[:] = [_branch_of(adapter, monitor, path, stack)]
            branches[0].prepare_branch(*arguments, **options)

        monitor = open_to_read(stack, path, trust=trust, prepare=prepare)
        stack.callback(monitor.processes.close)
        subject = recorded_subject(monitor, path)
        first, last = subject.extent
        if scan is not None and not first <= scan <= last:
            raise ValueError(f"{path} has no scan {scan}: it has {first} to {last}")
        driver = RecordingDriver(adapter, subject, first if scan is None else scan)
        adapter.begin(subject, driver)
        _serve(adapter, monitor, driver)
        if branches and driver.branched and not adapter.over:
            assert monitor.job is not None
            branches[0].play_prepared(monitor.job)


def recorded_subject(monitor: TraceMonitor, path: Path) -> RecordedScans:
    """Return the scans of a recording, as the class that fits the kind of program."""
    logic = monitor.subject.programs.at(0).logic
    is_text = logic is not None and not isinstance(logic, LadderLogic)
    return RecordedText(monitor, path) if is_text else RecordedRungs(monitor, path)


def _serve(adapter: Adapter, monitor: TraceMonitor, driver: RecordingDriver) -> None:
    """Serve the client until it ends or branches; between requests, index scans and search."""
    is_busy, idle_s = True, IDLE_S  # the first run of the scans continues while there are no requests
    while not driver.over and not adapter.over:
        longest_wait_s = idle_s if is_busy else None
        served = adapter.serve(0 if adapter.running else longest_wait_s)
        is_busy = is_busy or served
        idle_s = IDLE_S if served else 0
        if not served and not adapter.running:
            is_busy = monitor.tick() | driver.prepare()  # `|`, because both do part of their work
        driver.search_slice()


def _branch_of(adapter: Adapter, monitor: TraceMonitor, path: Path, stack: ExitStack) -> Play:
    """Return a session that runs a branch from a recording."""
    job = monitor.job
    assert job is not None
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="scanrack")))
    options = WatchOptions(
        WatchArguments(rack=str(path)),
        None,
        editable=False,
        page=False,
        door=lambda session, run: Live(adapter, session, run, job, page=False),
        remembered=REMEMBERED,
    )
    return Play(options, stack.enter_context(listen(0)), folder, stack)


class RecordedScans(Subject):
    """The scans of a recording."""

    live = False

    def __init__(self, monitor: TraceMonitor, path: Path) -> None:
        self.monitor, self.path = monitor, path
        trace = monitor.subject.timeline.opened()
        assert trace is not None
        rack = address_name(trace.head.metadata.get("rack_file", ""))
        self.folders = path.resolve().parent, Path(rack).parent  # of its files
        self.trace: Trace = trace
        self.words, self.units = monitor.subject.words, monitor.panel.units
        self._places: dict[int, Places] = {}
        self._events: dict[int, list[Event]] | None = None
        self._memories: dict[int, bytes] = {}

    @property
    def extent(self) -> tuple[int, int]:
        """The first and the last scan."""
        extent = self.monitor.subject.timeline.extent
        return (0, -1) if extent is None else extent

    def lines(self, stretch: Stretch) -> Places:
        """Return the lines of a program."""
        raise NotImplementedError

    @override
    def places(self, scan: int) -> Places:
        stretch = self.monitor.subject.programs.at(max(0, scan))
        if stretch.number not in self._places:
            self._places[stretch.number] = self.lines(stretch)
        return self._places[stretch.number]

    def memory(self, scan: int) -> bytes:
        """Return the images after a scan."""
        if scan not in self._memories:  # the next scans will probably be read next
            rows = self.monitor.subject.timeline.between(scan, scan + READ)
            self._memories = {int(row["scan"]): row["words"].tobytes() for row in rows}
        return self._memories.get(scan, b"")

    def events(self, scan: int) -> Sequence[Event]:
        """Return the events of a scan."""
        if self._events is None:
            self._events = {}
            for event in self.trace.events(topics=TOPICS):
                self._events.setdefault(event.scan, []).append((event.topic, event.fields))
        return self._events.get(scan, ())

    def now_ns(self, scan: int) -> int:
        """Return the time of a scan."""
        row: Any = self.monitor.subject.timeline.row(scan)
        return 0 if row is None else int(row["now_ns"])

    def forced(self, scan: int) -> Mapping[str, object]:
        """Return the forces in a scan."""
        forced = self.monitor.states.forces_at(scan)
        tags = forced.get("tags", {})
        return {**{name: words for name, words in forced.items() if name != "tags"}, **tags}


class RecordedRungs(RungSubject, RecordedScans):
    """The scans of a ladder program."""

    @override
    def lines(self, stretch: Stretch) -> Places:
        if not isinstance(stretch.logic, LadderLogic):
            raise DebugError(stretch.lacks or "the recording has no program")
        return RungPlaces(stretch.logic, self.folders)

    @override
    def replayer(self, scan: int) -> Replayer:
        self.places(scan)  # refuses a stretch without a program
        self.monitor.index_to(scan)
        replayer = self.monitor.subject.programs.at(scan).past
        assert replayer is not None
        return replayer


class RecordedText(TextSubject, RecordedScans):
    """The scans of a program without rungs."""

    def __init__(self, monitor: TraceMonitor, path: Path) -> None:
        RecordedScans.__init__(self, monitor, path)
        logic, load = monitor.subject.programs.at(0).logic, monitor.again
        assert logic is not None
        assert load is not None
        TextSubject.__init__(self, load, monitor.subject.spec, logic)
        self._recording: PackedTrace | None = None

    @override
    def lines(self, stretch: Stretch) -> Places:
        assert stretch.file is not None
        assert stretch.logic is not None
        return TextPlaces(files_of(stretch.file), lines_of(stretch.logic), self.folders)

    @override
    def recording(self) -> PackedTrace:
        if self._recording is None:
            self._recording = PackedTrace.of(self.trace)
        return self._recording


class RecordingDriver(Driver):
    """A driver that moves through a recording."""

    def __init__(self, adapter: Adapter, subject: RecordedScans, first: int) -> None:
        self._adapter, self._subject, self._first = adapter, subject, first
        self._searched_scan = -1  # the scan that a search has reached; -1 = no search
        self.over = self.branched = False

    @override
    def begin(self, *, stop: bool) -> None:
        self._adapter.look_at(self._first)
        self._adapter.stopped("entry")

    @override
    def go(self) -> None:
        self._searched_scan = self._adapter.place().scan
        self._adapter.leave()
        self._adapter.running = True

    def prepare(self) -> bool:
        """See `Subject`."""
        return self._subject.prepare()

    def search_slice(self) -> None:
        """Search a slice of scans for breakpoints, if the client has requested it."""
        adapter = self._adapter
        if not adapter.running or self._searched_scan < 0:
            return
        stop_points, last = adapter.stop_points(), self._subject.extent[1]
        if not stop_points:
            self._stop_at_end()
            return
        hit_scan, self._searched_scan = self._subject.first_after(stop_points, self._searched_scan)
        if hit_scan is not None:
            adapter.stop_at_hit(hit_scan, adapter.hits_in(hit_scan))
        elif self._searched_scan >= last:
            self._stop_at_end()

    def _stop_at_end(self) -> None:
        self._adapter.look_at(self._subject.extent[1], "end")
        self._adapter.stopped("pause", "this is the end of the recording")

    @override
    def pause(self) -> None:
        def stop() -> None:
            self._adapter.look_at(self._searched_scan, "end")
            self._adapter.stopped("pause")

        self._adapter.after_response(stop)

    @override
    def step(self) -> None:
        self._stop_at_end()

    @override
    def set_breakpoints(self, requested: list[Breakpoint]) -> None:
        """Check breakpoints, which may run scans again; then restore the client's position."""
        adapter = self._adapter
        if adapter.cursor is None:
            self._subject.check(requested, self._first)
            return
        scan, spot = adapter.cursor.scan, adapter.cursor.spot
        self._subject.check(requested, scan)
        adapter.look_at(scan).go(spot)

    @override
    def branch(self, scan: int) -> None:
        self._subject.monitor.branch(scan, True)
        self._adapter.leave()
        self.over = self.branched = True

    @override
    def end(self) -> None:
        self.over = True
