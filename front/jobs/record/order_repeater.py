"""The orders of a recorded session, given again before the same scans."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...runtime.live.hands import GivenOrder, Hands
from ...runtime.live.orders import RECORDED, order_of, parsed
from ...runtime.loop.cpu import Cpu
from ...runtime.loop.listeners import QuietListener
from ...traces.format.topics import ORDERS
from ...traces.read.reader import Trace, TraceEvent

RecordedOrder = GivenOrder
"""An order in a recording."""


def is_session(trace: Trace) -> bool:
    """Return whether a trace is of a session."""
    return any(channel.topic == ORDERS.name for channel in trace.head.channels.values())


def orders_of(events: Iterable[TraceEvent]) -> list[RecordedOrder]:
    """Return the orders among the events of a recorded session; ValueError if one of them can't be read."""
    found = []
    for event in events:
        if event.topic == ORDERS.name:
            try:
                order = order_of(parsed(str(event.fields.get("order"))), RECORDED)
            except ValueError as error:
                says = f"the order before scan {event.scan} can't be given again: {error}"
                raise ValueError(says) from error
            found.append(RecordedOrder(event.scan, order))
    return found


class OrderRepeater(QuietListener):
    """Gives recorded orders again; the last listener of the scan loop.

    Args:
        hands: carries them out.
    """

    def __init__(self, cpu: Cpu, hands: Hands, orders: Iterable[RecordedOrder]) -> None:
        self._cpu, self._hands = cpu, hands
        self._orders: Sequence[RecordedOrder] = sorted(orders, key=lambda each: each.scan)
        self._next = 0
        self.refused: list[str] = []  # orders that could not be carried out, as sentences

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
