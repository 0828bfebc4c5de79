"""Collects scans one by one, and encodes them all at once as MCAP messages, which is faster.

Messages of the same size differ only in a few columns. When the batch is full, one join writes all records
with the same head. Then each byte of a column is written as one slice, with the size of a record as its step.

    opcode length channel | sequence log_time publish_time | prefix scan flags | images, tags
    constant              | column   column   column       | const. col.  col. | collected bytes
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from struct import Struct

from mcap.opcode import Opcode

from .schema import CDR_PREFIX
from .tagplan import TagSource

_HEAD = Struct("<BQHIQQIII")
"""Opcode, length, channel, sequence, log time, publish time, CDR prefix, scan, flags."""

HEAD_BYTES = _HEAD.size
"""The fields before the images in the record of a scan."""

_PREAMBLE_BYTES = 9
"""Size of a record's opcode and length, which the length does not include."""

_NUMBER_OFFSETS, _NUMBER_BYTES = (11, 35), 4
_TIME_OFFSETS, _TIME_BYTES = (15, 23), 8
_FLAG_OFFSETS, _FLAG_BYTES = (39,), 4
"""Offsets of each column in a record, and the bytes of its values."""


class ScanBatch:
    """Up to `room` scans, which are encoded together as message records.

    Args:
        memory: the rack's memory block, copied at every scan.

    Attributes:
        room: maximum number of scans in the batch, 1 or more; may be reduced.
        stride: bytes of a scan's message record.
    """

    def __init__(self, channel: int, memory: bytearray, room: int) -> None:
        self._start(channel, room, len(memory), memoryview(memory).tobytes)  # faster than bytes

    def _start(self, channel: int, room: int, body_bytes: int, copy: Callable[[], bytes]) -> None:
        """Prepare the head of the records; `copy` returns the `body_bytes` bytes after a scan's flags."""
        self.room = room
        self.stride = HEAD_BYTES + body_bytes
        self._copy = copy
        self._numbers: list[int] = []
        self._times: list[int] = []
        self._flags: list[int] = []
        self._images: list[bytes] = []
        length = self.stride - _PREAMBLE_BYTES
        self._head = Opcode.MESSAGE, length, channel, 0, 0, 0, CDR_PREFIX, 0

    def add(self, scan: int, now_ns: int, flags: int) -> bool:
        """Add a scan with the current memory block; return whether the batch is full."""
        self._numbers.append(scan)
        self._times.append(now_ns)
        self._flags.append(flags)
        self._images.append(self._copy())
        return len(self._images) >= self.room

    @property
    def look(self) -> Callable[[], bool] | None:
        """The function to call after the logic of each scan that is recorded as a row; None without tags.

        It returns whether messages will follow the scan, which then ends the rows.
        """
        return None

    def begin_rows(self) -> int:
        """Return the maximum number of rows for the next `add_rows`."""
        return max(1, self.room - len(self._images))

    def add_rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> bool:
        """Add successive scans with these images; return whether the batch is full."""
        self._numbers += scans
        self._times += times
        self._flags += [flags] * len(scans)
        self._images += images
        return len(self._images) >= self.room

    def take(self) -> tuple[array[int], bytearray]:
        """Return the times of the scans and their successive message records, and empty the batch."""
        flags = self._flags[0]  # usually the same in all scans
        head = bytearray(_HEAD.pack(*self._head, flags))
        records = head.join([b"", *self._images])
        times = array("Q", self._times)
        self._fill_column(records, times, _TIME_OFFSETS, _TIME_BYTES)
        self._fill_column(records, array("Q", self._numbers), _NUMBER_OFFSETS, _NUMBER_BYTES)
        if self._flags.count(flags) < len(self._flags):
            self._fill_column(records, array("Q", self._flags), _FLAG_OFFSETS, _FLAG_BYTES)
        for column in (self._numbers, self._times, self._flags, self._images):
            column.clear()
        return times, records

    def _fill_column(
        self, records: bytearray, column: array[int], offsets: tuple[int, ...], size: int
    ) -> None:
        """Write the lower `size` bytes of a column's values at some offsets of each record.

        The machine is little-endian, see io_images.image.
        """
        raw, stride, zeros = column.tobytes(), self.stride, bytes(len(column))
        for byte in range(size):
            values = raw[byte :: column.itemsize]
            if values != zeros:
                for offset in offsets:
                    records[offset + byte :: stride] = values

    def __len__(self) -> int:
        return len(self._images)


class TagBatch(ScanBatch):
    """A batch of scans with tags, in which images and tags are copied together."""

    def __init__(self, channel: int, memory: bytearray, room: int, tags: TagSource) -> None:
        self._start(channel, room, len(memory) + tags.plan.size, tags.take)
        self._pending = tags.pending
        self._rows: list[bytes] = []

    def add(self, scan: int, now_ns: int, flags: int) -> bool:
        """Add a scan; return whether the batch is full, or messages will follow the scan."""
        self._numbers.append(scan)  # not super().add(), which would add a quarter to the cost of the tags
        self._times.append(now_ns)
        self._flags.append(flags)
        self._images.append(self._copy())
        if self._pending:
            return True
        return len(self._images) >= self.room

    @property
    def look(self) -> Callable[[], bool] | None:
        """The function that copies a row's tags and returns whether messages will follow its scan."""
        return self._look

    def _look(self) -> bool:
        self._rows.append(self._copy())
        return bool(self._pending)

    def begin_rows(self) -> int:
        """Drop the tags copied so far, and return the maximum number of rows for the next `add_rows`."""
        self._rows.clear()
        return super().begin_rows()

    def add_rows(self, scans: list[int], times: list[int], flags: int, images: list[bytes]) -> bool:
        """Add successive scans, with the tags that `look` has copied; return whether the batch is full."""
        return super().add_rows(scans, times, flags, self._rows[: len(scans)])
