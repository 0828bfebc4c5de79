"""The monitor of a recording: pages look at its scans; nothing runs, and only a branch can be ordered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from typing_extensions import override

from ....ladder import LadderLogic
from ....traces.reader import Trace
from ...app.repeating import RecordedOrder
from ...app.watched_machines import PER_SLOT
from ...config.rackspec import RackSpec
from ...live.orders import NAMES, ORDERS, Branch, order_of
from ...live.ring import row_type
from ...loop.rack import SLOT_BYTES
from ...loop.scan import Logic
from ...modules.record import Trait
from ...modules.registry import has
from .event_log import EventLog
from .indexer import SLICE, Indexer, indexable
from .monitor import About, Monitor, Subject
from .page import Page
from .stretch import Stretch

Json = dict[str, Any]

IMPURE = (
    "The program calls routines in Python, so its scans are not run again here: its rungs have no power and "
    "no values."
)


class Source(NamedTuple):
    """A program of a recording.

    Attributes:
        first: its first scan.
        logic: the program; None if the trace does not bring it, or it must not be run.
        file: of the program; None without one.
    """

    first: int
    logic: Logic | None
    file: Path | None


class TraceMonitor(Monitor):
    """What pages look at of a recording.

    Args:
        about: what pages get about it.
        trace: the recording.
        path: its path.
        spec: its rack.
        sources: its programs, in the order of their scans; one at least.
        orders: of a session, given to the program again.
        first: the scan that pages begin with; None = the last one.
        branch: prepares a session that repeats the recording up to a scan, ValueError if that can't be.
    """

    def __init__(
        self,
        about: About,
        trace: Trace,
        path: Path,
        spec: RackSpec,
        sources: Sequence[Source],
        orders: Sequence[RecordedOrder],
        first: int | None,
        branch: Callable[[int], None],
    ) -> None:
        machines = tuple(slot.number for slot in spec.slot if has(slot.module, Trait.MACHINE))
        dtype = row_type(SLOT_BYTES * len(spec.slot), PER_SLOT * len(machines))
        subject = Subject(spec, machines, dtype, path)
        for each in sources:
            subject.programs.add(*each)
        super().__init__(about, subject)
        self._branch = branch
        self.log = EventLog(kept=1 << 20)
        self.log.take_all(trace.events())
        extent = subject.timeline.extent
        if extent is None:
            raise ValueError(f"{path}: there is no scan in it")
        self._last = extent[1]
        self._first = extent[1] if first is None else first
        self.latest = subject.timeline.row(self._first)
        if self.latest is None:
            raise ValueError(f"{path} has no scan {first}: it has {extent[0]} to {extent[1]}")
        if any(each.catalog is None for each in subject.programs.all):
            subject.values = subject.timeline.values(self._last)
        self._indexer: Indexer | None = None
        self._index_to = self._last
        programs, end = indexable(subject.programs.all)
        if programs and extent[0] == 0:
            self._index_to = min(self._last, end)
            self._indexer = Indexer(programs, subject.words, spec.scan_ns, orders, subject.keep)

    @property
    def _programs(self) -> Sequence[Stretch]:
        return self.subject.programs.all

    @override
    def state(self, *, past: bool) -> Json:
        return {"state": "past", "speed": {"wanted": 0, "reached": 0}, "late": 0, "missed": 0}

    @override
    def join(self, page: Page) -> None:
        page.past = self._first
        super().join(page)
        if any(isinstance(each.logic, LadderLogic) and each.logic.functions for each in self._programs):
            page.send({"note": IMPURE})

    @override
    def tick(self) -> bool:
        """Run a slice of the program's scans, until all have been run once."""
        indexer = self._indexer
        if indexer is None:
            return False
        rows = self.subject.timeline.between(indexer.next, min(indexer.next + SLICE - 1, self._index_to))
        indexer.run(rows)
        if not len(rows) or indexer.next > self._index_to:
            self._indexer = None
        self.wake()
        return self._indexer is not None

    @override
    def order(self, page: Page, number: object, said: Mapping[str, Any]) -> None:
        if said.get("do") == NAMES[Branch]:
            order = order_of({key: value for key, value in said.items() if key != "id"})
            assert isinstance(order, Branch)
            if order.scan > self._last + 1:
                raise ValueError(f"scan {order.scan} is not in the recording: the last one is {self._last}")
            self._branch(order.scan)
            self.over = True
            page.send({"answer": {"id": number, "ok": True, "scan": order.scan}})
            return
        if said.get("do") in ORDERS:
            raise ValueError("this is a recording: it takes no orders; branch from one of its scans")
        raise ValueError(f"there is nothing to do called {str(said.get('do'))[:60]!r}")
