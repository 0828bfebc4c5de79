"""A real serial port, which is reopened after it has been unplugged."""

from __future__ import annotations

from collections.abc import Callable
from threading import Event

import serial
from typing_extensions import override

from ..serialport import PORT_ERRORS, reason, settings
from ..wire import LineFormat
from .port import Port, PortError, Traffic

RETRY_S = 0.5
"""Time between two attempts to reopen a lost port, s."""


class SerialPort(Port):
    """A serial port of this machine; `name` is its path, such as /dev/ttyUSB0 or COM3.

    Raises:
        PortError: the port can't be opened.
    """

    def __init__(
        self,
        path: str,
        line_format: LineFormat,
        opened: Callable[[str, LineFormat], serial.Serial] | None = None,
    ) -> None:
        self.name = path
        self.traffic = Traffic()
        self._format = line_format
        self._open = opened or open_serial
        try:
            self._port: serial.Serial | None = self._open(path, line_format)
        except PORT_ERRORS as error:
            raise PortError(f"{path} can't be opened: {reason(error)}") from error

    @property
    def is_open(self) -> bool:
        """Whether the port is open."""
        return self._port is not None

    @override
    def wait(self, seconds: float) -> bytes:
        """Return received bytes; while the port is lost, try to reopen it."""
        if self._port is None:
            Event().wait(min(seconds, RETRY_S))
            self._reopen()
            return b""
        try:
            self._port.timeout = seconds
            data = self._port.read(1)
            data += self._port.read(self._port.in_waiting)
        except PORT_ERRORS:
            self._lose()
            return b""
        self.traffic.received += len(data)
        return bytes(data)

    @override
    def send(self, data: bytes) -> None:
        """Send bytes; drop them while the port is lost."""
        if self._port is None:
            return
        try:
            self._port.write(data)
            self._port.flush()
        except PORT_ERRORS:
            self._lose()
            return
        self.traffic.sent += len(data)

    @override
    def follow(self, line_format: LineFormat) -> None:
        """Change the format, also for a port that is reopened later."""
        if line_format == self._format:
            return
        self._format = line_format
        try:
            if self._port is not None:
                self._port.apply_settings(settings(self.name, line_format))
        except PORT_ERRORS:
            self._lose()

    @override
    def close(self) -> None:
        if self._port is not None:
            self._port.close()

    def _lose(self) -> None:
        self.traffic.lost += 1
        self.close()
        self._port = None

    def _reopen(self) -> None:
        try:
            self._port = self._open(self.name, self._format)
        except PORT_ERRORS:
            self._port = None


def open_serial(path: str, line_format: LineFormat) -> serial.Serial:
    """Open a serial port.

    Raises:
        OSError: the port does not exist, or another process uses it.
        ValueError: the port does not support the format.
        termios.error: the port was unplugged during the setup.
    """
    port = serial.Serial(path, exclusive=True, timeout=0)
    try:
        port.apply_settings(settings(path, line_format))
    except PORT_ERRORS:
        port.close()
        raise
    return port
