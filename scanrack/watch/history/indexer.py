"""Runs a recorded program once and takes regular snapshots, so that any scan can be shown at once.

scan      0 ... 4,095   4,096 ...   8,192 ...
values    *             *           *            the replica continues from here, in at most 60 ms
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from scanrack.io_images.module_words import ModuleWords
from scanrack.jobs.run.playback import RecordedInputs
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.model.errors import LadderFault
from scanrack.runtime.live import actions
from scanrack.runtime.live.actions import ALL, Action
from scanrack.runtime.live.ring import Rows
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.loop.scan import LogicScan

from .event_log import LAST_SCAN
from .program_replica import Row, scans_in
from .recorded_events import RecordedEvents
from .stretch import Stretch
from .watched_program import Inputs, Values, inputs_of, values_of

EVERY = 512
"""Scans between two snapshots."""

SLICE = 1000
"""Scans per step."""


def indexable(stretches: Sequence[Stretch]) -> tuple[list[LadderLogic], int]:
    """Return the programs that can be repeated from the first scan, and the last such scan."""
    programs: list[LadderLogic] = []
    for each in stretches:
        if not isinstance(each.logic, LadderLogic) or each.logic.functions:
            return programs, each.first - 1
        programs.append(each.logic)
    return programs, LAST_SCAN


class Indexer:
    """Runs a program on recorded images, scan by scan from the first.

    Args:
        programs: the program and its edited versions; none may have routines in Python.
    """

    def __init__(
        self,
        programs: Sequence[LadderLogic],
        slots: Mapping[int, ModuleWords],
        period_ns: int,
        recorded: RecordedEvents,
        keep: Callable[[Values | Inputs], None],
    ) -> None:
        program, *self._edited = programs
        self._modules = {slot: RecordedInputs([], []) for slot in slots}
        self._rack = Rack(Card(slot, self._modules[slot], words=words) for slot, words in slots.items())
        self._view = LogicScan(self._rack.slots, period_ns)
        self._debugger = Debugger(program, remembered=0)
        self._keep = keep
        self._words = slots
        self._recorded = recorded
        self._orders: dict[int, list[Action]] = {}
        self._links: dict[int, list[tuple[int, bool]]] = {}
        self.next = self._kept = 0
        self._forces: object = None

    def run(self, rows: Rows) -> bool:
        """Run successive scans, which begin with `next`; return whether a snapshot was stored."""
        kept = self._kept
        self._read(self.next, int(rows["scan"][-1]))
        for row in scans_in(rows):
            self._before(row.scan)
            if row.memory is not None:
                self._run(row, row.memory)
            self.next = row.scan + 1
        return self._kept > kept

    def _read(self, first: int, last: int) -> None:
        """Read the other inputs of scans: orders, and changes of links."""
        self._orders.clear()
        for each in self._recorded.orders(first, last):
            self._orders.setdefault(each.scan, []).append(each.order)
        self._links.clear()
        for slot in self._modules:
            for change in self._recorded.links(slot, first, last):
                self._links.setdefault(change.scan, []).append((slot, change.good))

    def _before(self, scan: int) -> None:
        for slot, good in self._links.get(scan, ()):
            self._modules[slot].linked = good
        edits = len(self._debugger.edits)
        for order in self._orders.get(scan, ()):
            self._give(order)
        if scan % EVERY == 0 or edits != len(self._debugger.edits):
            self._keep(values_of(self._debugger, scan))
            self._kept += 1
            self._forces = None

    def _give(self, order: Action) -> None:
        """Carry out an order on the program; the recorded images already include its other effects."""
        try:
            match order:
                case actions.Edit():
                    self._debugger.edit(self._edited.pop(0))
                case actions.Write(tag, value):
                    self._debugger.tags[tag] = value
                case actions.Force(tag, value) if tag in self._debugger.tags:
                    self._debugger.force(tag, value)
                case actions.Unforce(tag):
                    self._debugger.unforce(None if tag == ALL else tag)
        except ValueError:
            pass  # an image: the recorded images include its forces

    def _run(self, row: Row, memory: bytes) -> None:
        own = self._rack.memory
        for places in self._rack.layout.places.values():
            own[places.inputs] = memory[places.inputs]
        view = self._view
        view.number, view.now_ns, view.first = row.scan, row.now_ns, row.first
        try:
            self._debugger(view)
        except LadderFault:
            return  # it also stopped that scan in the recording
        entry, forces = self._debugger.latest, self._debugger.engine.memory.forces
        if forces is not self._forces or (entry is not None and entry.writes):
            self._forces = forces
            self._keep(inputs_of(self._debugger, row.scan))
