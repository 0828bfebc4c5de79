"""The server loop of a drive: Modbus TCP, and EtherNet/IP over TCP and UDP, in one thread."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Callable
from contextlib import suppress

from scanrack.io_images.enip.codes import LIST_IDENTITY
from scanrack.io_images.enip.frames import HEAD
from scanrack.runtime.line.ports import LineListener, ModbusTcpPort, PortError, Server
from scanrack.runtime.line.ports.modbustcp import reply_to
from scanrack.runtime.line.ports.sockets import Listener
from scanrack.runtime.loop.pace import Clock, wall_ns
from scanrack.runtime.tag_servers.drive_adapter import DriveAdapter, DriveSession
from scanrack.runtime.tag_servers.session import Frame
from scanrack.runtime.tag_servers.tag_snapshot import BrokenClientError, Instant
from typing_extensions import override

NS_PER_S = 1_000_000_000
DATAGRAM_BYTES_MAX = 2048
DATAGRAMS_MAX = 64
"""Maximum number of datagrams that are read from one socket before the other sockets are served."""

NO_TAGS = Instant((), 0, 0)
"""The empty tags for a session, since a drive has none."""


class LineTap:
    """Passes network traffic to a listener, with the current time.

    Args:
        listener: receives the traffic; None = no listener.
    """

    def __init__(self, clock: Clock, listener: LineListener | None) -> None:
        self._clock, self._listener = clock, listener

    def received(self, data: bytes) -> None:
        """Pass on received bytes."""
        if self._listener is not None:
            self._listener.received(self._clock.now_ns(), data)

    def sent(self, data: bytes) -> None:
        """Pass on sent bytes."""
        if self._listener is not None:
            self._listener.sent(self._clock.now_ns(), data)


class EnipPort:
    """Serves a drive on EtherNet/IP.

    Args:
        tap: receives the bytes of TCP connections and the class 1 packets.
        address: host, and port for TCP and for List Identity over UDP; 0 = any free port.
        io_port: UDP port for class 1 packets; 0 = any free port.

    Raises:
        PortError: a port can't be opened.
    """

    def __init__(
        self,
        adapter: DriveAdapter,
        address: tuple[str, int],
        io_port: int,
        selector: selectors.BaseSelector,
        tap: LineTap,
    ) -> None:
        host, port = address
        self.adapter, self._selector, self._tap = adapter, selector, tap
        self._listener = Listener(host, port, selector=selector)
        self.name = self._listener.name
        self._port = int(self.name.rpartition(":")[2])
        self._udp_sockets: list[socket.socket] = []
        try:
            self._identity_socket = self._open_udp(host, self._port)  # same number as the TCP port
            self._io_socket = self._open_udp(host, io_port)
        except PortError:
            self.close()
            raise
        self.io_port = int(self._io_socket.getsockname()[1])
        self._address = adapter.address = _ipv4(host)
        self._sessions: dict[socket.socket, DriveSession] = {}

    def _open_udp(self, host: str, port: int) -> socket.socket:
        """Return a UDP socket that the selector watches; raise PortError if it can't be opened."""
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        udp_socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            udp_socket.bind((host, port))
        except (OSError, OverflowError) as error:
            udp_socket.close()
            raise PortError(f"{host}:{port} (UDP) can't be opened: {error}") from error
        udp_socket.setblocking(False)
        self._udp_sockets.append(udp_socket)
        self._selector.register(udp_socket, selectors.EVENT_READ, self)
        return udp_socket

    def take(self, ready: object, advance: Callable[[], None]) -> None:
        """Handle a socket that the selector reports as ready.

        Args:
            advance: advances the drive to the current time.
        """
        for udp_socket in self._udp_sockets:
            if ready is udp_socket:
                self._take_datagrams(udp_socket, advance)
                return
        for connection, data in self._listener.take(ready):
            if not data:
                self._end(connection)
                continue
            self._tap.received(data)
            try:
                session = self._sessions.get(connection) or self._begin(connection)
                for frame in session.receive(data):
                    advance()
                    reply = session.answer_at(frame, NO_TAGS, wall_ns())
                    if reply and not self._listener.send(connection, reply):
                        raise BrokenClientError("the client does not receive its replies")
                    if reply:
                        self._tap.sent(reply)
            except (BrokenClientError, OSError):
                self._end(connection)

    def _begin(self, connection: socket.socket) -> DriveSession:
        host = str(connection.getpeername()[0])
        session = DriveSession(self.adapter, self._address, self._port, self.io_port, host)
        self._sessions[connection] = session
        return session

    def _end(self, connection: socket.socket) -> None:
        self._sessions.pop(connection, None)
        self._listener.drop(connection)

    def _take_datagrams(self, udp_socket: socket.socket, advance: Callable[[], None]) -> None:
        """Receive waiting class 1 packets on the I/O socket; answer List Identity on the other socket."""
        for _ in range(DATAGRAMS_MAX):
            try:
                data, sender = udp_socket.recvfrom(DATAGRAM_BYTES_MAX)
            except OSError:
                return
            if udp_socket is self._io_socket:
                self._tap.received(data)
                advance()
                self.adapter.receive(data, str(sender[0]), wall_ns())
            elif len(data) == HEAD.size and int.from_bytes(data[:2], "little") == LIST_IDENTITY:
                session = DriveSession(self.adapter, self._address, self._port, self.io_port, "")
                with suppress(OSError):
                    context = data[12:20]  # the sender's; the reply returns it
                    reply = session.reply(Frame(LIST_IDENTITY, 0, context, b""), NO_TAGS)
                    udp_socket.sendto(reply, sender)

    def produce(self, advance: Callable[[], None]) -> None:
        """Send the packet that is due, or end a connection that has timed out."""
        wake_ns = self.adapter.wake_ns
        if wake_ns is None or wall_ns() < wake_ns:
            return
        advance()
        packet = self.adapter.due(wall_ns())
        if packet is not None:
            self._tap.sent(packet[0])
            with suppress(OSError):
                self._io_socket.sendto(*packet)

    def drop_all(self) -> None:
        """End all connections."""
        for connection in list(self._sessions):
            self._end(connection)
        self.adapter.end()

    def close(self) -> None:
        """End all connections and stop listening."""
        for udp_socket in self._udp_sockets:
            self._selector.unregister(udp_socket)
            udp_socket.close()
        self._listener.close()


