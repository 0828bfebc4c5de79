"""The line's bytes over TCP, like a serial device server."""

from __future__ import annotations

import socket

from typing_extensions import override

from ..wire import LineFormat
from .port import Port, Traffic
from .sockets import Listener


class RawTcpPort(Port):
    """Carries the line's bytes over TCP: RTU frames, or ASCII while the unit uses ASCII.

    Several clients can connect, but they share one line, so replies go to the latest sender.

    Args:
        port: port number; 0 selects any free port.

    Raises:
        PortError: the port can't listen on the address.
    """

    def __init__(self, host: str, port: int) -> None:
        self._listener = Listener(host, port)
        self._latest_sender: socket.socket | None = None
        self.name = self._listener.name
        self.traffic = Traffic()

    @override
    def wait(self, seconds: float) -> bytes:
        """Return the bytes of one client, which becomes the receiver of replies."""
        for connection, data in self._listener.wait(seconds):
            if data:
                self._latest_sender = connection
                self.traffic.received += len(data)
                return data
        return b""

    @override
    def send(self, data: bytes) -> None:
        if self._latest_sender is not None and self._listener.send(self._latest_sender, data):
            self.traffic.sent += len(data)

    def follow(self, line_format: LineFormat) -> None:
        """Do nothing, since TCP has no line format."""

    @override
    def close(self) -> None:
        self._listener.close()
