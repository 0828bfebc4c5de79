"""Several units on one RS485 line: each hears the master and every other unit.

    master   |request|
    unit 1             |reply|
    unit 2   |request|  |reply|  quiet |    a unit does not hear its own characters

A port delivers a frame at once. Bytes of the master that arrive while a unit still
sends therefore wait until the line is quiet: on the real line they would have been complete
after the reply, not on top of it.
"""

from __future__ import annotations

from collections import deque

from typing_extensions import override

from ..wire import Device, LineFormat

QUIET_CHARACTERS = 5
"""Silence after a unit has sent, in characters: more than the 3.5 that end a Modbus frame."""


class BusSegment(Device):
    """A line with several units, as one device.

    Args:
        units: at least one, in the order of their addresses.
        quiet_ns: silence after a unit has sent, ns; None = `QUIET_CHARACTERS` at the line's speed.
    """

    def __init__(self, *units: Device, quiet_ns: int | None = None) -> None:
        self.units = units
        self._quiet_ns = quiet_ns
        self._free_ns = 0
        self._waiting: deque[bytes] = deque()

    @property
    def line_format(self) -> LineFormat:
        """The format of the first unit; all units of a line have the same."""
        return self.units[0].line_format

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next wake-up of a unit, or of the end of a wait for silence."""
        times = [wake_ns for unit in self.units if (wake_ns := unit.next_wake_ns) is not None]
        if self._waiting:
            times.append(self._free_ns)
        return min(times, default=None)

    @override
    def receive(self, now_ns: int, data: bytes) -> None:
        if now_ns < self._free_ns or self._waiting:
            self._waiting.append(data)
        else:
            self._deliver(now_ns, data)

    @override
    def advance(self, now_ns: int) -> bytes:
        """Return the bytes that the units have put on the line."""
        sent_bytes = b""
        while (wake_ns := self.next_wake_ns) is not None and wake_ns <= now_ns:
            sent_bytes += self._step(wake_ns)
        return sent_bytes + self._step(now_ns)

    def _step(self, now_ns: int) -> bytes:
        if self._waiting and now_ns >= self._free_ns:
            self._deliver(now_ns, self._waiting.popleft())
        return b"".join(self._advance_unit(unit, now_ns) for unit in self.units)

    def _advance_unit(self, unit: Device, now_ns: int) -> bytes:
        """Advance a unit, and deliver its bytes to the others."""
        sent_bytes = unit.advance(now_ns)
        if sent_bytes:
            span_ns = unit.line_format.span_ns(QUIET_CHARACTERS) if self._quiet_ns is None else self._quiet_ns
            self._free_ns = now_ns + span_ns
            self._deliver(now_ns, sent_bytes, unit)
        return sent_bytes

    def _deliver(self, now_ns: int, data: bytes, but: Device | None = None) -> None:
        for unit in self.units:
            if unit is not but:
                unit.receive(now_ns, data)
