"""A pseudo-terminal: a serial port without hardware, whose path is printed."""

from __future__ import annotations

import os
import select

from typing_extensions import override

from ..wire import LineFormat
from .port import Port, Traffic

CHUNK = 4096


class PtyPort(Port):
    """A pseudo-terminal in raw mode; not on Windows.

    Programs may open and close its path at any time: its other end is kept open here, so that it
    never hangs up. Speed and parity have no meaning on it; a program that requires even parity gets an
    error from the operating system and must be set to none.
    """

    def __init__(self) -> None:
        import tty  # not on every system

        self._own, self._kept = os.openpty()
        tty.setraw(self._kept)
        os.set_blocking(self._own, False)
        self.name = os.ttyname(self._kept)
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
