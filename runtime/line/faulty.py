"""A device whose replies are late, lost or damaged on purpose.

    drop=3       the next three replies are lost, after the device has acted
    crc=1/10     the last of every ten replies is damaged
    delay=200    each reply comes 200 ms later, until delay=0
    silence=on   the device receives and sends nothing until silence=off, as on a cut line
    reset        the device loses its power and gets it back

A reply is what a device sends at one instant. Its last byte belongs to the checksum of a Modbus or
PMC006 frame; in AA ASCII it is the end of the line.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from typing_extensions import override

from .wire import ControllerDevice, Device, LineFormat

MOST_REPLIES = 1_000_000
LONGEST_DELAY_MS = 60_000
DAMAGE = 0xFF
"""The bits of a damaged reply's last byte that change."""

_HITS = re.compile(r"([0-9]{1,7})(?:/([0-9]{1,7}))?", re.ASCII)
ALLOWED = "drop=N, drop=N/M, crc=N, crc=N/M, delay=MS, silence=on, silence=off and reset"


@dataclass(slots=True)
class Hits:
    """The replies that a fault affects: the next `count`, or the last `count` of every `of`."""

    count: int = 0
    of: int = 0
    _seen: int = 0

    def next(self) -> bool:
        """Count a reply; return whether the fault affects it."""
        if self.of:
            self._seen = self._seen % self.of + 1
            return self._seen > self.of - self.count
        self.count -= (is_hit := self.count > 0)
        return is_hit


def hits_of(value: str) -> Hits:
    """Parse the replies that a fault affects, such as `3` or `1/10`.

    Raises:
        ValueError: it is neither, or the first number is greater than the second.
    """
    match = _HITS.fullmatch(value)
    count, total = (int(match[1]), int(match[2] or 0)) if match else (-1, 0)
    is_whole = match is not None and (match[2] is None or 1 <= count <= total)
    if not is_whole or max(count, total) > MOST_REPLIES:
        raise ValueError(f"{value!r} is no number of replies: must be N, or N/M for N of every M")
    return Hits(count, total)


class FaultInjector(Device):
    """A device on a line with faults on request; without faults it behaves as the device.

    Args:
        device: the device on the line.
        turnaround_ns: returns the silence between a request and its reply, ns; a delay adds to it.
    """

    def __init__(self, device: ControllerDevice, turnaround_ns: Callable[[], int] = lambda: 0) -> None:
        self._device = device
        self._turnaround_ns = turnaround_ns
        self._drop, self._crc = Hits(), Hits()
        self._delay_ns = 0
        self._silent = False
        self._waiting: deque[tuple[int, bytes, LineFormat]] = deque()
        self._format: LineFormat | None = None
        self._now_ns = 0

    @property
    def line_format(self) -> LineFormat:
        """The format of the reply that was sent last, or else of the device."""
        return self._format or self._device.line_format

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the device's next event, or of a reply that waits."""
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
            self._wait(now_ns, reply)
        self._format = None
        due = b""
        while self._waiting and self._waiting[0][0] <= now_ns:
            _, data, self._format = self._waiting.popleft()
            due += data
        return due

    def set(self, text: str) -> None:
        """Set or end a fault, in the notation above.

        Raises:
            ValueError: it is not a fault.
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

    def _wait(self, now_ns: int, reply: bytes) -> None:
        """Queue a reply until it is due; replies stay in order."""
        due_ns = now_ns + self._turnaround_ns() + self._delay_ns
        if self._waiting:
            due_ns = max(due_ns, self._waiting[-1][0])
        damaged = reply[:-1] + bytes((reply[-1] ^ DAMAGE,)) if self._crc.next() else reply
        self._waiting.append((due_ns, damaged, self._device.line_format))


def _delay_ms(value: str) -> int:
    if not (value.isascii() and value.isdecimal() and int(value[:9]) <= LONGEST_DELAY_MS):
        raise ValueError(f"delay={value}: must be 0 to {LONGEST_DELAY_MS:,} ms")
    return int(value)
