"""The monitor of a trace. Nothing runs, and the only action is a branch."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from scanrack.jobs.load.loading import LoadedRack
from scanrack.jobs.load.panels import panel_name
from scanrack.jobs.trust.trust import address_name
from scanrack.jobs.why.traced_run import Load
from scanrack.ladder import LadderLogic
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import ACTIONS, NAMES, Branch, action_of
from scanrack.runtime.live.ring import row_type
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.runtime.modules.record import Trait
from scanrack.traces.read.reader import Trace
from typing_extensions import override

from ..history.event_log import LAST_SCAN
from ..history.indexer import SLICE, Indexer, indexable
from ..history.recorded_events import RecordedEvents
from ..history.watched_machines import PER_SLOT
from ..panels.kept_panel import KeptPanel
from .marks import Marks
from .monitor import Json, Monitor, SessionFacts, Subject
from .page import Page

IMPURE = (
    "The program calls routines in Python, so its scans can't run again here. Its rungs have no power and "
    "no values."
)


class Source(NamedTuple):
    """A program of a trace."""

    first: int
    logic: ScanLogic | None  # None if the trace lacks it or it must not run
    file: Path | None  # the program's file, or None
    lacks: str = ""  # why the program can't be shown; "" if it can


def _panel_in(trace: Trace, rack: str) -> bytes:
    """Return the operator panel's file in a trace; empty if there is no panel."""
    files = {attachment.name: attachment.data for attachment in trace.attachments()}
    return files.get(panel_name(rack), b"")


