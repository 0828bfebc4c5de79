"""A writer that lays the messages out itself, a chunk at a time.

A message is one struct pack and one append; what the `mcap` library's writer
does beside that costs five times as much. All other records are written with the
library's own classes.

    chunk   | message | message | ...   compressed with zstd, level 1
    index   | time, offset | ...        per channel
            both in one write, so that a killed process leaves both or neither
"""

from __future__ import annotations

import zlib
from array import array
from struct import Struct

import numpy as np
import zstandard
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
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from numpy.typing import NDArray

from .output import TraceFile
from .records import MAGIC

_MESSAGE = Struct("<BQHIQQ")
_MESSAGE_FIELDS_BYTES = 22
_INDEX = Struct("<BQHI")
_INDEX_FIELDS_BYTES = 6
_FOOTER = Struct("<BQQQ")
_FOOTER_BYTES = 20
_ZSTD_LEVEL = 1


class ChunkWriter:
    """Writes chunks of messages, with all indexes and the CRCs of chunks and summary.

    Schemas, channels, metadata and attachments come first, then messages.

    Args:
        file: where the records go.
        profile: the MCAP profile, "ros2".
        library: what the header names as the writing software.
        chunk_bytes: size at which a chunk is closed, before compression.
    """

    def __init__(self, file: TraceFile, *, profile: str, library: str, chunk_bytes: int) -> None:
        self._file = file
        self._chunk_bytes = chunk_bytes
        self._compressor = zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
        self._records = bytearray()
        self._entries: dict[int, array[int]] = {}  # channel -> time, offset, time, offset, ...
        self._summary: dict[Opcode, bytearray] = {opcode: bytearray() for opcode in _SUMMARY_GROUPS}
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
        file.write(MAGIC + _encoded(Header(profile, library)))

    @property
    def open_bytes(self) -> int:
        """Bytes of messages in the chunk that is not written yet."""
        return len(self._records)

    def channel(self, topic: str, encoding: str, schema_name: str, schema_encoding: str, schema: str) -> int:
        """Register a channel with a schema of its own; return the channel's id."""
        number = self._counts.channel_count + 1
        self._counts.channel_count = self._counts.schema_count = number
        self._entries[number] = array("Q")
        described = Schema(id=number, name=schema_name, encoding=schema_encoding, data=schema.encode())
        self._register(Opcode.SCHEMA, described)
        self._register(Opcode.CHANNEL, Channel(number, topic, encoding, {}, number))
        return number

    def _register(self, opcode: Opcode, record: Schema | Channel) -> None:
        """Write a record now, and again in the summary."""
        self._file.write(_encoded(record))
        self._summary[opcode] += _encoded(record)

    def add_metadata(self, name: str, data: dict[str, str]) -> None:
        """Write a metadata record."""
        record = _encoded(Metadata(name=name, metadata=data))
        self._counts.metadata_count += 1
        index = MetadataIndex(offset=self._file.tell(), length=len(record), name=name)
        self._summary[Opcode.METADATA_INDEX] += _encoded(index)
        self._file.write(record)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment. It has no time of its own."""
        record = _encoded(Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data))
        self._counts.attachment_count += 1
        index = AttachmentIndex(self._file.tell(), len(record), 0, 0, len(data), name, media_type)
        self._summary[Opcode.ATTACHMENT_INDEX] += _encoded(index)
        self._file.write(record)

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int, /
    ) -> None:
        """Take one message; times in ns."""
        records = self._records
        offset, length = len(records), _MESSAGE_FIELDS_BYTES + len(data)
        records += _MESSAGE.pack(_MESSAGE_OPCODE, length, channel_id, sequence, log_time, publish_time) + data
        self._entries[channel_id].extend((log_time, offset))
        if len(records) >= self._chunk_bytes:
            self._write_chunk()

    def add_block(self, channel_id: int, log_times: NDArray[np.uint64], block: bytes) -> None:
        """Take message records of one size that are laid out already, with their times in ns."""
        start, stride = len(self._records), len(block) // len(log_times)
        entries = np.empty((len(log_times), 2), np.uint64)
        entries[:, 0] = log_times
        entries[:, 1] = start + stride * np.arange(len(log_times), dtype=np.uint64)
        self._entries[channel_id].frombytes(entries.tobytes())
        self._records += block
        if len(self._records) >= self._chunk_bytes:
            self._write_chunk()

    def finish(self) -> None:
        """Write the open chunk, the summary and the footer. The file stays open."""
        if self._records:
            self._write_chunk()
        self._file.write(_encoded(DataEnd(0)))
        start = self._file.tell()
        self._summary[Opcode.STATISTICS] += _encoded(self._counts)
        summary, offsets = bytearray(), bytearray()
        for opcode, group in self._summary.items():
            if group:
                offsets += _encoded(SummaryOffset(opcode, start + len(summary), len(group)))
                summary += group
        offset_start = start + len(summary)
        summary += offsets
        crc = zlib.crc32(_FOOTER.pack(Opcode.FOOTER, _FOOTER_BYTES, start, offset_start), zlib.crc32(summary))
        self._file.write(bytes(summary) + _encoded(Footer(start, offset_start, crc)) + MAGIC)

    def _write_chunk(self) -> None:
        records = self._records
        used = {channel: entries for channel, entries in self._entries.items() if entries}
        first = min(min(entries[::2]) for entries in used.values())
        last = max(max(entries[::2]) for entries in used.values())
        chunk = Chunk(
            compression="zstd",
            data=self._compressor.compress(records),
            message_end_time=last,
            message_start_time=first,
            uncompressed_crc=zlib.crc32(records),
            uncompressed_size=len(records),
        )
        start = self._file.tell()
        out = bytearray(_encoded(chunk))
        length, offsets = len(out), {}
        for channel, entries in used.items():
            offsets[channel] = start + len(out)
            out += _message_index(channel, entries)
        self._summary[Opcode.CHUNK_INDEX] += _encoded(
            ChunkIndex(
                chunk_length=length,
                chunk_start_offset=start,
                compression=chunk.compression,
                compressed_size=len(chunk.data),
                message_end_time=last,
                message_index_length=len(out) - length,
                message_index_offsets=offsets,
                message_start_time=first,
                uncompressed_size=len(records),
            )
        )
        self._count(used, first, last)
        records.clear()
        for entries in used.values():
            del entries[:]
        self._file.write(bytes(out))

    def _count(self, used: dict[int, array[int]], first: int, last: int) -> None:
        counts = self._counts
        counts.message_start_time = min(first, counts.message_start_time) if counts.chunk_count else first
        counts.message_end_time = max(last, counts.message_end_time)
        counts.chunk_count += 1
        for channel, entries in used.items():
            messages = len(entries) // 2
            counts.message_count += messages
            counts.channel_message_counts[channel] = counts.channel_message_counts.get(channel, 0) + messages


_MESSAGE_OPCODE = int(Opcode.MESSAGE)

_SUMMARY_GROUPS = (
    Opcode.SCHEMA,
    Opcode.CHANNEL,
    Opcode.STATISTICS,
    Opcode.CHUNK_INDEX,
    Opcode.ATTACHMENT_INDEX,
    Opcode.METADATA_INDEX,
)
"""Order of the records in the summary."""


def _encoded(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    data: bytes = builder.end()  # type: ignore[no-untyped-call]
    return data


def _message_index(channel: int, entries: array[int]) -> bytes:
    """Return the message index of a channel; the machine is little-endian, see io_images.image."""
    data = entries.tobytes()
    return _INDEX.pack(Opcode.MESSAGE_INDEX, _INDEX_FIELDS_BYTES + len(data), channel, len(data)) + data
