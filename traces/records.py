"""MCAP from the reading side: find the records of a file, take a chunk apart.

    89 "MCAP0" 0D 0A                          magic
    opcode u8 | length u64 | content          a record; again and again, the footer last
    89 "MCAP0" 0D 0A                          magic

Reading does not lean on the summary at the end, which a killed process did not
get to write. What is whole is given; what is not is named by its offset.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from io import BytesIO
from typing import BinaryIO, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

MAGIC = b"\x89MCAP0\r\n"

RECORD_HEAD = struct.Struct("<BQ")
"""What every record begins with: opcode, length of the content."""

_MESSAGE = struct.Struct("<HIQQ")
_COMPRESSIONS = frozenset({"", "zstd", "lz4"})
_FIRST_PRIVATE_OPCODE = 0x80
_OPCODES = frozenset(opcode.value for opcode in Opcode)
BROKEN = (McapError, struct.error, ValueError, OverflowError, RuntimeError, EOFError, MemoryError, ZstdError)
"""What the libraries raise on bytes that are not what they should be."""

R = TypeVar("R")


class TraceError(ValueError):
    """A file that can't be read as a trace; the message says what is the matter, and where."""


class Span(NamedTuple):
    """Where a record lies: the offset of its opcode, and the length of its content, in bytes."""

    opcode: int
    offset: int
    length: int


class Message(NamedTuple):
    """A message as it stands in a chunk; time in ns."""

    channel: int
    sequence: int
    log_time: int
    data: bytes


def find_records(file: BinaryIO, size: int) -> tuple[list[Span], str | None]:
    """Hop over the records of a file.

    Args:
        file: open for reading, its magic checked.
        size: its size in bytes.

    Returns:
        The whole records in order, and what ended the file too early (None if it has its footer).
    """
    spans: list[Span] = []
    offset = len(MAGIC)
    while offset + RECORD_HEAD.size <= size:
        file.seek(offset)
        opcode, length = RECORD_HEAD.unpack(file.read(RECORD_HEAD.size))
        if opcode not in _OPCODES and opcode < _FIRST_PRIVATE_OPCODE:
            return spans, f"damaged at byte {offset:,}: no record begins with {opcode:#04x}"
        if offset + RECORD_HEAD.size + length > size:
            break
        spans.append(Span(opcode, offset, length))
        offset += RECORD_HEAD.size + length
        if opcode == Opcode.FOOTER and file.seek(offset) == offset and file.read(len(MAGIC)) == MAGIC:
            return spans, None
    return spans, f"it has no end: the last whole record ends at byte {offset:,} of {size:,}"


def read_record(file: BinaryIO, span: Span, read: Callable[[ReadDataStream], R]) -> R:
    """Read a record with the `read` of its class in `mcap.records`.

    Raises:
        TraceError: its content is damaged; the message names its offset.
    """
    file.seek(span.offset + RECORD_HEAD.size)
    try:
        return read(ReadDataStream(BytesIO(file.read(span.length))))
    except BROKEN as error:
        raise TraceError(f"damaged record at byte {span.offset:,}: {error}") from error


def chunk_data(file: BinaryIO, span: Span) -> bytes:
    """Return what is in a chunk, decompressed.

    Raises:
        TraceError: it is damaged, its CRC included; the message names its offset.
    """
    chunk = read_record(file, span, Chunk.read)
    try:
        if chunk.compression not in _COMPRESSIONS:
            raise ValueError(f"compression {chunk.compression!r} is not known")
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        if length != chunk.uncompressed_size:
            raise ValueError(f"it holds {length:,} bytes instead of {chunk.uncompressed_size:,}")
        return stream.read(length)
    except BROKEN as error:
        raise TraceError(f"damaged chunk at byte {span.offset:,}: {error}") from error


def read_chunk(file: BinaryIO, span: Span) -> list[Message | Channel | Schema]:
    """Read a chunk: its messages, and the schemas and channels registered in it, in order.

    Raises:
        TraceError: as `chunk_data`.
    """
    data = chunk_data(file, span)
    records, offset = [], 0
    try:
        while offset < len(data):
            record, offset = split(data, offset)
            if record is not None:
                records.append(record)
    except BROKEN as error:
        raise TraceError(f"damaged chunk at byte {span.offset:,}: {error}") from error
    return records


def split(data: bytes, offset: int) -> tuple[Message | Channel | Schema | None, int]:
    """Return the record that begins at `offset`, None for one of another kind, and where the next one does.

    Raises:
        ValueError, struct.error: it is no whole record.
    """
    opcode, length = RECORD_HEAD.unpack_from(data, offset)
    start = offset + RECORD_HEAD.size
    end = start + length
    if end > len(data):
        raise ValueError("a record in it is longer than the chunk")
    if opcode == Opcode.MESSAGE:
        channel, sequence, log_time, _ = _MESSAGE.unpack_from(data[start:end])
        return Message(channel, sequence, log_time, data[start + _MESSAGE.size : end]), end
    if opcode == Opcode.CHANNEL:
        return Channel.read(ReadDataStream(BytesIO(data[start:end]))), end
    if opcode == Opcode.SCHEMA:
        return Schema.read(ReadDataStream(BytesIO(data[start:end]))), end
    return None, end
