"""Runs a Python program or a list of steps again beside a session.

    recorded scan        images, time ---> the twin ---> outputs, compared with the recorded ones
    a scan in question                       |
                                             +--> an observer of its lines

A program can't be copied in the middle of a run. To go back, the twin starts again with the first scan.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from io import StringIO
from typing import Any

from scanrack.ladder.files.steps import Steps
from scanrack.ladder.python.line_marks import WATCH, Observer
from scanrack.ladder.python.online.editing import edit_logic
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import ALL, Action, Edit, Force, Unforce, Write, names_in
from scanrack.runtime.live.operator_actions import AppliedAction
from scanrack.runtime.loop.events import Event
from scanrack.runtime.loop.phases import IDLE_PHASES
from scanrack.runtime.loop.rack import Card, Rack
from scanrack.runtime.loop.scan import MODE_MASK, LogicScan, ScanFlag, ScanLogic, attached
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.packed import CHUNK_SCANS
from scanrack.traces.replay import PackedTrace
from typing_extensions import override

from ..load.building import round_trip_ms
from ..load.program import lines_marked
from ..record.link_losses import LinkChange, link_changes
from ..record.logic_wrapper import unwrapped
from ..replay.replaying import score_of
from ..replay.tag_orders import TagOrders
from .traced_run import Load, fresh

_FIRST, _FAULT = int(ScanFlag.FIRST_SCAN), int(ScanFlag.FAULT)
_SET_FROM_OUTSIDE = int(ScanFlag.TAGS_FROM_OUTSIDE)
_UNTOUCHED = int(ScanFlag.OUTPUT_FORCES | ScanFlag.FAULT)
"""Flags of scans whose recorded outputs were not set by the program alone."""

_IDLE = frozenset(int(mode) for mode, idle in IDLE_PHASES.items() if "logic" in idle)
"""The modes in which the program does not run."""


class _ShownWords:
    """A module whose inputs are written from outside."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.linked = True

    def update(self, now_ns: int, outputs: Any) -> Any:
        raise AssertionError("no scan loop runs it")

    def plc_run(self, running: bool) -> None:
        """Do nothing."""

    def power_cycle(self) -> None:
        """Do nothing."""


class _Silent(StringIO):
    """Discards what the program prints when it runs again."""

    @override
    def write(self, text: str) -> int:
        return len(text)


_SILENT = _Silent()


