"""A pseudo-terminal: a serial port without hardware, whose path is printed."""

from __future__ import annotations

import os
import select
from importlib import import_module
from typing import Any

from typing_extensions import override

from ..wire import LineFormat
from .port import Port, Traffic

CHUNK = 4096

NO_PTY = "no pseudo-terminals on this system: use --tcp, or --serial with a pair of virtual ports"


class PtyPort(Port):
    """A pseudo-terminal in raw mode; not on Windows.

    Programs may open and close its path at any time: its other end is kept open here, so that it
    never hangs up. Speed and parity have no meaning on it; a program that requires even parity gets an
    error from the operating system and must be set to none.

    Raises:
        ValueError: the system has none.
    """

    def __init__(self) -> None:
        if not hasattr(os, "openpty"):
            raise ValueError(NO_PTY)
        system: Any = os  # type checkers know these functions on POSIX only
        self._own, self._kept = system.openpty()
        vars(import_module("tty"))["setraw"](self._kept)
        system.set_blocking(self._own, False)
        self.name: str = system.ttyname(self._kept)
        self.traffic = Traffic()

    @override
    def wait(self, seconds: float) -> bytes:
        if not select.select([self._own], [], [], seconds)[0]:
            return b""
        data = os.read(self._own, CHUNK)
        self.traffic.received += len(data)
        return data

    @override
    def send(self, data: bytes) -> None:
        """Send what fits; drop the rest if the reader does not read."""
        try:
            self.traffic.sent += os.write(self._own, data)
        except BlockingIOError:
            self.traffic.lost += 1

    def follow(self, line_format: LineFormat) -> None:
        """Do nothing: a pseudo-terminal has no line format."""

    @override
    def close(self) -> None:
        os.close(self._own)
        os.close(self._kept)
