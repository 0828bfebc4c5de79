"""The tap: the last listener of the scan loop. It fills the ring, and carries out orders after each scan."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from multiprocessing.connection import Connection
from typing import Protocol

from ..loop.events import JsonValue
from ..loop.listeners import QuietListener
from ..loop.pace import rest, wall_ns
from ..loop.rack import Rack
from .ring import ASKED, ORDERS, Ring
from .session import Session

FIGURES_NS = 10_000_000
"""Least time between two reads of the machines."""

FIGURES_SCANS = 512
"""Least number of scans between them at full speed: a read ends the prediction of modules."""


class Notes(Protocol):
    """The notes that a monitor needs to run a program's scans again."""

    def note(self, scan: int) -> None:
        """Write the inputs of a scan; called after it."""

    def give(self, scan: int) -> None:
        """Write the values before a scan."""


class NoNotes:
    """A program that a monitor can't run again."""

    def note(self, scan: int) -> None:
        """Do nothing: there are no notes."""

    def give(self, scan: int) -> None:
        """Do nothing: there are no values."""


class Figures(Protocol):
    """Numbers of the machines, beside the images."""

    def read(self, now_ns: int) -> tuple[int, ...]:
        """Return them at the instant of the latest scan."""


class Tap(QuietListener):
    """Fills the ring; a listener of the scan loop that never raises.

    Args:
        rack: its memory is copied after every scan.
        figures: numbers beside the images.
    """

    session: Session  # obeys orders after each scan; set before the first one

    def __init__(self, ring: Ring, rack: Rack, period_ns: int, figures: Figures) -> None:
        self._ring, self._put, self._head = ring, ring.put, ring.head
        self._memory, self._period_ns = rack.memory, period_ns
        self._figures = figures
        self.notes: Notes = NoNotes()
        self.lasting: Callable[[], Iterable[Mapping[str, object]]] = tuple  # messages for a new monitor
        self._latest: tuple[int, ...] = (0,) * ring.shape.figures
        self._due_ns = self._due = 0
        self._seen_asked = self._next = 0
        self._forces: Mapping[str, JsonValue] = {}
        self._last: tuple[int, int, int] | None = None

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Pass an event on."""
        if topic == "/forces":
            self._forces = fields
        self.tell({"event": {"scan": scan, "t": now_ns, "topic": topic, **fields}})

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Pass a scan on, and carry out orders."""
        wall = wall_ns()
        if wall >= self._due_ns and (scan >= self._due or self.session.state.speed is not None):
            self._due_ns, self._due = wall + FIGURES_NS, scan + FIGURES_SCANS
            self._latest = self._figures.read(now_ns)
        self._put(scan, flags, now_ns, wall, self._latest, self._memory)
        self.notes.note(scan)
        if self._head[ASKED] != self._seen_asked:
            self._give(scan + 1)
        self._next = scan + 1
        self._last = scan, now_ns, flags
        self.session.attend_scan(now_ns + self._period_ns, scan + 1)

    def attend(self) -> None:
        """Serve the monitor during a pause."""
        if self._last is not None:  # present machines, for the picture of the pause
            scan, now_ns, flags = self._last
            self._last = None
            self._latest = self._figures.read(now_ns)
            self._ring.put(scan, flags, now_ns, wall_ns(), self._latest, self._memory)
            self.notes.give(scan + 1)
        if self._ring.asked != self._seen_asked:
            self.give()

    def give(self) -> None:
        """Send the values before the next scan to the monitor."""
        self._give(self._next)

    def _give(self, scan: int) -> None:
        if self._seen_asked != self._ring.asked:
            for message in self.lasting():
                self.tell(message)
        self._seen_asked = self._ring.asked
        self.notes.give(scan)
        self.tell({"state": self.session.described()})
        self.tell({"forces": {"scan": self.session.scan, "forces": self._forces}})

    def tell(self, message: Mapping[str, object]) -> None:
        """Write a message to the monitor; one that is too long is lost."""
        self._ring.messages.write(json.dumps(message, separators=(",", ":")).encode())


class PipeInbox:
    """Orders from a pipe, counted in the ring."""

    def __init__(self, ring: Ring, pipe: Connection) -> None:
        self._head, self._pipe = ring.head, pipe
        self._taken = ring.orders

    def connect(self, pipe: Connection) -> None:
        """Continue with another pipe: the monitor has been restarted."""
        self._pipe = pipe

    @property
    def pending(self) -> bool:
        """Whether an order is there."""
        return self._head[ORDERS] != self._taken

    def take(self) -> bytes:
        """Return the next order; ValueError if the monitor died before it could send it."""
        self._taken += 1
        try:
            if self._pipe.poll(0):
                return self._pipe.recv_bytes()
        except (EOFError, OSError):
            pass
        raise ValueError("the monitor has gone before its order came")

    def wait(self, seconds: float) -> None:
        """Wait for an order."""
        try:
            self._pipe.poll(seconds)
        except (EOFError, OSError):
            rest(seconds)
