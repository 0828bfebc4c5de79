"""The tap, the last listener of the scan loop: it fills the ring, and carries out actions after each scan."""

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
"""Minimum time between two reads of the machines' figures, ns."""

FIGURES_SCANS = 2048
"""Minimum number of scans between two reads at full speed, since a read ends the prediction of modules."""

BATCH_NS = 8_000_000
"""Duration, ns, of a batch of scans at full speed. Rows and notes are written at the end of the batch."""

SCANS_PER_CHECK = 16
"""Number of scans between two checks of the batch's duration, since scans may have become slow."""


class Notes(Protocol):
    """The notes that a monitor needs, in addition to the rows, to rerun a program's scans."""

    def must_note(self) -> bool:
        """Whether `note` must be called for the latest scan; called after every scan."""

    def note(self, scan: int) -> None:
        """Note the latest scan; called if `must_note` is true, and after some other scans."""

    def send_values(self, scan: int) -> None:
        """Send the monitor the program's present values, which are those before the next scan, `scan`."""


class NoNotes(Notes):
    """The notes for a program that a monitor can't rerun."""

    @override
    def must_note(self) -> bool:
        return False

    @override
    def note(self, scan: int) -> None:
        return

    @override
    def send_values(self, scan: int) -> None:
        return


class Figures(Protocol):
    """Numbers of the machines, such as positions, in addition to the images."""

    def read(self, now_ns: int) -> tuple[int, ...]:
        """Return the figures at the instant of the latest scan."""


