"""Listeners of the scan loop: the recorder, a display, a user's own probe."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from typing import Protocol

from typing_extensions import override

from .events import Event, JsonValue
from .rack import Slot

TOPIC_OF_KIND = {"stimulus": "/stimuli", "indicator": "/indicators", "order": "/orders"}
"""Topics of the kinds of events; all others go to "/events"."""


class ScanListener(Protocol):
    """A listener of the scan loop. Within a scan it receives the events first, then the scan.

    The images are in the rack's memory block (`Rack.memory`). A listener receives that
    block when it is made; while `scan` runs, the block holds the scan's images.
    """

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Receive an event: anything but an image.

        Args:
            scan: number of the scan that reports it.
            now_ns: its time; times never decrease within a topic.
            topic: "/events", "/stimuli", "/indicators", "/forces", "/cpu", "/faults" or
                "/orders".
            fields: its values by name.
        """

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Receive a finished scan; its input and output images are in the rack's memory.

        Args:
            scan: its number, from 0.
            flags: flags of the CPU, see `runtime.loop.scan.ScanFlag`.
        """

    def close(self) -> None:
        """Finish. Called exactly once, as the last call."""


ROWS_AT_ONCE = 4096
"""Maximum scans that are passed on at once."""


class RowListener(ScanListener, Protocol):
    """A listener that can also receive many scans at once, while only the modules' inputs change.

    Such scans have no events, and the same outputs as the scan before them.
    """

    @property
    def look(self) -> Callable[[], bool] | None:
        """Return the function to call after the logic of each of these scans; None = no function.

        If that function returns true, the rows end, and this scan is passed on by itself.
        """

    def begin_rows(self, scan: int) -> int:
        """Return how many scans it can receive at once from number `scan` on; 0 = each by itself for now."""

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Receive finished scans, one or more, at most as many as `begin_rows` has returned.

        The rack's memory has the images of the last one.

        Args:
            scans: their numbers.
            times: their times, ns.
            flags: flags of the CPU, the same in all of them.
            images: the rack's memory in each.
        """


def by_rows(listener: ScanListener) -> RowListener | None:
    """Return a listener that can receive rows, None for others; faster than `isinstance`."""
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
        self.called_last: ScanListener | None = None  # an exception is attributed to it
        self._to_close = list(self.listeners)
        self._by_rows: list[RowListener] | None = None  # the same listeners; None = some can't receive rows
        self._sort()

    def _sort(self) -> None:
        receivers = [receiver for listener in self.listeners if (receiver := by_rows(listener)) is not None]
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
        """Return the functions to call after the logic of each scan by rows."""
        looks = [listener.look for listener in self._by_rows or ()]
        return [look for look in looks if look is not None]

    def begin_rows(self, scan: int) -> int:
        """Return how many scans all can receive at once from number `scan` on; 0 = each by itself."""
        if self._by_rows is None:
            return 0
        return min([ROWS_AT_ONCE, *(listener.begin_rows(scan) for listener in self._by_rows)])

    def rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> None:
        """Pass on successive finished scans."""
        for listener in self._by_rows or ():
            self.called_last = listener
            listener.rows(scans, times, flags, images)

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Pass on an event."""
        for listener in self.listeners:
            self.called_last = listener
            listener.event(scan, now_ns, topic, fields)

    def raised(self, scan: int, event: Event, **origin: int) -> None:
        """Pass on an event of a module, or of the CPU itself.

        Args:
            scan: number of the scan that reports it.
            origin: `slot`, the number of the module's slot.
        """
        own_fields = {"kind": event.kind, "name": event.name, "text": event.text}
        topic = TOPIC_OF_KIND.get(event.kind, "/events")
        self.event(scan, event.at_ns, topic, {**event.fields, **origin, **own_fields})

    def module_events(self, scan: int, slots: Iterable[Slot]) -> None:
        """Pass on the modules' events in order of time, and empty the modules' lists."""
        events = [(slot.number, event) for slot in slots for event in slot.module.events]
        for slot in slots:
            slot.module.events.clear()
        for number, event in sorted(events, key=lambda entry: entry[1].at_ns):
            self.raised(scan, event, slot=number)

    def dismiss(self, listener: ScanListener) -> None:
        """Close a listener and stop passing events to it; do nothing if it is closed."""
        if listener in self._to_close:
            self._to_close.remove(listener)
            self.listeners.remove(listener)
            self._sort()
            listener.close()

    def dismiss_present(self) -> None:
        """Pass nothing more to the listener called last; it is still closed at the end."""
        if self.called_last is not None:
            self.listeners.remove(self.called_last)

    def close(self) -> None:
        """Close every listener once, in order, even if one of them raises; then raise its error."""
        with ExitStack() as stack:
            while self._to_close:
                stack.callback(self._to_close.pop().close)
