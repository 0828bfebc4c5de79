"""A network between a master and a device, in virtual time, which delivers whole segments after a delay."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from .wire import Device, LineFormat

TRAVEL_NS = 250_000
"""Delay of a segment, including the network stacks at both ends."""


class _Segment(NamedTuple):
    arrival_ns: int
    data: bytes


class SegmentBus:
    """A connection between a master and one device."""

    def __init__(self, device: Device, now_ns: int = 0) -> None:
        self.device = device
        self.now_ns = now_ns
        self._to_device: deque[_Segment] = deque()
        self._to_master: deque[_Segment] = deque()
        self._heard = bytearray()

    def send(self, data: bytes, line_format: LineFormat) -> None:
        """Send as the master, starting now."""
        self._to_device.append(_Segment(self.now_ns + TRAVEL_NS, data))

    def take(self) -> bytes:
        """Return the bytes that the master has received since the last call."""
        data = bytes(self._heard)
        self._heard.clear()
        return data

    def silence(self) -> None:
        """Drop all segments in transit, and all received bytes that have not been taken."""
        self._to_device.clear()
        self._to_master.clear()
        self._heard.clear()

    def run_until(self, until_ns: int) -> None:
        """Advance through all arrivals up to and including `until_ns`."""
        while (due_ns := self.next_event_ns()) is not None and due_ns <= until_ns:
            self._step(due_ns)
        self.now_ns = max(self.now_ns, until_ns)

    def next_event_ns(self) -> int | None:
        """Return the instant of the next arrival or wake-up, or None."""
        instants = [segments[0].arrival_ns for segments in (self._to_device, self._to_master) if segments]
        wake_ns = self.device.next_wake_ns
        if wake_ns is not None:
            instants.append(wake_ns)
        return max(min(instants), self.now_ns) if instants else None

    def _step(self, now_ns: int) -> None:
        """Deliver the segments that arrive at `now_ns`; send the device's bytes."""
        self.now_ns = now_ns
        while self._to_device and self._to_device[0].arrival_ns <= now_ns:
            self.device.receive(now_ns, self._to_device.popleft().data)
        while self._to_master and self._to_master[0].arrival_ns <= now_ns:
            self._heard += self._to_master.popleft().data
        data = self.device.advance(now_ns)
        if data:
            self._to_master.append(_Segment(now_ns + TRAVEL_NS, data))
