"""MCAP from the reading side: find the records of a file, take a chunk apart.

    89 "MCAP0" 0D 0A                          magic
    opcode u8 | length u64 | content          a record; again and again, the footer last
    89 "MCAP0" 0D 0A                          magic

Reading does not lean on the summary at the end, which a killed process did not
get to write. What is whole is given; what is not is named by its offset.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Callable, Sequence
from io import BytesIO
from typing import BinaryIO, NamedTuple, TypeVar

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Footer, Schema
from mcap.stream_reader import get_chunk_data_stream
from zstandard import ZstdError

MAGIC = b"\x89MCAP0\r\n"

RECORD_HEAD = struct.Struct("<BQ")
"""What every record begins with: opcode, length of the content."""

_MESSAGE = struct.Struct("<HIQQ")
_COMPRESSIONS = frozenset({"", "zstd", "lz4"})
_COMPRESSION = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_COMPRESSION_BYTES_MAX = 8
_CHUNK_NAME = 37
"""Where in a chunk the name of its compression is, after opcode, length, two times, size and CRC."""

_CRC = struct.Struct("<I")
_LENGTH = struct.Struct("<Q")
_SEARCH_BYTES = 1 << 20
_FIRST_PRIVATE_OPCODE = 0x80
_OPCODES = frozenset(opcode.value for opcode in Opcode)
BROKEN = (McapError, struct.error, ValueError, OverflowError, RuntimeError, EOFError, MemoryError, ZstdError)
"""What the libraries raise on bytes that are not what they should be."""

DAMAGED = "damaged "
"""What every note of damage begins with; the others tell of an end that was never written."""

R = TypeVar("R")


class TraceError(ValueError):
    """A file that can't be read as a trace; the message says what is the matter, and where."""


class Span(NamedTuple):
    """Where a record lies: the offset of its opcode, and the length of its content, in bytes."""

    opcode: int
    offset: int
    length: int

    @property
    def end(self) -> int:
        """Offset of what follows."""
        return self.offset + RECORD_HEAD.size + self.length


class Message(NamedTuple):
    """A message as it stands in a chunk; time in ns."""

    channel: int
    sequence: int
    log_time: int
    data: bytes


def find_records(file: BinaryIO, size: int) -> tuple[list[Span], list[str]]:
    """Hop over the records of a file. Where a hop leads astray, go on with the next chunk.

    Args:
        file: open for reading, its magic checked.
        size: its size in bytes.

    Returns:
        The whole records in order, and what is wrong with the file.
    """
    spans: list[Span] = []
    troubles: list[str] = []
    offset = len(MAGIC)
    while (trouble := _hop(file, size, offset, spans)) is not None:
        last_start, last_end = _last(spans)
        found = _next_chunk(file, size, last_start + 1)
        if found is None:
            return spans, [*troubles, trouble]
        troubles.append(f"{DAMAGED}at byte {last_end:,}; the next chunk is at byte {found:,}")
        offset = found
    return spans, troubles


def _hop(file: BinaryIO, size: int, offset: int, spans: list[Span]) -> str | None:
    """Add the records from `offset` on; return what ended them before the footer."""
    while offset + RECORD_HEAD.size <= size:
        file.seek(offset)
        opcode, length = RECORD_HEAD.unpack(file.read(RECORD_HEAD.size))
        if opcode not in _OPCODES and opcode < _FIRST_PRIVATE_OPCODE:
            return f"{DAMAGED}at byte {offset:,}: no record begins with {opcode:#04x}"
        if offset + RECORD_HEAD.size + length > size:
            break
        spans.append(Span(opcode, offset, length))
        offset = spans[-1].end
        if ends_whole(file, spans):
            return None
    return f"it has no end: the last whole record ends at byte {offset:,} of {size:,}"


def ends_whole(file: BinaryIO, spans: Sequence[Span]) -> bool:
    """Return whether the last of the records is the footer, and the magic follows it."""
    if not spans or spans[-1].opcode != Opcode.FOOTER:
        return False
    file.seek(spans[-1].end)
    return file.read(len(MAGIC)) == MAGIC


def sound_summary(file: BinaryIO, spans: Sequence[Span]) -> int | None:
    """Return where the summary of a file begins; None if it has none, or one whose CRC does not fit."""
    if not ends_whole(file, spans):
        return None
    footer = read_record(file, spans[-1], Footer.read)
    size = spans[-1].end - _CRC.size - footer.summary_start
    if not footer.summary_start or not footer.summary_crc or size < 0:
        return None
    file.seek(footer.summary_start)
    return footer.summary_start if zlib.crc32(file.read(size)) == footer.summary_crc else None


def _last(spans: Sequence[Span]) -> tuple[int, int]:
    """Return where the last record begins and ends."""
    return (spans[-1].offset, spans[-1].end) if spans else (0, len(MAGIC))


def _next_chunk(file: BinaryIO, size: int, start: int) -> int | None:
    """Search for a chunk that begins at `start` or later by the name of its compression and by its sizes."""
    before = b""
    file.seek(start + _CHUNK_NAME)
    place = start + _CHUNK_NAME
    while data := before + file.read(_SEARCH_BYTES):
        for match in _COMPRESSION.finditer(data):
            offset = place + match.start() - _CHUNK_NAME
            if _is_chunk(file, size, offset, len(match[0])):
                return offset
        if len(data) == len(before):
            break
        before = data[-_COMPRESSION_BYTES_MAX:]
        place += len(data) - len(before)
        file.seek(place + len(before))
    return None


def _is_chunk(file: BinaryIO, size: int, offset: int, name: int) -> bool:
    """Return whether the sizes in a record agree with one another and with the file, as in a chunk."""
    file.seek(offset)
    head = file.read(_CHUNK_NAME + name + 8)
    if len(head) < _CHUNK_NAME + name + 8:
        return False
    opcode, length = RECORD_HEAD.unpack_from(head)
    (data_length,) = _LENGTH.unpack_from(head, _CHUNK_NAME + name)
    fits = length == len(head) - RECORD_HEAD.size + data_length
    return bool(opcode == Opcode.CHUNK and fits and offset + RECORD_HEAD.size + length <= size)


def read_record(file: BinaryIO, span: Span, read: Callable[[ReadDataStream], R]) -> R:
    """Read a record with the `read` of its class in `mcap.records`.

    Raises:
        TraceError: its content is damaged; the message names its offset.
    """
    file.seek(span.offset + RECORD_HEAD.size)
    try:
        return read(ReadDataStream(BytesIO(file.read(span.length))))
    except BROKEN as error:
        raise TraceError(f"{DAMAGED}record at byte {span.offset:,}: {error}") from error


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
        raise TraceError(
            f"{DAMAGED}attachment {attachment.name!r} at byte {span.offset:,}: its CRC does not fit"
        )
    return attachment


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
        raise TraceError(f"{DAMAGED}chunk at byte {span.offset:,}: {error}") from error


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
        raise TraceError(f"{DAMAGED}chunk at byte {span.offset:,}: {error}") from error
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
