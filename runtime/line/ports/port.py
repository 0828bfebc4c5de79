"""The interface that every port has, and the count of its bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..wire import LineFormat


@dataclass(slots=True)
class Traffic:
    """Number of bytes that passed through a port, and number of times the port was lost."""

    received: int = 0
    sent: int = 0
    lost: int = 0


class PortError(ValueError):
    """A port can't be opened; the message contains the port and the cause."""


class Port(Protocol):
    """A stream of bytes to and from the other end."""

    name: str
    """Address for clients, such as /dev/pts/3 or 127.0.0.1:5020."""

    traffic: Traffic

    def wait(self, seconds: float) -> bytes:
        """Return received bytes, or b"" after `seconds`."""

    def send(self, data: bytes) -> None:
        """Send bytes; if there is no receiver, drop them, as on a line."""

    def follow(self, line_format: LineFormat) -> None:
        """Change the character format, if the port has one."""

    def close(self) -> None:
        """Close the port."""
