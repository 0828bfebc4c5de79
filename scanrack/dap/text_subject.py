"""Programs without rungs (Python, sequences, lists of steps), which are run again on recorded inputs.

window    the scans before the scan in view; their lines are cached for backward steps
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

from scanrack.jobs.record.logic_wrapper import unwrapped
from scanrack.jobs.why.answer import Why
from scanrack.jobs.why.program_rerun import ProgramRerun
from scanrack.jobs.why.traced_run import Load
from scanrack.ladder.files.steps import Steps
from scanrack.ladder.model.tree import Origin
from scanrack.ladder.python.line_marks import WATCH
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.traces.replay import PackedTrace
from typing_extensions import override

from .breakpoints import Breakpoint, Hit, LinePoints, Looker
from .capture import Capture, ProgramValues, TextRun, TextState
from .conditions import NamedValues
from .cursor import END
from .protocol import DebugError, Json
from .subject import Poll, Subject
from .variables import python_value, values_in
from .view import Node, Stop, Tree, View

WINDOW, WINDOW_MOST, SHARE = 64, 4096, 64
"""Minimum and maximum number of cached scans before scan n, and the divisor of n for a number in between."""

QUICK = 8192
"""Number of scans between two checks for requests, while lines are not observed."""

POLLED = 1024
"""Number of scans between two checks for requests during a search."""


class TextScan(View):
    """A scan of a program without rungs."""

    def __init__(self, scan: int, captured: Capture) -> None:
        self.scan = scan
        # before each line, then at the end of the scan
        self._states: list[TextState] = [state for _run, _depth, state in captured.runs]
        self._states.append(captured.state())
        self._stops = [
            Stop(index, run, None, depth) for index, (run, depth, _state) in enumerate(captured.runs)
        ]
        self.tags: dict[str, Any] = {}
        self.values = NamedValues(self.tags)
        self._waits: Mapping[str, str] = {}
        self.show(None)

    @property
    def stops(self) -> Sequence[Stop]:
        """See `View`."""
        return self._stops

    def show(self, order: int | None) -> None:
        """See `View`."""
        state = self._states[-1 if order is None else order]
        self.tags.clear()
        self.tags.update(state.values)
        self._waits = state.waits

    def set(self, tag: str, value: object) -> None:
        """See `View`."""
        self.tags[tag] = value

    def last_write(self, tag: str) -> tuple[int, int | None] | None:
        """See `View`; this is the line after the line that changed the tag, or the end of the scan."""
        values = [state.values.get(tag) for state in self._states]
        changes = [index for index, (before, after) in enumerate(pairwise(values), 1) if before != after]
        if not changes:
            return None
        return (changes[-1], changes[-1]) if changes[-1] < len(self._stops) else (END, None)

    def frame(self, run: TextRun) -> str:
        """See `View`."""
        return f"{run.name}, line {run.line.number}"

    def last_origin(self) -> Origin | None:
        """See `View`."""
        return self._stops[-1].run.line.origin if self._stops else None

    def full_name(self, name: str, run: TextRun | None) -> str | None:
        """See `View`; `self.step` is the step of the program."""
        if run is not None and name in run.values:
            return name
        if name in self.tags or not name.startswith("self."):
            return name if name in self.tags else None
        field_name = name.removeprefix("self.")
        return next((tag for tag in self.tags if tag.partition(".")[2] == field_name), None)

    def names(self, run: TextRun | None) -> Sequence[tuple[str, str]]:
        """See `View`."""
        return [(name, name) for name in (*(() if run is None else run.values), *self.tags)]

    def scopes(self, tree: Tree, run: TextRun | None) -> Iterator[tuple[str, Node]]:
        """See `View`."""
        if run is not None and run.values:
            yield "Locals", partial(values_in, tree, run.values)
        if self.tags:
            yield "Tags", partial(values_in, tree, self.tags, owned=True)
        if self._waits:
            yield "Waits", partial(values_in, tree, self._waits)

    def value(self, tree: Tree, name: str, address: str) -> Json:
        """See `View`."""
        if address in self.tags:
            return python_value(tree, name, self.tags[address], owned=True)
        spaces = (stop.run.values for stop in self._stops)
        value = next((space[address] for space in spaces if address in space), None)
        return python_value(tree, name, value)


class TextSubject(Subject):
    """A program without rungs.

    It has three runs of the program: one at the scan in view, one for earlier scans, and one for searches.
    """

    def __init__(self, load: Load, spec: RackSpec, logic: ScanLogic) -> None:
        self._load, self._spec, self._in_python = load, spec, not lines_of(logic)
        self._shown, self._earlier, self._searched = (
            ProgramRerun(load, spec, self.recording) for _ in range(3)
        )
        self._cache: dict[int, TextScan] = {}
        self._scan_in_view = 0
        self._filling: Iterator[None] | None = None  # caches scans before the window, in slices
        self._hits: tuple[object, list[Hit]] = None, []  # of the latest search, with its key

    def recording(self) -> PackedTrace:
        """Return the scans so far."""
        raise NotImplementedError

    @override
    def view(self, scan: int) -> View:
        self._scan_in_view, view = scan, self._cache.get(scan)
        if view is None:
            view = self._run_up_to(scan)
        if view is None:
            raise DebugError(f"scan {scan:,} can no longer be repeated")
        return view

    def _run_up_to(self, scan: int) -> TextScan | None:
        """Run the scans up to `scan` again, and cache `scan` with some scans before it; return `scan`."""
        reruns = self._shown, self._earlier
        candidates = (
            past_rerun for past_rerun in reruns if 0 <= past_rerun.at < scan <= past_rerun.at + WINDOW
        )
        rerun = next(candidates, reruns[self._shown.at >= scan])
        window = WINDOW if rerun is self._shown else min(max(WINDOW, scan // SHARE), WINDOW_MOST)
        first = max(0, scan + 1 - window)
        self._filling = None
        self._cache_scans(rerun, max(first, rerun.at + 1) if rerun.at < scan else first, scan)
        return self._cache.get(scan)

    def _cache_scans(self, rerun: ProgramRerun, first: int, last: int) -> None:
        """Cache the scans from `first` to `last`; raise DebugError if they can't be repeated."""
        for number, captured in rerun.walk(first, last, Capture):
            assert isinstance(captured, Capture)
            if rerun.departs is None:
                self._cache[number] = TextScan(number, captured)
        departs: int | None = rerun.departs
        if departs is not None and departs <= last:
            raise DebugError(
                f"run again on the recorded inputs, the program writes other words from scan {departs:,} on: "
                "it depends on more than its inputs and its time"
            )
        if len(self._cache) > 3 * WINDOW_MOST:
            by_distance = sorted(self._cache, key=lambda scan: abs(scan - self._scan_in_view))
            self._cache = {scan: self._cache[scan] for scan in by_distance[: 2 * WINDOW_MOST]}

    @override
    def prepare(self) -> bool:
        """Cache a slice of scans before the cached scans; return whether work remains."""
        if self._filling is None:
            low = self._scan_in_view
            while low - 1 in self._cache:
                low -= 1
            is_done = low not in self._cache or not low or self._scan_in_view - low >= WINDOW_MOST
            if is_done or self._earlier.departs is not None:
                return False
            self._filling = self._cache_earlier(low)
        if next(self._filling, self) is self:  # at its end, `next` returns its default
            self._filling = None
        return True

    def _cache_earlier(self, low: int) -> Iterator[None]:
        """Cache the scans before the window, in slices."""
        first, rerun = max(0, low - WINDOW_MOST), self._earlier
        rerun.rewind(first)
        while rerun.at + 1 < first:
            last = min(first - 1, rerun.at + QUICK)
            yield from (None for _ in rerun.walk(last, last, lambda _logic: None))
        for number in range(first, low, WINDOW):
            self._cache_scans(rerun, number, min(number + WINDOW, low) - 1)
            yield

    @override
    def hits_between(
        self, requested: Sequence[Breakpoint], first: int, last: int, poll: Poll = lambda _scan: None
    ) -> Iterator[tuple[int, list[Hit]]]:
        rerun, begin = self._searched, max(0, first - 1)  # changes are known from the second scan on
        continues = 0 <= rerun.at == begin  # where the last search has ended
        rerun.rewind(first if continues else begin)
        looker, points = self._looker(requested, rerun)
        if continues:
            begin = first
            looker.note_values(rerun.at)
        for number, _observer in rerun.walk(begin, last, lambda _logic: points):
            hits = looker.hits(number)
            if hits and number >= first:
                yield number, hits
            if number % POLLED == 0:
                poll(number)

    def _looker(self, requested: Sequence[Breakpoint], rerun: ProgramRerun) -> tuple[Looker, LinePoints]:
        """Return the object that checks breakpoints after each scan, and the observer of a run's lines."""
        points = LinePoints(ProgramValues(lambda: rerun.logic), in_frames=self._in_python)
        return Looker(requested, points, self.around(lambda: rerun.at), self.events), points

    @override
    def check(self, requested: Sequence[Breakpoint], scan: int) -> None:
        self._shown.rewind(self._shown.at + 1)
        self._looker(requested, self._shown)

    @override
    def hits(self, requested: Sequence[Breakpoint], scan: int) -> list[Hit]:
        key = scan, [(point.number, point.name, point.condition) for point in requested]
        if self._hits[0] != key:
            self._hits = key, super().hits(requested, scan)
        return self._hits[1]

    @override
    def last_before(self, requested: Sequence[Breakpoint], scan: int, poll: Poll) -> int | None:
        last_scan: int | None = None
        for number, _hits in self.hits_between(requested, self.extent[0], scan - 1, poll):
            last_scan = number
        return last_scan

    @override
    def last_change(self, tag: str, scan: int) -> int | None:
        point = Breakpoint(0, "data", tag)
        return self.last_before([point], scan + 1, lambda _scan: None)

    @override
    def why(self, tag: str, scan: int) -> list[tuple[str, Origin]]:
        recording = self.recording()
        text, chain = Why(recording, scan, self._spec, self._load).explain(tag)
        folder = self._load.folder
        links = [
            (str(link), Origin(str(folder / link.site.file), link.site.line))
            for link in chain.path[1:]
            if link.site is not None and link.site.file and link.site.line
        ]
        return [(text, Origin()), *links]


def files_of(program: Path) -> list[Path]:
    """Return the file of a program, and the files of the modules that it imports from its folder."""
    return list(dict.fromkeys([program.resolve(), *WATCH.get().files(program.parent)]))


def lines_of(logic: ScanLogic) -> list[int]:
    """Return the lines of a list of steps; the result is empty for any other program."""
    inside: object = unwrapped(logic)
    return [step.line for step in inside.steps] if isinstance(inside, Steps) else []
