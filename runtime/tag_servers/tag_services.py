"""Reading and writing tags [1756-PM020, services 4Ch, 4Dh, 4Eh, 52h, 53h]."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping

from scanrack.io_images.enip.codes import (
    BAD_VALUE,
    BEYOND,
    DONE,
    GENERAL,
    MODIFY,
    OFFSET_BEYOND,
    OTHER_TYPE,
    PARTIAL,
    READ,
    READ_PART,
    STRUCTURED,
    TOO_LARGE,
    TOO_MUCH,
    TOO_SHORT,
    TYPE_CODES,
    WRITE,
    WRITE_PART,
    CipRefusedError,
)
from scanrack.io_images.enip.listing import PlainKind

from .database import Database, Target
from .tag_snapshot import ReadBytes, TagSnapshot, WriteBytes, bits_to_write

Answer = tuple[int, bytes]
"""General status and data of a reply."""

HEAD_BYTES = 4
"""Number of bytes in a reply before its data."""

MASK_SIZES = (1, 2, 4, 8, 12)
"""Allowed mask sizes of service 4Eh, bytes."""


def type_of(database: Database, target: Target) -> bytes:
    """Return the CIP code of a target's type; for a structure, this contains its handle."""
    if isinstance(target.kind, PlainKind):
        return target.kind.code.to_bytes(2, "little")
    return struct.pack("<HH", STRUCTURED, database.templates.template_of(target.kind).handle)


def _read(database: Database, target: Target, data: bytes, snapshot: TagSnapshot, most: int) -> Answer:
    return _read_from(database, target, struct.unpack_from("<H", data)[0], 0, snapshot, most)


def _read_part(database: Database, target: Target, data: bytes, snapshot: TagSnapshot, most: int) -> Answer:
    count, skip = struct.unpack_from("<HI", data)
    return _read_from(database, target, count, skip, snapshot, most)


def _read_from(
    database: Database, target: Target, count: int, skip: int, snapshot: TagSnapshot, most: int
) -> Answer:
    """Read `count` elements, without their first `skip` bytes; PARTIAL means that not all bytes fit."""
    if target.bit is not None:
        byte = snapshot.read(ReadBytes(target.symbol.index, target.offset, 1))[0]
        return DONE, struct.pack("<HB", TYPE_CODES["BOOL"], byte >> target.bit & 1)
    if not 1 <= count <= target.count:
        raise CipRefusedError(GENERAL, BEYOND)
    total_bytes, head = count * target.kind.size, type_of(database, target)
    if skip >= total_bytes:
        raise CipRefusedError(GENERAL, OFFSET_BEYOND)
    size = min(total_bytes - skip, most - HEAD_BYTES - len(head))
    if size < total_bytes - skip:
        size = size // 4 * 4
    if size < 1:
        raise CipRefusedError(TOO_LARGE)
    value_bytes = snapshot.read(ReadBytes(target.symbol.index, target.offset + skip, size))
    return (DONE if skip + size == total_bytes else PARTIAL), head + value_bytes


def _write(database: Database, target: Target, data: bytes, snapshot: TagSnapshot, _most: int) -> Answer:
    """Write whole elements, or one bit; bytes after them are ignored. The reply has no data."""
    count, offset = _head(database, target, data)
    total_bytes = _total(target, count)
    # pycomm3 1.2.16 sends the message of a single write twice
    value_bytes = data[offset : offset + total_bytes]
    if len(value_bytes) < total_bytes:
        raise CipRefusedError(TOO_SHORT)
    if target.bit is not None:
        snapshot.write(bits_to_write(target.symbol.index, 8 * target.offset + target.bit, value_bytes[:1]))
    else:
        snapshot.write(WriteBytes(target.symbol.index, target.offset, value_bytes))
    return DONE, b""


def _write_part(database: Database, target: Target, data: bytes, snapshot: TagSnapshot, most: int) -> Answer:
    """Write bytes of elements, beginning at a byte that the data names; the reply has no data."""
    count, offset = _head(database, target, data)
    total_bytes, (skip,) = _total(target, count), struct.unpack_from("<I", data, offset)
    value_bytes = data[offset + 4 :]
    if skip >= total_bytes:
        raise CipRefusedError(GENERAL, OFFSET_BEYOND)
    if skip + len(value_bytes) > total_bytes:
        raise CipRefusedError(TOO_MUCH)
    if not value_bytes:
        raise CipRefusedError(TOO_SHORT)
    if target.bit is not None:
        return _write(database, target, data[:offset] + value_bytes, snapshot, most)
    snapshot.write(WriteBytes(target.symbol.index, target.offset + skip, value_bytes))
    return DONE, b""


def _head(database: Database, target: Target, data: bytes) -> tuple[int, int]:
    """Check access and type; return the element count and the offset after it."""
    database.refuse_write(target)
    type_bytes = type_of(database, target)
    if data[: len(type_bytes)] != type_bytes:
        raise CipRefusedError(GENERAL, OTHER_TYPE)
    (element_count,) = struct.unpack_from("<H", data, len(type_bytes))
    if not 1 <= element_count <= target.count:
        raise CipRefusedError(GENERAL, BEYOND)
    return element_count, len(type_bytes) + 2


def _total(target: Target, count: int) -> int:
    return 1 if target.bit is not None else count * target.kind.size


def _modify(database: Database, target: Target, data: bytes, snapshot: TagSnapshot, _most: int) -> Answer:
    """Set and clear bits of an integer; `data` has an OR mask followed by an AND mask."""
    database.refuse_write(target)
    (size,) = struct.unpack_from("<H", data)
    if size not in MASK_SIZES or len(data) < 2 + 2 * size:
        raise CipRefusedError(BAD_VALUE)
    if not isinstance(target.kind, PlainKind) or target.bit is not None:
        raise CipRefusedError(GENERAL, OTHER_TYPE)
    if not target.kind.bits or size > target.kind.size:
        raise CipRefusedError(GENERAL, OTHER_TYPE)
    ors, ands = data[2 : 2 + size], data[2 + size : 2 + 2 * size]
    keep_mask = bytes(and_byte & ~or_byte & 0xFF for or_byte, and_byte in zip(ors, ands, strict=True))
    on_bytes = bytes(or_byte & and_byte for or_byte, and_byte in zip(ors, ands, strict=True))
    snapshot.write(WriteBytes(target.symbol.index, target.offset, on_bytes, keep_mask))
    return DONE, b""


TagService = Callable[[Database, Target, bytes, TagSnapshot, int], Answer]

TAG_SERVICES: Mapping[int, TagService] = {
    READ: _read,
    READ_PART: _read_part,
    WRITE: _write,
    WRITE_PART: _write_part,
    MODIFY: _modify,
}
"""Services of a tag; the last argument is the maximum size of the reply in bytes."""
