"""Sets the initial values of tags in bytes, with a table per type instead of path by path."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.stretches import BITS
from ..model.types import BOOL, DataType, Elementary, Structure, count_of, members_at, size_of
from .named_parts import alias_place
from .tag_bytes import TagBytes, set_chars
from .values import checked


@dataclass(frozen=True, slots=True)
class _MemberPlace:
    """A member in the bytes of its structure."""

    type: DataType
    dims: tuple[int, ...]
    bit: int  # its first bit


def load_bytes(tag: TagBytes, kind: DataType, dims: tuple[int, ...], value: Any) -> bool:
    """Set a tag's values, in the form for `Memory.load`; return False if one is unusual or does not fit."""
    try:
        _load(tag, kind, dims, 0, value)
    except (ValueError, LookupError, TypeError, AttributeError):
        return False
    return True


def _load(tag: TagBytes, kind: DataType, dims: tuple[int, ...], first_bit: int, value: Any) -> None:
    """Set the values that begin at a bit; raise an exception for a value that does not fit."""
    if dims:
        if not isinstance(value, Sequence) or isinstance(value, str) or len(value) > dims[0]:
            raise ValueError
        step = count_of(dims[1:]) * (1 if kind is BOOL else 8 * size_of(kind))
        for number, item in enumerate(value):
            _load(tag, kind, dims[1:], first_bit + number * step, item)
    elif isinstance(kind, Elementary):
        view, bits = (BITS, 1) if kind is BOOL else (kind.code, kind.bits)
        tag.put(view, first_bit // bits, checked("", kind, value))
    elif isinstance(value, str):
        capacity = kind.members[1].dims[-1]  # of DATA, after LEN
        characters = value.encode("latin-1", errors="replace")
        if len(characters) > capacity or not kind.is_string:
            raise ValueError
        set_chars(tag, first_bit // 8, capacity, characters)
    else:
        places = _member_places(kind)
        for name, item in value.items():
            place = places[name]
            _load(tag, place.type, place.dims, first_bit + place.bit, item)


@lru_cache(maxsize=1024)
def _member_places(kind: Structure) -> Mapping[str, _MemberPlace]:
    """Return the members of a structure by name."""
    members = members_at(kind)
    places = {
        stored_member.name: _MemberPlace(stored_member.type, stored_member.dims, 8 * byte + (bit or 0))
        for stored_member, byte, bit in members
    }
    return places | {
        member.name: _MemberPlace(*alias_place(kind, member)) for member in kind.members if member.at
    }
