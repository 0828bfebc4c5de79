"""A network between page and rack that can be cut: the port of the IPv6 loopback, forwarded to IPv4."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress


class Network:
    """Forwards connections to [::1]:port.

    Attributes:
        frozen: nothing passes, and no connection ends, as when a cable is pulled.
    """

    def __init__(self, port: int) -> None:
        self.port, self.frozen = port, False
        self._ends: list[socket.socket] = []

    def begin(self) -> None:
        """Accept connections; OSError without IPv6."""
        self._listening = socket.create_server(("::1", self.port), family=socket.AF_INET6)
        threading.Thread(target=self._accept, args=(self._listening,), daemon=True).start()

    def cut(self) -> None:
        """End all connections, and accept no more."""
        for each in (self._listening, *self._ends):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        self._ends.clear()

    def _accept(self, listening: socket.socket) -> None:
        with suppress(OSError):
            while True:
                page, _ = listening.accept()
                rack = socket.create_connection(("127.0.0.1", self.port))
                self._ends += page, rack
                for pair in ((page, rack), (rack, page)):
                    threading.Thread(target=self._pass_on, args=pair, daemon=True).start()

    def _pass_on(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while content := source.recv(1 << 16):
                while self.frozen:
                    time.sleep(0.02)
                sink.sendall(content)
            sink.shutdown(socket.SHUT_RDWR)


@contextmanager
def network(port: int) -> Iterator[Network]:
    """Forward a port as long as the context lasts; OSError without IPv6."""
    found = Network(port)
    found.begin()
    try:
        yield found
    finally:
        found.frozen = False
        found.cut()
