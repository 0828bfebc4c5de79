"""Whether two forms of a value agree: both in the form of `Tag.initial`.

What the second form lacks agrees: it is without local tags of add-ons.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from scanrack.ladder.model.types import DataType, Elementary, Structure

Path = tuple[str, ...]
"""Steps to a value: `(".Steps", "[2]")`."""

_BIT = re.compile(r"(\w+)\.(\d+)")
_PRECISION = 1e-8  # relative, of an LREAL as text


def first_difference(kind: DataType, dims: tuple[int, ...], whole: Any, other: Any) -> Path | None:
    """Return the path to the first value that differs, None without one.

    Args:
        whole: a form with all values; what is None is zero.
        other: a form that may lack some, which are None; it has its zeros.
    """
    if other is None:
        return None
    if dims:
        return _in_array(kind, dims[1:], whole, other)
    if isinstance(kind, Structure) and isinstance(other, Mapping):
        return _in_structure(kind, whole or {}, other)
    mine = _zero(kind) if whole is None else whole
    return None if _is_same(kind, mine, other) else ()


def _is_same(kind: DataType, mine: Any, other: Any) -> bool:
    if mine == other or (mine != mine and other != other):  # NaN
        return True
    return isinstance(kind, Elementary) and kind.is_double and math.isclose(mine, other, rel_tol=_PRECISION)


def _in_array(kind: DataType, dims: tuple[int, ...], whole: Any, other: Any) -> Path | None:
    for place, each in enumerate(other):
        inner = None if whole is None else whole[place]
        found = first_difference(kind, dims, inner, each)
        if found is not None:
            return (f"[{place}]", *found)
    return None


def _in_structure(kind: Structure, whole: Mapping[str, Any], other: Mapping[str, Any]) -> Path | None:
    if whole == other:
        return None
    bits = _bits(kind)
    for name, each in other.items():
        member = kind.member(name)
        if member is None:
            continue
        if member.at:  # a part of another member
            differs = name in bits and _bit_of(whole, other, bits[name]) != each
            found: Path | None = () if differs else None
        else:
            found = first_difference(member.type, member.dims, whole.get(member.name), each)
        if found is not None:
            return (f".{name}", *found)
    return None


def value_at(kind: DataType, value: Any, path: Path) -> Any:
    """Return the value at a path."""
    here = kind
    for step in path:
        if step[0] == "[":
            value = None if value is None else value[int(step[1:-1])]
            continue
        assert isinstance(here, Structure)
        member = here.member(step[1:])
        assert member is not None
        given = value or {}
        value, here = given.get(member.name), member.type
        if member.at and value is None:
            return _bit_of(given, {}, _bits(kind)[member.name])
    return _zero(here) if value is None else value


def _bit_of(whole: Mapping[str, Any], other: Mapping[str, Any], at: tuple[str, int]) -> bool:
    host, bit = at
    return bool(int(whole.get(host, other.get(host)) or 0) >> bit & 1)


@lru_cache(maxsize=1024)
def _bits(kind: Structure) -> Mapping[str, tuple[str, int]]:
    """Return the bits of a structure's integers by name, each with its host and its number."""
    found = {}
    for each in kind.members:
        place = _BIT.fullmatch(each.at)
        host = kind.member(place[1]) if place else None
        if place and host is not None and isinstance(host.type, Elementary) and not host.dims:
            found[each.name] = host.name, int(place[2])
    return found


def _zero(kind: DataType) -> Any:
    return kind.zero if isinstance(kind, Elementary) else "" if kind.is_string else {}
