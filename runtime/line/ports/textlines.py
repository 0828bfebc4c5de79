"""Lines of text over TCP, each answered by a line."""

from __future__ import annotations

import socket
from collections.abc import Callable

from .sockets import Listener

LONGEST_LINE = 4096
MOST_CLIENTS = 8


class TextLinePort:
    """Answers lines of UTF-8 text; a longer line than `LONGEST_LINE` bytes ends its connection.

    Args:
        port: the port, 0 = any that is free.

    Raises:
        PortError: it can't listen there.
    """

    def __init__(self, host: str, port: int) -> None:
        self._listener = Listener(host, port)
        self._pending: dict[socket.socket, bytes] = {}
        self.name = self._listener.name

    def serve(self, answer: Callable[[str], str]) -> None:
        """Answer the lines that have arrived."""
        for connection, data in self._listener.wait(0):
            if data:
                self._serve(connection, self._pending.get(connection, b"") + data, answer)
            else:
                self._end(connection)
        for connection in list(self._listener.connections)[MOST_CLIENTS:]:
            self._end(connection)

    def close(self) -> None:
        """End all connections and stop listening."""
        self._listener.close()

    def _serve(self, connection: socket.socket, data: bytes, answer: Callable[[str], str]) -> None:
        *lines, rest = data.split(b"\n")
        if max(map(len, [*lines, rest])) > LONGEST_LINE:
            self._end(connection)
            return
        self._pending[connection] = rest
        said = "".join(answer(line.decode(errors="replace")) + "\n" for line in lines if line.strip())
        if said and not self._listener.send(connection, said.encode()):
            self._end(connection)

    def _end(self, connection: socket.socket) -> None:
        self._pending.pop(connection, None)
        self._listener.drop(connection)
