"""`--server ethernet-ip`: starts the process of the tag server, and starts it again when it dies.

The scans are not affected: they find a request in shared memory, or none.
"""

from __future__ import annotations

import os
import pickle
import socket
import threading
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection

from ...io_images.enip.codes import PORT
from ...runtime.line.hosts import join_address, split_address
from ...runtime.live.mailbox import Mailbox
from ...runtime.live.tag_desk import NoTags, TagDesk
from ...runtime.live.tag_server import TagSetup
from ..load.loading import Job
from ..trust.launcher import Helper, TimeoutExpired, launch
from .running import JobRun

MAIN = "scanrack.runtime.live.tag_server:main"
PROTOCOL = "ethernet-ip"
HOST = "127.0.0.1"

LOGIX, SLC = "1769-L33ER scanrack", "1764-LRP"
"""Product names of a CompactLogix and of a MicroLogix."""

GRACE_S = 0.05
"""A server that ends within this time of the run is not started again."""

PATIENCE_S = 2
"""Longest time of a server to end."""

DEATHS_MOST = 10
"""Most restarts."""


@dataclass(frozen=True, slots=True)
class ServerAddress:
    """Where the server listens."""

    host: str = HOST
    port: int = PORT

    @classmethod
    def parse(cls, text: str) -> ServerAddress:
        """Return the address of `ethernet-ip[:[HOST:]PORT]`.

        >>> ServerAddress.parse("ethernet-ip:0")
        ServerAddress(host='127.0.0.1', port=0)

        Raises:
            ValueError: another protocol, or no address.
        """
        protocol, _, rest = text.partition(":")
        if protocol != PROTOCOL:
            raise ValueError(
                f"--server {text} is not allowed: {PROTOCOL}, {PROTOCOL}:PORT or {PROTOCOL}:HOST:PORT"
            )
        if not rest:
            return cls()
        try:
            host, port = split_address(rest)
        except ValueError as error:
            raise ValueError(f"--server {text}: {error}") from error
        return cls(host or HOST, port)

    @property
    def is_local(self) -> bool:
        """Whether only this machine reaches it."""
        return self.host in ("localhost", "::1") or self.host.startswith("127.")


class TagService:
    """A tag server for the runs of a command; it outlives branches.

    Args:
        writes: whether clients may write what the rack file lists.
        say: called with lines for the user.

    Raises:
        ValueError: the port can't be used.
    """

    def __init__(self, job: Job, where: ServerAddress, say: Callable[[str], object], *, writes: bool) -> None:
        self._say, self._writes, self._spec = say, writes, job.spec
        self._host = where.host
        self._listening, self._udp = _listen(where)
        self._mailbox = Mailbox()
        self._ending = threading.Event()
        self._changing = threading.Lock()
        self._setup: TagSetup | None = None
        self._waker: socket.socket | None = None
        self._their_waker: socket.socket | None = None
        self._pipe: Connection | None = None
        self._desk: TagDesk | None = None
        self._process: Helper

    @property
    def port(self) -> int:
        """The port in use."""
        port: int = self._listening.getsockname()[1]
        return port

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._process.pid

    @property
    def desk(self) -> TagDesk | None:
        """The desk of the present run; None before the first one."""
        return self._desk

    def said(self) -> list[str]:
        """Return the lines that tell of the server."""
        patterns = self._spec.server.writable if self._writes else ()
        there = join_address(self._host, self.port)
        can = f"clients write {', '.join(patterns)}" if patterns else "clients read"
        lines = [f"EtherNet/IP server on {there}: {can}"]
        if not ServerAddress(self._host).is_local:
            lines.append(
                "anyone who reaches this address reads all tags"
                + (" and writes the listed ones" if patterns else "")
                + ": the protocol has no password"
            )
        return lines

    def serve(self, run: JobRun) -> TagDesk:
        """Serve the tags of a run from now on; return its desk, which the caller adds to the listeners."""
        if self._waker is None:
            self._waker, self._their_waker = socket.socketpair()
        debugger = run.program.debugger
        desk = TagDesk(
            self._mailbox,
            self._waker,
            run.hands,
            run.rack,
            run.cpu.period_ns,
            lambda: NoTags() if run.program.debugger is None else run.program.debugger.images,
            writes=self._writes and bool(self._spec.server.writable),
            profile=self._spec.server.profile,
            version=1 if self._desk is None else self._desk.version + 1,
        )
        self._desk = desk
        if debugger is not None:
            debugger.on_edit = lambda _edit: self._renew(desk)
        self._offer(desk)
        return desk

    def _renew(self, desk: TagDesk) -> None:
        desk.renew()
        threading.Thread(target=self._offer, args=(desk,), daemon=True).start()

    def _offer(self, desk: TagDesk) -> None:
        """Send the tags of a desk to the server; start it the first time."""
        with self._changing:
            self._setup = TagSetup(
                desk.listing,
                desk.version,
                tuple(self._spec.server.writable) if self._writes else (),
                self._spec.name,
                SLC if desk.listing.files else LOGIX,
                _packed(self._listening.getsockname()[0]),
                self.port,
            )
            if self._pipe is None:
                self._start()
                threading.Thread(target=self._keep, name="tag server's keeper", daemon=True).start()
                return
            with suppress(OSError):  # it has died: the next one gets the new setup
                self._pipe.send_bytes(pickle.dumps(self._setup))

    def _start(self) -> None:
        assert self._their_waker is not None
        mine, theirs = socket.socketpair()
        sockets = (theirs, self._their_waker)
        given = (*(each.fileno() for each in sockets), self._mailbox.file)
        given += (self._listening.fileno(), self._udp.fileno())
        self._process = launch(MAIN, *given, pass_fds=given, own_session=True)
        theirs.close()
        self._pipe = Connection(mine.detach())
        with suppress(OSError):  # it has died at once: the keeper notices
            self._pipe.send_bytes(pickle.dumps(self._setup))

    def _keep(self) -> None:
        for _ in range(DEATHS_MOST):
            self._process.wait()
            if self._ending.wait(GRACE_S):
                return
            self._say("the EtherNet/IP server has died and is started again; the scans go on")
            with self._changing:
                if self._ending.is_set():
                    return
                assert self._pipe is not None
                self._pipe.close()
                self._start()
        self._process.wait()
        if not self._ending.wait(GRACE_S):
            self._say("the EtherNet/IP server has died too often: the scans go on without it")

    def end(self) -> None:
        """End the server."""
        self._ending.set()
        with self._changing:
            for each in (self._pipe, self._waker, self._their_waker):
                if each is not None:
                    each.close()
        if self._pipe is not None:
            try:
                self._process.wait(PATIENCE_S)
            except TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._listening.close()
        self._udp.close()


def _listen(where: ServerAddress) -> tuple[socket.socket, socket.socket]:
    """Listen for clients; ValueError if the port is in use, or not allowed."""
    with ExitStack() as opened:
        try:
            family = socket.AF_INET6 if ":" in where.host else socket.AF_INET
            listening = opened.enter_context(
                socket.create_server((where.host, where.port), family=family, backlog=64)
            )
            udp = opened.enter_context(socket.socket(family, socket.SOCK_DGRAM))
            udp.bind((where.host, listening.getsockname()[1]))
        except OSError as error:
            text = os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
            at = join_address(where.host, where.port)
            raise ValueError(f"--server {PROTOCOL}:{at}: {text}: choose another port") from error
        opened.pop_all()
    return listening, udp


def _packed(host: str) -> bytes:
    return socket.inet_aton(host) if ":" not in host else bytes(4)
