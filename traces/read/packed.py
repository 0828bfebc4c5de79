"""Packs scans in memory: a few bytes per scan instead of 52. Sequential reads are as fast as from a list.

chunk      4,096 scans, compressed
view       a column as a sequence; it keeps the chunk that was read last unpacked
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Generic, TypeVar, overload

import numpy as np
import zstandard

from .columns import Columns, join, no_columns

CHUNK_SCANS = 4096

_HEAD = 3
"""Number of values before a scan's images: its number, time and flags."""

T = TypeVar("T")

RECENT = 16
"""Maximum number of unpacked chunks to keep, since searches read chunks more than once."""


class PackedScans:
    """Scans, packed chunk by chunk."""

    def __init__(self, words: int) -> None:
        self._words = words
        self._packed: list[bytes] = []
        self._unpacked = no_columns(words)  # scans at the end, fewer than a chunk
        self._compressor = zstandard.ZstdCompressor(level=1)
        self._recent: dict[int, Columns] = {}  # unpacked chunks by number, the most recently read one last

    @classmethod
    def of(cls, words: int, blocks: Iterable[Columns]) -> PackedScans:
        """Pack blocks of scans.

        Args:
            words: words of the memory block.
        """
        scans = cls(words)
        for columns in blocks:
            scans.add(columns)
        return scans

    def __len__(self) -> int:
        return CHUNK_SCANS * len(self._packed) + len(self._unpacked.scan)

    def add(self, columns: Columns) -> None:
        """Add scans at the end."""
        rows = join((self._unpacked, columns))
        start = 0
        while len(rows.scan) - start >= CHUNK_SCANS:
            self._packed.append(self._pack(rows.rows(start, start + CHUNK_SCANS)))
            start += CHUNK_SCANS
        self._unpacked = rows.each(lambda column: column[start:].copy())

    def chunk(self, number: int) -> Columns:
        """Return the scans of a chunk; empty if the number is past the last chunk."""
        if number < len(self._packed):
            unpacked = self._recent.pop(number, None) or self._unpack(self._packed[number])
            self._recent[number] = unpacked
            if len(self._recent) > RECENT:
                del self._recent[next(iter(self._recent))]
            return unpacked
        return self._unpacked if number == len(self._packed) else no_columns(self._words)

    def chunks(self, first: int = 0) -> Iterator[Columns]:
        """Iterate over the chunks, beginning with number `first`, without keeping them unpacked."""
        for number in range(first, len(self._packed) + 1):
            yield self._unpack(self._packed[number]) if number < len(self._packed) else self._unpacked

    def columns(self, first: int = 0) -> Columns:
        """Return the scans from chunk `first` on, unpacked to 20 bytes per scan and two per word."""
        return join([no_columns(self._words), *self.chunks(first)])

    def view(self, values: Callable[[Columns], Sequence[T]]) -> View[T]:
        """Return a sequence of the values that a function computes from the scans of each chunk."""
        return View(self, values)

    def _pack(self, columns: Columns) -> bytes:
        packed = self._compressor.compress(b"".join(column.tobytes() for column in columns.images()))
        return bytes(memoryview(packed))  # a copy without the compressor's spare room

    def _unpack(self, packed: bytes) -> Columns:
        """Return the columns of a packed chunk with `CHUNK_SCANS` scans."""
        data = zstandard.decompress(packed)
        offset, columns = 0, []
        for empty in no_columns(self._words).images():  # for type and width of each column
            width = empty.shape[1] if empty.ndim > 1 else 1
            values = np.frombuffer(data, empty.dtype, CHUNK_SCANS * width, offset)
            columns.append(values.reshape((CHUNK_SCANS, *empty.shape[1:])))
            offset += values.nbytes
        return Columns(*columns)


class NotedScans:
    """Scans that a listener of the scan loop receives one by one; each full chunk is packed."""

    def __init__(self, words: int) -> None:
        self._packed = PackedScans(words)
        self._heads = array("q")
        self._blocks = bytearray()

    def __len__(self) -> int:
        return len(self._packed) + len(self._heads) // _HEAD

    def add(self, scan: int, now_ns: int, flags: int, block: bytes | bytearray) -> None:
        """Add a scan with its number, time and flags, and the rack's current memory block."""
        self._heads.extend((scan, now_ns, flags))
        self._blocks += block
        if len(self._heads) == _HEAD * CHUNK_SCANS:
            self.packed()

    def packed(self) -> PackedScans:
        """Return all scans up to now; later scans are added to the same object."""
        if self._heads:
            heads = np.array(self._heads, np.int64).reshape(-1, _HEAD)
            words = np.array(self._blocks).view(np.int16).reshape(len(heads), -1)
            self._packed.add(Columns(heads[:, 0], heads[:, 1], heads[:, 2].astype(np.uint32), words))
            self._heads = array("q")
            self._blocks = bytearray()
        return self._packed


class View(Sequence[T], Generic[T]):
    """A sequence of values computed from each scan, which is fast when read in order.

    Args:
        values: returns the values of a chunk, one for each scan.
    """

    def __init__(self, scans: PackedScans, values: Callable[[Columns], Sequence[T]]) -> None:
        self._scans, self._values = scans, values
        self._start = self._stop = 0
        self._chunk_values: Sequence[T] = ()  # of the rows from `_start` to before `_stop`

    def __len__(self) -> int:
        return len(self._scans)

    @overload
    def __getitem__(self, row: int) -> T: ...
    @overload
    def __getitem__(self, row: slice) -> Sequence[T]: ...
    def __getitem__(self, row: int | slice) -> T | Sequence[T]:
        """Return the value of a scan, or a list of values; compute the values of its chunk if necessary."""
        if row.__class__ is int and self._start <= row < self._stop:  # read in order, as in nearly all cases
            return self._chunk_values[row - self._start]
        if isinstance(row, slice):
            return [self[index] for index in range(*row.indices(len(self)))]
        row = row + len(self) if row < 0 else row
        if not 0 <= row < len(self):
            raise IndexError("no such scan")
        number = row // CHUNK_SCANS
        self._chunk_values = self._values(self._scans.chunk(number))
        self._start = CHUNK_SCANS * number
        self._stop = self._start + len(self._chunk_values)
        return self._chunk_values[row - self._start]


def memory_blocks(columns: Columns) -> list[bytes]:
    """Return the rack's memory block in each scan."""
    size = 2 * columns.words.shape[1]
    data = columns.words.tobytes()
    return [data[start : start + size] for start in range(0, len(data), size)]
