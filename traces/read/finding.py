"""Finds the records of a file, even if a length or an opcode is damaged.

    head | chunk | index | chunk | index | data end | summary | footer | magic

Reading does not depend on the summary, which is missing if the process was killed. A chunk states its length
twice, in its header and as the length of its data. If one of them is damaged, the chunk is still found:

    06 | length | times, size, CRC | "zstd" | length of the data | data
         ^^^^^^                               ^^^^^^^^^^^^^^^^^^
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Sequence
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer

from ..format.records import DRAFT, MAGIC, RECORD_HEAD, Damage, Span, TraceError, check_count, read_record

_COMPRESSION = re.compile(rb"\x04\x00\x00\x00zstd|\x03\x00\x00\x00lz4")
_COMPRESSION_BYTES_MAX = 8
_CHUNK_NAME = 37
"""Offset of the compression's name in a chunk, after opcode, length, two times, size and CRC."""

_CRC = struct.Struct("<I")
_LENGTH = struct.Struct("<Q")
_CHUNK_HEAD_BYTES = _CHUNK_NAME + _COMPRESSION_BYTES_MAX + _LENGTH.size
_SEARCH_BYTES = 1 << 20
_FOOTER_HEAD = RECORD_HEAD.pack(Opcode.FOOTER, 20)
_FOOTER_BYTES = RECORD_HEAD.size + 20
_DATA_END_HEAD = RECORD_HEAD.pack(Opcode.DATA_END, _CRC.size)
_FIRST_PRIVATE_OPCODE = 0x80
_OPCODES = frozenset(opcode.value for opcode in Opcode)


UNDER_WAY = "it is being recorded; data after its last whole chunk are left out"


def find_records(
    file: BinaryIO, size: int, first_spans: Sequence[Span] = (), *, drafts: bool = True
) -> tuple[list[Span], list[str]]:
    """Find the records of a file. After a damaged length, continue at the next chunk or the end.

    Args:
        first_spans: the first records of the file, if known; the search begins after them.
        drafts: whether an unfinished chunk is read; if not, the file ends before it.

    Returns:
        The complete records in order, and notes on the file's defects; the last note describes a missing end.

    Raises:
        TraceLimitError: the file has more records than the limits allow.
    """
    spans = list(first_spans)
    notes: list[str] = []
    offset = spans[-1].end if spans else len(MAGIC)
    while True:
        defect = _add_records(file, size, offset, spans, notes, drafts=drafts)
        if defect is None:
            return spans, notes
        if defect == UNDER_WAY:
            return spans, [*notes, defect]
        last_start, last_end = (spans[-1].offset, spans[-1].end) if spans else (0, len(MAGIC))
        target, next_offset = "next chunk", _next_chunk(file, size, last_start + 1)
        if next_offset is None:
            target, next_offset = "end of its data", _end_of_data(file, size, last_start + 1)
        if next_offset is None:
            return spans, [*notes, defect]
        if next_offset > last_end:
            notes.append(Damage(f"damaged at byte {last_end:,}; the {target} is at byte {next_offset:,}"))
        offset = next_offset


def _add_records(
    file: BinaryIO, size: int, offset: int, spans: list[Span], notes: list[str], *, drafts: bool
) -> str | None:
    """Add successive records from `offset` to `spans`, up to the footer or a defect.

    Returns:
        None if the footer was reached, otherwise the defect.
    """
    while offset + RECORD_HEAD.size <= size:
        span = _record_at(file, size, offset, notes)
        if span is None or (span.opcode == DRAFT and not drafts):
            return UNDER_WAY
        if not _is_known(span.opcode):
            return Damage(f"damaged at byte {offset:,}: {span.opcode:#04x} is not the opcode of a record")
        if span.end > size:
            break
        spans.append(span)
        offset = span.end
        check_count(len(spans), offset)
        if ends_whole(file, spans):
            end = offset + len(MAGIC)
            if end < size:
                notes.append(Damage(f"damaged at byte {end:,}: {size - end:,} bytes follow its end"))
            return None
    if _footer_at_the_end(file, size) or _contradicts_itself(file, size, offset):
        return Damage(f"damaged at byte {offset:,}: the record there is longer than the file")
    return f"it has no end: the last whole record ends at byte {offset:,} of {size:,}"


