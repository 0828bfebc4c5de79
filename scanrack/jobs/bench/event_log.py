"""The events of the rack on a bench."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.listeners import QuietListener


@dataclass(frozen=True, slots=True)
class BenchEvent:
    """An event of `bench.events`.

    Attributes:
        scan: number of the scan that reported it.
        now_ns: time of the event, ns since power-up.
        slot: slot number of the module; 0 for the CPU.
        kind: "rule", "move", "stimulus", "indicator", or the topic of an event of the CPU.
        name: the rule's id, the move's kind, the input's name; the topic for the CPU.
        text: description of the event.
    """

    scan: int
    now_ns: int
    slot: int
    kind: str
    name: str
    text: str

    def __str__(self) -> str:
        source = f"slot {self.slot}" if self.slot else "CPU"
        return f"scan {self.scan:,}, {seconds(self.now_ns)} s, {source}: {self.text}"


class EventLog(QuietListener):
    """A listener that stores events, and ends a run.

    Attributes:
        events: the events, oldest first.
        is_over: called after every scan; the run ends if it returns true.
        cpu: the CPU to stop.
    """

    def __init__(self) -> None:
        self.events: list[BenchEvent] = []
        self.is_over: Callable[[], object] = bool
        self.cpu: Cpu

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Store an event."""
        slot = fields.get("slot", 0)
        text = fields.get("text", ", ".join(f"{key} {value}" for key, value in fields.items()))
        kind = str(fields.get("kind", topic.strip("/")))
        name = str(fields.get("name", kind))
        self.events.append(
            BenchEvent(scan, now_ns, slot if isinstance(slot, int) else 0, kind, name, str(text))
        )

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Stop the CPU if the run is over."""
        if self.is_over():
            self.cpu.stop()
