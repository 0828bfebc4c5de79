"""A pseudo-terminal: a serial port without hardware."""

from __future__ import annotations

import os
import select
from importlib import import_module
from typing import Any

from typing_extensions import override

from ..wire import LineFormat
from .port import Port, Traffic

CHUNK = 4096

NO_PTY = "this system has no pseudo-terminals: use --tcp, or --serial with a pair of virtual ports"


class PtyPort(Port):
    """A pseudo-terminal in raw mode; not available on Windows.

    Programs can open and close its path at any time, because this port keeps the client's end open so that
    the terminal never hangs up. Speed and parity have no effect. The operating system refuses even parity, so
    set the program to no parity.

    Raises:
        ValueError: the system has no pseudo-terminals.
    """

    def __init__(self) -> None:
        if not hasattr(os, "openpty"):
            raise ValueError(NO_PTY)
        system: Any = os  # for type checkers, these functions exist on POSIX only
        self._port_fd, self._client_fd = system.openpty()
        vars(import_module("tty"))["setraw"](self._client_fd)
        system.set_blocking(self._port_fd, False)
        self.name: str = system.ttyname(self._client_fd)
        self.traffic = Traffic()

    @override
    def wait(self, seconds: float) -> bytes:
        if not select.select([self._port_fd], [], [], seconds)[0]:
            return b""
        data = os.read(self._port_fd, CHUNK)
        self.traffic.received += len(data)
        return data

    @override
    def send(self, data: bytes) -> None:
        """Send bytes; drop bytes that do not fit because the reader is not reading."""
        try:
            self.traffic.sent += os.write(self._port_fd, data)
        except BlockingIOError:
            self.traffic.lost += 1

    def follow(self, line_format: LineFormat) -> None:
        """Do nothing, since a pseudo-terminal has no line format."""

    @override
    def close(self) -> None:
        os.close(self._port_fd)
        os.close(self._client_fd)
