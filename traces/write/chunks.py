"""Writes MCAP in chunks, using a custom message layout.

A message takes one struct pack and one append; the `mcap` library's writer takes five
times as long. All other records are written with the library's own classes.

    chunk   | message | message | ...   compressed with zstd, level 1
    index   | time, offset | ...        per channel
            both are in one write, so that a killed process leaves both or neither
"""

from __future__ import annotations

import json
import zlib
from array import array
from collections.abc import Iterable, Mapping
from struct import Struct
from typing import Protocol

import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema

from ..format.records import MAGIC
from ..format.schema import MESSAGE_ENCODING, SCHEMA_ENCODING, ScanSchema
from ..format.summary import Entries, Summary, encoded
from ..format.topics import MESSAGE_ENCODING as JSON_ENCODING
from ..format.topics import SCAN_TOPIC, Topic
from ..format.topics import SCHEMA_ENCODING as JSON_SCHEMA_ENCODING
from .output import TraceFile

_MESSAGE = Struct("<BQHIQQ")
_MESSAGE_OPCODE = int(Opcode.MESSAGE)
_MESSAGE_FIELDS_BYTES = 22
_ZSTD_LEVEL = 1
_SEQUENCE_MASK = 0xFFFF_FFFF
_NEVER_NS = 1 << 64
"""A time later than every other time, ns."""

_GAPS, _GAP_MORE = 2, 1 << 16
"""Room for a chunk before its draft: this multiple of its uncompressed size, plus this many bytes."""


class Sink(Protocol):
    """The target of the records: a `TraceFile`, or another file that counts its bytes."""

    def write(self, data: bytes, /) -> int:
        """Write records."""

    def tell(self) -> int:
        """Return the number of bytes written."""


