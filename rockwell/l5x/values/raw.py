"""Values as bytes: `<Data>3C 00 00 00</Data>` is the memory of a tag, lowest byte first, see `layouts`.

| type | bytes |
|---|---|
| BOOL | bit 0 of one byte; an array has one bit each, in groups of 32 |
| SINT to LREAL | 1, 2, 4 or 8; in a structure at a multiple of its size |
| structure | begins at a multiple of 4; with an 8-byte value, at a multiple of 8 |
| string | LEN, then the characters |

The multiple of 8 is required from revision 27 on [1756-RM100F]. The layout of predefined types other than
timers, counters and controls is unknown.
"""

from __future__ import annotations

import struct
from typing import Any

from scanrack.ladder.model.types import BOOL, DataType, Structure, count_of

from ..xml.records import Element
from .initials import nested
from .layouts import Layouts


def bytes_in(element: Element) -> bytes | None:
    """Return the bytes in an element; None if it has a different form."""
    try:
        return bytes.fromhex(element.text or "")
    except ValueError:
        return None


def fits(data: bytes, kind: DataType, dims: tuple[int, ...], layouts: Layouts) -> bool:
    """Return whether bytes match a tag's size, possibly padded to a multiple of 4 or 8."""
    size = layouts.size(kind, dims)
    return len(data) in (size, -(-size // 4) * 4, -(-size // 8) * 8)


class RawReader:
    """Reads values from memory that `fits`."""

    def __init__(self, data: bytes, layouts: Layouts, *, keep_zeros: bool) -> None:
        self._data, self._layouts, self._keep_zeros = data, layouts, keep_zeros

    def read(self, kind: DataType, dims: tuple[int, ...]) -> Any:
        """Return an initial value as in `Tag.initial`; None for zeros that may be omitted."""
        return self._value(0, kind, dims) if self._keep_zeros or any(self._data) else None

    def _value(self, offset: int, kind: DataType, dims: tuple[int, ...]) -> Any:
        """Return the value at a byte, as in `Tag.initial`; None for zeros that are not kept."""
        if not dims:
            return self._element(offset, kind)
        count = count_of(dims)
        values: list[Any]
        if isinstance(kind, Structure):
            size = self._layouts.size(kind)
            values = [self._element(offset + index * size, kind) for index in range(count)]
        elif kind is BOOL:
            values = [self._bit(offset, index) for index in range(count)]
        else:
            values = list(struct.unpack_from(f"<{count}{kind.code}", self._data, offset))
        return nested(values, kind, dims) if self._keep_zeros or any(values) else None

    def _element(self, offset: int, kind: DataType) -> Any:
        """Return a value without dimensions at a byte; None for zeros that are not kept."""
        if isinstance(kind, Structure):
            return self._text(offset, kind) if kind.is_string else self._members(offset, kind)
        if kind is BOOL:
            return self._bit(offset, 0)
        value = struct.unpack_from(f"<{kind.code}", self._data, offset)[0]
        return value if value or self._keep_zeros else None

    def _bit(self, offset: int, bit: int) -> bool:
        """Return a bit, counted from the lowest bit of the byte at an offset."""
        return bool(self._data[offset + bit // 8] >> bit % 8 & 1)

    def _members(self, offset: int, kind: Structure) -> Any:
        """Return the values of members by name; None for zeros that are not kept."""
        values = {}
        for member, member_offset, bit in self._layouts.places(kind):
            if bit is None:
                value = self._value(offset + member_offset, member.type, member.dims)
            else:
                value = self._bit(offset + member_offset, bit) or (False if self._keep_zeros else None)
            if value is not None:
                values[member.name] = value
        return values or None

    def _text(self, offset: int, kind: Structure) -> str | None:
        """Return the characters of a string, all of them if LEN is beyond its size; None if it is empty."""
        (length,) = struct.unpack_from("<I", self._data, offset)
        begin, most = offset + 4, kind.members[1].dims[0]
        text = self._data[begin : begin + min(length, most)].decode("latin-1")
        return text if text or self._keep_zeros else None