def _record_at(file: BinaryIO, size: int, offset: int, notes: list[str]) -> Span | None:
    """Return the record at `offset`; note and correct a damaged opcode or length of a chunk.

    None if the file has become shorter than `size`, because a recorder has removed its unfinished chunk.
    """
    file.seek(offset)
    head = file.read(_CHUNK_HEAD_BYTES)
    if len(head) < RECORD_HEAD.size:
        return None
    opcode, length = RECORD_HEAD.unpack_from(head)
    span = Span(opcode, offset, length)
    chunk_length = _chunk_length(head)
    if chunk_length is None or (opcode, length) == (Opcode.CHUNK, chunk_length):
        return span
    chunk = Span(Opcode.CHUNK, offset, chunk_length)
    is_opcode_wrong = length == chunk_length
    is_length_wrong = opcode == Opcode.CHUNK and not _begins_record(file, size, span.end)
    if (is_opcode_wrong or is_length_wrong) and _begins_record(file, size, chunk.end):
        notes.append(f"the head of the chunk at byte {offset:,} is damaged; the chunk is whole")
        return chunk
    return span


def _chunk_length(head: bytes) -> int | None:
    """Return the length of a chunk's content, from the length of its data; None if it is not a chunk."""
    match = _COMPRESSION.match(head, _CHUNK_NAME)
    if match is None or len(head) < match.end() + _LENGTH.size:
        return None
    (data_length,) = _LENGTH.unpack_from(head, match.end())
    return int(match.end() + _LENGTH.size - RECORD_HEAD.size + data_length)


def _contradicts_itself(file: BinaryIO, size: int, offset: int) -> bool:
    """Return whether a chunk at `offset` states two different lengths: damaged, not truncated."""
    if offset + RECORD_HEAD.size > size:
        return False
    file.seek(offset)
    head = file.read(_CHUNK_HEAD_BYTES)
    _, length = RECORD_HEAD.unpack_from(head)
    return _chunk_length(head) not in (None, length)


def _is_known(opcode: int) -> bool:
    return opcode in _OPCODES or opcode >= _FIRST_PRIVATE_OPCODE


def _begins_record(file: BinaryIO, size: int, offset: int) -> bool:
    """Return whether a complete record seems to begin at `offset`, or whether the file ends there."""
    if offset + RECORD_HEAD.size > size:
        return offset == size
    file.seek(offset)
    opcode, length = RECORD_HEAD.unpack(file.read(RECORD_HEAD.size))
    return _is_known(opcode) and offset + RECORD_HEAD.size + length <= size


def ends_whole(file: BinaryIO, spans: Sequence[Span]) -> bool:
    """Return whether the last record is the footer and the magic follows it."""
    if not spans or spans[-1].opcode != Opcode.FOOTER:
        return False
    file.seek(spans[-1].end)
    return file.read(len(MAGIC)) == MAGIC


def sound_summary(file: BinaryIO, spans: Sequence[Span]) -> int | None:
    """Return the offset of a file's summary; None if the summary is missing or its CRC is wrong."""
    footer = _footer(file, spans)
    if footer is None or not footer.summary_start or not footer.summary_crc:
        return None
    size = spans[-1].end - _CRC.size - footer.summary_start
    if size < 0:
        return None
    file.seek(footer.summary_start)
    return footer.summary_start if zlib.crc32(file.read(size)) == footer.summary_crc else None


