"""Modbus TCP: requests have a seven-byte header, and each reply has the transaction number of its request.

    0-1  transaction   2-3  protocol, 0   4-5  length of the rest   6  unit   7...  PDU

A client can send further requests without waiting; the replies are in order. A connection ends if it receives
bytes that are not Modbus TCP.

pymodbus's framer and server are not used. The framer loses a byte after an 11h request. The server answers
only the first of several requests in one packet, refuses an unknown function with 80h in place of the
function, and serves functions that no device here has (tests/unit/line/test_pymodbus.py).
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
"""Function that returns the reply PDU for a unit's address and a request PDU, or None for no reply."""


class ModbusTcpPort:
    """A Modbus TCP server.

    Args:
        port: port number; 0 selects any free port.
        places: maximum number of connections; further ones are closed. None for the limit in `places`.
        selector: a selector that also waits for other ports; by default a new one.

    Raises:
        PortError: the port can't listen on the address.
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
        """Answer the received requests; return within `seconds`."""
        for connection, requests in self.requests(seconds):
            self.send(connection, b"".join(reply_to(request, answer) for request in requests))

    def requests(self, seconds: float) -> Iterator[tuple[socket.socket, list[bytes]]]:
        """Yield the received request frames of each connection; return within `seconds`."""
        yield from self._split(self.listener.wait(seconds))

    def take(self, ready: object) -> Iterator[tuple[socket.socket, list[bytes]]]:
        """Yield the request frames of a socket that the selector reports as ready."""
        yield from self._split(self.listener.take(ready))

    def _split(
        self, received: Iterator[tuple[socket.socket, bytes]]
    ) -> Iterator[tuple[socket.socket, list[bytes]]]:
        """Yield the request frames of each connection; keep incomplete ones, and end closed connections."""
        for connection, data in received:
            if not data:
                self._end(connection)
                continue
            self.traffic.received += len(data)
            requests = self._requests(connection, self._pending.get(connection, b"") + data)
            if requests:
                yield connection, requests

    def send(self, connection: socket.socket, replies: bytes) -> None:
        """Send reply frames; end the connection if that fails."""
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
        """Return the complete requests of a connection, and store the remaining bytes."""
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
    """Return the complete frames at the start of a stream, and the remaining bytes.

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
    """Return the reply frame to a request frame, or b"" for no reply."""
    _, _, _, unit = HEADER.unpack_from(request)
    pdu = answer(unit, request[HEADER.size :])
    return b"" if pdu is None else reply_frame(request, pdu)


def reply_frame(request: bytes, pdu: bytes) -> bytes:
    """Return the frame of a reply PDU, with the transaction and unit of its request."""
    transaction, _, _, unit = HEADER.unpack_from(request)
    return HEADER.pack(transaction, 0, len(pdu) + 1, unit) + pdu