class ChunkWriter:
    """Writes chunks of messages, with all indexes and the CRCs of chunks, data and summary.

    Schemas, channels and metadata come first, then messages. Attachments can be added at any time.

    Args:
        profile: the MCAP profile, "ros2".
        chunk_bytes: uncompressed size at which a chunk is closed.
    """

    def __init__(self, file: Sink, *, profile: str, library: str, chunk_bytes: int) -> None:
        self._file = file
        self._chunk_bytes = chunk_bytes
        self._compressor = zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
        self._records = bytearray()
        self._entries: dict[int, Entries] = {}  # by channel
        self._first_ns, self._last_ns = _NEVER_NS, 0  # the least and greatest time in the open chunk
        self._offsets = array("Q")  # offsets in a chunk of successive messages with the same size
        self._summary = Summary()
        self._crc = 0
        self._drafted = 0  # bytes of the open chunk that are already in the file as a draft
        self._write(MAGIC + encoded(Header(profile, library)))

    @property
    def open_bytes(self) -> int:
        """Number of message bytes in the chunk that has not been written yet."""
        return len(self._records)

    def channel(self, topic: str, encoding: str, schema_name: str, schema_encoding: str, schema: str) -> int:
        """Register a channel with its own schema; return the channel's id."""
        number = len(self._entries) + 1
        self._entries[number] = array("Q")
        described = Schema(id=number, name=schema_name, encoding=schema_encoding, data=schema.encode())
        registered = Channel(number, topic, encoding, {}, number)
        self._write(encoded(described))
        self._write(encoded(registered))
        self._summary.register(described)
        self._summary.register(registered)
        return number

    def register(self, schema: ScanSchema, topics: Iterable[Topic]) -> dict[str, int]:
        """Register /scan and the topics of events; return the channel IDs by topic."""
        scan = self.channel(SCAN_TOPIC, MESSAGE_ENCODING, schema.name, SCHEMA_ENCODING, schema.text)
        events = {
            topic.name: self.json_channel(topic.name, topic.schema, topic.schema_text) for topic in topics
        }
        return {SCAN_TOPIC: scan, **events}

    def json_channel(self, topic: str, schema_name: str, schema: str) -> int:
        """Register a channel of JSON messages; return the channel's id."""
        return self.channel(topic, JSON_ENCODING, schema_name, JSON_SCHEMA_ENCODING, schema)

    def add_metadata(self, name: str, data: dict[str, str]) -> None:
        """Write a metadata record."""
        record = Metadata(name=name, metadata=data)
        content = encoded(record)
        self._summary.metadata(self._file.tell(), len(content), record)
        self._write(content)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment that has no time."""
        record = Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)
        content = encoded(record)
        self._summary.attachment(self._file.tell(), len(content), record)
        self._write(content)

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int, /
    ) -> None:
        """Add one message; its times are in ns."""
        records = self._records
        offset, length = len(records), _MESSAGE_FIELDS_BYTES + len(data)
        records += _MESSAGE.pack(_MESSAGE_OPCODE, length, channel_id, sequence, log_time, publish_time) + data
        self._entries[channel_id].extend((log_time, offset))
        self._note_times(log_time, log_time)
        if len(records) >= self._chunk_bytes:
            self._write_chunk()

    def add_event(self, channel_id: int, scan: int, now_ns: int, fields: Mapping[str, object]) -> None:
        """Add the JSON message of an event; raise ValueError for a number that is not finite."""
        content = {"scan": scan, **fields}
        text = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        self.add_message(channel_id, now_ns, text.encode(), now_ns, scan & _SEQUENCE_MASK)

    def add_block(self, channel_id: int, log_times: array[int], block: bytearray) -> None:
        """Add encoded message records of the same size; times are in ns, 64-bit, ascending.

        The writer takes ownership of the block.
        """
        count = len(log_times)
        entries = array("Q", bytes(2 * log_times.itemsize * count))
        entries[::2] = log_times
        entries[1::2] = self._offsets_of(count, len(block) // count)
        self._entries[channel_id] += entries
        self._note_times(log_times[0], log_times[-1])
        if self._records:
            self._records += block
        else:
            self._records = block  # not copied
        if len(self._records) >= self._chunk_bytes:
            self._write_chunk()

    def _offsets_of(self, count: int, stride: int) -> array[int]:
        """Return the offsets of the next messages, which have `stride` bytes each.

        The offsets are the same in most chunks, so the last chunk's array is reused.
        """
        start = len(self._records)
        first_index, gap = divmod(start, stride)
        offsets = self._offsets[first_index : first_index + count]
        if gap or len(offsets) < count or offsets[-1] != start + (count - 1) * stride:
            offsets = array("Q", range(start, start + count * stride, stride))
            if not start:
                self._offsets = offsets
        return offsets

    def _note_times(self, first_ns: int, last_ns: int) -> None:
        """Extend the time range of the open chunk."""
        if first_ns < self._first_ns:
            self._first_ns = first_ns
        if last_ns > self._last_ns:
            self._last_ns = last_ns

    def draft(self, file: TraceFile) -> None:
        """Write the open chunk's new messages, uncompressed.

        Args:
            file: this writer's file. The chunk will replace the messages.
        """
        if len(self._records) > self._drafted:
            gap = _GAPS * self._chunk_bytes + _GAP_MORE
            file.draft(bytes(memoryview(self._records)[self._drafted :]), gap)
            self._drafted = len(self._records)

    def finish(self) -> None:
        """Write the open chunk, the summary and the footer. The file stays open."""
        if self._records:
            self._write_chunk()
        self._file.write(self._summary.end(self._file.tell(), self._crc))

    def _write_chunk(self) -> None:
        """Write the open chunk, compressed, and its indexes in one write; begin the next chunk."""
        records = self._records
        used_entries = {channel: entries for channel, entries in self._entries.items() if entries}
        chunk = chunk_of(records, self._first_ns, self._last_ns, self._compressor)
        content = encoded(chunk)
        indexes = self._summary.chunk(self._file.tell(), len(content), chunk, used_entries)
        self._records = bytearray()
        for entries in used_entries.values():
            del entries[:]
        self._first_ns, self._last_ns = _NEVER_NS, 0
        self._write(content + indexes)

    def _write(self, data: bytes) -> None:
        """Write records of the data section, include them in its CRC, and remove a draft."""
        self._drafted = 0
        self._file.write(data)
        self._crc = zlib.crc32(data, self._crc)


def chunk_of(
    records: bytes | bytearray,
    first_ns: int,
    last_ns: int,
    compressor: zstandard.ZstdCompressor | None = None,
) -> Chunk:
    """Return a chunk that contains the given message records.

    Args:
        first_ns: time of the earliest message.
        last_ns: time of the latest message.
        compressor: a compressor of level 1; None = a new one.
    """
    compressor = compressor or zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
    return Chunk(
        compression="zstd",
        data=compressor.compress(records),
        message_end_time=last_ns,
        message_start_time=first_ns,
        uncompressed_crc=zlib.crc32(records),
        uncompressed_size=len(records),
    )
