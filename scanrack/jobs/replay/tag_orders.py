"""Repeats a recording's operator actions on the tags of a program during its replay.

/orders    of a session: writes, forces and releases, in order
/forces    of any other recording: the forced tags with their values
/events    of any other recording: the fields of a Python program that a test has set; no writes of tags
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

from scanrack.ladder import LadderLogic
from scanrack.runtime.live.actions import Edit, Force, Unforce, Write
from scanrack.runtime.live.operator_actions import AppliedAction, OperatorActions
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanFlag, ScanLogic
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import PackedTrace

from ..record.edits_and_forces import Forced, forced_in, is_edit, is_set
from ..record.order_repeater import OrderRepeater, orders_of

_SHOWN = 3


class TagOrders:
    """The orders on tags in a recording.

    Args:
        edits: whether to repeat the edits whose files are in the recording; if not, the first program
            continues.

    Attributes:
        orders: the orders, by scan.
        lost: scans from which the recorded program differs from the one that runs here.

    Raises:
        ValueError: an order of the recording can't be read.
    """

    def __init__(self, recording: PackedTrace, *, edits: bool = False) -> None:
        events = recording.events
        is_session = any(event.topic == ORDERS.name for event in events)
        kinds = (Write, Force, Unforce, Edit) if edits else (Write, Force, Unforce)
        orders = orders_of(events)
        if not is_session:
            orders = [*_orders_of_forces(events), *orders]
        self.orders = [order for order in orders if isinstance(order.order, kinds)]
        # other recordings contain no writes of tags
        self._recording, self._may_lack_values = recording, bool(events) and not is_session
        repeated = {order.scan for order in self.orders if isinstance(order.order, Edit)}
        self.lost = [event.scan for event in events if is_edit(event) and event.scan not in repeated]

    @property
    def notes(self) -> list[str]:
        """Notes about orders that can't be repeated."""
        return list(_notes_on_unknown_values(self._recording)) if self._may_lack_values else []

    def program(self, logic: ScanLogic) -> ScanLogic:
        """Return the program to run; if there are orders, a ladder program runs under a debugger."""
        if not self.orders or not isinstance(logic, LadderLogic):
            return logic
        from scanrack.ladder.debug import Debugger  # most recordings need no debugger

        return Debugger(logic, remembered=0)

    def give(self, cpu: Cpu, rack: Rack, logic: ScanLogic) -> OrderRepeater:
        """Add a repeater that applies the orders before the same scans of a CPU; return the repeater.

        Args:
            cpu: runs the program; it has run no scan yet.
            logic: the result of `program`.
        """
        from ..record.settable_tags import settable_tags

        repeated = OrderRepeater(cpu, OperatorActions(cpu, rack, settable_tags(logic)), self.orders)
        cpu.add_listener(repeated)
        repeated.begin()
        return repeated


def _orders_of_forces(events: Sequence[TraceEvent]) -> Iterator[AppliedAction]:
    """Yield the forces and releases of tags in the messages on /forces."""
    last_forced: Forced = {}
    for event in events:
        if event.topic == "/forces":
            forced = forced_in(event)
            releases: list[Force | Unforce] = [Unforce(tag) for tag in last_forced if tag not in forced]
            forces = [Force(tag, forced[tag]) for tag in forced if last_forced.get(tag) != forced[tag]]
            for order in releases + forces:
                yield AppliedAction(event.scan, order)
            last_forced = forced


def _notes_on_unknown_values(recording: PackedTrace) -> Iterator[str]:
    """Yield a note if tags were set to values that are not recorded."""
    events = recording.events
    changes = {event.scan: bool(forced_in(event)) for event in events if event.topic == "/forces"}
    scans_with_values = {event.scan for event in events if is_set(event)} | changes.keys()
    is_forced = False
    scans = []
    for number, flags in zip(recording.numbers, recording.flags, strict=True):
        is_forced = changes.get(number, is_forced)
        if flags & ScanFlag.TAGS_FROM_OUTSIDE and not is_forced and number not in scans_with_values:
            scans.append(number)
    if scans:
        times = f"{len(scans):,} scan{'s' * (len(scans) != 1)}, first before scan {scans[0]:,}"
        yield f"tags were set from outside before {times}: the trace does not have the values"


def first_few(sentences: Sequence[str]) -> list[str]:
    """Return the first sentences, followed by the total number if some are omitted.

    >>> first_few(["a", "b"])
    ['a', 'b']
    >>> first_few("abcde")
    ['a', 'b', 'c', 'and so on, 5 times in all']
    """
    few = list(islice(sentences, _SHOWN))
    return few if len(sentences) <= _SHOWN else [*few, f"and so on, {len(sentences):,} times in all"]
