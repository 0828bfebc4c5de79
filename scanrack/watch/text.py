"""`scanrack watch --text`: mode, words and events in the terminal, for machines without a browser."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text
from scanrack.runtime.live.session import Session
from scanrack.runtime.loop.events import JsonValue
from scanrack.runtime.loop.pace import AdjustablePace
from scanrack.runtime.loop.rack import Rack, Slot
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, ScanFlag, mode_name
from scanrack.terminal.terminal import on_a_line
from scanrack.traces.read.number_formats import NumberFormats

HZ = 4
EVENTS = 8
"""Number of events on the screen, the latest last."""


class TextView:
    """A listener that shows a session in the terminal without delaying the scan loop."""

    def __init__(self, name: str, rack: Rack, session: Session, pacer: AdjustablePace) -> None:
        self._name, self._rack, self._session, self._pacer = name, rack, session, pacer
        self._formats = NumberFormats()
        self._events: deque[str] = deque(maxlen=EVENTS)
        self._scan = self._now_ns = self._flags = 0
        self._live = Live(console=Console(stderr=True), get_renderable=self.shown, refresh_per_second=HZ)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Keep an event for the picture."""
        self._formats.note(scan, fields)
        text = str(fields.get("text") or f"{topic} {dict(fields)}")
        self._events.append(on_a_line(f"{scan:>9,}  {now_ns / 1e9:>9.3f} s  {text}"))

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Keep a scan for the picture."""
        self._scan, self._now_ns, self._flags = scan, now_ns, flags

    def close(self) -> None:
        """Stop showing the session."""
        self._live.stop()

    def begin(self) -> None:
        """Start showing the session."""
        self._live.start()

    def shown(self) -> RenderableType:
        """Return the current picture."""
        slots = [self._slot(slot) for slot in self._rack.slots.values()]
        events = Text("\n".join(self._events) or "no events yet")
        return Group(self._head(), *slots, events)

    def _head(self) -> Text:
        """Return the line above the slots: mode, speed, scan and time, late scans, forces and fault."""
        state = self._session.state
        mode = mode_name(CpuMode(self._flags & MODE_MASK))
        speed = "max" if state.speed is None else f"{state.speed:g}x"
        parts = [
            on_a_line(self._name),
            "PAUSED" if state.paused else f"{mode} {speed}",
            f"scan {self._scan:,}",
            f"{self._now_ns / 1e9:.3f} s",
            f"{sum(self._pacer.late[1:]):,} late",
        ]
        if self._flags & (ScanFlag.INPUT_FORCES | ScanFlag.OUTPUT_FORCES | ScanFlag.TAGS_FROM_OUTSIDE):
            parts.append("FORCED")
        if state.fault:
            parts.append(f"FAULT: {on_a_line(state.fault)}")
        return Text("  ".join(parts), style="bold")

    def _slot(self, slot: Slot) -> RenderableType:
        """Return a table of a slot's words with the names of bits that are on, and its position."""
        table = Table(title=f"slot {slot.number}  {slot.catalog}", title_justify="left", box=None)
        table.add_column("", width=4)
        columns = max(len(slot.inputs), len(slot.outputs))
        for word in range(columns):
            table.add_column(str(word), justify="right", min_width=6)
        table.add_column("on")
        for letter, image in (("I", slot.inputs), ("O", slot.outputs)):
            words = list(image)
            blank = [""] * (columns - len(words))
            table.add_row(letter, *map(str, words), *blank, ", ".join(_names_on(slot, letter, words)))
        position, inputs = slot.words.quantity("position"), list(slot.inputs)
        if position is not None and not slot.words.configures("I", inputs):
            value = self._formats.value(slot.number, self._scan, position, inputs)
            table.add_row("", *[""] * columns, f"position {value:,}")
        return table


def _names_on(slot: Slot, image: str, words: list[int]) -> list[str]:
    """Return the names of the bits of an image, "I" or "O", that are on."""
    return [
        name
        for word, value in enumerate(words)
        for name, bit in slot.words.bits(image, word)
        if value >> bit & 1
    ]
