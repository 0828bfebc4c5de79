"""A ring in shared memory that passes scans, messages and snapshots to another process, without a lock.

    head      counters of 8 bytes, one writer each, see `_ROWS` and the others
    rows      one per scan: number, flags, times, figures, the rack's memory, the number again
    messages  records of JSON: events and answers
    snapshots records of bytes: the program's values at some scans

The scan loop writes and never waits. A reader copies rows, then reads the head again and drops any rows that
may have been overwritten in the meantime. Each row repeats its number at its end, because some processors
reorder stores.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .shared_memory import SharedMemory

ROWS = 1 << 15
"""Default number of rows: 65 s of scans at 2 ms."""

AT_ONCE = 256
"""Maximum number of rows written at once."""

MESSAGE_BYTES = 1 << 20
SNAPSHOT_BYTES = 1 << 23

SCAN_MASK = 0xFFFF_FFFF

Row = np.void
Rows = NDArray[np.void]
"""Rows of a ring: scan, flags, now_ns, wall_ns, figures, memory, again."""


_ROWS, _MESSAGES, _SNAPSHOTS, ORDERS, REQUESTS = range(5)
"""Counters in the head. The scan loop counts written rows, and written bytes of messages and snapshots.
The monitor counts the actions that it sends, and the snapshots that it requests.
"""

_HEAD_BYTES = 128


class RingShape(NamedTuple):
    """The dimensions that another process needs to open a ring."""

    memory_bytes: int
    figures: int  # figures per row, in addition to the memory
    rows: int


class RingRows(NamedTuple):
    """Rows that were read."""

    rows: Rows  # a copy, in the order of the scans
    end: int  # position of the next read
    lost: int  # rows that were overwritten before they could be read


Put = Callable[[int, int, int, int, tuple[int, ...], bytes | bytearray], None]
"""Function that writes a row: scan, flags, now_ns, wall_ns, figures and the rack's memory."""


