"""Programs without rungs: plain Python, sequences, lists of steps. They run again beside the session.

window    scans before the scan in view, whose lines are kept, so that steps back stay in it
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
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
"""Minimum and maximum scans that are kept before a scan, and their share of all scans up to it."""

QUICK = 8192
"""Scans between two checks for requests while scans are only run."""

POLLED = 1024
"""Scans of a search between two checks for requests."""


class TextScan(View):
    """A scan of a program without rungs."""

    def __init__(self, scan: int, captured: Capture) -> None:
        self.scan = scan
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
        """See `View`: the line after the one that changed the tag, or the end of the scan."""
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
        """See `View`: `self.step` is the step of the program."""
        if run is not None and name in run.values:
            return name
        own_name = name.removeprefix("self.")
        fitting = (tag for tag in self.tags if own_name != name and tag.partition(".")[2] == own_name)
        return name if name in self.tags else next(fitting, None)

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
        values = (stop.run.values for stop in self._stops)
        local = next((value for value in values if address in value), dict[str, Any]())
        return python_value(tree, name, local.get(address))


class TextSubject(Subject):
    """A program without rungs.

    Three runs: one at the scan that was looked at last, one before it, one for searches.
    """

    def __init__(self, load: Load, spec: RackSpec, logic: ScanLogic) -> None:
        self._load, self._spec, self._in_python = load, spec, not lines_of(logic)
        self._shown, self._before, self._searched = (
            ProgramRerun(load, spec, self.recording) for _ in range(3)
        )
        self._kept: dict[int, TextScan] = {}
        self._at = 0  # the scan that was looked at last
        self._filling: Iterator[None] | None = None
        self._hits: tuple[object, list[Hit]] = None, []

    def recording(self) -> PackedTrace:
        """Return the scans so far."""
        raise NotImplementedError

    @override
    def view(self, scan: int) -> View:
        self._at, view = scan, self._kept.get(scan)
        if view is None:
            view = self._looked(scan)
        if view is None:
            raise DebugError(f"scan {scan:,} can no longer be repeated")
        return view

    def _looked(self, scan: int) -> TextScan | None:
        """Run the scans up to `scan` again, and keep it with some scans before it."""
        reruns = self._shown, self._before
        candidates = (
            past_rerun for past_rerun in reruns if 0 <= past_rerun.at < scan <= past_rerun.at + WINDOW
        )
        rerun = next(candidates, reruns[self._shown.at >= scan])
        window = WINDOW if rerun is self._shown else min(max(WINDOW, scan // SHARE), WINDOW_MOST)
        first = max(0, scan + 1 - window)
        self._filling = None
        self._keep(rerun, max(first, rerun.at + 1) if rerun.at < scan else first, scan)
        return self._kept.get(scan)

    def _keep(self, rerun: ProgramRerun, first: int, last: int) -> None:
        """Keep the scans from `first` to `last`; a DebugError if they can't be repeated."""
        for number, captured in rerun.walk(first, last, Capture):
            assert isinstance(captured, Capture)
            if rerun.departs is None:
                self._kept[number] = TextScan(number, captured)
        departs: int | None = rerun.departs
        if departs is not None and departs <= last:
            raise DebugError(
                f"run again on the recorded inputs, the program writes other words from scan {departs:,} on: "
                "it depends on more than its inputs and its time"
            )
        if len(self._kept) > 3 * WINDOW_MOST:
            near_scans = sorted(self._kept, key=lambda each: abs(each - self._at))[: 2 * WINDOW_MOST]
            self._kept = {scan: self._kept[scan] for scan in near_scans}

    @override
    def prepare(self) -> bool:
        if self._filling is None:
            low = self._at
            while low - 1 in self._kept:
                low -= 1
            is_done = low not in self._kept or not low or self._at - low >= WINDOW_MOST
            if is_done or self._before.departs is not None:
                return False
            self._filling = self._fill(low)
        if next(self._filling, self) is self:
            self._filling = None
        return True

    def _fill(self, low: int) -> Iterator[None]:
        """Keep the scans before the window, in slices."""
        first, rerun = max(0, low - WINDOW_MOST), self._before
        rerun.rewind(first)
        while rerun.at + 1 < first:
            last = min(first - 1, rerun.at + QUICK)
            yield from (None for _ in rerun.walk(last, last, lambda _logic: None))
        for number in range(first, low, WINDOW):
            self._keep(rerun, number, min(number + WINDOW, low) - 1)
            yield

    @override
    def hits_between(
        self, requested: Sequence[Breakpoint], first: int, last: int, poll: Poll = lambda _scan: None
    ) -> Iterator[tuple[int, list[Hit]]]:
        rerun, begin = self._searched, max(0, first - 1)  # changes are known from the second scan on
        continues = 0 <= rerun.at == begin
        rerun.rewind(first if continues else begin)
        looker, points = self._looker(requested, lambda: rerun.logic, lambda: rerun.at)
        if continues:
            begin = first
            looker.prime(rerun.at)
        for number, _own in rerun.walk(begin, last, lambda _logic: points):
            hits = looker.hits(number)
            if hits and number >= first:
                yield number, hits
            if number % POLLED == 0:
                poll(number)

    def _looker(
        self, requested: Sequence[Breakpoint], logic: Callable[[], ScanLogic], at: Callable[[], int]
    ) -> tuple[Looker, LinePoints]:
        """Return the looker for breakpoints after each scan of a program, and the tracer of its lines."""
        points = LinePoints(ProgramValues(logic), in_frames=self._in_python)
        return Looker(requested, points, self.around(at), self.events), points

    @override
    def check(self, requested: Sequence[Breakpoint], scan: int) -> None:
        rerun = self._shown
        rerun.rewind(rerun.at + 1)
        self._looker(requested, lambda: rerun.logic, lambda: rerun.at)

    @override
    def hits(self, requested: Sequence[Breakpoint], scan: int) -> list[Hit]:
        key = scan, [(point.number, point.name, point.condition) for point in requested]
        if self._hits[0] != key:
            self._hits = key, super().hits(requested, scan)
        return self._hits[1]

    @override
    def last_before(self, requested: Sequence[Breakpoint], scan: int, poll: Poll) -> int | None:
        first, scans = self.extent[0], deque[int](maxlen=1)
        scans.extend(number for number, _hits in self.hits_between(requested, first, scan - 1, poll))
        return scans[0] if scans else None

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
    """Return the file of a program, and the files of imported modules in its folder."""
    return list(dict.fromkeys([program.resolve(), *WATCH.get().files(program.parent)]))


def lines_of(logic: ScanLogic) -> list[int]:
    """Return the lines of a list of steps; no lines for any other program."""
    inside: object = unwrapped(logic)
    return [step.line for step in inside.steps] if isinstance(inside, Steps) else []
