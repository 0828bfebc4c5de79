"""Stretches: memory for values passed by reference, and for structures copied as a whole.

Most tags are variables of the compiled program. An instance of an add-on instruction, and a tag passed to an
InOut, is a stretch of a list, with its elementary values in the same order for all tags of a type. A function
with a list and an offset as arguments works on all tags of a type.

A string, or a structure that is copied or filled, is a stretch of bytes in a controller's layout; see
`types.fields_of`. Each value is an element of a view of all bytes as its type; a BOOL is a bit.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.records import record

from .types import BOOL, HIDDEN, DataType, Elementary, Structure, count_of, members_at, size_of


@record
class StretchPart:
    """The values of one path in a stretch."""

    offset: int  # of the first value
    dims: tuple[int, ...] = ()  # lengths of the arrays in the structure around it, the outermost first
    strides: tuple[int, ...] = ()  # distance between neighbors, per dimension


@dataclass(frozen=True, slots=True)
class Stretch:
    """The layout of one element of a type in a list."""

    parts: dict[str, StretchPart]  # by path in capitals; "" for an elementary type itself
    zeros: list[bool | int | float]  # the initial values

    @property
    def size(self) -> int:
        """Number of values."""
        return len(self.zeros)


@lru_cache(maxsize=1024)
def stretch_of(kind: DataType) -> Stretch:
    """Return the stretch of a type.

    >>> from .types import BOOL, DINT, Member, Structure
    >>> found = stretch_of(Structure("Pair", (Member("On", BOOL), Member("Data", DINT, (2, 3)))))
    >>> found.size, found.parts["DATA"]
    (7, StretchPart(offset=1, dims=(2, 3), strides=(3, 1)))
    """
    if isinstance(kind, Elementary):
        return Stretch({"": StretchPart(0)}, [kind.zero])
    zeros: list[bool | int | float] = []
    parts = {}
    for member in kind.own:
        inner = stretch_of(member.type)
        strides = row_strides(member.dims, inner.size)
        for path, part in inner.parts.items():
            name = f"{member.name}.{path}" if path else member.name
            offset = len(zeros) + part.offset
            parts[name.upper()] = StretchPart(offset, member.dims + part.dims, strides + part.strides)
        zeros += inner.zeros * count_of(member.dims)
    for member in kind.hidden:
        parts[f"{HIDDEN}{member.name}".upper()] = StretchPart(len(zeros))
        zeros.append(0)
    return Stretch(parts, zeros)


def row_strides(dims: tuple[int, ...], size: int) -> tuple[int, ...]:
    """Return the distance between neighbors per dimension, for elements of the given size."""
    strides: tuple[int, ...] = ()
    for length in reversed(dims):
        strides = (size, *strides)
        size *= length
    return strides


BITS, HIDDEN_VALUES, STRUCTURES = "bits", "hidden", "B"
"""Views of bytes for BOOLs, for hidden members, and for structures; the others are `Elementary.code`."""

_UNITS = {BITS: 1, "h": 16, "H": 16, "i": 32, "I": 32, "f": 32, "q": 64, "Q": 64, "d": 64}  # others are 8


@record
class BytePart:
    """The values, or the structures, of one path in bytes; all numbers count bits."""

    view: str
    offset: int
    dims: tuple[int, ...] = ()
    strides: tuple[int, ...] = ()

    def within(self, offset: int, dims: tuple[int, ...], size: int) -> BytePart:
        """Return the part inside an array at `offset`, whose structures have `size` bits."""
        strides = row_strides(dims, size)
        return BytePart(self.view, offset + self.offset, dims + self.dims, strides + self.strides)

    @property
    def counted(self) -> StretchPart:
        """The part, counted in elements of its view."""
        unit = _UNITS.get(self.view, 8)
        return StretchPart(self.offset // unit, self.dims, tuple(stride // unit for stride in self.strides))


@lru_cache(maxsize=1024)
def byte_parts(kind: DataType) -> dict[str, BytePart]:
    """Return the parts of a type by path in capitals; "" is the path of the structure or number itself.

    >>> from .types import DINT, STRING, Member
    >>> found = byte_parts(Structure("Note", (Member("New", BOOL), Member("Text", STRING, (4,)))))
    >>> found["TEXT.LEN"]
    BytePart(view='i', offset=32, dims=(4,), strides=(704,))
    >>> found["TEXT.LEN"].counted
    StretchPart(offset=1, dims=(4,), strides=(22,))
    """
    if isinstance(kind, Elementary):
        return {"": BytePart(kind.code, 0)}
    parts = {"": BytePart(STRUCTURES, 0)}
    for member, byte, bit in members_at(kind):
        name, dims, offset = member.name.upper(), member.dims, 8 * byte + (bit or 0)
        if isinstance(member.type, Structure):
            for path, part in byte_parts(member.type).items():
                nested = part.within(offset, dims, 8 * size_of(member.type))
                parts[f"{name}.{path}" if path else name] = nested
        else:
            view = BITS if member.type is BOOL else member.type.code
            parts[name] = BytePart(view, offset, dims, row_strides(dims, member.type.bits))
    for number, member in enumerate(kind.hidden):
        parts[f"{HIDDEN}{member.name}".upper()] = BytePart(HIDDEN_VALUES, 8 * number)
    return parts


@lru_cache(maxsize=1024)
def fits_bytes(kind: DataType) -> bool:
    """Return whether a type can be stored as bytes.

    The number of a hidden member is its position plus the structure's first byte. So a structure with hidden
    members can't contain structures, or have more hidden members than bytes. COP treats a tag of type BOOL as
    a byte, but it is a bit in memory.
    """
    if isinstance(kind, Elementary):
        return not kind.is_bool
    if not kind.own:
        return False
    inner = [member.type for member in kind.own if isinstance(member.type, Structure)]
    if kind.hidden and (inner or len(kind.hidden) > size_of(kind)):
        return False
    return all(map(fits_bytes, inner))


def hidden_places(kind: DataType, count: int) -> Iterator[int]:
    """Yield the numbers of all hidden members in `count` elements of a type; see `fits_bytes`."""
    for path, part in byte_parts(kind).items():
        if part.view == HIDDEN_VALUES:
            spot = spot_of(kind, (count,), path, "", in_bytes=True)
            yield from map(spot.at, range(count * count_of(part.dims)))


@record
class Spot:
    """The place of a leaf, or of structures, in a list or in bytes."""

    ident: str  # variable of the list or the bytes in the compiled program
    base: str  # variable of the stretch's offset in values or bytes, "" for 0
    size: int  # values per element of the tag
    part: StretchPart  # the leaf in an element
    strides: tuple[int, ...]  # of all dimensions of the leaf, the tag's included
    view: str = ""  # view of the bytes that has the values; "" for a list

    @property
    def variable(self) -> str:
        """The list or the view in the compiled program."""
        return f"{self.ident}.{self.view}" if self.view else self.ident

    @property
    def unit(self) -> int:
        """Bits per element of the view."""
        return _UNITS.get(self.view, 8)

    def begin(self, base: int) -> int:
        """Return the index of the element at an offset in values or bytes."""
        return base * 8 // self.unit if self.view else base

    @property
    def begin_text(self) -> str:
        """Return Python code for `begin`, with the offset in the variable `base`."""
        if self.unit == 1:
            return f"{self.base} * 8"
        shift = self.unit.bit_length() - 4
        return f"({self.base} >> {shift})" if shift else self.base

    def at(self, index: int) -> int:
        """Return the offset of a value from its flat index in the leaf."""
        part = self.part
        if not part.dims:
            return index * self.size + part.offset
        element, remaining = divmod(index, count_of(part.dims))
        offset = element * self.size + part.offset
        for length, stride in zip(reversed(part.dims), reversed(part.strides), strict=True):
            remaining, subscript = divmod(remaining, length)
            offset += subscript * stride
        return offset


def spot_of(
    kind: DataType, dims: tuple[int, ...], rest: str, ident: str, base: str = "", *, in_bytes: bool = False
) -> Spot:
    """Return the place of path `rest` in a tag, in list or bytes `ident` starting at `base`."""
    if in_bytes:
        bits = byte_parts(kind)[rest.upper()]
        size = size_of(kind) * 8 // _UNITS.get(bits.view, 8)
        counted = bits.counted
        return Spot(ident, base, size, counted, row_strides(dims, size) + counted.strides, bits.view)
    stretch = stretch_of(kind)
    part = stretch.parts[rest.upper()]
    return Spot(ident, base, stretch.size, part, row_strides(dims, stretch.size) + part.strides)
