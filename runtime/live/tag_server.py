"""The process of a tag server: its sockets and client sessions; see `runtime.tag_servers`.

The server passes one waiting packet from each client to the scan process, which answers all of them at one
instant. Thus a client delays another client by at most the time of one packet.
"""

from __future__ import annotations

import pickle
import selectors
import socket
import struct
import sys
from collections.abc import Callable
from contextlib import ExitStack, suppress
from multiprocessing.connection import Connection
from typing import NamedTuple

from ..line.ports.places import make_place
from ..loop.pace import wall_ns
from ..tag_servers.exchange import ANSWER, Packet, request_of, results_in
from ..tag_servers.setup import SESSIONS, TagSetup
from ..tag_servers.tag_snapshot import BrokenClientError, Instant, Operation, Plan, ReadBytes
from .mailbox import AREA_BYTES, Mailbox
from .shared_memory import SharedMemory
from .tag_client import Client

STEP_S = 0.25
"""Longest wait between two checks of the clients' time limits."""

BATCH_BYTES = AREA_BYTES // 4
"""Maximum number of bytes read and written in one exchange with the scan process."""

OPERATION_BYTES = 512
"""Minimum bytes counted for each read or write, so that an exchange of many small ones stays short."""

RESET_AT_CLOSE = struct.pack("hh" if sys.platform == "win32" else "ii", 1, 0)
"""An SO_LINGER option of 0 s, which resets a connection when its socket is closed."""


class ExchangeResults(NamedTuple):
    """The results of packets that the scan process answered at one instant."""

    now_ns: int
    version: int  # of the program
    results: list[list[bytes | None]]  # of each packet's operations


ScanExchange = Callable[[list[Packet]], ExchangeResults | None]
"""Function that carries out packets' operations at one instant; returns None if the program was edited."""


def _bytes_of(operation: Operation) -> int:
    """Return the number of bytes that an operation counts as in a batch."""
    size = operation.size if isinstance(operation, ReadBytes) else 2 * len(operation.data)
    return max(size, OPERATION_BYTES)


class TagServer:
    """A tag server for the clients of a listening socket.

    Args:
        udp: socket for List Identity requests, or None.

    Attributes:
        clients: the connected clients, by socket.
        dropped: number of clients whose connection the server has ended.
        reason: why the server last ended a connection.
    """

    def __init__(
        self, setup: TagSetup, listening: socket.socket, udp: socket.socket | None, exchange: ScanExchange
    ) -> None:
        self._listening, self._udp, self._exchange = listening, udp, exchange
        self.clients: dict[socket.socket, Client] = {}
        self.dropped, self.reason = 0, ""
        self._selector = selectors.DefaultSelector()
        for listener in (listening, udp):
            if listener is not None:
                listener.setblocking(False)
                self._selector.register(listener, selectors.EVENT_READ)
        self.set_up(setup)

    def set_up(self, setup: TagSetup) -> None:
        """Serve the tags of a program to connected and new clients."""
        self.setup, self._sessions = setup, SESSIONS[setup.protocol](setup)
        for client in self.clients.values():
            client.session.router = self._sessions.router

    def watch(self, pipe: Connection) -> None:
        """Make `step` return when a pipe has data."""
        self._selector.register(pipe, selectors.EVENT_READ)

    def step(self, seconds: float = STEP_S) -> bool:
        """Wait for events, handle them, and answer one packet from each client.

        Returns:
            Whether a watched pipe has data.
        """
        has_message = False
        for key, events in self._selector.select(0 if self._has_packets() else seconds):
            if isinstance(key.fileobj, socket.socket):
                self._handle(key.fileobj, events)
            else:
                has_message = True
        if self._has_packets() and not self._serve():
            return True
        now_ns = wall_ns()
        for client in [client for client in self.clients.values() if client.is_late(now_ns)]:
            self._drop(client, "it is silent, or its frame is incomplete")
        return has_message

    def _has_packets(self) -> bool:
        return any(client.waiting for client in self.clients.values())

    def _handle(self, ready: socket.socket, events: int) -> None:
        """Accept a client, answer a datagram, or receive from and send to a client."""
        if ready is self._listening:
            self._accept()
        elif ready is self._udp:
            self._answer_datagram(self._udp)
        elif ready in self.clients:  # a new client may just have replaced it
            self._transfer(self.clients[ready], events)

    def close(self) -> None:
        """Reset all connections, since an orderly close breaks st-ethernet-ip, which Node-RED uses."""
        for client in list(self.clients.values()):
            client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET_AT_CLOSE)
            self._drop(client, "the server ends")
        self._selector.close()

    # --- clients

    def _accept(self) -> None:
        """Accept a client, or close its connection if the server is full."""
        try:
            connection, address = self._listening.accept()
        except OSError:
            return
        if not self._has_place():
            connection.close()
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.clients[connection] = Client(connection, self._sessions.open(), f"{address[0]}:{address[1]}")
        self._selector.register(connection, selectors.EVENT_READ)

    def _has_place(self) -> bool:
        """Return whether another client can connect; if necessary, drop a silent one."""
        heard_times = {connection: client.heard_ns for connection, client in self.clients.items()}
        evicted, has_place = make_place(heard_times, wall_ns())
        if evicted is not None:
            self._drop(self.clients[evicted], "too many clients are connected, and it is silent")
        return has_place

    def _transfer(self, client: Client, events: int) -> None:
        """Receive bytes from a client, and send the bytes that are pending for it."""
        try:
            if events & selectors.EVENT_WRITE:
                self._send(client, b"")
            if events & selectors.EVENT_READ and not client.waiting:
                client.receive()
        except BlockingIOError:
            pass
        except (OSError, BrokenClientError) as error:
            self._drop(client, str(error))

    def _send(self, client: Client, data: bytes) -> None:
        """Send bytes to a client; while some are unsent, wait until the client can accept more."""
        writes = 0 if client.send(data) else selectors.EVENT_WRITE
        if self._selector.get_key(client.socket).events != selectors.EVENT_READ | writes:
            self._selector.modify(client.socket, selectors.EVENT_READ | writes)

    def _drop(self, client: Client, reason: str) -> None:
        """End a client's connection, and keep the reason."""
        self.dropped, self.reason = self.dropped + 1, reason
        if self.clients.pop(client.socket, None) is not None:
            self._selector.unregister(client.socket)
        client.waiting.clear()
        client.socket.close()

    def _answer_datagram(self, udp: socket.socket) -> None:
        """Receive a datagram, and answer it if it is a request."""
        try:
            data, sender = udp.recvfrom(1 << 12)
            reply = self._sessions.datagram(data)
            if reply:
                udp.sendto(reply, sender)
        except OSError:
            return

    # --- packets

    def _next_plans(self) -> list[tuple[Client, Plan]]:
        """Return the packets to answer now: one from each waiting client, up to BATCH_BYTES."""
        plans: list[tuple[Client, Plan]] = []
        bytes_left = BATCH_BYTES
        for client in [client for client in self.clients.values() if client.waiting]:
            plan = self._planned(client)
            if plan is None:
                continue
            bytes_left -= sum(map(_bytes_of, plan.operations))
            if bytes_left < 0 and plans:
                break
            plans.append((client, plan))
        return plans

    def _serve(self) -> bool:
        """Answer a packet from each waiting client; return False if the program has been edited."""
        plans = self._next_plans()
        packets: list[Packet] = [(client.address, plan.operations) for client, plan in plans]
        exchanged: ExchangeResults | None = ExchangeResults(0, self.setup.version, [[] for _ in packets])
        if any(plan.operations or plan.is_timed for _, plan in plans):
            exchanged = self._exchange(packets)
        if exchanged is None:
            return False
        for (client, _), results in zip(plans, exchanged.results, strict=True):
            self.clients[client.socket] = self.clients.pop(client.socket)  # the last one in the next batch
            self._reply(client, Instant(results, exchanged.now_ns, exchanged.version))
        return True

    def _planned(self, client: Client) -> Plan | None:
        """Return the operations in a client's next packet, or None if the packet ends the connection."""
        try:
            return client.session.plan(client.waiting[0], self.setup.version)
        except Exception as error:  # an error, in a packet or in our code, ends only this connection
            self._drop(client, f"{type(error).__name__}: {error}")
            return None

    def _reply(self, client: Client, instant: Instant) -> None:
        """Answer a client's next packet with the results of its operations."""
        try:
            self._send(client, client.session.reply(client.waiting.pop(0), instant))
        except Exception as error:  # as above
            self._drop(client, f"{type(error).__name__}: {error}")


