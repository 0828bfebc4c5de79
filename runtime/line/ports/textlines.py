"""Lines of text over TCP, each answered by a line; a client must be admitted by one of its first lines."""

from __future__ import annotations

import socket
from collections.abc import Callable

from .sockets import Listener

LONGEST_LINE = 4096

MOST_CLIENTS, MOST_STRANGERS = 8, 8
"""Maximum number of admitted clients, and of clients that are not admitted yet."""


class EndOfTalkError(ValueError):
    """Ends the connection after one more answer, the message of this error."""


class TextLinePort:
    """Answers lines of UTF-8 text; a longer line than `LONGEST_LINE` bytes ends its connection.

    A client is a stranger until one of its lines is answered. If there are too many strangers, the earliest
    is dropped; if there are too many clients, the one that was silent longest. A new client always finds a
    place.

    Args:
        port: the port, 0 = any that is free.

    Raises:
        PortError: it can't listen there.
    """

    def __init__(self, host: str, port: int) -> None:
        self._listener = Listener(host, port)
        self._pending: dict[socket.socket, bytes] = {}
        self._admitted: set[socket.socket] = set()
        self.name = self._listener.name

    def serve(self, answer: Callable[[str, bool], str]) -> None:
        """Answer the lines that have arrived.

        Args:
            answer: gets a line and whether its client was admitted; an `EndOfTalkError` ends the connection.
        """
        for connection, data in self._listener.wait(0):
            if data:
                self._serve(connection, self._pending.pop(connection, b"") + data, answer)
            else:
                self._end(connection)
        connections = self._listener.connections
        strangers = [connection for connection in connections if connection not in self._admitted]
        clients = sorted(self._admitted, key=lambda connection: connections[connection])
        for connection in strangers[:-MOST_STRANGERS] + clients[:-MOST_CLIENTS]:
            self._end(connection)

    def close(self) -> None:
        """End all connections and stop listening."""
        self._listener.close()

    def _serve(self, connection: socket.socket, data: bytes, answer: Callable[[str, bool], str]) -> None:
        *lines, partial_line = data.split(b"\n")
        if max(map(len, [*lines, partial_line])) > LONGEST_LINE:
            self._end(connection)
            return
        if partial_line:
            self._pending[connection] = partial_line
        answers, ends_client = [], False
        for line in filter(bytes.strip, lines):
            try:
                answers.append(answer(line.decode(errors="replace"), connection in self._admitted))
                self._admitted.add(connection)
            except EndOfTalkError as end:
                answers.append(str(end))
                ends_client = True
                break
        text = "".join(f"{line}\n" for line in answers).encode()
        if (text and not self._listener.send(connection, text)) or ends_client:
            self._end(connection)

    def _end(self, connection: socket.socket) -> None:
        self._pending.pop(connection, None)
        self._admitted.discard(connection)
        self._listener.drop(connection)
