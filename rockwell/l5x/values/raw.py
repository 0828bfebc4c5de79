"""Values as bytes: `<Data>3C 00 00 00</Data>`, the memory of a tag, lowest byte first.

They are read where the byte layout is known: that of elementary types, strings, timers, counters,
controls, and the document's own types of them. The layout of other predefined types and add-ons is unknown.

| type | bytes |
|---|---|
| BOOL | bit 0 of one; an array has one bit each, 32 to a group |
| SINT to LREAL | 1, 2, 4, 8, at a multiple of that in a structure |
| structure | begins at a multiple of 4; of 8 with a value of 8, from revision 27 on [1756-RM100F] |
| string | LEN, then the characters |
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any

from ....ladder.model.types import (
    BOOL,
    CONTROL,
    COUNTER,
    TIMER,
    DataType,
    Elementary,
    Structure,
    count_of,
    members_at,
    size_of,
)
from ..xml.records import Element
from .initials import nested

_KNOWN = (TIMER, COUNTER, CONTROL)


def bytes_in(element: Element) -> bytes | None:
    """Return the bytes of an element, None if it has another form."""
    try:
        return bytes.fromhex(element.text or "")
    except ValueError:
        return None


def has_known_bytes(kind: DataType, own: Iterable[str], *, eights: bool) -> bool:
    """Whether the byte layout of a type is known; `eights`: 8-byte values lie at multiples of 8."""
    if isinstance(kind, Elementary):
        return eights or kind.bits < 64
    if kind in _KNOWN or kind.is_string:
        return True
    return kind.name.upper() in own and all(
        (each.type is not BOOL or bool(each.dims)) and has_known_bytes(each.type, own, eights=eights)
        for each in kind.own
    )


def is_certain(kind: DataType) -> bool:
    """Whether all arrays in a type begin at a multiple of 4, whatever the alignment of small numbers."""
    if isinstance(kind, Elementary) or kind.is_string:
        return True
    return all(
        (not member.dims or offset % 4 == 0) and is_certain(member.type)
        for member, offset, bit in members_at(kind)
        if bit is None
    )


def fits(data: bytes, kind: DataType, dims: tuple[int, ...]) -> bool:
    """Whether bytes match a tag's size, possibly padded to a multiple of 4 or 8."""
    wanted = _bytes_of(kind, dims)
    return len(data) in (wanted, -(-wanted // 4) * 4, -(-wanted // 8) * 8)


def from_bytes(data: bytes, kind: DataType, dims: tuple[int, ...]) -> Any:
    """Return an initial value as in `Tag.initial` from memory that `fits`, None for zeros."""
    return _value(data, 0, kind, dims) if any(data) else None


def _bytes_of(kind: DataType, dims: tuple[int, ...]) -> int:
    if kind is BOOL and dims:
        return -(-count_of(dims) // 32) * 4
    return size_of(kind) * count_of(dims)


def _value(data: bytes, at: int, kind: DataType, dims: tuple[int, ...]) -> Any:
    if not dims:
        return _one(data, at, kind)
    count = count_of(dims)
    values: list[Any]
    if isinstance(kind, Structure):
        size = size_of(kind)
        values = [_one(data, at + place * size, kind) for place in range(count)]
    elif kind is BOOL:
        values = [bool(data[at + place // 8] >> place % 8 & 1) for place in range(count)]
    else:
        values = list(struct.unpack_from(f"<{count}{kind.code}", data, at))
    return nested(values, kind, dims) if any(values) else None


def _one(data: bytes, at: int, kind: DataType) -> Any:
    if isinstance(kind, Elementary):
        return (
            bool(data[at] & 1) if kind is BOOL else struct.unpack_from(f"<{kind.code}", data, at)[0] or None
        )
    if kind.is_string:
        return _text(data, at, kind)
    found = {}
    for member, offset, bit in members_at(kind):
        if bit is not None:
            value: Any = bool(data[at + offset] >> bit & 1) or None
        else:
            value = _value(data, at + offset, member.type, member.dims)
        if value is not None:
            found[member.name] = value
    return found or None


def _text(data: bytes, at: int, kind: Structure) -> str | None:
    """Return the characters of a string; a LEN beyond its size means all of them."""
    room = kind.members[1].dims[0]
    (length,) = struct.unpack_from("<I", data, at)
    return data[at + 4 : at + 4 + min(length, room)].decode("latin-1") or None
