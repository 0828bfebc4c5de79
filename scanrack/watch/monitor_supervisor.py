"""The supervisor of the monitor process, which restarts the monitor if it dies while scans continue."""

from __future__ import annotations

import pickle
import socket
import threading
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection

from scanrack.jobs.trust.launcher import TimeoutExpired, launch
from scanrack.runtime.live.ring import REQUESTS, Ring
from scanrack.runtime.live.tap import PipeInbox
from scanrack.runtime.loop.pace import wall_ns

from .monitors.session_monitor import Setup
from .monitors.stretched import SessionProgram

MAIN = f"{__package__}.session_process:main"
"""Main function of a monitor process. The user's main module is not imported, since it may have side effects.
"""

PATIENCE_S = 2
"""Time limit for a monitor to end, s."""

GRACE_S = 0.05
"""Time to wait for the end of the session before restarting a monitor, s."""

STARTS_MOST = 10
"""Maximum number of restarts in a row."""

SOON_NS = 30_000_000_000
"""Lifetime of a monitor after which its death starts a new count of restarts, ns."""

PAUSES_S = (0, 0.2, 1, 3)
"""Delays before a restart, by number of deaths in a row, s. The last one applies to all later deaths."""


class MonitorSupervisor:
    """The supervisor of a monitor.

    Args:
        setup: the data about the session that a monitor needs.
        listening: the server's socket, which all monitors use in turn.
        report: prints a message.

    Attributes:
        pipe: the connection to the present monitor.
    """

    def __init__(
        self, setup: Setup, ring: Ring, listening: socket.socket, report: Callable[[str], object]
    ) -> None:
        self._setup, self._ring, self._listening, self._report = setup, ring, listening, report
        self._ending = threading.Event()
        self._died = False  # whether any monitor has died
        self._changing = threading.Lock()  # for `_setup`, which two threads change
        self._inbox: PipeInbox | None = None
        self.pipe = self._start()
        self._thread = threading.Thread(
            target=self._restart_when_dead, name="monitor's supervisor", daemon=True
        )

    def watch(self, inbox: PipeInbox) -> None:
        """Begin to restart the monitor whenever it dies, and connect each monitor to the queue of actions."""
        self._inbox = inbox
        self._thread.start()

    def replace_programs(
        self, *, programs: tuple[SessionProgram, ...], trace: str | None = None, record: str | None = None
    ) -> None:
        """Set the programs and the recording for later monitors.

        Args:
            trace: path of a branch's recording; None = unchanged.
            record: the same path if the user keeps the recording, otherwise None.
        """
        with self._changing:
            self._setup = replace(self._setup, programs=programs)
            if trace is not None:
                facts = replace(self._setup.about, record=record)
                self._setup = replace(self._setup, about=facts, trace=trace)

    @property
    def pid(self) -> int:
        """Process ID of the monitor."""
        return self._process.pid

    def _start(self) -> Connection:
        """Start a monitor process and send it its setup; return the connection to it."""
        own_socket, child_socket = socket.socketpair()
        # its own session: Ctrl-C must only reach the scan process, which ends the monitor
        self._process = launch(
            MAIN, handed=(child_socket, self._listening, self._ring.memory), own_session=True
        )
        child_socket.close()
        pipe = Connection(own_socket.detach())
        pipe.send_bytes(pickle.dumps(self._setup))
        return pipe

    def _restart_when_dead(self) -> None:
        """Restart the monitor whenever it dies, until `end` or until it has died too often."""
        deaths = 0
        while True:
            begun_ns = wall_ns()
            self._process.wait()
            if self._ending.wait(GRACE_S):
                return
            self._died = True
            deaths = 1 if wall_ns() - begun_ns > SOON_NS else deaths + 1
            if deaths > STARTS_MOST:
                self._report("the monitor has died too often; the scans continue without a page until Ctrl-C")
                return
            self._report("the monitor has died and is started again; the scans continue")
            if self._ending.wait(PAUSES_S[min(deaths, len(PAUSES_S)) - 1]):
                return
            with self._changing:
                self._setup = replace(self._setup, started=self._setup.started + 1)
            self.pipe.close()
            self.pipe = self._start()
            assert self._inbox is not None
            self._inbox.connect(self.pipe)

    def end(self) -> bool:
        """End the monitor; return False if every monitor died before its first scan."""
        self._ending.set()
        self.pipe.close()  # the monitor notices this
        try:
            self._died |= self._process.wait(PATIENCE_S) != 0
        except TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._listening.close()
        return not self._died or self._ring.head[REQUESTS] > 0


class NoMonitor:
    """The supervisor of a session without a page."""

    def replace_programs(self, **_changed: object) -> None:
        """Do nothing."""

    def end(self) -> bool:
        """Return True, since no monitor has died."""
        return True
