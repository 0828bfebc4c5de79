"""The tap: the last listener of the scan loop. It fills the ring, and carries out orders after each scan."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from multiprocessing.connection import Connection
from typing import Protocol

from typing_extensions import override

from ..loop.events import JsonValue
from ..loop.listeners import QuietListener
from ..loop.pace import rest, wall_ns
from ..loop.rack import Rack
from .ring import ORDERS, REQUESTS, Ring
from .session import Session

FIGURES_NS = 10_000_000
"""Least time between two reads of the machines."""

FIGURES_SCANS = 2048
"""Least number of scans between them at full speed: a read ends the prediction of modules."""

BATCH_NS = 8_000_000
"""Time of a batch of scans at full speed: rows are written at once, and notes are taken at its end."""

LOOK = 16
"""Scans of a batch after which its time is checked, since they may have become slow."""


class Notes(Protocol):
    """The notes that a monitor needs to run a program's scans again."""

    def news(self) -> bool:
        """Whether the latest scan must be noted; called after every scan."""

    def note(self, scan: int) -> None:
        """Note the latest scan; called if `news` is true, and after some other scans."""

    def give(self, scan: int) -> None:
        """Write the values before a scan."""


class NoNotes:
    """A program that a monitor can't run again."""

    def news(self) -> bool:
        """Return False: there are no notes."""
        return False

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

    At full speed the rows of a batch of scans are written at once, and before any message. Orders are checked
    after every scan.

    Args:
        rack: its memory is copied after every scan.
        figures: numbers beside the images.
    """

    session: Session  # obeys orders after each scan; set before the first one

    def __init__(self, ring: Ring, rack: Rack, period_ns: int, figures: Figures) -> None:
        self._ring = ring
        self._copy, self._period_ns = memoryview(rack.memory).tobytes, period_ns
        self._figures = figures
        self.notes: Notes = NoNotes()
        self.lasting: Callable[[], Iterable[Mapping[str, object]]] = tuple  # messages for a new monitor
        self._latest: tuple[int, ...] = (0,) * ring.shape.figures
        self._due_ns = self._due = 0
        self._seen_requests = 0
        self._forces: Mapping[str, JsonValue] = {}
        self._images: list[bytes] = []  # the latest scans, whose rows are not written yet
        self._batch, self._begun_ns = 1, 0  # maximum scans of a batch, and when it began
        self._done, self._left = 0, 1  # scans of the batch up to the latest check, and until the next one
        self._scan, self._now_ns, self._flags = -1, 0, 0  # number, time and flags of the latest scan
        self._wall_ns = 0  # wall time of the latest written row
        self._rested = -1

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Pass an event on."""
        if topic == "/forces":
            self._forces = fields
        self.tell({"event": {"scan": scan, "t": now_ns, "topic": topic, **fields}})

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Pass a scan on, and carry out orders."""
        if flags != self._flags:
            self._write()
            self._flags = flags
        self._images.append(self._copy())
        self._scan, self._now_ns = scan, now_ns
        if self.notes.news():
            self.notes.note(scan)
        self._left -= 1
        if not self._left:
            self._look()
        session = self.session  # checked here, since another call would slow a scan by 1 %
        if session.inbox.pending() or session.takeovers or session.state.breakpoints:
            session.attend_scan(now_ns + self._period_ns, scan + 1)

    def _look(self) -> None:
        """End the batch if it is full or its time is over. Rows that a message has written count, too."""
        self._done += min(LOOK, self._batch - self._done)
        took_ns = wall_ns() - self._begun_ns
        is_paced = self.session.state.speed is not None
        if self._done >= self._batch or took_ns >= BATCH_NS or is_paced:
            self._end_batch()
            fitting = self._done * BATCH_NS // max(1, took_ns)
            self._batch = 1 if is_paced else max(1, min(2 * self._done, fitting, self._ring.at_once))
            self._begun_ns, self._done = wall_ns(), 0
        self._left = min(LOOK, self._batch - self._done)

    def _end_batch(self) -> None:
        """Write the rows of a batch, and the figures and notes that are due."""
        wall, scan = wall_ns(), self._scan
        if wall >= self._due_ns and (scan >= self._due or self.session.state.speed is not None):
            self._due_ns, self._due = wall + FIGURES_NS, scan + FIGURES_SCANS
            self._latest = self._figures.read(self._now_ns)
        self._write()
        self.notes.note(scan)
        if self._ring.head[REQUESTS] != self._seen_requests:
            self.give()

    def _write(self) -> None:
        """Write the rows of the scans since the last ones."""
        images, count, wall = self._images, len(self._images), wall_ns()
        took_ns, self._wall_ns = wall - self._wall_ns, wall
        row = self._scan, self._flags, self._now_ns, wall, self._latest
        if count == 1:
            self._ring.put(*row, images[0])
        elif count:
            step_ns = took_ns // count
            self._ring.put_all(*row, images, period_ns=self._period_ns, wall_step_ns=step_ns)
        images.clear()

    def attend(self) -> None:
        """Serve the monitor during a pause."""
        self._write()
        if self._rested != self._scan:  # present machines, for the picture of the pause
            self._rested = self._scan
            self._latest = self._figures.read(self._now_ns)
            self._images.append(self._copy())
            self._write()
            self.notes.give(self._scan + 1)
        if self._ring.head[REQUESTS] != self._seen_requests:
            self.give()

    def give(self) -> None:
        """Send the values before the next scan to the monitor."""
        if self._seen_requests != self._ring.head[REQUESTS]:
            for message in self.lasting():
                self.tell(message)
        self._seen_requests = self._ring.head[REQUESTS]
        self.notes.give(self._scan + 1)
        self.tell({"state": self.session.described()})
        self.tell({"forces": {"scan": self.session.scan, "forces": self._forces}})

    def tell(self, message: Mapping[str, object]) -> None:
        """Write a message to the monitor, after the rows of earlier scans; one that is too long is lost."""
        self._write()
        self._ring.messages.write(json.dumps(message, separators=(",", ":")).encode())

    @override
    def close(self) -> None:
        self._write()


class PipeInbox:
    """Orders from a pipe, counted in the ring."""

    def __init__(self, ring: Ring, pipe: Connection) -> None:
        self._head, self._pipe = ring.head, pipe
        self._taken = ring.head[ORDERS]

    def connect(self, pipe: Connection) -> None:
        """Continue with another pipe: the monitor has been restarted."""
        self._pipe = pipe

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


class NoInbox:
    """The orders of a session without a page: none."""

    def pending(self) -> bool:
        """Return False."""
        return False

    def take(self) -> bytes:
        """Raise an error: there are no orders."""
        raise ValueError("a session without a page has no orders")

    def wait(self, seconds: float) -> None:
        """Wait."""
        rest(seconds)
