"""Lines of text over TCP, each answered by a line; a client must be admitted by one of its first lines."""

from __future__ import annotations

import socket
from collections.abc import Callable

from .sockets import Listener

LINE_MAX = 4096

CLIENTS_MAX, STRANGERS_MAX = 8, 8
"""Maximum number of admitted clients, and of strangers, which have not been admitted yet."""


class EndOfTalkError(ValueError):
    """Ends the connection after one more answer, the message of this error."""


class TextLinePort:
    """Answers lines of UTF-8 text; a line longer than `LINE_MAX` bytes ends its connection.

    A client is a stranger until one of its lines is answered. If there are too many strangers, the earliest
    one is dropped; if there are too many admitted clients, the one that has been silent longest is dropped.
    The port always accepts a new client.

    Args:
        port: port number; 0 selects any free port.

    Raises:
        PortError: the port can't listen at the address.
    """

    def __init__(self, host: str, port: int) -> None:
        self._listener = Listener(host, port)
        self._pending: dict[socket.socket, bytes] = {}
        self._admitted: set[socket.socket] = set()
        self.name = self._listener.name

    def serve(self, answer: Callable[[str, bool], str]) -> None:
        """Answer the lines that have arrived.

        Args:
            answer: function that returns the answer to a line and whether its client is admitted; an
                `EndOfTalkError` ends the connection.
        """
        for connection, data in self._listener.wait(0):
            if data:
                self._serve(connection, self._pending.pop(connection, b"") + data, answer)
            else:
                self._end(connection)
        connections = self._listener.connections
        strangers = [connection for connection in connections if connection not in self._admitted]
        clients = sorted(self._admitted, key=lambda connection: connections[connection])
        for connection in strangers[:-STRANGERS_MAX] + clients[:-CLIENTS_MAX]:
            self._end(connection)

    def close(self) -> None:
        """End all connections and stop listening."""
        self._listener.close()

    def _serve(self, connection: socket.socket, data: bytes, answer: Callable[[str, bool], str]) -> None:
        """Answer the complete lines in a connection's bytes, and keep the incomplete one.

        The first answered line admits the client.
        """
        *lines, partial_line = data.split(b"\n")
        if max(map(len, [*lines, partial_line])) > LINE_MAX:
            self._end(connection)
            return
        if partial_line:
            self._pending[connection] = partial_line
        reply, ends_client = "", False
        for line in filter(bytes.strip, lines):
            try:
                reply += answer(line.decode(errors="replace"), connection in self._admitted) + "\n"
                self._admitted.add(connection)
            except EndOfTalkError as end:
                reply += f"{end}\n"
                ends_client = True
                break
        is_lost = bool(reply) and not self._listener.send(connection, reply.encode())
        if is_lost or ends_client:
            self._end(connection)

    def _end(self, connection: socket.socket) -> None:
        self._pending.pop(connection, None)
        self._admitted.discard(connection)
        self._listener.drop(connection)
