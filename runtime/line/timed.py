"""A line on which characters take time, connected to a port that delivers bytes instantly.

client  |request, at once                      reply, character by character|
line       |s|d d d ...|  3.5 characters  |s|d d d ...
"""

from __future__ import annotations

from typing_extensions import override

from .wire import Device, LineFormat, SerialBus


class TimedLine(Device):
    """Units on a line, as one device; requests and replies pass at the speed of the line.

    Args:
        units: one or more, with the same line format.
    """

    def __init__(self, *units: Device) -> None:
        self._units = units
        self._bus = SerialBus(*units)

    @property
    def line_format(self) -> LineFormat:
        """The format of the units."""
        return self._units[0].line_format

    @property
    def next_wake_ns(self) -> int | None:
        """Instant of the next whole character, or of a unit's next event."""
        return self._bus.next_event_ns()

    @override
    def receive(self, now_ns: int, data: bytes) -> None:
        self._bus.run_until(now_ns)
        self._bus.send(data, self.line_format)

    @override
    def advance(self, now_ns: int) -> bytes:
        """Return the characters that have arrived."""
        self._bus.run_until(now_ns)
        return self._bus.take()
