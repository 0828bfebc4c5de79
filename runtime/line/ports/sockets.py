"""TCP: a listening socket and its connections."""

from __future__ import annotations

import selectors
import socket
from collections.abc import Iterator

from ...loop.pace import wall_ns
from ..hosts import join_address
from .places import make_place
from .port import PortError

CHUNK = 4096


class Listener:
    """A listening TCP socket with its connections.

    Attributes:
        name: host:port; for port 0, this has the port that the system chose.
        connections: the clients, each with the wall time of its latest bytes; see `places`.

    Args:
        port: port number; 0 selects any free port.
        places: maximum number of connections; further ones are closed. None for the limit in `places`.
        selector: a selector that also waits for other listeners; by default a new one.

    Raises:
        PortError: the socket can't listen on the address.
    """

    def __init__(
        self,
        host: str,
        port: int,
        places: int | None = None,
        selector: selectors.BaseSelector | None = None,
    ) -> None:
        try:
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
            self._socket = socket.create_server((host, port), family=family)
        except (OSError, OverflowError) as error:
            raise PortError(f"can't listen at {join_address(host, port)}: {error}") from error
        self._socket.setblocking(False)
        self.name = join_address(host, self._socket.getsockname()[1])
        self.connections: dict[socket.socket, int] = {}
        self._connections_max = places
        self._shared = selector is not None
        self._selector = selector or selectors.DefaultSelector()
        self._selector.register(self._socket, selectors.EVENT_READ, self)

    def wait(self, seconds: float) -> Iterator[tuple[socket.socket, bytes]]:
        """Accept new connections; yield the bytes received on existing ones, b"" for a closed connection."""
        for key, _ in self._selector.select(seconds):
            yield from self.take(key.fileobj)

    def take(self, ready: object) -> Iterator[tuple[socket.socket, bytes]]:
        """Handle a socket that the selector reports as ready, as `wait` does."""
        if ready is self._socket:
            evicted = self._accept()
            if evicted is not None:
                yield evicted, b""
        elif isinstance(ready, socket.socket) and ready in self.connections:
            yield ready, self._read(ready)

    def send(self, connection: socket.socket, data: bytes) -> bool:
        """Send to a connection, and drop it if that fails; return whether all bytes were sent."""
        try:
            is_sent = connection.send(data) == len(data)
        except OSError:
            is_sent = False
        if not is_sent:
            self.drop(connection)
        return is_sent

    def drop(self, connection: socket.socket) -> None:
        """End a connection, if it has not ended yet."""
        if connection in self.connections:
            del self.connections[connection]
            self._selector.unregister(connection)
            connection.close()

    def close(self) -> None:
        """End all connections and stop listening."""
        for connection in list(self.connections):
            self.drop(connection)
        if self._shared:
            self._selector.unregister(self._socket)
        else:
            self._selector.close()
        self._socket.close()

    def _accept(self) -> socket.socket | None:
        """Accept a client unless the limit is reached; return the client dropped to make room, or None."""
        try:
            connection, _ = self._socket.accept()
        except OSError:  # the client has already closed the connection
            return None
        if self._connections_max is None:
            evicted, has_place = make_place(self.connections, wall_ns())
        else:
            evicted, has_place = None, len(self.connections) < self._connections_max
        if evicted is not None:
            self.drop(evicted)
        if not has_place:
            connection.close()
            return None
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connections[connection] = wall_ns()
        self._selector.register(connection, selectors.EVENT_READ, self)
        return evicted

    def _read(self, connection: socket.socket) -> bytes:
        """Return the bytes that a connection has received; drop a closed one and return b""."""
        try:
            data = connection.recv(CHUNK)
        except OSError:
            data = b""
        if data:
            self.connections[connection] = wall_ns()
        else:
            self.drop(connection)
        return data
