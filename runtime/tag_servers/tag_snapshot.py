"""The instant at which a packet reads and writes, and its two passes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from scanrack.io_images.enip.codes import BAD_VALUE, CipRefusedError


class BrokenClientError(ValueError):
    """What a client sends is not its protocol, or it has ended its session: the connection ends."""


@dataclass(frozen=True, slots=True)
class ReadBytes:
    """Bytes of a tag that a packet needs."""

    tag: int  # its index in the listing
    offset: int
    size: int


@dataclass(frozen=True, slots=True)
class WriteBytes:
    """Bytes that a packet puts into a tag."""

    tag: int
    offset: int
    data: bytes
    keep: bytes = b""  # bits that stay as they are; none of them without it


Operation = ReadBytes | WriteBytes


class TagSnapshot(Protocol):
    """Values at one instant; a packet is answered inside of one.

    Attributes:
        now_ns: virtual time.
        version: number of the program's edition, from 1.
    """

    now_ns: int
    version: int

    def read(self, part: ReadBytes) -> bytes:
        """Return bytes."""

    def write(self, change: WriteBytes) -> None:
        """Put bytes; refused if the rack refuses them."""


class Plan(TagSnapshot):
    """The first pass: notes what a packet needs.

    Attributes:
        is_timed: whether the packet asks for the time.
    """

    def __init__(self, version: int = 1) -> None:
        self.version = version
        self.operations: list[Operation] = []
        self.is_timed = False

    @property
    def now_ns(self) -> int:  # type: ignore[override]
        """Note that the time is needed."""
        self.is_timed = True
        return 0

    def read(self, part: ReadBytes) -> bytes:
        """Note it; return zeros."""
        self.operations.append(part)
        return bytes(part.size)

    def write(self, change: WriteBytes) -> None:
        """Note it."""
        self.operations.append(change)


class Instant(TagSnapshot):
    """The second pass: what the scan process has given, in the same order.

    Args:
        results: bytes of a read, b"" of a write, None of what was refused.
    """

    def __init__(self, results: Sequence[bytes | None], now_ns: int, version: int) -> None:
        self._results: Iterator[bytes | None] = iter(results)
        self.now_ns, self.version = now_ns, version

    def read(self, part: ReadBytes) -> bytes:
        """Return the bytes that came back."""
        return self._next()

    def write(self, change: WriteBytes) -> None:
        """Refuse what was refused."""
        self._next()

    def _next(self) -> bytes:
        found = next(self._results, None)
        if found is None:
            raise CipRefusedError(BAD_VALUE)
        return found
