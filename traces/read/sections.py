"""Finds the sections of a trace, and splits a section into parts.

A section is a chunk, or a series of uncompressed messages in another writer's file without chunks.
The head of a chunk and the message indexes after it list its contents, so that the chunk need not be read:

    | chunk: times, sizes, ... | index: channel 1, n entries | index: channel 3, n entries |
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import pairwise
from typing import BinaryIO, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds_column

from ..format.message_layout import message_layout
from ..format.records import (
    BROKEN,
    RECORD_HEAD,
    DamageError,
    Message,
    Span,
    TraceLimitError,
    check_count,
    chunk_data,
    split,
)
from ..format.schema import CDR_PREFIX

_CHUNK_HEAD = struct.Struct("<QQQ")
_INDEX_HEAD = struct.Struct("<HI")
_INDEX_ENTRY_BYTES = 16
_LOOSE_BYTES = 1 << 20
_EVER = 1 << 64
_SAME_HEAD = struct.Struct("<BQH")
"""The first bytes of a message, equal for all messages with the same size and channel."""

_PREFIX = CDR_PREFIX.to_bytes(4, "little")
_PREFIX_AT = 31
"""Offset of the payload's prefix in the record of a scan."""

ScanRows = NDArray[np.void]
"""Successive scans, with the layout of `message_layout`."""


class Part(NamedTuple):
    """A part of a section.

    Attributes:
        offset: offset of the part's first byte in the section.
        content: successive scans, another message, a channel, or a schema.
    """

    offset: int
    content: ScanRows | Message | Channel | Schema


@dataclass(frozen=True, slots=True)
class Section:
    """A chunk, or successive messages outside of chunks."""

    span: Span  # the chunk; outside of chunks, all its messages, from the first opcode on
    start_ns: int  # time of its earliest message; 0 if unknown
    end_ns: int  # time of its latest message; 2**64 if unknown
    size: int  # bytes of its messages, before compression
    counts: Mapping[int, int] = field(default_factory=dict)  # number of messages by channel, from its indexes

    @property
    def is_chunk(self) -> bool:
        """Whether the section is a chunk."""
        return self.span.opcode == Opcode.CHUNK


def find_sections(file: BinaryIO, spans: Sequence[Span]) -> list[Section]:
    """Find the sections of a file among its records, in order."""
    sections: list[Section] = []
    loose: list[Span] = []
    counts: dict[int, int] = {}
    for span in spans:
        if span.opcode == Opcode.MESSAGE:
            loose.append(span)
        elif span.opcode == Opcode.CHUNK:
            counts = {}  # of this chunk; the indexes that follow fill it
            sections.extend(_stretches(loose))
            loose.clear()
            sections.append(_chunk(file, span, counts))
        elif span.opcode == Opcode.MESSAGE_INDEX and span.length >= _INDEX_HEAD.size:
            file.seek(span.offset + RECORD_HEAD.size)
            channel, size = _INDEX_HEAD.unpack(file.read(_INDEX_HEAD.size))
            counts[channel] = size // _INDEX_ENTRY_BYTES
    return [*sections, *_stretches(loose)]


def _chunk(file: BinaryIO, span: Span, counts: Mapping[int, int]) -> Section:
    """Return a chunk's section from the head of the chunk; the caller can fill `counts` later."""
    file.seek(span.offset + RECORD_HEAD.size)
    head = file.read(min(span.length, _CHUNK_HEAD.size))
    start_ns, end_ns, size = _CHUNK_HEAD.unpack(head) if len(head) == _CHUNK_HEAD.size else (0, _EVER, 0)
    return Section(span, start_ns, end_ns, size, counts)


def torn_chunk(file: BinaryIO, spans: Sequence[Span], size: int) -> Section | None:
    """Return the chunk that is cut off by the end of the file, if its times are readable."""
    offset = spans[-1].end
    file.seek(offset)
    head = file.read(RECORD_HEAD.size)
    if offset + RECORD_HEAD.size + _CHUNK_HEAD.size > size or head[0] != Opcode.CHUNK:
        return None
    return _chunk(file, Span(Opcode.CHUNK, offset, size - offset - RECORD_HEAD.size), {})


def _stretches(messages: Sequence[Span]) -> Iterator[Section]:
    """Yield sections of messages outside of chunks; adjacent messages are combined up to 1 MiB."""
    begin = 0
    for index, (message, following) in enumerate(pairwise(messages), start=1):
        touching = message.end == following.offset
        if not touching or following.end - messages[begin].offset > _LOOSE_BYTES:
            yield _stretch(messages[begin:index])
            begin = index
    if messages:
        yield _stretch(messages[begin:])


def _stretch(messages: Sequence[Span]) -> Section:
    size = messages[-1].end - messages[0].offset
    span = Span(Opcode.MESSAGE, messages[0].offset, size - RECORD_HEAD.size)
    return Section(span, 0, _EVER, size)


