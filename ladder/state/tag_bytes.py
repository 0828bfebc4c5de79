"""Tags in bytes: a buffer in a controller's layout, with a view for each type of its values."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

from ..model.stretches import BITS, HIDDEN_VALUES, STRUCTURES, Spot, byte_parts, hidden_places
from ..model.types import DataType, count_of, size_of

_ALIGNED = 8  # bytes of the largest value: a view needs a buffer whose size is a multiple

Saved = tuple[bytes, dict[int, Any]]
"""The values of a tag in bytes: visible values, hidden values."""


class TagBytes:
    """The values of a structure, or of an array.

    Attributes:
        bits: all bytes, one by one, whose bits are the BOOLs.
        hidden: hidden members, see `stretches.fits_bytes`.
        B: all bytes, for slices; the other attributes are its casts, for the types of value that it has.
    """

    __slots__ = ("B", "H", "I", "Q", "b", "bits", "d", "f", "h", "hidden", "i", "q")

    def __init__(self, kind: DataType, count: int) -> None:
        size = size_of(kind) * count
        self.bits: Any = bytearray(-(-size // _ALIGNED) * _ALIGNED)
        self.hidden: Any = dict.fromkeys(hidden_places(kind, count), 0)
        whole: Any = memoryview(self.bits)
        self.B = whole
        for view in {part.view for part in byte_parts(kind).values()} - {BITS, HIDDEN_VALUES, STRUCTURES}:
            setattr(self, view, whole.cast(view))

    def get(self, view: str, at: int) -> Any:
        """Return an element of a view."""
        if view == BITS:
            return bool(self.bits[at >> 3] >> (at & 7) & 1)
        return getattr(self, view)[at]

    def put(self, view: str, at: int, value: Any) -> None:
        """Set an element of a view."""
        if view == BITS:
            byte, mask = at >> 3, 1 << (at & 7)
            self.bits[byte] = self.bits[byte] | mask if value else self.bits[byte] & ~mask
        else:
            getattr(self, view)[at] = value

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


def chars(tag: Any, at: int, room: int) -> bytes:
    """Return the characters of a STRING at a byte: LEN of them, or all of DATA if LEN is larger."""
    length = tag.i[at >> 2]
    if length <= 0:
        return b""
    return tag.B[at + 4 : at + 4 + (length if length < room else room)].tobytes()  # type: ignore[no-any-return]


def set_chars(tag: Any, at: int, room: int, value: bytes) -> None:
    """Set a STRING at a byte to characters, truncated to its size and padded with 0."""
    codes = value[:room]
    tag.i[at >> 2] = len(codes)
    tag.B[at + 4 : at + 4 + room] = codes.ljust(room, b"\0")


PUT_TEXT = "put_text_"
"""Name of a `text_writer` in the compiled program, less the size of DATA."""


def text_writer(room: int, *, held: bool) -> Callable[[Any, int, int, bytes], object]:
    """Return a function that writes LEN and characters of a STRING, padded with 0.

    It takes a tag's bytes, the number of the STRING's first byte, LEN, and at least LEN characters.

    Args:
        room: the size of DATA.
        held: whether the bytes may be forced: views of forced bytes are not buffers.
    """
    layout = struct.Struct(f"<i{room}s")
    if not held:
        return layout.pack_into

    def write(view: Any, at: int, length: int, text: bytes) -> None:
        view[at : at + layout.size] = layout.pack(length, text)

    return write
