"""The end of a trace, with the indexes of all records and the footer.

    DataEnd | schemas, channels, statistics, chunk, attachment and metadata indexes | offsets | Footer |
    magic

A writer or a repair collects the summary while it writes the preceding records.
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Mapping
from struct import Struct
from typing import TypeAlias

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from .records import MAGIC

Entries: TypeAlias = "array[int]"
"""For each message, its time and then its offset in the chunk, as unsigned 64-bit integers."""

_INDEX = Struct("<BQHI")
_INDEX_FIELDS_BYTES = 6
_FOOTER = Struct("<BQQQ")
_FOOTER_BYTES = 20
_GROUPS = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
)
"""Order of the records in the summary."""


class Summary:
    """Collects the summary of the records in a trace."""

    def __init__(self) -> None:
        self._groups: dict[Opcode, bytearray] = {opcode: bytearray() for opcode in _GROUPS}
        self._registered: set[tuple[Opcode, int]] = set()
        self._counts = Statistics(
            attachment_count=0,
            channel_count=0,
            channel_message_counts={},
            chunk_count=0,
            message_count=0,
            message_end_time=0,
            message_start_time=0,
            metadata_count=0,
            schema_count=0,
        )

    def register(self, record: Schema | Channel) -> None:
        """Add a schema or channel, unless one with the same ID has already been added."""
        kind = Opcode.SCHEMA if isinstance(record, Schema) else Opcode.CHANNEL
        if (kind, record.id) in self._registered:
            return
        self._registered.add((kind, record.id))
        self._groups[kind] += encoded(record)
        if kind == Opcode.SCHEMA:
            self._counts.schema_count += 1
        else:
            self._counts.channel_count += 1

    def metadata(self, offset: int, length: int, record: Metadata) -> None:
        """Add a metadata record that is `length` bytes long at `offset`."""
        self._groups[Opcode.METADATA_INDEX] += encoded(MetadataIndex(offset, length, record.name))
        self._counts.metadata_count += 1

    def attachment(self, offset: int, length: int, record: Attachment) -> None:
        """Add an attachment that is `length` bytes long at `offset`."""
        index = AttachmentIndex(
            offset=offset,
            length=length,
            create_time=record.create_time,
            log_time=record.log_time,
            data_size=len(record.data),
            name=record.name,
            media_type=record.media_type,
        )
        self._groups[Opcode.ATTACHMENT_INDEX] += encoded(index)
        self._counts.attachment_count += 1

    def chunk(self, offset: int, length: int, chunk: Chunk, entries: Mapping[int, Entries]) -> bytes:
        """Add a chunk; return its message indexes, which follow it."""
        indexes, offsets = bytearray(), {}
        for channel, time_offsets in entries.items():
            offsets[channel] = offset + length + len(indexes)
            indexes += _message_index(channel, time_offsets)
        self._groups[Opcode.CHUNK_INDEX] += encoded(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=offset,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                message_end_time=chunk.message_end_time,
                message_index_length=len(indexes),
                message_index_offsets=offsets,
                message_start_time=chunk.message_start_time,
                uncompressed_size=chunk.uncompressed_size,
            )
        )
        self._counts.chunk_count += 1
        self.messages(chunk.message_start_time, chunk.message_end_time, entries)
        return bytes(indexes)

    def messages(self, first_ns: int, last_ns: int, entries: Mapping[int, Entries]) -> None:
        """Count messages by channel.

        Args:
            first_ns: time of the earliest message.
            last_ns: time of the latest message.
        """
        counts = self._counts
        by_channel = counts.channel_message_counts
        for channel, time_offsets in entries.items():
            message_count = len(time_offsets) // 2
            counts.message_start_time = (
                min(first_ns, counts.message_start_time) if counts.message_count else first_ns
            )
            counts.message_end_time = max(last_ns, counts.message_end_time)
            counts.message_count += message_count
            by_channel[channel] = by_channel.get(channel, 0) + message_count

    def end(self, offset: int, crc: int) -> bytes:
        """Return the bytes at the end of a file.

        Args:
            offset: the end of its data.
            crc: CRC of all data, including the magic; 0 = unknown.
        """
        data_end = encoded(DataEnd(crc))
        start = offset + len(data_end)
        self._groups[Opcode.STATISTICS] += encoded(self._counts)
        summary, offsets = bytearray(), bytearray()
        for opcode, group in self._groups.items():
            if group:
                offsets += encoded(SummaryOffset(opcode, start + len(summary), len(group)))
                summary += group
        offset_start = start + len(summary)
        summary += offsets
        summary_crc = zlib.crc32(
            _FOOTER.pack(Opcode.FOOTER, _FOOTER_BYTES, start, offset_start), zlib.crc32(summary)
        )
        return data_end + bytes(summary) + encoded(Footer(start, offset_start, summary_crc)) + MAGIC


def encoded(record: McapRecord) -> bytes:
    """Return a record as bytes."""
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def _message_index(channel: int, entries: Entries) -> bytes:
    """Return the message index of a channel; the machine is little-endian, see io_images.image."""
    data = entries.tobytes()
    return _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX_FIELDS_BYTES + len(data), channel, len(data)) + data
