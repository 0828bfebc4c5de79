"""The processes of tag servers; a process that dies or hangs is restarted.

The scans do not wait for a server: they only check shared memory for a request.
"""

from __future__ import annotations

import pickle
import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection

from scanrack.io_images.enip.listing import Listing
from scanrack.runtime.line.hosts import join_address
from scanrack.runtime.live.mailbox import Mailbox
from scanrack.runtime.live.tag_desk import NoTags, TagDesk
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.nearest import unknown_patterns
from scanrack.runtime.tag_servers.register_map import RegisterMap
from scanrack.runtime.tag_servers.setup import MODBUS_TCP, OPC_UA, TagSetup
from scanrack.runtime.tag_servers.ua_security import UaSecurity
from scanrack.runtime.tag_servers.variables import VARIABLES_MOST, TagTree

from ...load.loading import LoadedRack
from ...trust.launcher import Handed, Helper, TimeoutExpired, launch
from ..running import JobRun
from .kinds import ServerAddress
from .offered import listing_of_job
from .ua_files import CERTIFICATE, FOLDER, TRUSTED, thumbprint, ua_security

LOGIX, SLC = "1769-L33ER scanrack", "1764-LRP"
"""Product names of a CompactLogix and of a MicroLogix."""

GRACE_S = 0.05
"""A server is not restarted if it ends within this time before the end of the run, s."""

PATIENCE_S = 2
"""Maximum time to wait for a server to end, s."""

DEATHS_MOST = 10
"""Maximum number of restarts."""

BEAT_S, STILL_MOST = 1.0, 10
"""Interval of heartbeat checks, s, and number of checks without a heartbeat after which a server is hung."""


class TagService:
    """A tag server for all runs of a command, including branches.

    Args:
        writes: whether clients may write what the rack file lists.
        say: called with lines for the user.

    Raises:
        ValueError: the port can't be used, or the rack file names tags that the program lacks.
    """

    def __init__(
        self, job: LoadedRack, address: ServerAddress, say: Callable[[str], object], *, writes: bool
    ) -> None:
        if address.kind.maps and job.spec.server.modbus is None:
            raise ValueError(f"--server {address.protocol}: the rack file has no [{address.kind.maps}]")
        self._say, self._writes, self._spec = say, writes, job.spec
        self._address, self._title = address, address.kind.title
        listing = listing_of_job(job)
        if problems := _problems(job, listing, address.protocol):
            raise ValueError("; ".join(problems))
        self._job = job
        self._security = ua_security(job.folder, address.host, address.users) if address.encrypted else None
        self._sockets = address.listen()
        if address.protocol == OPC_UA and TagTree(Database(listing)).is_long:
            say(f"{self._title} clients see the first {VARIABLES_MOST:,} variables only")
        self._mailbox = Mailbox()
        self._ending = threading.Event()
        self._died = False  # whether a process of the server has died
        self._changing = threading.Lock()  # while the process and its pipe are replaced
        self._setup: TagSetup | None = None
        # two ends of a connection, by which the desk wakes the server
        self._waker: socket.socket | None = None
        self._their_waker: socket.socket | None = None
        self._pipe: Connection | None = None  # sends setups to the server; None before its start
        self._desk: TagDesk | None = None
        self._process: Helper

    @property
    def port(self) -> int:
        """The port that is in use."""
        port: int = self._sockets[0].getsockname()[1]
        return port

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._process.pid

    @property
    def desk(self) -> TagDesk | None:
        """The desk of the current run; None before the first run."""
        return self._desk

    def describe(self) -> list[str]:
        """Return lines about the server: its address, and who can read and write."""
        writable = self._spec.server.writable
        own_address = join_address(self._address.host, self.port)
        access = f"clients write {', '.join(writable)}"
        if not writable:
            access = "clients read; [server] writable lists nothing to write"
        elif not self._writes:
            access = "clients read; with --live only watch --allow-writes lets them write"
        lines = [f"{self._title} server on {own_address}: {access}"]
        if self._security is not None:
            lines.append(_security_line(self._security))
        if not (self._address.is_local or (self._security is not None and self._security.users)):
            lines.append(self._warning(writes=self._writes and bool(writable)))
        return lines

    def _warning(self, *, writes: bool) -> str:
        """Return a sentence about who can reach the tags without a password."""
        is_trusting = self._security is not None and self._security.trusted is not None
        readers = "each trusted client" if is_trusting else "anyone who reaches this address"
        tags = f"all {'mapped ' if self._address.kind.maps else ''}tags"
        also = " and writes the listed ones" if writes else ""
        return f"{readers} reads {tags}{also}: the server asks for no password"

    def serve(self, run: JobRun) -> TagDesk:
        """Serve the tags of a run; return its desk, which is a listener of the run."""
        if self._waker is None:
            self._waker, self._their_waker = socket.socketpair()
        desk = TagDesk(
            self._mailbox,
            self._waker,
            run.hands,
            run.rack,
            run.cpu.period_ns,
            tags=lambda: NoTags() if run.program.debugger is None else run.program.debugger.images,
            writes=self._writes and bool(self._spec.server.writable),
            profile=self._spec.server.profile,
            version=1 if self._desk is None else self._desk.version + 1,
        )
        setup = self._setup_of(desk.listing, desk.version)
        self._desk = desk
        run.cpu.add_listener(desk)
        self._send_setup(setup)
        return desk

    def renew(self) -> None:
        """Serve the tags of an edited program."""
        assert self._desk is not None
        self._desk.renew()
        setup = self._setup_of(self._desk.listing, self._desk.version)
        for problem in _problems(self._job, self._desk.listing, self._address.protocol):
            self._say(problem)
        threading.Thread(target=self._send_setup, args=(setup,), daemon=True).start()

    def _setup_of(self, listing: Listing, version: int) -> TagSetup:
        """Return the tags and settings to send to the server."""
        server = self._spec.server
        return TagSetup(
            listing,
            version,
            writable=tuple(server.writable) if self._writes else (),
            name=self._spec.name,
            product=SLC if listing.files else LOGIX,
            address=_packed_address(self._sockets[0].getsockname()[0]),
            port=self.port,
            protocol=self._address.protocol,
            modbus=server.modbus,
            ua_security=self._security,
        )

    def _send_setup(self, setup: TagSetup) -> None:
        """Send tags to the server; start it if this is the first time."""
        with self._changing:
            self._setup = setup
            if self._pipe is None:
                self._start()
                threading.Thread(target=self._keep_alive, name="tag server's keeper", daemon=True).start()
                return
            with suppress(OSError):  # it has died; the next server gets the new setup
                self._pipe.send_bytes(pickle.dumps(self._setup))

    def _start(self) -> None:
        """Start a server process with the sockets and the shared memory, and send it the current setup."""
        assert self._their_waker is not None
        own_end, server_end = socket.socketpair()
        handed: list[Handed] = [server_end, self._their_waker, self._mailbox.memory, *self._sockets]
        self._process = launch(self._address.kind.main, handed=handed, own_session=True)
        server_end.close()
        self._pipe = Connection(own_end.detach())
        with suppress(OSError):  # it has died at once, which the keeper notices
            self._pipe.send_bytes(pickle.dumps(self._setup))

    def _keep_alive(self) -> None:
        """Restart the server when its process ends, at most `DEATHS_MOST` times, until `end` is called."""
        for _ in range(DEATHS_MOST):
            end = self._wait_for_end()
            if self._ending.wait(GRACE_S):
                return
            self._died = True
            self._say(f"the {self._title} server {end} and is restarted; the scans continue")
            with self._changing:
                if self._ending.is_set():
                    return
                assert self._pipe is not None
                self._pipe.close()
                self._start()
        self._process.wait()
        if not self._ending.wait(GRACE_S):
            self._say(f"the {self._title} server died too often: the scans continue without it")

    def _wait_for_end(self) -> str:
        """Wait until the server has ended, and end it if it hangs; return a verb for how it ended."""
        first_beats = last_beats = self._mailbox.beats
        still = 0
        while True:
            try:
                self._process.wait(BEAT_S)
            except TimeoutExpired:
                beats = self._mailbox.beats
                # a server that has not begun yet, or waits for the scans, does not hang
                still = still + 1 if beats == last_beats and not self._mailbox.has_request else 0
                if still >= STILL_MOST and beats != first_beats:
                    self._process.kill()
                    self._process.wait()
                    return "hung"
                last_beats = beats
            else:
                return "died"

    def end(self) -> bool:
        """End the server; return False if every process died before it served anything."""
        self._ending.set()
        with self._changing:
            for resource in (self._pipe, self._waker, self._their_waker):
                if resource is not None:
                    resource.close()
        if self._pipe is not None:
            try:
                self._died |= self._process.wait(PATIENCE_S) != 0
            except TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for resource in self._sockets:
            resource.close()
        return not self._died or self._mailbox.beats > 0


