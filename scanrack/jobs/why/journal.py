"""Stores the scans of a bench, so that they can be explained later."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.runtime.loop.rack import Rack
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.packed import NotedScans
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import PackedTrace


class Journal(QuietListener):
    """A listener that stores all scans, packed into a few bytes each."""

    def __init__(self, rack: Rack) -> None:
        self._memory = rack.memory
        self._slots = tuple(
            SlotInfo(slot.number, slot.catalog, slot.firmware, slot.words) for slot in rack.slots.values()
        )
        self._scans = NotedScans(rack.layout.words)
        self._events: list[TraceEvent] = []

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Store an event."""
        self._events.append(TraceEvent(scan, now_ns, topic, dict(fields)))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Store a scan."""
        self._scans.add(scan, now_ns, flags, self._memory)

    def recording(self) -> PackedTrace:
        """Return all scans so far; raise ValueError before the first scan."""
        if not len(self._scans):
            raise ValueError("no scans yet")
        return PackedTrace(self._slots, self._scans.packed(), tuple(self._events))
