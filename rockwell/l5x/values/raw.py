"""Values as bytes: `<Data>3C 00 00 00</Data>`, the memory of a tag, lowest byte first, see `layouts`.

| type | bytes |
|---|---|
| BOOL | bit 0 of one byte; an array has one bit each, in groups of 32 |
| SINT to LREAL | 1, 2, 4, 8, at a multiple of that in a structure |
| structure | begins at a multiple of 4; of 8 with a value of 8, from revision 27 on [1756-RM100F] |
| string | LEN, then the characters |

The layout of predefined types other than timers, counters and controls is unknown.
"""

from __future__ import annotations

import struct
from typing import Any

from scanrack.ladder.model.types import BOOL, DataType, Structure, count_of

from ..xml.records import Element
from .initials import nested
from .layouts import Layouts


def bytes_in(element: Element) -> bytes | None:
    """Return the bytes in an element; None if it has another form."""
    try:
        return bytes.fromhex(element.text or "")
    except ValueError:
        return None


def fits(data: bytes, kind: DataType, dims: tuple[int, ...], layouts: Layouts) -> bool:
    """Return whether bytes match a tag's size, possibly padded to a multiple of 4 or 8."""
    size = layouts.size(kind, dims)
    return len(data) in (size, -(-size // 4) * 4, -(-size // 8) * 8)


class RawReader:
    """Reads values from memory that `fits`; with `keep`, zeros are values."""

    def __init__(self, data: bytes, layouts: Layouts, *, keep: bool) -> None:
        self._data, self._layouts, self._keep = data, layouts, keep

    def read(self, kind: DataType, dims: tuple[int, ...]) -> Any:
        """Return an initial value as in `Tag.initial`; None for zeros."""
        return self._value(0, kind, dims) if self._keep or any(self._data) else None

    def _value(self, at: int, kind: DataType, dims: tuple[int, ...]) -> Any:
        if not dims:
            return self._one(at, kind)
        count = count_of(dims)
        values: list[Any]
        if isinstance(kind, Structure):
            size = self._layouts.size(kind)
            values = [self._one(at + place * size, kind) for place in range(count)]
        elif kind is BOOL:
            values = [bool(self._data[at + place // 8] >> place % 8 & 1) for place in range(count)]
        else:
            values = list(struct.unpack_from(f"<{count}{kind.code}", self._data, at))
        return nested(values, kind, dims) if self._keep or any(values) else None

    def _one(self, at: int, kind: DataType) -> Any:
        if isinstance(kind, Structure):
            return self._text(at, kind) if kind.is_string else self._members(at, kind)
        if kind is BOOL:
            return bool(self._data[at] & 1)
        value = struct.unpack_from(f"<{kind.code}", self._data, at)[0]
        return value if value or self._keep else None

    def _members(self, at: int, kind: Structure) -> Any:
        parsed = {}
        for member, offset, bit in self._layouts.places(kind):
            if bit is None:
                value = self._value(at + offset, member.type, member.dims)
            else:
                value = bool(self._data[at + offset] >> bit & 1) or (False if self._keep else None)
            if value is not None:
                parsed[member.name] = value
        return parsed or None

    def _text(self, at: int, kind: Structure) -> str | None:
        """Return the characters of a string; a LEN beyond its size means all of them."""
        room = kind.members[1].dims[0]
        (length,) = struct.unpack_from("<I", self._data, at)
        text = self._data[at + 4 : at + 4 + min(length, room)].decode("latin-1")
        return text if text or self._keep else None
