"""L5K text to initial values: `[1.50000000e+000,[7,0],[0,5000,0]]`.

It has the values of all members in memory order.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ....ladder.model.types import DINT, DataType, Elementary, Member, Structure, count_of
from ..xml.records import number_of
from .initials import ValueReading, nested, scalar
from .value_texts import ValueTextError, unquoted_or_raise

_DEEPEST = 64  # maximum depth of brackets


_TOKEN = re.compile(
    r"\s*(?:(?P<mark>[\[\],])|(?P<string>'(?:[^'$]++|\$.)*+')|(?P<value>[^\[\],'\s]+))", re.DOTALL
)


def from_l5k(text: str, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    """Return an initial value as in `Tag.initial`, None for the type's own; or raise a ValueTextError."""
    text = text.strip()
    if not text:
        return None
    return _l5k_value(_l5k_tree(text), kind, dims, how)


def _l5k_tree(text: str) -> Any:
    outer: list[Any] = []
    open_lists = [outer]
    at = 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        if found is None:
            if not text[at:].strip():
                break
            raise ValueTextError(f"{text[at : at + 20]!r} is not L5K data")
        at = found.end()
        mark = found["mark"]
        if mark == "[":
            if len(open_lists) > _DEEPEST:
                raise ValueTextError(f"L5K data are more than {_DEEPEST} levels deep")
            open_lists[-1].append([])
            open_lists.append(open_lists[-1][-1])
        elif mark == "]":
            if len(open_lists) == 1:
                raise ValueTextError("L5K data have an unmatched closing bracket")
            open_lists.pop()
        elif mark is None:
            open_lists[-1].append(found["string"] or found["value"])
    if len(open_lists) != 1 or len(outer) != 1:
        raise ValueTextError("L5K data are not one value")
    return outer[0]


def _l5k_value(tree: Any, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    if dims:
        return _l5k_array(tree, kind, dims, how)
    if isinstance(kind, Elementary):
        return scalar(tree, kind, how) if isinstance(tree, str) else None
    if kind.is_string:
        return _l5k_string(tree, kind)
    return _l5k_structure(tree, kind, how) if isinstance(tree, list) else None


def _l5k_array(tree: Any, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    flat: list[Any] = [tree]
    for _ in dims:
        flat = [each for part in flat if isinstance(part, list) for each in part]
    if len(flat) > count_of(dims):
        raise ValueTextError(f"{len(flat)} values are given; it has {count_of(dims)}")
    values = [_l5k_value(each, kind, (), how) for each in flat]
    if all(each is None for each in values):
        return None
    return nested(values + [None] * (count_of(dims) - len(values)), kind, dims)


def _l5k_string(tree: Any, kind: Structure) -> str | None:
    if not (isinstance(tree, list) and len(tree) == 2 and all(isinstance(each, str) for each in tree)):
        return None
    length, text = tree
    characters, most = unquoted_or_raise(text.strip("'")), number_of(length)
    return characters[:most] or None if most is not None else None


def _l5k_structure(tree: Sequence[Any], kind: Structure, how: ValueReading) -> Any:
    """Return members in memory order; status bits of predefined types share a first word."""
    bits = [each for each in kind.own if each.bit is not None]
    words = [each for each in kind.own if each.bit is None]
    packed = any(each.type.name == "BOOL" and not each.dims for each in words)
    if len(tree) != len(words) + bool(bits) or packed:
        how.say(f"its data are of another version of {kind.name}")
        return None
    found: dict[str, Any] = {}
    if bits:
        word = scalar(tree[0], DINT, _KEPT) if isinstance(tree[0], str) else 0
        found.update((each.name, True) for each in bits if int(word) >> _bit(each) & 1)
    for member, part in zip(words, tree[bool(bits) :], strict=True):
        value = _l5k_value(part, member.type, member.dims, how)
        if value is not None:
            found[member.name] = value
    return found or None


_KEPT = ValueReading(keep=True)


def _bit(member: Member) -> int:
    return member.bit or 0