def _ipv4(host: str) -> bytes:
    """Return the four bytes of an IPv4 address; zeros for any other host."""
    try:
        return socket.inet_aton(host)
    except OSError:
        return bytes(4)


class DriveServer(Server):
    """Serves a stack on Modbus TCP and a drive on EtherNet/IP.

    Args:
        modbus: Modbus TCP port; None = no Modbus TCP.
        answer: returns the reply to a unit's request PDU at the current time.
        enip: EtherNet/IP port; None = no EtherNet/IP.
        advance: advances the drives to the current time.
        selector: selector of both ports.
    """

    def __init__(
        self,
        modbus: ModbusTcpPort | None,
        answer: Callable[[int, bytes], bytes],
        enip: EnipPort | None,
        advance: Callable[[], None],
        selector: selectors.BaseSelector,
    ) -> None:
        self._modbus, self._answer, self._enip = modbus, answer, enip
        self._advance, self._selector = advance, selector

    @override
    def step(self, longest_s: float) -> None:
        """Wait up to `longest_s` for traffic or a due packet; answer requests, and advance the drives."""
        wake_ns = None if self._enip is None else self._enip.adapter.wake_ns
        if wake_ns is not None:
            longest_s = min(longest_s, max(0, wake_ns - wall_ns()) / NS_PER_S)
        for key, _ in self._selector.select(longest_s):
            if self._enip is not None and not self._is_modbus(key.data):
                self._enip.take(key.fileobj, self._advance)
            elif self._modbus is not None:
                for connection, requests in self._modbus.take(key.fileobj):
                    replies = b"".join(reply_to(request, self._answer) for request in requests)
                    self._modbus.send(connection, replies)
        if self._enip is not None:
            self._enip.produce(self._advance)
        self._advance()

    def _is_modbus(self, owner: object) -> bool:
        return self._modbus is not None and owner is self._modbus.listener

    def drop_all(self) -> None:
        """End all connections, as a power loss does."""
        for port in (self._modbus, self._enip):
            if port is not None:
                port.drop_all()

    @override
    def close(self) -> None:
        for port in (self._modbus, self._enip):
            if port is not None:
                port.close()
        self._selector.close()
