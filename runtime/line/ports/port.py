"""What a port is, and what every port has: a count of the bytes that went through it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from ..wire import LineFormat


@dataclass(slots=True)
class Traffic:
    """Bytes that went through a port.

    Attributes:
        received: from the master.
        sent: to the master.
        lost: times that the port went away.
    """

    received: int = 0
    sent: int = 0
    lost: int = 0


class PortError(ValueError):
    """A port that can't be opened; the message says which and why."""


class Port(Protocol):
    """A stream of bytes to and from whoever is at the other end."""

    name: str
    """Where others find it, such as /dev/pts/3 or 127.0.0.1:5020."""

    traffic: Traffic

    def wait(self, seconds: float) -> bytes:
        """Return what has come in; b"" when nothing does within that time."""
        ...

    def send(self, data: bytes) -> None:
        """Send; what nobody is there to take is dropped, as on a line."""
        ...

    def follow(self, line_format: LineFormat) -> None:
        """Listen and speak in a format from now on, where the port has such a thing."""
        ...

    def close(self) -> None:
        """Give the port back."""
        ...
