"""A device with late, lost or damaged replies, for tests.

    drop=3       the next three replies are lost, after the device has acted
    crc=1/10     the last of every ten replies is damaged
    delay=200    each reply comes 200 ms later, until delay=0
    silence=on   the device receives and sends nothing until silence=off, as on a cut line
    reset        the device's power is cycled

A reply is all bytes that a device sends at one instant. A fault damages the last byte, which belongs to the
checksum of a Modbus or PMC006 frame, or to the line end in AA ASCII.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from typing_extensions import override

from .wire import ControllerDevice, Device, LineFormat

REPLIES_MAX = 1_000_000
DELAY_MAX_MS = 60_000
DAMAGE = 0xFF
"""Mask of the bits that are flipped in the last byte of a damaged reply."""

_HITS = re.compile(r"([0-9]{1,7})(?:/([0-9]{1,7}))?", re.ASCII)
ALLOWED = "drop=N, drop=N/M, crc=N, crc=N/M, delay=MS, silence=on, silence=off and reset"


@dataclass(slots=True)
class Hits:
    """The replies that a fault affects: the next `count`, or the last `count` of every `period` replies."""

    count: int = 0
    period: int = 0  # 0 for the next `count` replies
    _position: int = 0  # replies so far in the present period

    def next(self) -> bool:
        """Count a reply; return whether the fault affects it."""
        if self.period:
            self._position = self._position % self.period + 1
            return self._position > self.period - self.count
        if self.count == 0:
            return False
        self.count -= 1
        return True


def hits_of(value: str) -> Hits:
    """Parse which replies a fault affects, as in `3` or `1/10`.

    Raises:
        ValueError: the text has another form, or the first number is greater than the second.
    """
    match = _HITS.fullmatch(value)
    count, period = (int(match[1]), int(match[2] or 0)) if match else (-1, 0)
    is_valid = match is not None and (match[2] is None or 1 <= count <= period)
    if not is_valid or max(count, period) > REPLIES_MAX:
        raise ValueError(f"{value!r} is not a number of replies: must be N, or N/M for N of every M")
    return Hits(count, period)


class FaultInjector(Device):
    """A device on a line with faults on request; without faults it behaves like the bare device.

    Args:
        device: the device on the line.
        turnaround_ns: function that returns the silence between a request and its reply, ns; a delay is added
            to it.
    """

    def __init__(self, device: ControllerDevice, turnaround_ns: Callable[[], int] = lambda: 0) -> None:
        self._device = device
        self._turnaround_ns = turnaround_ns
        self._drop, self._crc = Hits(), Hits()
        self._delay_ns = 0
        self._silent = False
        self._waiting: deque[tuple[int, bytes, LineFormat]] = deque()  # instant, reply, format
        self._format: LineFormat | None = None
        self._now_ns = 0

    @property
    def line_format(self) -> LineFormat:
        """The format of the last reply; before the first reply, the device's format."""
        return self._format or self._device.line_format

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the device's next event, or the instant at which a waiting reply is due."""
        due_ns = self._device.next_wake_ns
        if not self._waiting:
            return due_ns
        return self._waiting[0][0] if due_ns is None else min(due_ns, self._waiting[0][0])

    @override
    def receive(self, now_ns: int, data: bytes) -> None:
        if not self._silent:
            self._device.receive(now_ns, data)

    @override
    def advance(self, now_ns: int) -> bytes:
        """Advance the device; return the replies that are due."""
        self._now_ns = now_ns
        reply = self._device.advance(now_ns)
        if reply and not self._silent and not self._drop.next():
            self._queue_reply(now_ns, reply)
        self._format = None
        due = b""
        while self._waiting and self._waiting[0][0] <= now_ns:
            _, data, self._format = self._waiting.popleft()
            due += data
        return due

    def set(self, text: str) -> None:
        """Set or end a fault, in the notation above.

        Raises:
            ValueError: the text is not a fault.
        """
        name, _, value = text.partition("=")
        if text == "reset":
            self._device.power_cycle(self._now_ns)
            self._waiting.clear()
        elif name == "drop":
            self._drop = hits_of(value)
        elif name == "crc":
            self._crc = hits_of(value)
        elif name == "delay":
            self._delay_ns = _delay_ms(value) * 1_000_000
        elif name == "silence" and value in ("on", "off"):
            self._silent = value == "on"
            self._waiting.clear()
        else:
            raise ValueError(f"{text!r} is not a fault; choose from {ALLOWED}")

    def _queue_reply(self, now_ns: int, reply: bytes) -> None:
        """Queue a reply until it is due; replies stay in order."""
        due_ns = now_ns + self._turnaround_ns() + self._delay_ns
        if self._waiting:
            due_ns = max(due_ns, self._waiting[-1][0])
        damaged = reply[:-1] + bytes((reply[-1] ^ DAMAGE,)) if self._crc.next() else reply
        self._waiting.append((due_ns, damaged, self._device.line_format))


def _delay_ms(value: str) -> int:
    """Return the delay of a reply, ms; raise a ValueError if it is not a number or is too long."""
    if not (value.isascii() and value.isdecimal() and int(value[:9]) <= DELAY_MAX_MS):
        raise ValueError(f"delay={value}: must be 0 to {DELAY_MAX_MS:,} ms")
    return int(value)
