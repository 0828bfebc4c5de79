"""Repeats the operator actions of a recorded session before the same scans."""

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
"""An operator action in a recording."""


def is_session(trace: Trace) -> bool:
    """Return whether a trace is the recording of a session."""
    return any(channel.topic == ORDERS.name for channel in trace.head.channels.values())


def orders_of(events: Iterable[TraceEvent]) -> list[RecordedOrder]:
    """Return the operator actions among the events of a recording; raise ValueError if one can't be read.

    A session has messages on /orders. A bench has events for the fields that a test set, and for edits whose
    files are in the trace.
    """
    orders = []
    for event in events:
        is_order = event.topic == ORDERS.name or is_set(event)
        if is_order or is_edit_with_files(event.topic, event.fields):
            try:
                order = action_of(parsed(str(event.fields.get("order"))), RECORDED)
            except ValueError as error:
                raise ValueError(f"the action before scan {event.scan} can't be repeated: {error}") from error
            orders.append(RecordedOrder(event.scan, order))
    return orders


def is_edit_with_files(topic: str, fields: Mapping[str, object]) -> bool:
    """Return whether an event is a bench edit with files in the trace; the event then contains its order."""
    return topic == "/events" and fields.get("kind") == "edit" and "order" in fields


def lost_edits(events: Iterable[TraceEvent]) -> list[int]:
    """Return the scans of edits without files. From then on, the trace lacks the program that ran."""
    edits, scans_with_files = [], set()
    for event in events:
        if event.topic == ORDERS.name and event.fields.get("name") == "edit":
            scans_with_files.add(event.scan)
        elif is_edit(event) and not is_edit_with_files(event.topic, event.fields):
            edits.append(event)
    return [event.scan for event in edits if event.scan not in scans_with_files]


class OrderRepeater(QuietListener):
    """Repeats recorded operator actions; it must be the last listener of the scan loop.

    Args:
        executor: applies the actions.

    Attributes:
        refused: a sentence for each action that could not be repeated.
    """

    def __init__(self, cpu: Cpu, executor: OperatorActions, orders: Iterable[RecordedOrder]) -> None:
        self._cpu, self._executor = cpu, executor
        self._orders: Sequence[RecordedOrder] = sorted(orders, key=lambda each: each.scan)
        self._next = 0
        self.refused: list[str] = []

    def begin(self) -> None:
        """Apply the actions before scan 0."""
        self._apply_before(0)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Apply the actions before the next scan."""
        self._apply_before(scan + 1)

    def _apply_before(self, scan: int) -> None:
        """Apply the pending actions before a scan. Add a sentence to `refused` for each that fails."""
        while self._next < len(self._orders) and self._orders[self._next].scan <= scan:
            number, order = self._orders[self._next]
            self._next += 1
            try:
                self._executor.act(order, number * self._cpu.period_ns, number)
            except ValueError as error:
                self.refused.append(f"the action before scan {number} is not repeated: {error}")
