"""The instant at which a packet reads and writes, and its two passes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from scanrack.io_images.enip.codes import BAD_VALUE, CipRefusedError


class BrokenClientError(ValueError):
    """A protocol violation or the end of a session; either one ends the connection."""


@dataclass(frozen=True, slots=True)
class ReadBytes:
    """Bytes of a tag that a packet reads."""

    tag: int  # its index in the listing
    offset: int
    size: int


@dataclass(frozen=True, slots=True)
class WriteBytes:
    """Bytes that a packet writes to a tag."""

    tag: int
    offset: int
    data: bytes
    keep: bytes = b""  # mask of bits that do not change; empty = every bit is written


Operation = ReadBytes | WriteBytes


def bits_to_write(tag: int, first: int, bits: Sequence[object]) -> WriteBytes:
    """Return the operation that writes successive bits; other bits in the same bytes do not change.

    Args:
        first: number of the first bit in the tag.
    """
    offset, shift = divmod(first, 8)
    size = -(-(shift + len(bits)) // 8)
    on_bits = sum(bool(bit) << bit_place for bit_place, bit in enumerate(bits, shift))
    keep_mask = (1 << 8 * size) - 1 - (((1 << len(bits)) - 1) << shift)
    return WriteBytes(tag, offset, on_bits.to_bytes(size, "little"), keep_mask.to_bytes(size, "little"))


class TagSnapshot(Protocol):
    """The values at one instant; each packet is answered from one snapshot.

    Attributes:
        now_ns: virtual time.
        version: edition number of the program, from 1.
    """

    now_ns: int
    version: int

    def read(self, part: ReadBytes) -> bytes:
        """Return bytes of a tag."""

    def write(self, change: WriteBytes) -> None:
        """Write bytes; refuse the write if the rack refuses it."""


class Plan(TagSnapshot):
    """The first pass, which records the operations of a packet.

    Attributes:
        is_timed: whether the packet needs the time.
    """

    def __init__(self, version: int = 1) -> None:
        self.version = version
        self.operations: list[Operation] = []
        self.is_timed = False

    @property
    def now_ns(self) -> int:  # type: ignore[override]
        """0; a read of this property records that the packet needs the time."""
        self.is_timed = True
        return 0

    def read(self, part: ReadBytes) -> bytes:
        """Record the read; return zeros."""
        self.operations.append(part)
        return bytes(part.size)

    def write(self, change: WriteBytes) -> None:
        """Record the write."""
        self.operations.append(change)


class Instant(TagSnapshot):
    """The second pass, which returns the results from the scan process in the same order.

    Args:
        results: the bytes of a read, b"" for a write, None for a refused operation.
    """

    def __init__(self, results: Sequence[bytes | None], now_ns: int, version: int) -> None:
        self._results: Iterator[bytes | None] = iter(results)
        self.now_ns, self.version = now_ns, version

    def read(self, part: ReadBytes) -> bytes:
        """Return the bytes of the next result."""
        return self._next()

    def write(self, change: WriteBytes) -> None:
        """Consume the next result; refuse if the scan process refused the write."""
        self._next()

    def _next(self) -> bytes:
        result = next(self._results, None)
        if result is None:
            raise CipRefusedError(BAD_VALUE)
        return result
