"""The interface of every port, and its count of bytes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..wire import LineFormat


@dataclass(slots=True)
class Traffic:
    """Bytes that went through a port, and the number of times that it was lost."""

    received: int = 0
    sent: int = 0
    lost: int = 0


class PortError(ValueError):
    """A port that can't be opened; the message names it and the cause."""


class Port(Protocol):
    """A stream of bytes to and from the other end."""

    name: str
    """Address for clients, such as /dev/pts/3 or 127.0.0.1:5020."""

    traffic: Traffic

    def wait(self, seconds: float) -> bytes:
        """Return received bytes; b"" if none arrive in that time."""

    def send(self, data: bytes) -> None:
        """Send; bytes without a receiver are dropped, as on a line."""

    def follow(self, line_format: LineFormat) -> None:
        """Change the character format, if the port has one."""

    def close(self) -> None:
        """Close the port."""