def summary_damage(file: BinaryIO, spans: Sequence[Span]) -> str | None:
    """Return a note if the CRC of the summary is wrong; None if it is correct or missing."""
    footer = _footer(file, spans)
    if footer is None or not footer.summary_start or not footer.summary_crc:
        return None
    return None if sound_summary(file, spans) is not None else "its summary is damaged: its CRC does not fit"


def _footer(file: BinaryIO, spans: Sequence[Span]) -> Footer | None:
    return read_record(file, spans[-1], Footer.read) if ends_whole(file, spans) else None


def data_crc(file: BinaryIO, spans: Sequence[Span]) -> int | None:
    """Return the CRC of all data as stated in the file; 0 = not stated, None = the data has no end."""
    data_ends = [span for span in spans if span.opcode == Opcode.DATA_END]
    try:
        return read_record(file, data_ends[-1], DataEnd.read).data_section_crc if data_ends else None
    except TraceError:
        return None


def data_damage(file: BinaryIO, spans: Sequence[Span]) -> str | None:
    """Return a note if the CRC of all data is wrong; None if it is correct or not stated."""
    recorded_crc = data_crc(file, spans)
    if not recorded_crc:
        return None
    file.seek(0)
    unread = next(span.offset for span in reversed(spans) if span.opcode == Opcode.DATA_END)
    crc = 0
    while unread and (data := file.read(min(unread, _SEARCH_BYTES))):
        crc = zlib.crc32(data, crc)
        unread -= len(data)
    return None if crc == recorded_crc else DATA_DAMAGE


DATA_DAMAGE = Damage(
    "damaged data: their CRC does not fit; the metadata, such as the name of the rack file, may be wrong"
)


def _next_chunk(file: BinaryIO, size: int, start: int) -> int | None:
    """Return the offset of the first chunk at `start` or later; None if there is none.

    A chunk is recognized by the name of its compression and by its two lengths.
    """
    overlap = b""
    file.seek(start + _CHUNK_NAME)
    data_start = start + _CHUNK_NAME
    while data := overlap + file.read(_SEARCH_BYTES):
        for match in _COMPRESSION.finditer(data):
            offset = data_start + match.start() - _CHUNK_NAME
            if _is_chunk(file, size, offset):
                return offset
        if len(data) == len(overlap):
            break
        overlap = data[-_COMPRESSION_BYTES_MAX:]
        data_start += len(data) - len(overlap)
        file.seek(data_start + len(overlap))
    return None


def _is_chunk(file: BinaryIO, size: int, offset: int) -> bool:
    """Return whether a complete chunk begins at `offset`."""
    span = _record_at(file, size, offset, [])
    file.seek(offset)
    return (
        span is not None
        and span.opcode == Opcode.CHUNK
        and span.end <= size
        and _chunk_length(file.read(_CHUNK_HEAD_BYTES)) == span.length
    )


def _footer_at_the_end(file: BinaryIO, size: int) -> int | None:
    """Return the offset of the footer if the file ends with one."""
    offset = size - len(MAGIC) - _FOOTER_BYTES
    if offset < 0:
        return None
    file.seek(offset)
    end = file.read(_FOOTER_BYTES + len(MAGIC))
    return offset if end.startswith(_FOOTER_HEAD) and end.endswith(MAGIC) else None


def _end_of_data(file: BinaryIO, size: int, start: int) -> int | None:
    """Return the offset of the record that ends the data, found from the footer at the file's end.

    None if there is no footer there, or if the data ends before `start`.
    """
    footer = _footer_at_the_end(file, size)
    if footer is None:
        return None
    file.seek(footer + RECORD_HEAD.size)
    (summary_start,) = _LENGTH.unpack(file.read(_LENGTH.size))
    offset = summary_start - len(_DATA_END_HEAD) - _CRC.size
    if not start <= offset < size:
        return None
    file.seek(offset)
    return offset if file.read(len(_DATA_END_HEAD)) == _DATA_END_HEAD else None
