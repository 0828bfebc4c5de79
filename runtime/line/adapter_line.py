"""The line between an adapter and its controller; a simulated one can be disturbed.

drop_next     so many replies are lost; the controller has acted
corrupt_next  one bit is flipped in so many replies
down          nothing gets through in either direction, a frame in flight included
"""

from __future__ import annotations

from typing import Protocol

from typing_extensions import override

from .wire import Device, LineFormat, SerialBus


class Line(Protocol):
    """A line between an adapter and a controller, simulated or real."""

    def next_event_ns(self) -> int | None:
        """Return when something happens next on the line or behind it, None if nothing does."""

    def run_until(self, now_ns: int) -> None:
        """Let time run."""

    def take(self) -> bytes:
        """Return what has been received since the last call."""

    def send(self, data: bytes, line_format: LineFormat) -> None:
        """Send without waiting; receive in the same format from then on."""


class FaultyDevice:
    """A device whose line may fail.

    Attributes:
        drop_next: replies that will be lost.
        corrupt_next: replies that will be damaged.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self.drop_next = self.corrupt_next = 0
        self.down = False

    @property
    def line_format(self) -> LineFormat:
        """The device's."""
        return self.device.line_format

    @property
    def next_wake_ns(self) -> int | None:
        """The device's."""
        return self.device.next_wake_ns

    def receive(self, now_ns: int, data: bytes) -> None:
        """Pass data on unless the line is down."""
        if not self.down:
            self.device.receive(now_ns, data)

    def advance(self, now_ns: int) -> bytes:
        """Let time run; return the reply, lost or damaged as set."""
        data = self.device.advance(now_ns)
        if not data or self.down:
            return b""
        if self.drop_next:
            self.drop_next -= 1
            return b""
        if self.corrupt_next:
            self.corrupt_next -= 1
            return bytes((*data[:-1], data[-1] ^ 0x10))
        return data


class SimulatedLine(Line):
    """A line with one simulated controller."""

    def __init__(self, device: Device, now_ns: int = 0) -> None:
        self.faults = FaultyDevice(device)
        self._bus = SerialBus(self.faults, now_ns=now_ns)

    @override
    def next_event_ns(self) -> int | None:
        return self._bus.next_event_ns()

    @override
    def run_until(self, now_ns: int) -> None:
        self._bus.run_until(now_ns)

    @override
    def take(self) -> bytes:
        data = self._bus.take()
        return b"" if self.faults.down else data

    @override
    def send(self, data: bytes, line_format: LineFormat) -> None:
        self._bus.send(data, line_format)

    def take_down(self) -> None:
        """Cut the line; what is in flight is lost."""
        self.faults.down = True
        self.silence()

    def silence(self) -> None:
        """Lose what is in flight."""
        self._bus.silence()

    def put_up(self) -> None:
        """Mend the line."""
        self.faults.down = False
