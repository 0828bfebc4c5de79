"""Reads records and chunks of MCAP.

    89 "MCAP0" 0D 0A                          magic
    opcode u8 | length u64 | content          a record; again and again, the footer last
    89 "MCAP0" 0D 0A                          magic

Only complete records are returned. Errors name the offset of a damaged record.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from io import BytesIO
from typing import BinaryIO, NamedTuple, TypeVar

from lz4.frame import LZ4FrameDecompressor
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Schema
from zstandard import ZstdDecompressor, ZstdError, frame_content_size

from .limits import limits

MAGIC = b"\x89MCAP0\r\n"

RECORD_HEAD = struct.Struct("<BQ")
"""Head of every record: its opcode and the length of its content."""

DRAFT = 0xD7
"""scanrack's private record: a placeholder for an unfinished chunk whose messages follow uncompressed."""

_MESSAGE = struct.Struct("<HIQQ")
_CRC = struct.Struct("<I")
BROKEN = (McapError, struct.error, ValueError, OverflowError, RuntimeError, EOFError, MemoryError, ZstdError)
"""Exceptions that libraries raise for malformed bytes."""

R = TypeVar("R")


class TraceError(ValueError):
    """A file can't be read as a trace; the message states the reason and the offset."""


class DamageError(TraceError):
    """Part of a file is damaged; the message begins with "damaged"."""

    def __init__(self, text: str) -> None:
        super().__init__(f"damaged {text}")


class Damage(str):
    """A note about damage; other notes report a missing end."""

    __slots__ = ()


def note_of(error: TraceError, outcome: str) -> str:
    """Return a note about an error and its outcome, such as "it is left out"; a Damage for a DamageError."""
    text = f"{error}; {outcome}"
    return Damage(text) if isinstance(error, DamageError) else text


class TraceLimitError(TraceError):
    """A trace exceeds the limits; see `limits.Limits`."""

    def __init__(self, message: str, limit: str) -> None:
        super().__init__(message)
        self.limit = limit


class Span(NamedTuple):
    """The location of a record, as the offset of its opcode and the length of its content, in bytes."""

    opcode: int
    offset: int
    length: int

    @property
    def end(self) -> int:
        """Offset of the next record."""
        return self.offset + RECORD_HEAD.size + self.length


class Message(NamedTuple):
    """A message in a chunk; time in ns."""

    channel: int
    sequence: int
    log_time: int
    data: bytes


def read_record(file: BinaryIO, span: Span, read: Callable[[ReadDataStream], R]) -> R:
    """Read a record with the `read` function of its class in `mcap.records`.

    Raises:
        TraceError: the record's content is damaged; the message names its offset.
    """
    file.seek(span.offset + RECORD_HEAD.size)
    try:
        return read(ReadDataStream(BytesIO(file.read(span.length))))
    except BROKEN as error:
        raise DamageError(f"record at byte {span.offset:,}: {error}") from error


_NAME_LENGTH = struct.Struct("<I")
_NAME_AT, _NAME_MOST = 20, 400
"""Offset of an attachment's name, after two times and the name's length; and number of bytes to read."""


def read_attachment(file: BinaryIO, span: Span) -> Attachment:
    """Read an attachment.

    Raises:
        TraceError: it is damaged, its CRC included; the message names its offset.
    """
    attachment: Attachment = read_record(file, span, Attachment.read)
    file.seek(span.offset + RECORD_HEAD.size)
    content = file.read(span.length)
    (crc,) = _CRC.unpack(content[-_CRC.size :])
    if crc not in (0, zlib.crc32(content[: -_CRC.size])):
        raise DamageError(f"attachment {attachment.name!r} at byte {span.offset:,}: its CRC does not fit")
    return attachment


def attachment_name(file: BinaryIO, span: Span) -> str:
    """Return the name of an attachment without reading its data; "" if it is damaged."""
    file.seek(span.offset + RECORD_HEAD.size)
    head = file.read(min(span.length, _NAME_AT + _NAME_MOST))
    if len(head) < _NAME_AT:
        return ""
    (length,) = _NAME_LENGTH.unpack_from(head, _NAME_AT - _NAME_LENGTH.size)
    return head[_NAME_AT : _NAME_AT + length].decode(errors="replace")


def chunk_data(file: BinaryIO, span: Span) -> bytes:
    """Return the decompressed contents of a chunk.

    Raises:
        TraceError: it is damaged, its CRC included; the message names its offset.
    """
    chunk = read_record(file, span, Chunk.read)
    try:
        return _unpacked(chunk, span.offset)
    except TraceLimitError:
        raise
    except BROKEN as error:
        raise DamageError(f"chunk at byte {span.offset:,}: {error}") from error