class ScanProcess:
    """Exchanges packets with the scan process; each call blocks until the scan process has answered.

    Raises:
        EOFError: the scan process has ended.
    """

    def __init__(self, mailbox: Mailbox, waker: socket.socket) -> None:
        self._mailbox, self._waker = mailbox, waker
        self.version = 0

    def __call__(self, packets: list[Packet]) -> ExchangeResults | None:
        """See `ScanExchange`."""
        self._wait()  # for the reply to a request of an earlier server, which has died
        self._mailbox.post_request(request_of(self.version, packets))
        self._wait()
        data = self._mailbox.reply()
        version, now_ns = ANSWER.unpack_from(data)
        if not version:
            raise EOFError  # the request was damaged: end, so that another server starts
        if version != self.version:
            return None
        return ExchangeResults(now_ns, version, results_in(data, packets))

    def beat(self) -> None:
        """Signal that the server is alive; call it about every `STEP_S`."""
        self._mailbox.beat()

    def _wait(self) -> None:
        while self._mailbox.has_request:
            if not self._waker.recv(1 << 10):
                raise EOFError


def main(
    setups: socket.socket,
    waker: socket.socket,
    mailbox: SharedMemory,
    listening: socket.socket,
    udp: socket.socket | None = None,
) -> None:
    """Run a server process.

    Args:
        setups: socket that receives a setup at the start, and after each program edit.
        waker: socket that wakes this process when the mailbox has a reply.
    """
    pipe = Connection(setups.detach())
    process = ScanProcess(Mailbox(mailbox), waker)
    with ExitStack() as stack, suppress(EOFError, OSError, KeyboardInterrupt):
        setup: TagSetup = pickle.loads(pipe.recv_bytes())  # trusted: it comes from our own scan process
        process.version = setup.version
        server = TagServer(setup, listening, udp, process)
        stack.callback(server.close)
        server.watch(pipe)
        while True:
            process.beat()
            if server.step():
                setup = pickle.loads(pipe.recv_bytes())
                process.version = setup.version
                server.set_up(setup)
