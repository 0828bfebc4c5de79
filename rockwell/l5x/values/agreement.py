"""Compares two forms of a value, both as in `Tag.initial`.

The first form is complete. Values that the second form lacks count as equal, because decorated data lacks the
local tags of add-ons.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from scanrack.ladder.model.types import DataType, Elementary, Structure

Path = tuple[str, ...]
"""Steps to a value: `(".Steps", "[2]")`."""

_BIT = re.compile(r"(\w+)\.(\d+)")
_PRECISION = 1e-8  # relative, of an LREAL as text


def first_difference(kind: DataType, dims: tuple[int, ...], complete: Any, partial: Any) -> Path | None:
    """Return the path to the first value that differs; None if all values are equal.

    Args:
        complete: a form with all values; None means zero.
        partial: a form with explicit zeros; None means a value that it lacks.
    """
    if partial is None:
        return None
    if dims:
        return _in_array(kind, dims[1:], complete, partial)
    if isinstance(kind, Structure) and isinstance(partial, Mapping):
        return _in_structure(kind, complete or {}, partial)
    return None if _is_same(kind, _zero(kind) if complete is None else complete, partial) else ()


def _is_same(kind: DataType, first: Any, second: Any) -> bool:
    """Return whether two values are equal; NaN equals NaN, and an LREAL may be rounded as in text."""
    if first == second or (first != first and second != second):  # NaN
        return True
    return isinstance(kind, Elementary) and kind.is_double and math.isclose(first, second, rel_tol=_PRECISION)


def _in_array(kind: DataType, dims: tuple[int, ...], complete: Any, partial: Any) -> Path | None:
    """Return the path to the first element that differs, see `first_difference`.

    `dims` are the dimensions of an element, which is an array itself if the array has several dimensions.
    """
    for index, element in enumerate(partial):
        path = first_difference(kind, dims, None if complete is None else complete[index], element)
        if path is not None:
            return (f"[{index}]", *path)
    return None


def _in_structure(kind: Structure, complete: Mapping[str, Any], partial: Mapping[str, Any]) -> Path | None:
    """Return the path to the first member that differs, see `first_difference`.

    A member that is a bit of an integer is compared with the bit of that integer.
    """
    if complete == partial:
        return None
    bits = _bits(kind)
    for name, value in partial.items():
        member = kind.member(name)
        if member is None:
            continue
        path: Path | None = None
        if not member.at:
            path = first_difference(member.type, member.dims, complete.get(member.name), value)
        elif name in bits:
            host = bits[name].host
            hosts = complete if host in complete else partial
            path = None if _is_set(hosts, bits[name]) == value else ()
        if path is not None:
            return (f".{name}", *path)
    return None


def value_at(kind: DataType, value: Any, path: Path) -> Any:
    """Return the value at a path in a value of a type; an omitted value is zero, "" or {}."""
    for step in path:
        if step[0] == "[":
            value = None if value is None else value[int(step[1:-1])]
            continue
        assert isinstance(kind, Structure)
        member = kind.member(step[1:])
        assert member is not None
        members = value or {}
        value = members.get(member.name)
        if member.at and value is None:
            return _is_set(members, _bits(kind)[member.name])
        kind = member.type
    return _zero(kind) if value is None else value


class _Bit(NamedTuple):
    host: str  # the integer member that contains it
    number: int


def _is_set(members: Mapping[str, Any], bit: _Bit) -> bool:
    """Return whether a bit of an integer is set; an omitted integer is zero."""
    return bool(int(members.get(bit.host) or 0) >> bit.number & 1)


@lru_cache(maxsize=1024)
def _bits(kind: Structure) -> Mapping[str, _Bit]:
    """Return the members of a structure that are bits of its integers, by name."""
    bits = {}
    for member in kind.members:
        match = _BIT.fullmatch(member.at)
        host = kind.member(match[1]) if match else None
        if match and host is not None and isinstance(host.type, Elementary) and not host.dims:
            bits[member.name] = _Bit(host.name, int(match[2]))
    return bits


def _zero(kind: DataType) -> Any:
    """Return zero for an elementary type, "" for a string and {} for a structure."""
    if isinstance(kind, Elementary):
        return kind.zero
    return "" if kind.is_string else {}
