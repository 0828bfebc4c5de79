"""Several units on one RS485 line; each unit hears the master and all other units.

    master   |request|
    unit 1             |reply|
    unit 2   |request|  |reply|  quiet |    a unit does not hear its own characters

A port delivers a whole frame at once, so the master's bytes can arrive while a unit is still sending. These
bytes wait until the line is quiet, since on a real line they would follow the reply.
"""

from __future__ import annotations

from collections import deque

from typing_extensions import override

from ..wire import Device, LineFormat

QUIET_CHARACTERS = 5
"""Silence after a unit's bytes, in characters; 3.5 characters end a Modbus frame."""


class BusSegment(Device):
    """A line with several units, as one device.

    Args:
        units: one or more with the same line format, in the order of their addresses.
        quiet_ns: silence after a unit's bytes, ns; None for `QUIET_CHARACTERS` at the line's speed.
    """

    def __init__(self, *units: Device, quiet_ns: int | None = None) -> None:
        self.units = units
        self._quiet_ns = quiet_ns
        self._free_ns = 0
        self._waiting: deque[bytes] = deque()

    @property
    def line_format(self) -> LineFormat:
        """The format of the units."""
        return self.units[0].line_format

    @property
    def next_wake_ns(self) -> int | None:
        """Instant at which a unit next wakes up or a wait for silence ends."""
        instants = [wake_ns for unit in self.units if (wake_ns := unit.next_wake_ns) is not None]
        if self._waiting:
            instants.append(self._free_ns)
        return min(instants, default=None)

    @override
    def receive(self, now_ns: int, data: bytes) -> None:
        if now_ns < self._free_ns or self._waiting:
            self._waiting.append(data)
        else:
            self._deliver(now_ns, data)

    @override
    def advance(self, now_ns: int) -> bytes:
        """Return the bytes that the units have sent."""
        sent_bytes = b""
        while (wake_ns := self.next_wake_ns) is not None and wake_ns <= now_ns:
            sent_bytes += self._step(wake_ns)
        return sent_bytes + self._step(now_ns)

    def _step(self, now_ns: int) -> bytes:
        if self._waiting and now_ns >= self._free_ns:
            self._deliver(now_ns, self._waiting.popleft())
        return b"".join(self._advance_unit(unit, now_ns) for unit in self.units)

    def _advance_unit(self, unit: Device, now_ns: int) -> bytes:
        """Advance a unit, deliver its bytes to the other units, and return the bytes."""
        sent_bytes = unit.advance(now_ns)
        if sent_bytes:
            span_ns = unit.line_format.span_ns(QUIET_CHARACTERS) if self._quiet_ns is None else self._quiet_ns
            self._free_ns = now_ns + span_ns
            self._deliver(now_ns, sent_bytes, unit)
        return sent_bytes

    def _deliver(self, now_ns: int, data: bytes, sender: Device | None = None) -> None:
        for unit in self.units:
            if unit is not sender:
                unit.receive(now_ns, data)