class Ring:
    """The ring of a session.

    Args:
        memory_bytes: size of the rack's memory.
        figures: how many 64-bit numbers each row has in addition to the memory.

    Attributes:
        shape: dimensions of the ring.
        at_once: maximum number of rows written at once. A reader skips this many of the oldest rows, since
            they may be overwritten in the meantime.
        memory: the shared memory of the ring.
        head: the counters, by `ORDERS`, `REQUESTS` and the others; the scan loop checks them after every
            scan.
        put: function that writes a row; called after every scan.
    """

    put: Put

    def __init__(self, memory_bytes: int, figures: int = 0, rows: int = ROWS) -> None:
        if rows & (rows - 1) or rows < 2:
            raise ValueError(f"a ring of {rows} rows is not allowed: must be a power of two")
        shape = RingShape(memory_bytes, figures, rows)
        self._open(SharedMemory(size_of(shape)), shape)

    @classmethod
    def opened(cls, shape: RingShape, memory: SharedMemory) -> Ring:
        """Open the ring that another process has created in `memory`."""
        ring = cls.__new__(cls)
        ring._open(memory, shape)
        return ring

    def _open(self, memory: SharedMemory, shape: RingShape) -> None:
        """Divide the memory into head, rows, messages and snapshots; make the function `put`."""
        self.shape = shape
        self.memory = memory
        self.dtype = row_type(shape.memory_bytes, shape.figures)
        self._stride = self.dtype.itemsize
        self._mask = shape.rows - 1
        self.at_once = min(AT_ONCE, shape.rows // 4 or 1)
        memory_view = memoryview(memory.map)
        start = _HEAD_BYTES + shape.rows * self._stride
        self.head = memory_view[:_HEAD_BYTES].cast("Q")
        self._rows = memory_view[_HEAD_BYTES:start]
        self.messages = Records(self.head, _MESSAGES, memory_view[start : start + MESSAGE_BYTES])
        start += MESSAGE_BYTES
        self.snapshots = Records(self.head, _SNAPSHOTS, memory_view[start : start + SNAPSHOT_BYTES])
        pad = self._stride - _row_struct(shape, 0).size
        self.put = _putter(self.head, self._rows, _row_struct(shape, pad), self._mask)

    def put_all(
        self,
        scan: int,
        flags: int,
        now_ns: int,
        wall_ns: int,
        figures: tuple[int, ...],
        images: Sequence[bytes],
        *,
        period_ns: int,
        wall_step_ns: int,
    ) -> None:
        """Write the rows of successive scans.

        Args:
            scan: number of the last scan.
            now_ns: virtual time of the last scan.
            wall_ns: wall time of the last scan.
            images: the rack's memory after each scan, at most `at_once`.
        """
        offsets, rows_written = np.arange(1 - len(images), 1), self.head[_ROWS]
        rows = np.zeros(len(images), self.dtype)
        rows["scan"] = rows["again"] = (scan + offsets) & SCAN_MASK
        rows["flags"], rows["figures"] = flags, figures
        rows["now_ns"], rows["wall_ns"] = now_ns + offsets * period_ns, wall_ns + offsets * wall_step_ns
        rows["words"] = np.frombuffer(b"".join(images), "<i2").reshape(rows["words"].shape)
        data, begin = rows.tobytes(), (rows_written & self._mask) * self._stride
        bytes_to_end = len(self._rows) - begin
        self._rows[begin : begin + len(data)] = data[:bytes_to_end]
        self._rows[: max(0, len(data) - bytes_to_end)] = data[bytes_to_end:]
        self.head[_ROWS] = rows_written + len(images)

    # --- the monitor

    @property
    def written(self) -> int:
        """Number of rows written so far."""
        return int(self.head[_ROWS])

    def take(self, since: int) -> RingRows:
        """Return the rows from a position on, without rows that were overwritten."""
        end = self.written
        first_row = max(since, end - self.shape.rows + self.at_once, 0)
        indexes = np.arange(first_row, end) & self._mask
        rows = np.frombuffer(self._rows, self.dtype)[indexes]
        overwritten = self.written - self.shape.rows + self.at_once - first_row
        if overwritten > 0:
            rows, first_row = rows[overwritten:], min(first_row + overwritten, end)
        return RingRows(rows[rows["scan"] == rows["again"]], end, first_row - since)

    def close(self) -> None:
        """Close the ring. The memory is released when the last process has closed the ring or has ended."""
        self.messages.release()
        self.snapshots.release()
        self.head.release()
        self._rows.release()
        self.memory.close()


def _putter(head: memoryview, rows: memoryview, row: Struct, mask: int) -> Put:
    """Return a function that writes rows; for speed, it uses local variables."""
    pack, stride = row.pack_into, row.size

    def put(
        scan: int, flags: int, now_ns: int, wall_ns: int, figures: tuple[int, ...], memory: bytes | bytearray
    ) -> None:
        rows_written = head[0]
        number = scan & SCAN_MASK
        pack(rows, (rows_written & mask) * stride, number, flags, now_ns, wall_ns, *figures, memory, number)
        head[0] = rows_written + 1

    return put


def size_of(shape: RingShape) -> int:
    """Return the size of a ring in bytes."""
    stride = row_type(shape.memory_bytes, shape.figures).itemsize
    return _HEAD_BYTES + shape.rows * stride + MESSAGE_BYTES + SNAPSHOT_BYTES


class Records:
    """A circular buffer of the latest byte records, which one process writes and another reads.

    A record consists of its length in 4 bytes and its data. Each record begins at a multiple of 8 bytes.

    Args:
        index: index in the head of the counter for bytes written so far.
    """

    def __init__(self, head: memoryview, index: int, buffer: memoryview) -> None:
        self._head, self._index, self._buffer = head, index, buffer
        self._size = len(buffer)

    @property
    def end(self) -> int:
        """Number of bytes written so far, which is the position of the next record."""
        return int(self._head[self._index])

    @property
    def oldest(self) -> int:
        """Position at which a new reader begins: 0, or `end` if the first record may be lost."""
        return 0 if self.end <= self._margin else self.end

    def write(self, record: bytes) -> bool:
        """Write a record; return False if it does not fit into a quarter of the buffer."""
        length = _aligned(4 + len(record))
        if length > self._size // 4:
            return False
        end = self.end
        offset = end % self._size
        if offset + length > self._size:  # continue at the start of the buffer
            _LENGTH.pack_into(self._buffer, offset, _END_OF_BUFFER)
            end += self._size - offset
            self._head[self._index] = end
            offset = 0
        _LENGTH.pack_into(self._buffer, offset, len(record))
        self._buffer[offset + 4 : offset + 4 + len(record)] = record
        self._head[self._index] = end + length
        return True

    def read(self, since: int) -> tuple[list[bytes], int, bool]:
        """Return the records from a position on.

        Returns:
            The records, the next position, and whether records were lost because the writer had overwritten
            them.
        """
        end = self.end
        copy = self._copied(since, end) if end - since <= self._margin else None
        if copy is None or self.end - since > self._margin:
            return [], self.end, True
        return _split(copy, since, self._size), end, False

    @property
    def _margin(self) -> int:
        """Maximum bytes between a reader and the writer, which may be writing the next quarter."""
        return self._size - self._size // 4

    def _copied(self, since: int, end: int) -> bytes:
        """Return the bytes between two positions, which can wrap around the end of the buffer."""
        begin, stop = since % self._size, end % self._size
        if end == since:
            return b""
        if begin < stop:
            return bytes(self._buffer[begin:stop])
        return bytes(self._buffer[begin:]) + bytes(self._buffer[:stop])

    def release(self) -> None:
        """Release the memory."""
        self._buffer.release()


_LENGTH = Struct("<I")
_END_OF_BUFFER = 0xFFFF_FFFF
"""Written in place of a length if the next record is at the start of the buffer."""


def _aligned(length: int) -> int:
    """Return a length rounded up to a multiple of 8."""
    return -(-length // 8) * 8


def _split(copy: bytes, since: int, size: int) -> list[bytes]:
    """Return the records in bytes that begin at position `since`, without gaps at the buffer's end."""
    records, offset = [], 0
    while offset < len(copy):
        (length,) = _LENGTH.unpack_from(copy, offset)
        if length == _END_OF_BUFFER:
            offset += size - (since + offset) % size
            continue
        records.append(copy[offset + 4 : offset + 4 + length])
        offset += _aligned(4 + length)
    return records


def row_type(memory_bytes: int, figures: int) -> np.dtype[Any]:
    """Return the memory layout of a row, see `Rows`; the pad makes its size a multiple of 8 bytes."""
    fields: list[tuple[Any, ...]] = [
        ("scan", "<u4"),
        ("flags", "<u4"),
        ("now_ns", "<i8"),
        ("wall_ns", "<i8"),
        ("figures", "<i8", (figures,)),
        ("words", "<i2", (memory_bytes // 2,)),
        ("again", "<u4"),
    ]
    packed = np.dtype(fields)
    fields.append(("pad", f"V{_aligned(packed.itemsize) - packed.itemsize or 8}"))
    return np.dtype(fields)


def _row_struct(shape: RingShape, pad: int) -> Struct:
    """Return the layout of `row_type` for packing, with a number of pad bytes."""
    return Struct(f"<IIqq{shape.figures}q{shape.memory_bytes}sI{pad}x")
