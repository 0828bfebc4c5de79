"""Modbus TCP: requests with a seven-byte header, each answered with its transaction number.

    0-1  transaction   2-3  protocol, 0   4-5  length of the rest   6  unit   7...  PDU

Requests may follow each other without waiting: each is answered, in order. Bytes that are
not Modbus TCP end their connection.

After a request 11h pymodbus's own framer takes a byte of the next one. Its server answers only the first of
several requests in one packet, refuses a function that it lacks with 80h in place of the function, and serves
functions that no device here has (tests/unit/line/test_pymodbus.py).
"""

from __future__ import annotations

import selectors
import socket
from collections.abc import Callable, Iterator
from struct import Struct

from .port import Traffic
from .sockets import Listener

HEADER = Struct(">HHHB")
PDU_MAX = 253
"""The longest PDU, bytes [Modbus application protocol]."""

AnswerPdu = Callable[[int, bytes], bytes | None]
"""From a unit's address and a request PDU to the reply PDU; None = no reply."""


class ModbusTcpPort:
    """A Modbus TCP server.

    Args:
        port: the port, 0 = any that is free.
        places: maximum simultaneous connections; further ones are closed. None = many, see `places`.
        selector: waits for this port and for others; by default one of its own.

    Raises:
        PortError: it can't listen there.
    """

    def __init__(
        self,
        host: str,
        port: int,
        places: int | None = None,
        selector: selectors.BaseSelector | None = None,
    ) -> None:
        self.listener = Listener(host, port, places, selector)
        self._pending: dict[socket.socket, bytes] = {}
        self.name = self.listener.name
        self.traffic = Traffic()  # bytes sent and received, headers included

    @property
    def connections(self) -> int:
        """Number of connected clients."""
        return len(self.listener.connections)

    def serve(self, seconds: float, answer: AnswerPdu) -> None:
        """Answer the received requests; return within that time."""
        for connection, requests in self.requests(seconds):
            self.send(connection, b"".join(reply_to(request, answer) for request in requests))

    def requests(self, seconds: float) -> Iterator[tuple[socket.socket, list[bytes]]]:
        """Yield the request frames that connections have sent; return within that time."""
        yield from self._split(self.listener.wait(seconds))

    def take(self, ready: object) -> Iterator[tuple[socket.socket, list[bytes]]]:
        """Yield the request frames of a socket that the selector has found ready."""
        yield from self._split(self.listener.take(ready))

    def _split(
        self, received: Iterator[tuple[socket.socket, bytes]]
    ) -> Iterator[tuple[socket.socket, list[bytes]]]:
        for connection, data in received:
            if not data:
                self._end(connection)
                continue
            self.traffic.received += len(data)
            requests = self._requests(connection, self._pending.get(connection, b"") + data)
            if requests:
                yield connection, requests

    def send(self, connection: socket.socket, replies: bytes) -> None:
        """Send reply frames; a connection that does not take them is ended."""
        if replies and self.listener.send(connection, replies):
            self.traffic.sent += len(replies)
        elif replies:
            self._end(connection)

    def drop_all(self) -> None:
        """End all connections."""
        for connection in list(self.listener.connections):
            self._end(connection)

    def close(self) -> None:
        """End all connections and stop listening."""
        self.listener.close()

    def _requests(self, connection: socket.socket, data: bytes) -> list[bytes]:
        """Return the whole requests of a connection, and keep the rest."""
        try:
            requests, self._pending[connection] = split_frames(data)
        except NotModbusError:
            self._end(connection)
            return []
        return requests

    def _end(self, connection: socket.socket) -> None:
        self._pending.pop(connection, None)
        self.listener.drop(connection)


class NotModbusError(ValueError):
    """The bytes are not a Modbus TCP frame."""


def split_frames(data: bytes) -> tuple[list[bytes], bytes]:
    """Return the whole frames at the head of a stream, and the rest.

    Raises:
        NotModbusError: the header is invalid.
    """
    frames: list[bytes] = []
    start = 0
    while len(data) - start >= HEADER.size:
        _, protocol, length, _ = HEADER.unpack_from(data, start)
        if protocol != 0 or not 2 <= length <= PDU_MAX + 1:
            raise NotModbusError(f"no Modbus TCP frame: {data[start : start + HEADER.size].hex(' ')}")
        end = start + 6 + length
        if len(data) < end:
            break
        frames.append(data[start:end])
        start = end
    return frames, data[start:]


def reply_to(request: bytes, answer: AnswerPdu) -> bytes:
    """Return the reply frame to a request frame; b"" if there is no reply."""
    _, _, _, unit = HEADER.unpack_from(request)
    pdu = answer(unit, request[HEADER.size :])
    return b"" if pdu is None else reply_frame(request, pdu)


def reply_frame(request: bytes, pdu: bytes) -> bytes:
    """Return the frame of a reply PDU, with transaction and unit of its request."""
    transaction, _, _, unit = HEADER.unpack_from(request)
    return HEADER.pack(transaction, 0, len(pdu) + 1, unit) + pdu
