"""Scans on their way into a chunk: collected one by one, laid out as MCAP messages all at once.

Messages of one size differ in few columns only. Constant columns are in the
arena from the start; numpy fills the rest, a column at a time, when the batch
is full. A scan costs four appends.

    opcode length channel | sequence log_time publish_time | prefix scan flags | images, tags
    constant              | column   column   column       | const. col.  col. | column
"""

from __future__ import annotations

from array import array
from collections.abc import Callable
from typing import Any

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from .schema import CDR_PREFIX
from .tagplan import FIELD, TagSource

_PREAMBLE_BYTES = 9
"""Opcode and length of a record, which its length does not include."""

_HEAD_BYTES = 43
"""The fields before the images in the record of a scan."""

_SEQUENCE_MASK = 0xFFFF_FFFF


class ScanBatch:
    """Up to `room` scans, and their layout as message records.

    Args:
        memory: the rack's memory block, copied at every scan.

    Attributes:
        room: most scans of the batch, 1 or more; may be reduced.
    """

    def __init__(self, channel: int, memory: bytearray, room: int) -> None:
        self._start(
            channel, room, message_layout(len(memory)), memoryview(memory).tobytes
        )  # faster than bytes

    def _start(self, channel: int, room: int, layout: np.dtype[np.void], copy: Callable[[], bytes]) -> None:
        """Prepare the records; `copy` returns the bytes after a scan's flags."""
        self.room = room
        self._copy = copy
        self._numbers: list[int] = []
        self._times: list[int] = []
        self._flags: list[int] = []
        self._images: list[bytes] = []
        self._arena = np.zeros(room, layout)
        self._bodies = self._arena.view(message_layout(layout.itemsize - _HEAD_BYTES))["images"]
        self._arena["opcode"] = Opcode.MESSAGE
        self._arena["length"] = self.stride - _PREAMBLE_BYTES
        self._arena["channel"] = channel
        self._arena["prefix"] = CDR_PREFIX

    @property
    def stride(self) -> int:
        """Bytes of a scan's message record."""
        return self._arena.dtype.itemsize

    def add(self, scan: int, now_ns: int, flags: int) -> bool:
        """Add a scan with the present memory block; return whether the batch is full."""
        self._numbers.append(scan)
        self._times.append(now_ns)
        self._flags.append(flags)
        self._images.append(self._copy())
        return len(self._images) >= self.room

    def take(self) -> tuple[NDArray[np.uint64], memoryview]:
        """Return the times of the scans and their successive message records, and start again.

        The records are lent, not copied: they are valid until the next `take`.
        """
        rows = self._arena[: len(self._images)]
        times = np.array(array("Q", self._times))
        numbers = np.array(array("Q", self._numbers)) & np.uint64(_SEQUENCE_MASK)
        rows["sequence"] = numbers
        rows["scan"] = numbers
        rows["log_time"] = times
        rows["publish_time"] = times
        rows["flags"] = array("I", self._flags)
        self._bodies[: len(rows)] = np.frombuffer(b"".join(self._images), self._bodies.dtype)
        for column in (self._numbers, self._times, self._flags, self._images):
            column.clear()
        return times, rows.view(np.uint8).data

    def __len__(self) -> int:
        return len(self._images)


class TagBatch(ScanBatch):
    """Scans with tags: images and tags are copied together."""

    def __init__(self, channel: int, memory: bytearray, room: int, tags: TagSource) -> None:
        self._start(channel, room, message_layout(len(memory), tags.plan.dtype), tags.take)
        self._pending = tags.pending

    def add(self, scan: int, now_ns: int, flags: int) -> bool:
        """Add a scan; return whether the batch is full, or messages are to follow the scan."""
        self._numbers.append(scan)  # not super().add(): the call costs a quarter of the tags
        self._times.append(now_ns)
        self._flags.append(flags)
        self._images.append(self._copy())
        if self._pending:
            return True
        return len(self._images) >= self.room


def message_layout(
    image_bytes: int, tags: np.dtype[np.void] | None = None, rest: np.dtype[np.void] | None = None
) -> np.dtype[np.void]:
    """Return the layout of a scan's message record in a chunk.

    >>> message_layout(32).itemsize
    75
    """
    more: list[Any] = [] if tags is None else [(FIELD, tags)]
    more += [] if rest is None else [("rest", rest)]
    return np.dtype(
        [
            ("opcode", "u1"),
            ("length", "<u8"),
            ("channel", "<u2"),
            ("sequence", "<u4"),
            ("log_time", "<u8"),
            ("publish_time", "<u8"),
            ("prefix", "<u4"),
            ("scan", "<u4"),
            ("flags", "<u4"),
            ("images", f"V{image_bytes}"),
            *more,
        ]
    )
