"""Stretches: the memory of values that are passed by reference.

Most tags are variables of the compiled program. An instance of an add-on instruction, and a tag passed to an
InOut, is a stretch of a list: its elementary values in one order for every tag of the type. A function that
takes a list and an offset works on all of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from .types import HIDDEN, DataType, Elementary, count_of


@dataclass(frozen=True, slots=True)
class StretchPart:
    """The values of one path in a stretch."""

    offset: int  # of the first value
    dims: tuple[int, ...] = ()  # lengths of the arrays in the structure around it, the outermost first
    strides: tuple[int, ...] = ()  # distance between neighbours, per dimension


@dataclass(frozen=True, slots=True)
class Stretch:
    """The list of one element of a type."""

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
    """Return the distance between neighbours per dimension, for elements of that size."""
    strides: tuple[int, ...] = ()
    for length in reversed(dims):
        strides = (size, *strides)
        size *= length
    return strides


@dataclass(frozen=True, slots=True)
class Spot:
    """The place of a leaf in a list."""

    ident: str  # variable of the list in the compiled program
    base: str  # variable of the stretch's offset, "" for 0
    size: int  # values per element of the tag
    part: StretchPart  # the leaf in an element
    strides: tuple[int, ...]  # of all dimensions of the leaf, the tag's included

    def at(self, index: int) -> int:
        """Return the offset of a value from its flat index in the leaf."""
        part = self.part
        if not part.dims:
            return index * self.size + part.offset
        element, rest = divmod(index, count_of(part.dims))
        at = element * self.size + part.offset
        for length, stride in zip(reversed(part.dims), reversed(part.strides), strict=True):
            rest, here = divmod(rest, length)
            at += here * stride
        return at


def spot_of(kind: DataType, dims: tuple[int, ...], rest: str, ident: str, base: str = "") -> Spot:
    """Return the place of members `rest` of a tag, in the list `ident` from the variable `base` on."""
    stretch = stretch_of(kind)
    part = stretch.parts[rest.upper()]
    return Spot(ident, base, stretch.size, part, row_strides(dims, stretch.size) + part.strides)