def _rows(recording: PackedTrace, number: int, last: int) -> Iterator[tuple[int, int, int, bytes]]:
    """Yield the number, time, flags and images of some scans."""
    while number <= last:
        rows = recording.scans.chunk(number // CHUNK_SCANS)
        start = number % CHUNK_SCANS
        count = min(len(rows.scan), last + 1 - number + start)
        if start >= count:
            return
        words, size = rows.words[start:count].tobytes(), 2 * rows.words.shape[1]
        blocks = (words[place : place + size] for place in range(0, len(words), size))
        heads = (column[start:count].tolist() for column in (rows.scan, rows.time_ns, rows.flags))
        yield from zip(*heads, blocks, strict=True)
        number += count - start


class Twin:
    """Runs a program again on recorded inputs, scan by scan.

    Args:
        recording: returns the recording of the scans so far.

    Attributes:
        at: number of the last scan that was run; -1 before the first one.
        logic: the program after that scan.
        departs: the first scan whose outputs differ from the recorded ones; None if there is none.
    """

    def __init__(self, load: Load, spec: RackSpec, recording: Callable[[], PackedTrace]) -> None:
        self._load, self._spec, self._recording = load, spec, recording
        self.at, self._begun = -1, False
        self.departs: int | None = None
        self._events = -1  # number of recorded events when `_orders` was made
        self._orders: list[AppliedAction] = []  # orders that are still to be repeated, the next one last
        self._links: list[tuple[LinkChange, _ShownWords]] = []  # link changes to come, the next one last
        self.logic: ScanLogic

    def rewind(self, first: int) -> None:
        """Start again if a scan has already run. Afterwards, `logic` is set."""
        if not self._begun or self.at >= first:
            self._begin()

    def _begin(self) -> None:
        recording = self._recording()
        if recording.numbers[0]:
            first = recording.numbers[0]
            raise ValueError(f"the recording begins with scan {first:,}: its program can't be run again")
        with lines_marked(), fresh(self._load) as logic:
            self.logic, self._watch = logic, WATCH.get()
        known = {slot.number: slot.words for slot in self._spec.slot}
        trips = {slot.number: round_trip_ms(self._spec, slot) for slot in self._spec.slot}
        self._modules = {each.number: _ShownWords() for each in recording.slots}

        def card(slot: SlotInfo) -> Card:
            own = known.get(slot.number)
            words = own if own == slot.words else slot.words  # a trace has no addresses for a card's data
            module = self._modules[slot.number]
            return Card(slot.number, module, slot.module, slot.firmware, words, trips.get(slot.number, 0))

        self._rack = Rack(map(card, recording.slots))
        self._view = LogicScan(self._rack.slots, self._spec.scan_ns)
        self._attach(self.logic)
        self._inputs = [self._rack.layout.places[number].inputs for number in self._modules]
        self.at, self.departs, self._begun, self._events = -1, None, True, -1

    def _attach(self, logic: ScanLogic) -> None:
        inside: object = unwrapped(logic)
        self._steps = inside if isinstance(inside, Steps) else None
        if (needs := attached(logic)) is not None:
            needs.__attach_logic__(self._view.slot)

    def walk(
        self, first: int, last: int, observer: Callable[[ScanLogic], Observer | None]
    ) -> Iterator[tuple[int, Observer | None]]:
        """Run scans up to `last`; yield each one from `first` on, with its observer.

        Args:
            observer: makes the observer of a scan from the program before it; None for no observer.

        Raises:
            ValueError: the scans can't be repeated.
        """
        self.rewind(first)
        recording = self._recording()
        self._take_events(recording)
        observed: Observer | None = None
        self._watch.only()
        for scan, now_ns, flags, block in _rows(recording, self.at + 1, last):
            if flags & _SET_FROM_OUTSIDE and not self._is_known(scan):
                self._depart(scan)
            while self._orders and self._orders[-1].scan <= scan:
                self._obey(self._orders.pop().order)
            if scan >= first:
                observed = observer(self.logic)
                if observed is not None and self._watch.observers != [observed]:
                    self._watch.only(observed)
            self._do(scan, now_ns, flags, block, observed)
            if scan >= first:
                yield scan, observed

    def _is_known(self, scan: int) -> bool:
        """Whether an order tells what was set before a scan, or a force is in effect."""
        logic = self.logic
        forced = isinstance(logic, Logic) and Fields(lambda: logic).forces
        return bool(forced) or bool(self._orders and self._orders[-1].scan <= scan)

    def _take_events(self, recording: PackedTrace) -> None:
        """Take the orders and link changes that are still to come."""
        events, now_ns = recording.events, self._view.now_ns if self.at >= 0 else -1
        if len(events) != self._events:
            self._events = len(events)
            given = TagOrders(score_of(recording), events, self._load.edited).given
            further = (each for each in given if each.scan > self.at)
            self._orders = sorted(further, key=lambda each: each.scan)[::-1]
        modules = self._modules.items()
        links = ((each, module) for number, module in modules for each in link_changes(events, number))
        later = (each for each in links if each[0].now_ns > now_ns)
        self._links = sorted(later, key=lambda each: each[0].now_ns)[::-1]

    def _do(self, scan: int, now_ns: int, flags: int, block: bytes, observer: Observer | None) -> None:
        self.at = scan
        if flags & MODE_MASK in _IDLE:
            return
        view, memory = self._view, self._rack.memory
        view.number, view.now_ns, view.first = scan, now_ns, bool(flags & _FIRST)
        for inputs in self._inputs:
            memory[inputs] = block[inputs]
        while self._links and self._links[-1][0].now_ns <= now_ns:
            change, module = self._links.pop()
            module.linked = change.good
        printed, sys.stdout, sys.stderr = (sys.stdout, sys.stderr), _SILENT, _SILENT
        try:
            self._call(view, observer)
        except Exception:
            if not flags & _FAULT:  # with a fault flag, the program also faulted in the recorded session
                self._depart(scan)
        finally:
            sys.stdout, sys.stderr = printed
        if not flags & _UNTOUCHED and memory != block:
            self._depart(scan)

    def _call(self, view: LogicScan, observer: Observer | None) -> None:
        steps = self._steps
        before = 0 if steps is None else steps.line
        self.logic(view)
        if steps is not None and observer is not None and (steps.line != before or view.first):
            observer.begins(self._load.program.name, steps.line, None)

    def _depart(self, scan: int) -> None:
        if self.departs is None:
            self.departs = scan

    def _obey(self, order: Action) -> None:
        """Replay an order that changes the program's values, or an edit of the program."""
        logic = self.logic
        if isinstance(order, Edit) and self._load.edited is not None:
            with lines_marked(self._watch):
                edited, restart = self._load.edited(order.number), names_in(order.restart)
            if isinstance(logic, Logic) and isinstance(edited, Logic) and ALL not in restart:
                edit_logic(logic, edited, restart)
            else:
                self.logic = edited
                self._attach(edited)
        elif isinstance(logic, Logic):
            _give(Fields(lambda: logic), order)


def _give(fields: Fields, order: Action) -> None:
    """Repeat an order on the program's fields. An order on an image already shows in the recorded images."""
    if isinstance(order, Write) and order.tag in fields:
        fields[order.tag] = order.value
    elif isinstance(order, Force) and order.tag in fields:
        fields.force(order.tag, order.value)
    elif isinstance(order, Unforce):
        for name in fields.forces if order.tag == ALL else {order.tag} & fields.forces.keys():
            fields.unforce(name)
