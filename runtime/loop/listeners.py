"""Listeners of the scan loop, such as a recorder, a display or a user's probe."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from typing import Protocol

from typing_extensions import override

from .events import Event, JsonValue
from .rack import Slot

TOPIC_OF_KIND = {"stimulus": "/stimuli", "indicator": "/indicators", "order": "/orders"}
"""Topics by kind of event; all other events go to "/events"."""


class ScanListener(Protocol):
    """A listener of the scan loop. Within a scan it receives the events first, then the scan.

    The images are in the rack's memory (`Rack.memory`), which a listener receives when it is created. While
    `scan` is running, the memory contains the scan's images.
    """

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Receive an event, or any other change that is not in an image.

        Args:
            scan: number of the scan that reports it.
            now_ns: time of the event; times never decrease within a topic.
            topic: "/events", "/stimuli", "/indicators", "/forces", "/cpu", "/faults" or
                "/orders".
            fields: values by name.
        """

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Receive a finished scan; its input and output images are in the rack's memory.

        Args:
            scan: its number, from 0.
            flags: flags of the CPU, see `runtime.loop.scan.ScanFlag`.
        """

    def close(self) -> None:
        """Finish. This is called exactly once, as the last call."""


ROWS_AT_ONCE = 4096
"""Maximum number of scans that are passed on together."""


class RowListener(ScanListener, Protocol):
    """A listener that can also receive many scans together, while only the modules' inputs change.

    These scans have no events. Their outputs are the same as in the previous scan.
    """

    @property
    def look(self) -> Callable[[], bool] | None:
        """The function to call after the logic of each of these scans; None = no function.

        If the function returns true, this scan ends the rows and is passed on separately.
        """

    def begin_rows(self, scan: int) -> int:
        """Return how many scans from number `scan` on it can receive together; 0 = only separately."""

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Receive one or more finished scans, at most as many as `begin_rows` has returned.

        The rack's memory contains the images of the last scan.

        Args:
            scans: numbers of the scans.
            times: times of the scans, ns.
            flags: flags of the CPU, the same in all scans.
            images: the rack's memory in each scan.
        """


def by_rows(listener: ScanListener) -> RowListener | None:
    """Return the listener if it can receive rows, otherwise None; faster than `isinstance`."""
    return listener if hasattr(listener, "begin_rows") else None  # type: ignore[return-value]


class QuietListener(ScanListener):
    """A listener that does nothing; subclasses override the methods that they need."""

    @override
    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        pass

    @override
    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        pass

    @override
    def close(self) -> None:
        pass


class Listeners:
    """The listeners of a CPU."""

    __slots__ = ("_by_rows", "_to_close", "called_last", "listeners")

    def __init__(self, listeners: Iterable[ScanListener]) -> None:
        self.listeners = list(listeners)  # listeners that receive events and scans, in order
        self.called_last: ScanListener | None = None  # the origin of an exception
        self._to_close = list(self.listeners)
        self._by_rows: list[RowListener] | None = None  # all listeners; None if one can't receive rows
        self._sort()

    def _sort(self) -> None:
        """Determine whether all listeners can receive rows."""
        receivers = [listener for listener in map(by_rows, self.listeners) if listener is not None]
        self._by_rows = receivers if len(receivers) == len(self.listeners) else None

    def add(self, listener: ScanListener) -> None:
        """Add a listener."""
        self.listeners.append(listener)
        self._to_close.append(listener)
        self._sort()

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Pass on a finished scan."""
        for listener in self.listeners:
            self.called_last = listener
            listener.scan(scan, now_ns, flags)

    @property
    def looks(self) -> list[Callable[[], bool]]:
        """The functions to call after the logic in each scan by rows."""
        looks = [listener.look for listener in self._by_rows or ()]
        return [look for look in looks if look is not None]

    def begin_rows(self, scan: int) -> int:
        """Return how many scans from number `scan` on all can receive together; 0 = only separately."""
        if self._by_rows is None:
            return 0
        return min([ROWS_AT_ONCE, *(listener.begin_rows(scan) for listener in self._by_rows)])

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Pass on successive finished scans together."""
        for listener in self._by_rows or ():
            self.called_last = listener
            listener.rows(scans, times, flags, images)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Pass on an event."""
        for listener in self.listeners:
            self.called_last = listener
            listener.event(scan, now_ns, topic, fields)

    def raised(self, scan: int, event: Event, **origin: int) -> None:
        """Pass on an event from a module, the CPU or the program.

        Args:
            scan: number of the scan that reports it.
            origin: `slot`, the number of the module's slot, or nothing.
        """
        own_fields = {"kind": event.kind, "name": event.name, "text": event.text}
        topic = TOPIC_OF_KIND.get(event.kind, "/events")
        self.event(scan, event.at_ns, topic, {**event.fields, **origin, **own_fields})

    def module_events(self, scan: int, slots: Iterable[Slot]) -> None:
        """Pass on the modules' events in chronological order, and clear the modules' lists."""
        events = [(slot.number, event) for slot in slots for event in slot.module.events]
        for slot in slots:
            slot.module.events.clear()
        for number, event in sorted(events, key=lambda entry: entry[1].at_ns):
            self.raised(scan, event, slot=number)

    def dismiss(self, listener: ScanListener) -> None:
        """Remove a listener and close it; do nothing if it is already closed."""
        if listener in self._to_close:
            self._to_close.remove(listener)
            self.listeners.remove(listener)
            self._sort()
            listener.close()

    def dismiss_present(self) -> None:
        """Stop passing anything to the listener that was called most recently; `close` still closes it."""
        if self.called_last is not None:
            self.listeners.remove(self.called_last)

    def close(self) -> None:
        """Close every listener once, in order; raise an error only after all of them are closed."""
        with ExitStack() as stack:
            while self._to_close:
                stack.callback(self._to_close.pop().close)
