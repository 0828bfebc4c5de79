"""Packs scans in memory: each takes a few bytes instead of 52, and reading in order is as fast as a list.

chunk      4,096 scans, compressed         any number of them
view       a column as a sequence          keeps the chunk that it reads unpacked
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Sequence
from typing import Generic, TypeVar, overload

import numpy as np
import zstandard

from .columns import Columns, join, no_columns

CHUNK_SCANS = 4096

_HEAD = 3
"""Numbers before a scan's images: number, time, flags."""

T = TypeVar("T")

RECENT = 16
"""Number of unpacked chunks that are kept, because searches read chunks more than once."""


class PackedScans:
    """Scans, packed chunk by chunk."""

    def __init__(self, words: int) -> None:
        self._words = words
        self._packed: list[bytes] = []
        self._waiting = no_columns(words)
        self._compressor = zstandard.ZstdCompressor(level=1)
        self._recent: dict[int, Columns] = {}  # unpacked chunks, the most recent one last

    @classmethod
    def of(cls, words: int, parts: Iterator[Columns] | Sequence[Columns]) -> PackedScans:
        """Return packed scans, for a memory block with a number of words."""
        scans = cls(words)
        for columns in parts:
            scans.add(columns)
        return scans

    def __len__(self) -> int:
        return CHUNK_SCANS * len(self._packed) + len(self._waiting.scan)

    def add(self, columns: Columns) -> None:
        """Add scans at the end."""
        rows = join((self._waiting, columns))
        start = 0
        while len(rows.scan) - start >= CHUNK_SCANS:
            self._packed.append(self._pack(rows.rows(start, start + CHUNK_SCANS)))
            start += CHUNK_SCANS
        self._waiting = rows.each(lambda column: column[start:].copy())

    def chunk(self, number: int) -> Columns:
        """Return the scans of a chunk; none after the last one."""
        if number < len(self._packed):
            unpacked = self._recent.pop(number, None) or self._unpack(self._packed[number])
            self._recent[number] = unpacked
            if len(self._recent) > RECENT:
                del self._recent[next(iter(self._recent))]
            return unpacked
        return self._waiting if number == len(self._packed) else no_columns(self._words)

    def chunks(self, first: int = 0) -> Iterator[Columns]:
        """Iterate over the chunks, beginning with number `first`; none is kept unpacked."""
        for number in range(first, len(self._packed) + 1):
            yield self._unpack(self._packed[number]) if number < len(self._packed) else self._waiting

    def columns(self, first: int = 0) -> Columns:
        """Return all scans, beginning with a chunk, as columns: 20 bytes per scan and two per word."""
        return join([no_columns(self._words), *self.chunks(first)])

    def view(self, values: Callable[[Columns], Sequence[T]]) -> View[T]:
        """Return the values that a function computes from the scans, chunk by chunk, as one sequence."""
        return View(self, values)

    def _pack(self, columns: Columns) -> bytes:
        packed = self._compressor.compress(b"".join(column.tobytes() for column in columns.images()))
        return bytes(memoryview(packed))  # a copy without the compressor's spare room

    def _unpack(self, packed: bytes) -> Columns:
        data = zstandard.decompress(packed)
        like = no_columns(self._words)
        offset, columns = 0, []
        for column in like.images():
            width = column.shape[1] if column.ndim > 1 else 1
            count = CHUNK_SCANS * width
            values = np.frombuffer(data, column.dtype, count, offset)
            columns.append(values.reshape((CHUNK_SCANS, *column.shape[1:])))
            offset += values.nbytes
        return Columns(*columns)


class NotedScans:
    """Scans that a listener of the scan loop receives, packed one by one."""

    def __init__(self, words: int) -> None:
        self._packed = PackedScans(words)
        self._heads = array("q")
        self._blocks = bytearray()

    def __len__(self) -> int:
        return len(self._packed) + len(self._heads) // _HEAD

    def add(self, scan: int, now_ns: int, flags: int, block: bytes | bytearray) -> None:
        """Add a scan: its number, time and flags, and the rack's current memory block."""
        self._heads.extend((scan, now_ns, flags))
        self._blocks += block
        if len(self._heads) == _HEAD * CHUNK_SCANS:
            self.packed()

    def packed(self) -> PackedScans:
        """Return all scans so far; later scans are added to the same object."""
        if self._heads:
            heads = np.array(self._heads, np.int64).reshape(-1, _HEAD)
            words = np.array(self._blocks).view(np.int16).reshape(len(heads), -1)
            self._packed.add(Columns(heads[:, 0], heads[:, 1], heads[:, 2].astype(np.uint32), words))
            self._heads = array("q")
            self._blocks = bytearray()
        return self._packed


class View(Sequence[T], Generic[T]):
    """A sequence of values computed from each scan; fast when read in order.

    Args:
        values: returns the values of a chunk, one for each scan.
    """

    def __init__(self, scans: PackedScans, values: Callable[[Columns], Sequence[T]]) -> None:
        self._scans, self._values = scans, values
        self._start = self._stop = 0
        self._held: Sequence[T] = ()

    def __len__(self) -> int:
        return len(self._scans)

    @overload
    def __getitem__(self, row: int) -> T: ...
    @overload
    def __getitem__(self, row: slice) -> Sequence[T]: ...
    def __getitem__(self, row: int | slice) -> T | Sequence[T]:
        if row.__class__ is int and self._start <= row < self._stop:  # read in order, as in nearly all cases
            return self._held[row - self._start]
        if isinstance(row, slice):
            return [self[index] for index in range(*row.indices(len(self)))]
        row = self._hold(row)
        return self._held[row - self._start]

    def _hold(self, row: int) -> int:
        """Unpack the chunk that contains a row; return the row, counted from the beginning."""
        row = row + len(self) if row < 0 else row
        if not 0 <= row < len(self):
            raise IndexError("no such scan")
        number = row // CHUNK_SCANS
        self._held = self._values(self._scans.chunk(number))
        self._start = CHUNK_SCANS * number
        self._stop = self._start + len(self._held)
        return row


def memory_blocks(columns: Columns) -> list[bytes]:
    """Return the rack's memory block in each scan."""
    size = 2 * columns.words.shape[1]
    data = columns.words.tobytes()
    return [data[start : start + size] for start in range(0, len(data), size)]
