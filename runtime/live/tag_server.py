"""The server's process: sockets and sessions of clients; see `runtime.outside`.

Packets that wait, one of each client, go to the scan process together, and are answered at one instant.
Nothing that a client sends costs another one more than a packet's time.
"""

from __future__ import annotations

import pickle
import selectors
import socket
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Protocol

from ...io_images.enip.codes import LIST_IDENTITY, SEND, SEND_CONNECTED
from ...io_images.enip.listing import Listing
from ..loop.pace import wall_ns
from ..outside.database import Database
from ..outside.exchange import ANSWER, Packet, request_of, results_in
from ..outside.room import Instant, Operation, Plan, ReadBytes
from ..outside.router import Router
from ..outside.session import HEAD, BrokenClientError, ClientSession, Frame
from .mailbox import AREA_BYTES, Mailbox

CLIENTS_MOST = 64
WAITING_MOST = 32
"""Packets of a client that wait for an answer."""

UNREAD_MOST = 1 << 16
"""Bytes of replies that a client has not read."""

HALF_NS, IDLE_NS = 5_000_000_000, 120_000_000_000
"""A frame that is not whole after this time ends its connection, and so does this silence."""

SILENT_NS = 10_000_000_000
"""Least silence of a client that gives way when all places are taken."""

STEP_S = 0.25
"""Longest wait between two looks at the clients' times."""

BATCH_BYTES = AREA_BYTES // 4
"""Bytes of reads and writes that go to the scan process together."""


@dataclass(frozen=True, slots=True)
class TagSetup:
    """What the server offers."""

    listing: Listing
    version: int  # of the program's edition
    writable: tuple[str, ...]  # patterns; none for a server that takes no writes
    name: str  # of the rack
    product: str
    address: bytes  # of the server, for List Identity
    port: int

    def router(self) -> Router:
        """Return what answers requests."""
        return Router(Database(self.listing, self.writable), self.name, self.product)


Answers = tuple[int, int, list[list[bytes | None]]]
"""Time, version, and the results of each packet's operations."""


def _bytes_of(operation: Operation) -> int:
    return operation.size if isinstance(operation, ReadBytes) else 2 * len(operation.data)


class ScanExchange(Protocol):
    """Carries out what packets need, at one instant."""

    def __call__(self, packets: list[Packet]) -> Answers | None:
        """Return the answers; None if the program has been edited meanwhile."""


class Client:
    """A connected client."""

    def __init__(self, where: socket.socket, session: ClientSession, address: str) -> None:
        self.socket, self.session, self.address = where, session, address
        self.waiting: list[Frame] = []
        self.unread = b""
        self.heard_ns = wall_ns()
        self.half_ns: int | None = None  # since when a frame is not whole

    def receive(self) -> None:
        """Take what has come; BrokenClientError or OSError ends the client."""
        data = self.socket.recv(1 << 16)
        if not data:
            raise BrokenClientError("the client has hung up")
        self.waiting += self.session.receive(data)
        if len(self.waiting) > WAITING_MOST:
            raise BrokenClientError(f"more than {WAITING_MOST} packets at once")
        self.heard_ns = wall_ns()
        if not self.session.pending:
            self.half_ns = None
        elif self.half_ns is None:
            self.half_ns = self.heard_ns

    def send(self, data: bytes) -> bool:
        """Send; return whether all has gone. BrokenClientError if the client does not read."""
        self.unread += data
        try:
            sent = self.socket.send(self.unread) if self.unread else 0
        except BlockingIOError:
            sent = 0
        self.unread = self.unread[sent:]
        if len(self.unread) > UNREAD_MOST:
            raise BrokenClientError("the client does not read")
        return not self.unread

    def is_late(self, now_ns: int) -> bool:
        """Whether it has been silent, or has left a frame half sent, for too long."""
        half = self.half_ns is not None and now_ns - self.half_ns > HALF_NS
        return half or now_ns - self.heard_ns > IDLE_NS


