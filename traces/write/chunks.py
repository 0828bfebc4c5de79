"""A writer that lays the messages out itself, a chunk at a time.

A message is one struct pack and one append; the `mcap` library's writer takes five
times as long. All other records are written with the library's own classes.

    chunk   | message | message | ...   compressed with zstd, level 1
    index   | time, offset | ...        per channel
            both in one write, so that a killed process leaves both or neither
"""

from __future__ import annotations

import zlib
from array import array
from collections.abc import Mapping
from struct import Struct
from typing import Protocol

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Header, Metadata, Schema
from numpy.typing import NDArray

from ..format.records import MAGIC
from ..format.summary import Entries, Summary, encoded
from .output import TraceFile

_MESSAGE = Struct("<BQHIQQ")
_MESSAGE_OPCODE = int(Opcode.MESSAGE)
_MESSAGE_FIELDS_BYTES = 22
_ZSTD_LEVEL = 1
_GAPS, _GAP_MORE = 2, 1 << 16
"""The room for a chunk before its draft: a multiple of its uncompressed size, and additional bytes."""


class Sink(Protocol):
    """The target of the records: a `TraceFile`, or a file that counts."""

    def write(self, data: bytes, /) -> int:
        """Write records."""

    def tell(self) -> int:
        """Return the number of written bytes."""


class ChunkWriter:
    """Writes chunks of messages, with all indexes and the CRCs of chunks, data and summary.

    Schemas, channels and metadata come first, then messages; attachments come between chunks at any time.

    Args:
        profile: the MCAP profile, "ros2".
        chunk_bytes: uncompressed size at which a chunk is closed.
    """

    def __init__(self, file: Sink, *, profile: str, library: str, chunk_bytes: int) -> None:
        self._file = file
        self._chunk_bytes = chunk_bytes
        self._compressor = zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
        self._records = bytearray()
        self._entries: dict[int, array[int]] = {}  # channel -> time, offset, time, offset, ...
        self._summary = Summary()
        self._crc = 0
        self._drafted = 0
        self._write(MAGIC + encoded(Header(profile, library)))

    @property
    def open_bytes(self) -> int:
        """Bytes of messages in the chunk that is not written yet."""
        return len(self._records)

    def channel(self, topic: str, encoding: str, schema_name: str, schema_encoding: str, schema: str) -> int:
        """Register a channel with its own schema; return the channel's id."""
        number = len(self._entries) + 1
        self._entries[number] = array("Q")
        described = Schema(id=number, name=schema_name, encoding=schema_encoding, data=schema.encode())
        registered = Channel(number, topic, encoding, {}, number)
        self._write(encoded(described))
        self._write(encoded(registered))
        self._summary.schema(described)
        self._summary.channel(registered)
        return number

    def add_metadata(self, name: str, data: dict[str, str]) -> None:
        """Write a metadata record."""
        record = Metadata(name=name, metadata=data)
        content = encoded(record)
        self._summary.metadata(self._file.tell(), len(content), record)
        self._write(content)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write an attachment. It has no own time."""
        record = Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data)
        content = encoded(record)
        self._summary.attachment(self._file.tell(), len(content), record)
        self._write(content)

    def add_message(
        self, channel_id: int, log_time: int, data: bytes, publish_time: int, sequence: int, /
    ) -> None:
        """Add one message; times in ns."""
        records = self._records
        offset, length = len(records), _MESSAGE_FIELDS_BYTES + len(data)
        records += _MESSAGE.pack(_MESSAGE_OPCODE, length, channel_id, sequence, log_time, publish_time) + data
        self._entries[channel_id].extend((log_time, offset))
        if len(records) >= self._chunk_bytes:
            self._write_chunk()

    def add_block(self, channel_id: int, log_times: NDArray[np.uint64], block: bytes | memoryview) -> None:
        """Add message records of one size, already laid out, with their times in ns."""
        start, stride = len(self._records), len(block) // len(log_times)
        entries = np.empty((len(log_times), 2), np.uint64)
        entries[:, 0] = log_times
        entries[:, 1] = start + stride * np.arange(len(log_times), dtype=np.uint64)
        self._entries[channel_id].frombytes(entries.tobytes())
        self._records += block
        if len(self._records) >= self._chunk_bytes:
            self._write_chunk()

    def draft(self, file: TraceFile) -> None:
        """Write the new messages of the open chunk uncompressed.

        Args:
            file: the file of this writer. The chunk will replace them.
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
        records = self._records
        used = {
            channel: np.array(entries, np.uint64).reshape(-1, 2)
            for channel, entries in self._entries.items()
            if entries
        }
        chunk = chunk_of(records, used, self._compressor)
        content = encoded(chunk)
        indexes = self._summary.chunk(self._file.tell(), len(content), chunk, used)
        records.clear()
        for channel in used:
            del self._entries[channel][:]
        self._write(content + indexes)

    def _write(self, data: bytes) -> None:
        """Write records of the data section, which the CRC at its end covers; a draft is removed."""
        self._drafted = 0
        self._file.write(data)
        self._crc = zlib.crc32(data, self._crc)


def chunk_of(
    records: bytes | bytearray,
    used: Mapping[int, Entries],
    compressor: zstandard.ZstdCompressor | None = None,
) -> Chunk:
    """Return the chunk of some messages.

    Args:
        used: their times and offsets, by channel.
        compressor: of level 1; None = a new one.
    """
    compressor = compressor or zstandard.ZstdCompressor(level=_ZSTD_LEVEL)
    return Chunk(
        compression="zstd",
        data=compressor.compress(records),
        message_end_time=max(int(entries[:, 0].max()) for entries in used.values()),
        message_start_time=min(int(entries[:, 0].min()) for entries in used.values()),
        uncompressed_crc=zlib.crc32(records),
        uncompressed_size=len(records),
    )