class TagServices:
    """The tag servers of a command.

    Args:
        writes: whether clients may write what the rack file lists.
        say: called with lines for the user.

    Raises:
        ValueError: a port can't be used, or the rack file lacks data that a server needs.
    """

    def __init__(
        self,
        job: LoadedRack,
        addresses: Sequence[ServerAddress],
        say: Callable[[str], object],
        *,
        writes: bool,
    ) -> None:
        self._services: list[TagService] = []
        with ExitStack() as opened:
            for address in addresses:
                self._services.append(TagService(job, address, say, writes=writes))
                opened.callback(self._services[-1].end)
            opened.pop_all()  # keep all servers, since none has failed
        for service in self._services:
            for line in service.describe():
                say(line)

    def serve(self, run: JobRun) -> list[TagDesk]:
        """Serve the tags of a run; return the desks, which are listeners of the run."""
        desks = [service.serve(run) for service in self._services]
        if run.program.debugger is not None and desks:
            run.program.debugger.on_edit = lambda _edit: self._renew()
        return desks

    def _renew(self) -> None:
        for service in self._services:
            service.renew()

    def rest(self, rests: bool) -> None:
        """Make clients wait while operator actions of a recording are repeated."""
        for service in self._services:
            if service.desk is not None:
                service.desk.on_hold = rests

    def end(self) -> bool:
        """End the servers; return False if every process of some server died before it served anything."""
        served = [service.end() for service in self._services]
        return all(served)


def _security_line(security: UaSecurity) -> str:
    """Return a line about an encrypted server."""
    certificate = f"{FOLDER}/{CERTIFICATE}, thumbprint {thumbprint(security.certificate)}"
    identity = f"user {' or '.join(security.users)}" if security.users else "no password"
    trusted = f"clients with any certificate: make {FOLDER}/{TRUSTED} to name those you trust"
    if security.trusted is not None:
        trusted = f"clients with one of {len(security.trusted)} certificates in {FOLDER}/{TRUSTED}"
    return f"encrypted with Basic256Sha256, {certificate}; {identity}; {trusted}"


def _problems(job: LoadedRack, listing: Listing, protocol: str) -> list[str]:
    """Return a sentence for each name in `writable` or a server's map that has no tag."""
    server = job.spec.server
    database = Database(listing, server.writable)
    unknown = unknown_patterns(database, server.writable)
    if protocol == MODBUS_TCP and server.modbus is not None:
        unknown += RegisterMap(database, server.modbus).problems
    return unknown


def _packed_address(host: str) -> bytes:
    return socket.inet_aton(host) if ":" not in host else bytes(4)
