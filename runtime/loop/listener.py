"""Who listens to the scan loop: the recorder first of all, a display, a user's own probe."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from .events import JsonValue


class ScanListener(Protocol):
    """What the scan loop tells its listeners, in this order within a scan: events, then the scan.

    The images themselves are in the rack's memory block (`Rack.memory`), which a
    listener is given when it is made and which holds the scan's images while
    `scan` is called.
    """

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Take notice of something that is not an image.

        Args:
            scan: number of the scan in which it became known.
            now_ns: when it happened; never before the event told last on the same topic.
            topic: "/events", "/stimuli", "/indicators", "/forces", "/cpu" or "/faults".
            fields: its values by name.
        """
        ...

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Take notice of a finished scan, its input and output images in the rack's memory.

        Args:
            scan: number of the scan, from 0.
            now_ns: virtual time of its input latch.
            flags: what the CPU was doing, see `runtime.loop.cpu.ScanFlag`.
        """
        ...

    def close(self) -> None:
        """Finish: nothing further will be told. Called once, in any case."""
        ...
