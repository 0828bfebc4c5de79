"""Repeats the orders of a recorded session before the same scans."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from scanrack.runtime.live.actions import RECORDED, action_of, parsed
from scanrack.runtime.live.operator_actions import AppliedAction, OperatorActions
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.reader import Trace, TraceEvent

from .edits_and_forces import is_edit, is_set

RecordedOrder = AppliedAction
"""An order in a recording."""


def is_session(trace: Trace) -> bool:
    """Return whether a trace is of a session."""
    return any(channel.topic == ORDERS.name for channel in trace.head.channels.values())


def orders_of(events: Iterable[TraceEvent]) -> list[RecordedOrder]:
    """Return the orders among the events of a recording; raise ValueError if one can't be read.

    A session has orders. A bench has the fields that a test set, and edits if their files are in the trace.
    """
    orders = []
    for event in events:
        known = event.topic == ORDERS.name or is_set(event)
        if known or is_edit_with_files(event.topic, event.fields):
            try:
                order = action_of(parsed(str(event.fields.get("order"))), RECORDED)
            except ValueError as error:
                problem = f"the order before scan {event.scan} can't be given again: {error}"
                raise ValueError(problem) from error
            orders.append(RecordedOrder(event.scan, order))
    return orders


def is_edit_with_files(topic: str, fields: Mapping[str, object]) -> bool:
    """Return whether an event is a bench edit with files in the trace; such an event contains its order."""
    return topic == "/events" and fields.get("kind") == "edit" and "order" in fields


def lost_edits(events: Iterable[TraceEvent]) -> list[int]:
    """Return the scans of bench edits without files: from them, the trace lacks the program that ran."""
    known = list(events)
    orders = [event for event in known if event.topic == ORDERS.name]
    brought = {event.scan for event in orders if event.fields.get("name") == "edit"}
    lost = [order for order in known if is_edit(order) and not is_edit_with_files(order.topic, order.fields)]
    return [event.scan for event in lost if event.scan not in brought]


class OrderRepeater(QuietListener):
    """Gives recorded orders again; it must be the last listener of the scan loop.

    Args:
        hands: carries out the orders.
    """

    def __init__(self, cpu: Cpu, hands: OperatorActions, orders: Iterable[RecordedOrder]) -> None:
        self._cpu, self._hands = cpu, hands
        self._orders: Sequence[RecordedOrder] = sorted(orders, key=lambda each: each.scan)
        self._next = 0
        self.refused: list[str] = []  # a sentence for each order that could not be carried out

    def begin(self) -> None:
        """Give the orders before scan 0."""
        self._give(0)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Give the orders before the next scan."""
        self._give(scan + 1)

    def _give(self, scan: int) -> None:
        while self._next < len(self._orders) and self._orders[self._next].scan <= scan:
            number, order = self._orders[self._next]
            self._next += 1
            try:
                self._hands.act(order, number * self._cpu.period_ns, number)
            except ValueError as error:
                self.refused.append(f"the order before scan {number} is not carried out: {error}")
