"""The line between an adapter and its device; a simulated line can be disturbed.

drop_next     number of replies that will be lost, after the device has acted
corrupt_next  number of replies that will have one flipped bit
down          no byte passes in either direction, not even the rest of a frame in transit
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from typing_extensions import override

from .wire import Device, LineFormat, SerialBus


class Line(Protocol):
    """A line between an adapter and a device, simulated or real."""

    def next_event_ns(self) -> int | None:
        """Return the instant of the next event on the line or in the device, or None."""

    def run_until(self, now_ns: int) -> None:
        """Advance to `now_ns`."""

    def take(self) -> bytes:
        """Return the bytes received since the last call."""

    def send(self, data: bytes, line_format: LineFormat) -> None:
        """Send without waiting, and receive in the same format."""


class FaultyDevice:
    """A device on a line that can fail; the attributes are described above."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.drop_next = self.corrupt_next = 0
        self.down = False

    @property
    def line_format(self) -> LineFormat:
        """The format of the device."""
        return self.device.line_format

    @property
    def next_wake_ns(self) -> int | None:
        """The instant of the device's next wake-up."""
        return self.device.next_wake_ns

    def receive(self, now_ns: int, data: bytes) -> None:
        """Pass data to the device, unless the line is down."""
        if not self.down:
            self.device.receive(now_ns, data)

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the reply, dropped or damaged as configured."""
        data = self.device.advance(now_ns)
        if not data or self.down:
            return b""
        if self.drop_next:
            self.drop_next -= 1
            return b""
        if self.corrupt_next:
            self.corrupt_next -= 1
            return self.damaged(data)
        return data

    def damaged(self, data: bytes) -> bytes:
        """Return a reply with one flipped bit."""
        return bytes((*data[:-1], data[-1] ^ 0x10))


class Bus(Protocol):
    """A transport for bytes in virtual time."""

    def next_event_ns(self) -> int | None:
        """Return the instant of the next event, or None."""

    def run_until(self, until_ns: int) -> None:
        """Advance through all events up to and including `until_ns`."""

    def take(self) -> bytes:
        """Return the bytes that the master has received since the last call."""

    def send(self, data: bytes, line_format: LineFormat) -> object:
        """Send as the master, starting now."""

    def silence(self) -> None:
        """Drop all bytes in transit, and all received bytes that have not been taken."""


class SimulatedLine(Line):
    """A line with one simulated device.

    Args:
        faults: the device, with the faults of its line.
        bus: function that creates the transport for the bytes.
    """

    def __init__(self, faults: FaultyDevice, bus: Callable[[FaultyDevice], Bus] = SerialBus) -> None:
        self.faults = faults
        self._bus = bus(faults)

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
        """Cut the line; bytes in transit are lost."""
        self.faults.down = True
        self.silence()

    def silence(self) -> None:
        """Drop the bytes in transit."""
        self._bus.silence()

    def put_up(self) -> None:
        """Repair the line."""
        self.faults.down = False
