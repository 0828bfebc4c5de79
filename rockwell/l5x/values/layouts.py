"""The memory layout of a structure in a controller: the order of its values, and their bytes.

| type | memory |
|---|---|
| TIMER, COUNTER, CONTROL | a word of status bits, then the members |
| defined by the document | the members in order; bits are in hidden members |
| add-on instruction | parameters by value, then local tags, in order; BOOLs are bits of 32-bit words |
| defined by a module | the members that its values show |

A word of BOOLs is at the place of its first BOOL [1756-RM084S p. 131]. A value begins at a multiple of its
size, a structure at a multiple of 4. A structure with an 8-byte value begins at a multiple of 8.
"""

from __future__ import annotations

from collections.abc import Container, Iterable
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from scanrack.ladder.model.types import (
    BOOL,
    CONTROL,
    COUNTER,
    TIMER,
    DataType,
    Elementary,
    Member,
    Structure,
    count_of,
    members_at,
    size_of,
)

from .per_type import per_type

Bits: TypeAlias = tuple[tuple[Member, int], ...]
"""BOOLs in a 32-bit word, each with its bit number."""

Part: TypeAlias = Member | Bits
"""A member with its own memory, or a word of BOOLs."""

Place: TypeAlias = tuple[Member, int, int | None]
"""A member with its own memory, its byte and, for a BOOL, its bit."""

WORD_BITS, WORD_BYTES = 32, 4

_WITH_STATUS = (TIMER, COUNTER, CONTROL)


@dataclass(slots=True)
class _Memory:
    """The memory of a structure; sizes in bytes."""

    places: tuple[Place, ...]
    size: int
    alignment: int


@dataclass(slots=True)
class Layouts:
    """The layouts of a document's types.

    Attributes:
        eights: whether 8-byte values begin at multiples of 8.
        own: types with all members known, by name in capitals.
        add_ons: add-on instructions by name in capitals, each with its members that no file contains.
    """

    eights: bool
    own: Container[str] = ()
    add_ons: dict[str, frozenset[str]] = field(default_factory=dict)
    by_type: dict[tuple[str, int], tuple[DataType, Any]] = field(default_factory=dict)  # see `per_type`

    @per_type
    def parts(self, kind: Structure) -> tuple[Part, ...]:
        """Return the parts of a structure in memory order."""
        status = tuple((member, member.bit) for member in kind.own if member.bit is not None)
        if status:
            return (status, *(member for member in kind.own if member.bit is None))
        omitted = self.add_ons.get(kind.name.upper())
        if omitted is None:
            return tuple(kind.own)
        return tuple(_packed(member for member in kind.own if member.name not in omitted))

    def has_members(self, kind: DataType) -> bool:
        """Return whether all members of a type are known, because the document defines or shows it."""
        return kind.name.upper() in self.own or kind.name.upper() in self.add_ons

    def is_complete(self, kind: Structure) -> bool:
        """Return whether `parts` covers the memory of a type.

        In other types, a single BOOL is a bit of an unknown word.
        """
        name = kind.name.upper()
        if name in self.add_ons or kind in _WITH_STATUS:
            return True
        return not any(member.type is BOOL and not member.dims for member in kind.own)

    @per_type
    def is_known(self, kind: DataType) -> bool:
        """Return whether the memory layout of a type is known."""
        if isinstance(kind, Elementary):
            return self.eights or kind.bits < 64
        if kind in _WITH_STATUS or kind.is_string:
            return True
        return (
            self.has_members(kind)
            and self.is_complete(kind)
            and all(self.is_known(member.type) for member in kind.own)
        )

    def size(self, kind: DataType, dims: tuple[int, ...] = ()) -> int:
        """Return the size of a value, in bytes."""
        if kind is BOOL and dims:
            return -(-count_of(dims) // WORD_BITS) * WORD_BYTES
        element_size = self._memory(kind).size if isinstance(kind, Structure) else size_of(kind)
        return element_size * count_of(dims)

    def places(self, kind: Structure) -> tuple[Place, ...]:
        """Return the members of a structure with their places."""
        return self._memory(kind).places

    @per_type
    def _memory(self, kind: Structure) -> _Memory:
        """Return the memory of a structure; each part begins at a multiple of its alignment."""
        if kind in _WITH_STATUS or kind.is_string or not self.is_complete(kind):
            return _Memory(members_at(kind), size_of(kind), WORD_BYTES)
        places: list[Place] = []
        size, widest = 0, WORD_BYTES
        for part in self.parts(kind):
            alignment = WORD_BYTES if isinstance(part, tuple) else self._alignment(part.type)
            widest = max(widest, alignment)
            size = -(-size // alignment) * alignment
            if isinstance(part, tuple):
                places += ((member, size + bit // 8, bit % 8) for member, bit in part)
                size += WORD_BYTES
            else:
                places.append((part, size, None))
                size += self.size(part.type, part.dims)
        return _Memory(tuple(places), -(-size // widest) * widest, widest)

    def _alignment(self, kind: DataType) -> int:
        """Return the alignment of a type, in bytes; its values begin at multiples of it."""
        if isinstance(kind, Structure):
            return self._memory(kind).alignment
        return WORD_BYTES if kind is BOOL else size_of(kind)

    def is_certain(self, kind: DataType) -> bool:
        """Return whether all arrays in a type begin at multiples of 4, where all alignment rules agree."""
        if isinstance(kind, Elementary) or kind.is_string:
            return True
        return all(
            (not member.dims or offset % 4 == 0) and self.is_certain(member.type)
            for member, offset, bit in self.places(kind)
            if bit is None
        )


def _packed(members: Iterable[Member]) -> Iterable[Part]:
    """Return members, with single BOOLs combined into 32-bit words."""
    parts: list[Member | list[tuple[Member, int]]] = []
    word: list[tuple[Member, int]] = []
    for member in members:
        if member.type is not BOOL or member.dims:
            parts.append(member)
            continue
        if len(word) in (0, WORD_BITS):
            word = []
            parts.append(word)
        word.append((member, len(word)))
    return [tuple(part) if isinstance(part, list) else part for part in parts]