class TraceMonitor(Monitor):
    """The monitor of a trace.

    Args:
        sources: the programs in the order of their scans, at least one.
        first: the scan that pages show first; None = the last one.
        branch: prepares a session that repeats the trace up to a scan and can pause there; raises ValueError

    Attributes:
        branch: see the argument.
        job, again: the rack and a loader of the programs, for a debug adapter; None if they may not run.
    """

    job: LoadedRack | None = None
    again: Load | None = None

    def __init__(
        self,
        about: SessionFacts,
        trace: Trace,
        path: Path,
        spec: RackSpec,
        sources: Sequence[Source],
        first: int | None,
        branch: Callable[[int, bool], None],
    ) -> None:
        machines = tuple(slot.number for slot in spec.slot if slot.has(Trait.MACHINE))
        dtype = row_type(spec.layout.size, PER_SLOT * len(machines))
        subject = Subject(spec, machines, dtype, path)
        subject.timeline.use(trace)
        for source in sources:
            subject.programs.add(*source)
        self._recorded = RecordedEvents(trace)
        self._program_starts = {source.first for source in sources}  # the first scans of known programs
        self._lost = LAST_SCAN  # the first scan whose program the trace lacks
        rack = address_name(trace.head.metadata.get("rack_file", ""))
        super().__init__(about, subject, self._recorded, KeptPanel(rack, _panel_in(trace, rack)))
        self.branch = branch
        self.marks: Marks = Marks(subject.timeline, self._recorded, subject.words)
        extent = subject.timeline.extent
        if extent is None and not trace.may_grow:
            raise ValueError(f"{path}: the trace has no scans")
        self._first = first
        self._last = -1  # the last scan so far
        if extent is not None:
            self._begin(extent[1])
            if first is not None and subject.timeline.row(first) is None:
                raise ValueError(f"{path} has no scan {first}; it has {extent[0]} to {extent[1]}")
        self._indexer, self._index_end = self._indexing(extent)

    def _indexing(self, extent: tuple[int, int] | None) -> tuple[Indexer | None, int]:
        """Return an indexer, or None if scans can't be repeated from scan 0 on, and its last scan."""
        subject = self.subject
        programs, end = indexable(subject.programs.all)
        if not programs or (extent is not None and extent[0] != 0):
            return None, end
        return Indexer(programs, subject.words, subject.spec, self._recorded, subject.keep), end

    def _begin(self, last: int) -> None:
        """Show the first scans that are available."""
        self._last, subject = last, self.subject
        self.latest = subject.timeline.row(last)
        if any(program.catalog is None for program in subject.programs.all):
            subject.values = subject.timeline.values(last)

    @override
    def state(self, *, past: bool) -> Json:
        return {"state": "past", "speed": {"requested": 0, "reached": 0}, "late": 0, "missed": 0}

    @override
    def join(self, page: Page) -> None:
        """Add a page that shows the requested scan, or else the last one."""
        page.past = self._last if self._first is None and self._last >= 0 else self._first
        super().join(page)
        programs = self.subject.programs.all
        if any(isinstance(program.logic, LadderLogic) and program.logic.functions for program in programs):
            page.send({"note": IMPURE})

    @override
    def events(self, page: Page) -> Sequence[Json]:
        return ()  # pages request the events up to their scans

    @override
    def tick(self) -> bool:
        """Follow a growing trace, read more events, and run more scans."""
        self.subject.timeline.follow()
        extent = self.subject.timeline.extent
        if extent is not None and extent[1] > self._last:
            self._advance_to(extent[1])
        is_busy = self._recorded.tick() | self.marks.tick()
        self._check_for_lost_edits()
        return is_busy or self._index()

    @override
    def all_events(self) -> Sequence[Json]:
        """Return the events, with marks for error bits that no event reports."""
        marks = self.marks.unexplained if self.marks.all else ()  # `all` updates `unexplained`
        mark_events = [mark._asdict() for mark in marks]
        return sorted([*super().all_events(), *mark_events], key=itemgetter("scan"))

    def run_once(self) -> None:
        """Prepare a pass over all scans: skip the indexer if the scans depend only on images."""
        recorded, past = self._recorded, self.subject.programs.all[0].past
        links = (link for slot in self.subject.words for link in recorded.links(slot, 0, self._last))
        is_plain = all(link.good for link in links) and not recorded.orders(0, self._last)
        if self._indexer is not None and past is not None and is_plain:
            self._indexer = None
            past.keep(0)

    def index_to(self, scan: int) -> None:
        """Run the program up to a scan, so that the scan can be repeated."""
        while self._indexer is not None and self._indexer.next <= scan and self._index():
            pass

    def _check_for_lost_edits(self) -> None:
        """Show no program after the first edit whose program is missing from the trace."""
        first = min(self._recorded.edits - self._program_starts, default=LAST_SCAN)
        if first < self._lost:
            from scanrack.jobs.replay.replaying import (
                lost_notes,
            )

            self._lost, self._index_end = first, min(self._index_end, first - 1)
            self.subject.programs.lose(first)
            (note,) = lost_notes([first])
            self.send_all({"note": note})
            self.wake()

    def _advance_to(self, last: int) -> None:
        """Advance to a new last scan, and move pages that show the previous last scan to it."""
        for page in self.pages:
            if page.past is None or page.past == self._last:
                page.past = last
        if self._last < 0:
            self._begin(last)
        self._last = last
        self.wake()

    def _index(self) -> bool:
        """Run some of the program's scans; return whether more scans may remain."""
        indexer, end = self._indexer, min(self._last, self._index_end)
        if indexer is None or indexer.next > end:
            return False
        rows = self.subject.timeline.between(indexer.next, min(indexer.next + SLICE - 1, end))
        if not len(rows) or rows[-1]["scan"] - indexer.next != len(rows) - 1:
            self._indexer = None  # scans are missing, so later values are unknown
            return False
        if indexer.run(rows):
            self.wake()
        return True

    @override
    def act(self, page: Page, number: object, message: Mapping[str, Any]) -> None:
        """Begin a branch, the only action in a trace; the server of the trace then ends."""
        name = message.get("do")
        if name not in ACTIONS:
            raise ValueError(f"no action {str(name)[:60]!r}")
        if name != NAMES[Branch]:
            raise ValueError("this is a recording: it accepts no actions; branch from one of its scans")
        branch = action_of({key: value for key, value in message.items() if key != "id"})
        assert isinstance(branch, Branch)
        if branch.scan > self._last + 1:
            raise ValueError(f"scan {branch.scan} is not in the recording: the last one is {self._last}")
        self.branch(branch.scan, branch.paused)
        self.over = True
        page.send({"answer": {"id": number, "ok": True, "scan": branch.scan}})
