"""Runs a program on recorded inputs, scan by scan, without modules and without a CPU.

    inputs, time, mode of each scan    ---> the program ---> outputs, compared with the recorded ones
    actions on tags, and edits         before the same scans
    lost links                         at the same times

| user | program | afterwards |
|---|---|---|
| `why.traced_run`, `why.trials` | Python | the lines of some scans; trials of other inputs |
| `why.program_rerun` | Python, a list of steps | the lines of a debug adapter and of a page |
| `why.followed` | ladder | its tags after a scan |
| `watch.history.indexer` | ladder | snapshots, from which a page shows any scan |

A ladder program whose inputs are only images needs no rack: see `why.followed` and `ladder.debug.replay`.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping

from scanrack.io_images.addresses import parse_address
from scanrack.io_images.times import exact_ns
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.python.online.editing import edit_logic
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import ALL, Action, Edit, Force, Unforce, Write, names_in
from scanrack.runtime.live.operator_actions import AppliedAction
from scanrack.runtime.loop.faults import Cause, ends_the_run
from scanrack.runtime.loop.pace import Watchdog
from scanrack.runtime.loop.phases import runs_logic
from scanrack.runtime.loop.scan import LogicScan, ScanFlag, ScanLogic, attached
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.replay import PackedTrace

from ..load.recorded_scans import RecordedScan, recorded_rack, recorded_scans
from ..record.link_losses import LinkChange, link_changes
from ..record.logic_wrapper import unwrapped
from ..record.settable_tags import settable_tags
from ..run.playback import RecordedInputs
from .tag_orders import TagOrders

_FIRST, _FAULT = int(ScanFlag.FIRST_SCAN), int(ScanFlag.FAULT)
_SET_FROM_OUTSIDE = int(ScanFlag.TAGS_FROM_OUTSIDE)
_NOT_COMPARED = int(ScanFlag.OUTPUT_FORCES | ScanFlag.FAULT)
"""Flags of scans whose recorded outputs were not set by the program alone."""

Call = Callable[[ScanLogic, LogicScan], object]
"""Runs one scan of a program."""


def _call(logic: ScanLogic, view: LogicScan) -> None:
    logic(view)


class InputReplay:
    """A program that runs on recorded inputs.

    Args:
        slots: the modules of the recording.
        call: runs one scan of the program, to observe it.
        edited: loads the program of an edit by number; None = the first program continues.

    Attributes:
        view: the rack as the program sees it.
        logic: the program after the last scan that was run; see `attach`.
        row, scan: row and number of that scan; -1 before the first one.
        departs: number of the first scan whose outputs differ from the recorded ones; None if there is none.
        faulted: whether the program faulted in the last scan.
        refused: a sentence for each operator action that could not be repeated.
        lost: the scans before which an edit could not be repeated.
        orders: the operator actions of the recording, see `read_events`.
    """

    logic: ScanLogic
    orders: TagOrders

    def __init__(
        self,
        spec: RackSpec,
        slots: Iterable[SlotInfo],
        *,
        call: Call = _call,
        edited: Callable[[int], ScanLogic] | None = None,
    ) -> None:
        slots = tuple(slots)
        self._modules = {slot.number: RecordedInputs((), ()) for slot in slots}  # `run` copies the images
        self._rack = recorded_rack(slots, spec, self._modules)
        self.view = LogicScan(self._rack.slots, spec.scan_ns)
        self._call, self._edited = call, edited
        self._rpi_ns = spec.rpi_ns if spec.controller == "compactlogix" else None
        self._watchdog = Watchdog(exact_ns(spec.watchdog_ms, "ms"))
        self._by_watchdog = False
        self._events = -1  # number of events in the recording when they were read
        self._inputs = [places.inputs for places in self._rack.layout.places.values()]
        self._replaced_inputs: list[tuple[slice, bytes]] = []
        self._orders: deque[AppliedAction] = deque()  # pending actions, by scan
        self._links: deque[tuple[int, LinkChange]] = deque()  # pending changes with their slots, by time
        self.row = self.scan = -1
        self._last_ordered_scan = -1  # the last scan before which the actions were applied
        self.departs: int | None = None
        self.faulted = False
        self.refused: list[str] = []
        self.lost: list[int] = []

    def attach(self, logic: ScanLogic) -> None:
        """Run this program, starting with the next scan."""
        self.logic = logic
        if (needs := attached(logic)) is not None:
            needs.__attach_logic__(self.view.slot)

    def play(self, recording: PackedTrace, last: int) -> Iterator[int]:
        """Run the scans of a recording up to a row, and yield each row after its scan.

        A fault of the program ends the run, as in the recording.
        """
        self.read_events(recording)
        try:
            for scan in recorded_scans(recording, 0, last):
                self.run(scan)
                yield self.row
                if self.faulted:
                    return
        finally:
            if (needs := attached(self.logic)) is not None:
                needs.__close_logic__()

    def read_events(self, recording: PackedTrace) -> None:
        """Set the pending operator actions and link changes from a recording, which may have grown."""
        events = recording.events
        if self._events != len(events):
            self._events, self.orders = len(events), TagOrders(recording, edits=self._edited is not None)
        self.set_pending(self.orders.orders, {slot: link_changes(events, slot) for slot in self._modules})
        self._by_watchdog = any(event.fields.get("cause") == Cause.WATCHDOG.value for event in events)

    def set_pending(self, orders: Iterable[AppliedAction], links: Mapping[int, Iterable[LinkChange]]) -> None:
        """Set the pending operator actions, sorted by scan, and link changes, sorted by time.

        Args:
            links: changes by slot.
        """
        now_ns = self.view.now_ns if self.row >= 0 else -1  # before the first scan, changes at 0 are pending
        later_changes = [
            (slot, change) for slot, changes in links.items() for change in changes if change.now_ns > now_ns
        ]
        self._links = deque(sorted(later_changes, key=lambda pair: pair[1].now_ns))
        later_orders = [order for order in orders if order.scan > self.scan]
        self._orders = deque(sorted(later_orders, key=lambda order: order.scan))

    def replace_inputs(self, slot: int, image: bytes) -> None:
        """Replace the recorded input image of a slot, starting with the next scan."""
        self._replaced_inputs.append((self._rack.layout.places[slot].inputs, image))

    def block(self) -> bytes:
        """Return the rack's current memory block, with the program's outputs so far."""
        return bytes(self._rack.memory)

    # --- one scan

    def give_orders(self, scan: RecordedScan) -> None:
        """Apply the operator actions before a scan; `run` does so unless this was called before."""
        if scan.number == self._last_ordered_scan:
            return
        self._last_ordered_scan = scan.number
        if scan.flags & _SET_FROM_OUTSIDE and not self._has_values_for(scan.number):
            self._depart(scan.number)
        while self._orders and self._orders[0].scan <= scan.number:
            number, order = self._orders.popleft()
            try:
                self._apply(order, number)
            except ValueError as error:
                self.refused.append(f"the action before scan {number} is not repeated: {error}")

    def run(self, scan: RecordedScan) -> None:
        """Apply the actions before a scan, run it, and compare its outputs with the recorded ones."""
        number, now_ns, flags, block = scan
        if self._orders or flags & _SET_FROM_OUTSIDE:
            self.give_orders(scan)
        self.row += 1
        self.scan, self.faulted = number, False
        if not runs_logic(flags):
            return
        view, memory = self.view, self._rack.memory
        if self._rpi_ns is not None:
            view.updated = self.row == 0 or now_ns // self._rpi_ns != view.now_ns // self._rpi_ns
        view.number, view.now_ns, view.first = number, now_ns, bool(flags & _FIRST)
        for span in self._inputs:
            memory[span] = block[span]
        for span, image in self._replaced_inputs:
            memory[span] = image
        while self._links and self._links[0][1].now_ns <= now_ns:
            slot, change = self._links.popleft()
            self._modules[slot].linked = change.good
        self.run_logic(flags)
        if not flags & _NOT_COMPARED and memory != block:
            self._depart(number)

    def run_logic(self, flags: int) -> None:
        """Run the program. The frames outside this one in the stack do not belong to the program."""
        try:
            if self._by_watchdog and flags & _FAULT:  # in other scans, a traced program may take longer
                with self._watchdog.armed(lambda: self.scan, InputReplay.run_logic.__code__):
                    self._call(self.logic, self.view)
            else:
                self._call(self.logic, self.view)
        except BaseException as error:
            if ends_the_run(error):
                raise
            self.faulted = True
            if not flags & _FAULT:
                self._depart(self.scan)

    def _depart(self, scan: int) -> None:
        if self.departs is None:
            self.departs = scan

    # --- orders

    def _has_values_for(self, scan: int) -> bool:
        """Return whether the recording has the values that were set from outside before a scan.

        A pending action or a force provides them. For a ladder program, the comparison of its outputs
        decides.
        """
        tags = settable_tags(self.logic)
        is_ordered = bool(self._orders) and self._orders[0].scan <= scan
        return is_ordered or isinstance(tags, Debugger) or (tags is not None and bool(tags.forces))

    def _apply(self, order: Action, scan: int) -> None:
        """Apply an action to the program; recorded images already have the effects of other actions."""
        tags = settable_tags(self.logic)
        match order:
            case Edit():
                try:
                    self._edit(order)
                except ValueError:
                    self.lost.append(scan)
                    raise
            case Unforce(tag) if tag == ALL and tags is not None:
                tags.unforce()
            case Write() | Force() | Unforce() if tags is not None:
                if not self._names_image_place(tags, order.tag):
                    _apply_to_tag(tags, order)

    def _names_image_place(self, tags: Debugger | Fields, name: str) -> bool:
        """Return whether a name is an address or a tag of an image."""
        try:
            parse_address(name, {slot.number: slot.words for slot in self._rack.slots.values()})
        except ValueError:
            return tags.address_of(name) is not None
        else:
            return True

    def _edit(self, order: Edit) -> None:
        """Continue with an edited program; it keeps the current values unless the edit restarts it."""
        if self._edited is None:
            return
        program, edited, restart = unwrapped(self.logic), self._edited(order.number), names_in(order.restart)
        if isinstance(program, Debugger) and isinstance(edited, LadderLogic):
            program.edit(edited)
        elif isinstance(program, Logic) and isinstance(edited, Logic) and ALL not in restart:
            edit_logic(program, edited, restart)
        else:
            self.attach(edited)


def _apply_to_tag(tags: Debugger | Fields, order: Write | Force | Unforce) -> None:
    """Write, force or release a tag."""
    if isinstance(order, Write):
        tags.tags[order.tag] = order.value
    elif isinstance(order, Force):
        tags.force(order.tag, order.value)
    else:
        tags.unforce(order.tag)
