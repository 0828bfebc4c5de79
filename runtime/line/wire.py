"""The serial line: characters that take time, in virtual time.

    sender     |s|d d d d d d d d|p|s|s|d d d ...      11 bits of 8E1 at 38,400 baud: 286.46 µs
                                     ^ here the receiver has the character

A device on the line is a state machine without I/O (`Device`): it receives characters, reports the instant of
its next event, and returns the bytes to send. The `SerialBus` carries characters between devices and a master
and delivers each one when it is complete.

The bus is ideal: overlapping characters from two senders arrive intact.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heappop, heappush
from typing import NamedTuple, Protocol

NS_PER_S = 1_000_000_000
PARITIES = ("N", "E", "O")


@dataclass(frozen=True, slots=True)
class LineFormat:
    """Speed and character format of a serial line.

    >>> LineFormat(38_400, "E").span_ns(1)  # the PCL601's t_char, about 286.5 µs
    286458
    >>> LineFormat(9600).span_ns(8)  # a frame of a PMC006
    8333333

    Raises:
        ValueError: a value is invalid.
    """

    baud: int  # bits per second, from 1
    parity: str = "N"
    stop_bits: int = 1
    data_bits: int = 8

    def __post_init__(self) -> None:
        if self.baud < 1:
            raise ValueError(f"baud {self.baud}: must be 1 or more")
        if self.parity not in PARITIES:
            raise ValueError(f"parity {self.parity!r}; choose from {', '.join(PARITIES)}")
        if self.stop_bits not in (1, 2) or self.data_bits not in (7, 8):
            raise ValueError(
                f"{self.data_bits} data bits and {self.stop_bits} stop bits: "
                "must be 7 or 8 data bits and 1 or 2 stop bits"
            )

    @property
    def bits(self) -> int:
        """Number of bits per character, including the start bit."""
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits

    def span_ns(self, characters: int) -> int:
        """Return the time that a number of successive characters takes, in ns, rounded down."""
        return characters * self.bits * NS_PER_S // self.baud

    def __str__(self) -> str:
        return f"{self.baud} {self.data_bits}{self.parity}{self.stop_bits}"


class Device(Protocol):
    """A participant on a serial line, which never raises an error."""

    @property
    def line_format(self) -> LineFormat:
        """The current format of its characters."""

    @property
    def next_wake_ns(self) -> int | None:
        """The latest instant for the next `advance`, or None while the device is waiting for a request."""

    def receive(self, now_ns: int, data: bytes) -> None:
        """Receive characters without gaps; the last one is complete at `now_ns`.

        The caller calls `advance(now_ns)` first. The characters may set `next_wake_ns` to `now_ns`.
        """

    def advance(self, now_ns: int) -> bytes:
        """Advance to `now_ns`; return the bytes to send at that instant.

        The result must not depend on the number of calls. A call later than `next_wake_ns` only delays
        sending.
        """


class ControllerDevice(Device, Protocol):
    """A controller on a serial line."""

    @property
    def turnaround_ns(self) -> int:
        """Silence between a request and its reply, at the line's speed, ns."""

    @property
    def motor_position(self) -> int:
        """Physical position of the motor, steps."""

    @property
    def motor_turns(self) -> bool:
        """Whether a motion is in progress."""

    def power_cycle(self, now_ns: int) -> None:
        """Cycle the power."""


class _Character(NamedTuple):
    """A character in transit; `order` is its position in the order of sending."""

    complete_ns: int
    order: int
    sender: int
    value: int


MASTER = -1


class SerialBus:
    """A line with one master and any number of devices.

    Attributes:
        heard: bytes that the master has received but not yet taken.
        quiet_since_ns: end of the last character, or None before the first one.
    """

    def __init__(self, *devices: Device, now_ns: int = 0) -> None:
        self.devices = devices
        self.now_ns = now_ns
        self.heard = bytearray()
        self.quiet_since_ns: int | None = None
        self._in_transit: list[_Character] = []  # a heap
        self._order = 0
        self._free_ns = dict.fromkeys(range(MASTER, len(devices)), now_ns)  # end of sending, by sender

    @property
    def is_idle(self) -> bool:
        """Whether no character is in transit."""
        return not self._in_transit

    def send(self, data: bytes, line_format: LineFormat, gap_ns: int = 0) -> int:
        """Send as the master, starting now; return the instant at which the last character is complete."""
        return self._enqueue(MASTER, data, line_format, gap_ns)

    def take(self) -> bytes:
        """Return the bytes that the master has received since the last call."""
        data = bytes(self.heard)
        self.heard.clear()
        return data

    def silence(self) -> None:
        """Drop all characters in transit, and all received characters that have not been taken."""
        self._in_transit.clear()
        self.heard.clear()

    def run_until(self, until_ns: int) -> None:
        """Advance through all characters and wake-ups up to and including `until_ns`."""
        while (due_ns := self.next_event_ns()) is not None and due_ns <= until_ns:
            self._step(due_ns)
        if until_ns > self.now_ns:
            self._step(until_ns)

    def next_event_ns(self) -> int | None:
        """Return the instant of the next complete character or wake-up, or None."""
        due_ns = self._in_transit[0].complete_ns if self._in_transit else None
        for device in self.devices:
            wake_ns = device.next_wake_ns
            if wake_ns is not None and (due_ns is None or wake_ns < due_ns):
                due_ns = wake_ns
        return self.now_ns if due_ns is not None and due_ns < self.now_ns else due_ns

    def _step(self, now_ns: int) -> None:
        """Advance all devices to `now_ns`, and deliver the characters that are complete."""
        self.now_ns = now_ns
        for index in range(len(self.devices)):
            self._advance(index)
        while self._in_transit and self._in_transit[0].complete_ns <= now_ns:
            self._deliver(heappop(self._in_transit))

    def _deliver(self, character: _Character) -> None:
        """Pass a character to everyone except its sender."""
        self.quiet_since_ns = character.complete_ns
        data = bytes((character.value,))
        if character.sender != MASTER:
            self.heard += data
        for index, device in enumerate(self.devices):
            if index != character.sender:
                device.receive(self.now_ns, data)

    def _advance(self, index: int) -> None:
        """Advance a device to the current instant, and queue what it sends."""
        device = self.devices[index]
        data = device.advance(self.now_ns)
        if data:
            self._enqueue(index, data, device.line_format, 0)

    def _enqueue(self, sender: int, data: bytes, line_format: LineFormat, gap_ns: int) -> int:
        """Queue characters after the sender's earlier ones; return the end of the last character."""
        start_ns = max(self.now_ns, self._free_ns[sender])
        complete_ns = start_ns
        for count, value in enumerate(data):
            complete_ns = start_ns + line_format.span_ns(count + 1) + count * gap_ns
            self._order += 1
            heappush(self._in_transit, _Character(complete_ns, self._order, sender, value))
        self._free_ns[sender] = complete_ns
        return complete_ns
