"""Compares two forms of a value, both as in `Tag.initial`.

Values that the second form lacks count as equal: it does not have local tags of add-ons.
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
    """Return the path to the first value that differs; None if none does.

    Args:
        whole: a form with all values; None means zero.
        other: a form with explicit zeros; None means that it lacks the value.
    """
    if other is None:
        return None
    if dims:
        return _in_array(kind, dims[1:], whole, other)
    if isinstance(kind, Structure) and isinstance(other, Mapping):
        return _in_structure(kind, whole or {}, other)
    own_value = _zero(kind) if whole is None else whole
    return None if _is_same(kind, own_value, other) else ()


def _is_same(kind: DataType, mine: Any, other: Any) -> bool:
    if mine == other or (mine != mine and other != other):  # NaN
        return True
    return isinstance(kind, Elementary) and kind.is_double and math.isclose(mine, other, rel_tol=_PRECISION)


def _in_array(kind: DataType, dims: tuple[int, ...], whole: Any, other: Any) -> Path | None:
    for place, element in enumerate(other):
        inner = None if whole is None else whole[place]
        path = first_difference(kind, dims, inner, element)
        if path is not None:
            return (f"[{place}]", *path)
    return None


def _in_structure(kind: Structure, whole: Mapping[str, Any], other: Mapping[str, Any]) -> Path | None:
    if whole == other:
        return None
    bits = _bits(kind)
    for name, part in other.items():
        member = kind.member(name)
        if member is None:
            continue
        if member.at:  # a part of another member
            differs = name in bits and _bit_of(whole, other, bits[name]) != part
            path: Path | None = () if differs else None
        else:
            path = first_difference(member.type, member.dims, whole.get(member.name), part)
        if path is not None:
            return (f".{name}", *path)
    return None


def value_at(kind: DataType, value: Any, path: Path) -> Any:
    """Return the value at a path."""
    current_kind = kind
    for step in path:
        if step[0] == "[":
            value = None if value is None else value[int(step[1:-1])]
            continue
        assert isinstance(current_kind, Structure)
        member = current_kind.member(step[1:])
        assert member is not None
        members = value or {}
        value, current_kind = members.get(member.name), member.type
        if member.at and value is None:
            return _bit_of(members, {}, _bits(kind)[member.name])
    return _zero(current_kind) if value is None else value


def _bit_of(whole: Mapping[str, Any], other: Mapping[str, Any], at: tuple[str, int]) -> bool:
    host, bit = at
    return bool(int(whole.get(host, other.get(host)) or 0) >> bit & 1)


@lru_cache(maxsize=1024)
def _bits(kind: Structure) -> Mapping[str, tuple[str, int]]:
    """Return the bits of a structure's integers by name, each with its host and its number."""
    bits = {}
    for member in kind.members:
        place = _BIT.fullmatch(member.at)
        host = kind.member(place[1]) if place else None
        if place and host is not None and isinstance(host.type, Elementary) and not host.dims:
            bits[member.name] = host.name, int(place[2])
    return bits


def _zero(kind: DataType) -> Any:
    return kind.zero if isinstance(kind, Elementary) else "" if kind.is_string else {}