class Tap(QuietListener):
    """A listener of the scan loop that fills the ring and never raises an error.

    At full speed it writes the rows of a batch of scans at once, before any message. It checks for actions
    after every scan.

    Args:
        rack: the rack; its memory is copied after every scan.

    Attributes:
        session: carries out actions; set it before the first scan.
        notes: the notes of the program.
        lasting: function that returns the messages that a new monitor needs.
    """

    session: Session

    def __init__(self, ring: Ring, rack: Rack, period_ns: int, figures: Figures) -> None:
        self._ring = ring
        self._copy, self._period_ns = memoryview(rack.memory).tobytes, period_ns
        self._figures = figures
        self.notes: Notes = NoNotes()
        self.lasting: Callable[[], Iterable[Mapping[str, object]]] = tuple
        self._latest_figures: tuple[int, ...] = (0,) * ring.shape.figures
        self._figures_due_ns = self._figures_due_scan = 0  # earliest wall time and scan of the next read
        self._seen_requests = 0
        self._forces: Mapping[str, JsonValue] = {}
        self._images: list[bytes] = []  # of the latest scans, whose rows are not written yet
        self._batch, self._begun_ns = 1, 0  # maximum scans of a batch, and when it began
        self._checked_scans = 0  # scans of the batch up to the latest check
        self._scans_to_check = 1
        self._scan, self._now_ns, self._flags = -1, 0, 0  # number, time and flags of the latest scan
        self._wall_ns = 0  # wall time of the latest written row
        self._paused_scan = -1  # the latest scan for which `attend` has written the picture of a pause

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Send an event to the monitor."""
        if topic == "/forces":
            self._forces = fields
        self.send({"event": {"scan": scan, "t": now_ns, "topic": topic, **fields}})

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Add a scan to the batch, and carry out actions."""
        if flags != self._flags:
            self._write()
            self._flags = flags
        self._images.append(self._copy())
        self._scan, self._now_ns = scan, now_ns
        if self.notes.must_note():
            self.notes.note(scan)
        self._scans_to_check -= 1
        if not self._scans_to_check:
            self._check_batch()
        session = self.session  # checked here, since another call would slow a scan by 1 %
        if session.inbox.pending() or session.takeovers or session.state.breakpoints:
            session.attend_scan(now_ns + self._period_ns, scan + 1)

    def _check_batch(self) -> None:
        """End the batch if it is full or its time is up, and choose the size of the next one."""
        self._checked_scans += min(SCANS_PER_CHECK, self._batch - self._checked_scans)
        took_ns = wall_ns() - self._begun_ns
        is_paced = self.session.state.speed is not None
        if self._checked_scans >= self._batch or took_ns >= BATCH_NS or is_paced:
            self._end_batch()
            fitting = self._checked_scans * BATCH_NS // max(1, took_ns)
            self._batch = 1 if is_paced else max(1, min(2 * self._checked_scans, fitting, self._ring.at_once))
            self._begun_ns, self._checked_scans = wall_ns(), 0
        self._scans_to_check = min(SCANS_PER_CHECK, self._batch - self._checked_scans)

    def _end_batch(self) -> None:
        """Write a batch's rows, and the figures and notes that are due."""
        wall, scan, is_paced = wall_ns(), self._scan, self.session.state.speed is not None
        if wall >= self._figures_due_ns and (scan >= self._figures_due_scan or is_paced):
            self._figures_due_ns, self._figures_due_scan = wall + FIGURES_NS, scan + FIGURES_SCANS
            self._latest_figures = self._figures.read(self._now_ns)
        self._write()
        self.notes.note(scan)
        if self._ring.head[REQUESTS] != self._seen_requests:
            self.send_values()

    def _write(self) -> None:
        """Write the rows of the scans whose rows have not been written yet."""
        images, count, wall = self._images, len(self._images), wall_ns()
        took_ns, self._wall_ns = wall - self._wall_ns, wall
        row = self._scan, self._flags, self._now_ns, wall, self._latest_figures
        if count == 1:
            self._ring.put(*row, images[0])
        elif count:
            step_ns = took_ns // count
            self._ring.put_all(*row, images, period_ns=self._period_ns, wall_step_ns=step_ns)
        images.clear()

    def attend(self) -> None:
        """Serve the monitor during a pause."""
        self._write()
        if self._paused_scan != self._scan:  # read the machines again, for the picture of the pause
            self._paused_scan = self._scan
            self._latest_figures = self._figures.read(self._now_ns)
            self._images.append(self._copy())
            self._write()
            self.notes.send_values(self._scan + 1)
        if self._ring.head[REQUESTS] != self._seen_requests:
            self.send_values()

    def send_values(self) -> None:
        """Send the values before the next scan, the state and the forces to the monitor."""
        if self._seen_requests != self._ring.head[REQUESTS]:
            for message in self.lasting():
                self.send(message)
        self._seen_requests = self._ring.head[REQUESTS]
        self.notes.send_values(self._scan + 1)
        self.send({"state": self.session.described()})
        self.send({"forces": {"scan": self.session.scan, "forces": self._forces}})

    def send(self, message: Mapping[str, object]) -> None:
        """Send a message to the monitor, after the rows of earlier scans; an overlong message is lost."""
        self._write()
        self._ring.messages.write(json.dumps(message, separators=(",", ":")).encode())

    @override
    def close(self) -> None:
        self._write()


class PipeInbox:
    """Actions from a pipe. The ring has the number of actions, which is faster to check than the pipe."""

    def __init__(self, ring: Ring, pipe: Connection) -> None:
        self._head, self._pipe = ring.head, pipe
        self._taken_count = ring.head[ORDERS]

    def connect(self, pipe: Connection) -> None:
        """Continue with the pipe of a restarted monitor."""
        self._pipe = pipe

    def pending(self) -> bool:
        """Whether an action is waiting."""
        return self._head[ORDERS] != self._taken_count

    def take(self) -> bytes:
        """Return the next action; raise ValueError if the monitor died before sending it."""
        self._taken_count += 1
        try:
            if self._pipe.poll(0):
                return self._pipe.recv_bytes()
        except (EOFError, OSError):
            pass
        raise ValueError("the monitor ended before it sent an action")

    def wait(self, seconds: float) -> None:
        """Wait for an action, at most `seconds`."""
        try:
            self._pipe.poll(seconds)
        except (EOFError, OSError):
            rest(seconds)


class NoInbox:
    """The empty queue of a session without a page."""

    def pending(self) -> bool:
        """Return False."""
        return False

    def take(self) -> bytes:
        """Raise an error, since the queue is empty."""
        raise ValueError("a session without a page has no actions")

    def wait(self, seconds: float) -> None:
        """Wait for `seconds`."""
        rest(seconds)