class ScanShape:
    """The layout of scans in a trace's sections.

    Args:
        channel: ID of the scans' channel; None for a trace without scans.
        memory_bytes: size of the rack's memory block.
        tags: type of the row of tags after the memory block, or None.
        rest_bytes: number of bytes after the tags in a scan, which are ignored.

    Attributes:
        layout: the message record of a scan as a numpy type.
        stride: bytes of that record.
    """

    def __init__(
        self,
        channel: int | None,
        memory_bytes: int,
        tags: np.dtype[np.void] | None = None,
        rest_bytes: int = 0,
    ) -> None:
        self.channel = channel
        unread: np.dtype[np.void] | None = np.dtype(f"V{rest_bytes}") if rest_bytes else None
        self.layout = message_layout(memory_bytes, tags, unread)
        self.stride = self.layout.itemsize
        self._length = self.stride - RECORD_HEAD.size  # as the record of a scan states it
        # the first bytes of each scan's record
        self._begin = b"" if channel is None else _SAME_HEAD.pack(Opcode.MESSAGE, self._length, channel)

    def only_scans(self, section: Section) -> bool:
        """Return whether a chunk's index proves that the chunk has only scans.

        The size and index must agree, so that a damaged or incomplete index is not used.
        """
        count = 0 if self.channel is None else section.counts.get(self.channel, 0)
        return section.is_chunk and count * self.stride == section.size

    def expected(self, section: Section) -> int:
        """Return the expected number of scans in a section, based on its index or its size."""
        if self.channel is None:
            return 0
        return section.counts.get(self.channel, 0 if section.counts else section.size // self.stride)

    def take_apart(self, data: bytes) -> Iterator[Part]:
        """Yield the parts of a section, with successive scans as one part and other records one by one.

        A message on the scans' channel that has a different layout becomes a `Message`.

        Raises:
            ValueError: the data is not made up of complete records.
            TraceLimitError: there are too many records; the caller completes the message.
        """
        offset = singles = single_bytes = 0
        while offset < len(data):
            count = self._scans_from(data, offset)
            if count:
                yield Part(offset, np.frombuffer(data, self.layout, count, offset))
                offset += count * self.stride
            else:
                record, end = split(data, offset)
                singles, single_bytes = singles + 1, single_bytes + end - offset
                check_count(singles, single_bytes)
                if record is not None:
                    yield Part(offset, record)
                offset = end

    def _scans_from(self, data: bytes, offset: int) -> int:
        """Return the number of successive scans that begin at `offset`."""
        if self.channel is None or not self._is_scan(data, offset):
            return 0
        if not self._is_scan(data, offset + self.stride):
            return 1
        rows = np.frombuffer(data, self.layout, (len(data) - offset) // self.stride, offset)
        checked_rows, rows_at_once = 2, 16
        while checked_rows < len(rows):
            are_scans = self._are_scans(rows[checked_rows : checked_rows + rows_at_once])
            if not are_scans.all():
                return checked_rows + int(np.argmin(are_scans))
            checked_rows, rows_at_once = checked_rows + len(are_scans), 4 * rows_at_once
        return len(rows)

    def _is_scan(self, data: bytes, offset: int) -> bool:
        """Return whether a complete scan begins at `offset`, like `_are_scans` but for a single scan."""
        is_whole = offset + self.stride <= len(data)
        return (
            is_whole
            and data.startswith(self._begin, offset)
            and data.startswith(_PREFIX, offset + _PREFIX_AT)
        )

    def _are_scans(self, rows: ScanRows) -> NDArray[np.bool_]:
        """Return a mask of the rows that begin with the head of a scan."""
        are_scans: NDArray[np.bool_] = rows["opcode"] == Opcode.MESSAGE
        are_scans &= rows["length"] == self._length
        are_scans &= rows["channel"] == self.channel
        are_scans &= rows["prefix"] == CDR_PREFIX
        return are_scans


def lost_scans(shape: ScanShape, section: Section) -> str:
    """Return text for a note about a section's scans, with their expected number and times if known."""
    count = shape.expected(section)
    if not count or section.end_ns >= _EVER:
        return "its scans"
    about = "its" if section.counts else "about"
    start, end = seconds_column(section.start_ns), seconds_column(section.end_ns)
    return f"{about} {count:,} scans from {start} s to {end} s"


def take_apart(file: BinaryIO, section: Section, shape: ScanShape) -> list[Part]:
    """Read a section and split it into parts.

    Raises:
        TraceError: the section or its CRC is damaged, or its messages are not complete records.
        TraceLimitError: the section unpacks to more bytes, or has more records, than the limits allow.
    """
    if section.is_chunk:
        data = chunk_data(file, section.span)
    else:
        file.seek(section.span.offset)
        data = file.read(section.size)
    try:
        return list(shape.take_apart(data))
    except TraceLimitError as error:
        raise TraceLimitError(f"the chunk at byte {section.span.offset:,} {error}", error.limit) from error
    except BROKEN as error:
        raise DamageError(f"chunk at byte {section.span.offset:,}: {error}") from error
