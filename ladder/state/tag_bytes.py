"""Tags in bytes: a buffer in a controller's layout, with a view for each value type."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from ..model.stretches import BITS, HIDDEN_VALUES, STRUCTURES, Spot, byte_parts, hidden_places
from ..model.types import DataType, count_of, size_of

_ALIGNED = 8  # bytes of the largest type: a view needs a buffer with a multiple of its size

Saved = tuple[bytes, dict[int, Any]]
"""The values of a tag in bytes: visible values, hidden values."""


class TagBytes:
    """The values of a structure, or of an array.

    Attributes:
        bits: all bytes; the BOOLs are bits in them.
        hidden: hidden members, see `stretches.fits_bytes`.
        B: all bytes, for slices. The other attributes are casts of `B`, one for each value type.
    """

    __slots__ = ("B", "H", "I", "Q", "b", "bits", "d", "f", "h", "hidden", "i", "q")

    def __init__(self, kind: DataType, count: int) -> None:
        """Create zeros, and a cast of the bytes for each type of value in them."""
        size = size_of(kind) * count
        self.bits: Any = bytearray(-(-size // _ALIGNED) * _ALIGNED)
        self.hidden: Any = dict.fromkeys(hidden_places(kind, count), 0)
        all_bytes: Any = memoryview(self.bits)
        self.B = all_bytes
        for view in {part.view for part in byte_parts(kind).values()} - {BITS, HIDDEN_VALUES, STRUCTURES}:
            setattr(self, view, all_bytes.cast(view))

    def get(self, view: str, index: int) -> Any:
        """Return an element of a view."""
        if view == BITS:
            return bool(self.bits[index >> 3] >> (index & 7) & 1)
        return getattr(self, view)[index]

    def put(self, view: str, index: int, value: Any) -> None:
        """Set an element of a view."""
        if view == BITS:
            byte, mask = index >> 3, 1 << (index & 7)
            self.bits[byte] = self.bits[byte] | mask if value else self.bits[byte] & ~mask
        else:
            getattr(self, view)[index] = value

    def values(self, spot: Spot, count: int) -> list[Any]:
        """Return the first values of a path."""
        inner = count_of(spot.part.dims)
        if spot.view in (BITS, HIDDEN_VALUES) or (inner > 1 and count > inner):
            return [self.get(spot.view, spot.at(index)) for index in range(count)]
        step = spot.size if inner == 1 else spot.strides[-1]
        begin = spot.part.offset
        elements: list[Any] = getattr(self, spot.view)[begin : begin + (count - 1) * step + 1 : step].tolist()
        return elements

    def copy(self) -> TagBytes:
        """Return a copy with its own memory."""
        other = TagBytes.__new__(TagBytes)
        other.bits, other.hidden = bytearray(self.bits), {**self.hidden}
        other.B = memoryview(other.bits)
        for view in ("b", "h", "H", "i", "I", "q", "Q", "f", "d"):
            if view in self.__slots__ and hasattr(self, view):
                setattr(other, view, other.B.cast(view))
        return other

    def saved(self) -> Saved:
        """Return a copy of all values, for `restore`."""
        return bytes(self.B[:]), dict(self.hidden)

    def restore(self, saved: Saved) -> None:
        """Set all values."""
        self.B[:] = saved[0]
        self.hidden.update(saved[1])


def chars(tag: Any, first_byte: int, capacity: int) -> bytes:
    """Return the characters of a STRING at a byte: as many as LEN, or all of DATA if LEN is larger."""
    length = tag.i[first_byte >> 2]
    if length <= 0:
        return b""
    return tag.B[first_byte + 4 : first_byte + 4 + (length if length < capacity else capacity)].tobytes()  # type: ignore[no-any-return]


def set_chars(tag: Any, first_byte: int, capacity: int, value: bytes) -> None:
    """Set a STRING at a byte to characters, truncated to its size and padded with 0."""
    codes = value[:capacity]
    tag.i[first_byte >> 2] = len(codes)
    tag.B[first_byte + 4 : first_byte + 4 + capacity] = codes.ljust(capacity, b"\0")


PUT_TEXT = "put_text_"
"""Prefix of a `text_writer` in the compiled program; the size of DATA follows."""


def text_writer(capacity: int, *, forced: bool) -> Callable[[Any, int, int, bytes], object]:
    """Return a function that writes LEN and characters of a STRING, padded with 0.

    Its arguments are a tag's bytes, the number of the STRING's first byte, LEN, and at least LEN characters.

    Args:
        capacity: the size of DATA.
        forced: whether the bytes may be forced. Forced bytes are not a buffer, which `pack_into` needs.
    """
    layout = struct.Struct(f"<i{capacity}s")
    if not forced:
        return layout.pack_into

    def write(view: Any, first_byte: int, length: int, text: bytes) -> None:
        view[first_byte : first_byte + layout.size] = layout.pack(length, text)

    return write
