"""Those who listen to a CPU, told in their order, and closed in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import ExitStack

from .events import JsonValue
from .listener import ScanListener
from .rack import Slot

TOPIC_OF_KIND = {"stimulus": "/stimuli", "indicator": "/indicators"}
"""Where events of a kind are told; others go to "/events"."""


class Audience:
    """The listeners of a CPU.

    Attributes:
        listeners: who is told, in this order.
        speaking_to: the listener told last; if that raised, it is the one to blame.
    """

    __slots__ = ("_to_close", "listeners", "speaking_to")

    def __init__(self, listeners: Iterable[ScanListener]) -> None:
        self.listeners = list(listeners)
        self.speaking_to: ScanListener | None = None
        self._to_close = list(self.listeners)

    def add(self, listener: ScanListener) -> None:
        """Tell a further listener from now on."""
        self.listeners.append(listener)
        self._to_close.append(listener)

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Tell that a scan is done."""
        for listener in self.listeners:
            self.speaking_to = listener
            listener.scan(scan, now_ns, flags)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Tell something that is not an image."""
        for listener in self.listeners:
            self.speaking_to = listener
            listener.event(scan, now_ns, topic, fields)

    def module_events(self, scan: int, slots: Iterable[Slot]) -> None:
        """Tell what the modules have to tell, in order of time, and empty their lists."""
        told = [(slot.number, event) for slot in slots for event in slot.module.events]
        for slot in slots:
            slot.module.events.clear()
        for number, event in sorted(told, key=lambda entry: entry[1].at_ns):
            topic = TOPIC_OF_KIND.get(event.kind, "/events")
            own: dict[str, JsonValue] = {
                "slot": number,
                "kind": event.kind,
                "name": event.name,
                "text": event.text,
            }
            self.event(scan, event.at_ns, topic, {**event.fields, **own})

    def dismiss_present(self) -> None:
        """Tell nothing further to the listener told last; it is still closed at the end."""
        if self.speaking_to is not None:
            self.listeners.remove(self.speaking_to)

    def close(self) -> None:
        """Close all listeners in order, each once, even if one of them raises; what it raised follows."""
        with ExitStack() as stack:
            while self._to_close:
                stack.callback(self._to_close.pop().close)