def _unpacked(chunk: Chunk, offset: int) -> bytes:
    """Decompress a chunk, up to the size in its header and up to the limit.

    Raises:
        TraceLimitError: its size exceeds the limit; the message names its offset.
        ValueError: its size, its CRC or its compression is wrong.
    """
    if chunk.compression not in _UNPACK:
        raise ValueError(f"compression {chunk.compression!r} is unknown")
    size, most_bytes = chunk.uncompressed_size, limits().chunk_bytes
    if chunk.compression == "zstd" and frame_content_size(chunk.data) not in (-1, size):
        raise ValueError(f"it has {frame_content_size(chunk.data):,} bytes instead of {size:,}")
    if size > most_bytes:
        raise TraceLimitError(
            f"the chunk at byte {offset:,} unpacks to {size:,} bytes; the limit is {most_bytes:,}",
            "chunk_bytes",
        )
    data = _UNPACK[chunk.compression](chunk.data, size + 1)
    if len(data) != size:
        prefix = "more than " if len(data) > size else ""
        raise ValueError(f"it has {prefix}{min(len(data), size):,} bytes instead of {size:,}")
    if chunk.uncompressed_crc not in (0, zlib.crc32(data)):
        raise ValueError("its CRC does not fit")
    return data


def _unpack_zstd(data: bytes, most: int) -> bytes:
    if frame_content_size(data) >= 0:  # the caller has checked that it is at most `most`
        content: bytes = ZstdDecompressor().decompress(data)
        return content
    return _beginning_of_zstd(data, most)


def _beginning_of_zstd(data: bytes, most: int) -> bytes:
    with ZstdDecompressor().stream_reader(data) as stream:
        return stream.read(most)


def unpacked(data: bytes, most: int) -> bytes:
    """Decompress a zstd-compressed attachment.

    Raises:
        ValueError: the attachment has more than `most` bytes, or is damaged.
    """
    try:
        content = _beginning_of_zstd(data, most + 1)
    except ZstdError as error:
        raise ValueError(str(error)) from error
    if len(content) > most:
        raise ValueError(f"it unpacks to more than {most:,} bytes")
    return content


def _unpack_lz4(data: bytes, most: int) -> bytes:
    content: bytes = LZ4FrameDecompressor().decompress(data, max_length=most)
    return content


_UNPACK: Mapping[str, Callable[[bytes, int], bytes]] = {
    "": lambda data, most: data[:most],
    "zstd": _unpack_zstd,
    "lz4": _unpack_lz4,
}
"""Decompressors of chunks, by name of the compression. Arguments: data, maximum number of bytes to return."""


def read_chunk(file: BinaryIO, span: Span) -> list[Message | Channel | Schema]:
    """Read a chunk: its messages, and the schemas and channels registered in it, in order.

    Raises:
        TraceError: as `chunk_data`.
    """
    data = chunk_data(file, span)
    try:
        return [record for _, record in records_in(data)]
    except TraceLimitError as error:
        raise TraceLimitError(f"the chunk at byte {span.offset:,} {error}", error.limit) from error
    except BROKEN as error:
        raise DamageError(f"chunk at byte {span.offset:,}: {error}") from error


def records_in(data: bytes) -> Iterator[tuple[int, Message | Channel | Schema]]:
    """Yield the messages, channels and schemas in a chunk's data, with their offsets.

    Raises:
        ValueError, struct.error: the data are not complete records.
        TraceLimitError: there are too many records; the caller completes the message.
    """
    offset = count = 0
    while offset < len(data):
        start = offset
        record, offset = split(data, start)
        count += 1
        check_count(count, offset)
        if record is not None:
            yield start, record


def check_count(count: int, size: int) -> None:
    """Raise `TraceLimitError` if the records exceed the limits."""
    if limits().too_many(count, size):
        raise TraceLimitError(f"has more than {limits().records:,} records, most of them empty", "records")


def split(data: bytes, offset: int) -> tuple[Message | Channel | Schema | None, int]:
    """Return the record at `offset` (None for another kind of record) and the offset of the next record.

    Raises:
        ValueError, struct.error: the data are not a complete record.
    """
    opcode, length = RECORD_HEAD.unpack_from(data, offset)
    start = offset + RECORD_HEAD.size
    end = start + length
    if end > len(data):
        raise ValueError("one of its records is longer than the chunk")
    if opcode == Opcode.MESSAGE:
        channel, sequence, log_time, _ = _MESSAGE.unpack_from(data[start:end])
        return Message(channel, sequence, log_time, data[start + _MESSAGE.size : end]), end
    if opcode == Opcode.CHANNEL:
        return Channel.read(ReadDataStream(BytesIO(data[start:end]))), end
    if opcode == Opcode.SCHEMA:
        return Schema.read(ReadDataStream(BytesIO(data[start:end]))), end
    return None, end