class TagServer:
    """Serves clients of a listening socket.

    Args:
        udp: answers List Identity; None without.

    Attributes:
        clients: by socket.
        dropped: clients that were ended, with the reason of the latest one.
    """

    def __init__(
        self, setup: TagSetup, listening: socket.socket, udp: socket.socket | None, exchange: ScanExchange
    ) -> None:
        self._listening, self._udp, self._exchange = listening, udp, exchange
        self.clients: dict[socket.socket, Client] = {}
        self.dropped, self.reason = 0, ""
        self._selector = selectors.DefaultSelector()
        for each in (listening, udp):
            if each is not None:
                each.setblocking(False)
                self._selector.register(each, selectors.EVENT_READ)
        self.set_up(setup)

    def set_up(self, setup: TagSetup) -> None:
        """Offer the tags of a program, also to those that are connected."""
        self.setup, self.router = setup, setup.router()
        for client in self.clients.values():
            client.session.router = self.router

    def watch(self, pipe: Connection) -> None:
        """Return from `step` when a pipe has something."""
        self._selector.register(pipe, selectors.EVENT_READ)

    def step(self, seconds: float = STEP_S) -> bool:
        """Wait for what comes next, and handle it; return whether a watched pipe has something."""
        told = False
        for key, events in self._selector.select(seconds):
            if key.fileobj is self._listening:
                self._accept()
            elif key.fileobj is self._udp:
                self._answer_datagram(self._udp)
            elif isinstance(key.fileobj, socket.socket):
                self._move(self.clients[key.fileobj], events)
            else:
                told = True
        while any(each.waiting for each in self.clients.values()):
            if not self._serve():
                return True
        now_ns = wall_ns()
        for client in [each for each in self.clients.values() if each.is_late(now_ns)]:
            self._drop(client, "it is silent, or its frame is not whole")
        return told

    def close(self) -> None:
        """End all clients."""
        for client in list(self.clients.values()):
            self._drop(client, "the server ends")
        self._selector.close()

    # --- clients

    def _accept(self) -> None:
        try:
            where, address = self._listening.accept()
        except OSError:
            return
        if len(self.clients) >= CLIENTS_MOST and not self._give_way():
            where.close()
            return
        where.setblocking(False)
        where.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        session = ClientSession(self.router, self.setup.address, self.setup.port)
        self.clients[where] = Client(where, session, f"{address[0]}:{address[1]}")
        self._selector.register(where, selectors.EVENT_READ)

    def _give_way(self) -> bool:
        """End the client that is silent for longest; return whether one could be ended."""
        longest = min(self.clients.values(), key=lambda each: each.heard_ns)
        if wall_ns() - longest.heard_ns < SILENT_NS:
            return False
        self._drop(longest, "all places are taken, and it is silent")
        return True

    def _move(self, client: Client, events: int) -> None:
        """Receive from a client, and send what it has not read."""
        try:
            if events & selectors.EVENT_WRITE:
                self._send(client, b"")
            if events & selectors.EVENT_READ:
                client.receive()
        except BlockingIOError:
            pass
        except (OSError, BrokenClientError) as error:
            self._drop(client, str(error))

    def _send(self, client: Client, data: bytes) -> None:
        writes = 0 if client.send(data) else selectors.EVENT_WRITE
        if self._selector.get_key(client.socket).events != selectors.EVENT_READ | writes:
            self._selector.modify(client.socket, selectors.EVENT_READ | writes)

    def _drop(self, client: Client, reason: str) -> None:
        self.dropped, self.reason = self.dropped + 1, reason
        if self.clients.pop(client.socket, None) is not None:
            self._selector.unregister(client.socket)
        client.waiting.clear()
        client.socket.close()

    def _answer_datagram(self, udp: socket.socket) -> None:
        try:
            data, where = udp.recvfrom(1 << 12)
            if len(data) == HEAD.size and int.from_bytes(data[:2], "little") == LIST_IDENTITY:
                session = ClientSession(self.router, self.setup.address, self.setup.port)
                frame = Frame(LIST_IDENTITY, 0, data[12:20], b"")
                udp.sendto(session.reply(frame, Instant((), 0, self.setup.version)), where)
        except OSError:
            return

    # --- packets

    def _serve(self) -> bool:
        """Answer a packet of each client that waits; return False if the program has been edited."""
        turn: list[tuple[Client, Plan]] = []
        left = BATCH_BYTES
        for client in [each for each in self.clients.values() if each.waiting]:
            plan = self._planned(client)
            if plan is None:
                continue
            left -= sum(map(_bytes_of, plan.operations))
            if left < 0 and turn:
                break
            turn.append((client, plan))
        packets: list[Packet] = [(client.address, plan.operations) for client, plan in turn]
        found: Answers | None = 0, self.setup.version, [[] for _ in packets]
        if any(plan.operations or plan.is_timed for _, plan in turn):
            found = self._exchange(packets)
        if found is None:
            return False
        now_ns, version, results = found
        for (client, _), result in zip(turn, results, strict=True):
            self._reply(client, Instant(result, now_ns, version))
        return True

    def _planned(self, client: Client) -> Plan | None:
        """Return what a client's next packet needs; None if that ends the client."""
        frame = client.waiting[0]
        if frame.command not in (SEND, SEND_CONNECTED):
            return Plan()
        try:
            return client.session.plan(frame, self.setup.version)
        except Exception as error:  # a packet's mistake, or ours, ends its own connection only
            self._drop(client, f"{type(error).__name__}: {error}")
            return None

    def _reply(self, client: Client, instant: Instant) -> None:
        try:
            self._send(client, client.session.reply(client.waiting.pop(0), instant))
        except Exception as error:  # as above
            self._drop(client, f"{type(error).__name__}: {error}")


class ScanProcess:
    """The exchange with the scan process.

    Raises:
        EOFError: it has ended.
    """

    def __init__(self, mailbox: Mailbox, waker: socket.socket) -> None:
        self._mailbox, self._waker = mailbox, waker
        self.version = 0

    def __call__(self, packets: list[Packet]) -> Answers | None:
        """See `ScanExchange`."""
        self._wait()  # for an answer to the request of a server that has died
        self._mailbox.ask(request_of(self.version, packets))
        self._wait()
        data = self._mailbox.reply()
        version, now_ns = ANSWER.unpack_from(data)
        if not version:
            raise EOFError  # the request was damaged: another server begins anew
        if version != self.version:
            return None
        return now_ns, version, results_in(data, packets)

    def _wait(self) -> None:
        while self._mailbox.waits:
            if not self._waker.recv(1 << 10):
                raise EOFError


def main(*descriptors: str) -> None:
    """Run a server's process.

    Args:
        descriptors: of the pipe for setups, the waker, the mailbox, the listening socket and the UDP socket.
    """
    pipe_file, waker_file, mailbox_file, listening_file, udp_file = map(int, descriptors)
    pipe, waker = Connection(pipe_file), socket.socket(fileno=waker_file)
    process = ScanProcess(Mailbox(mailbox_file), waker)
    listening, udp = socket.socket(fileno=listening_file), socket.socket(fileno=udp_file)
    try:
        setup: TagSetup = pickle.loads(pipe.recv_bytes())  # of our own scan process
        process.version = setup.version
        server = TagServer(setup, listening, udp, process)
        server.watch(pipe)
        while True:
            if server.step():
                setup = pickle.loads(pipe.recv_bytes())
                process.version = setup.version
                server.set_up(setup)
    except (EOFError, OSError, KeyboardInterrupt):
        return
