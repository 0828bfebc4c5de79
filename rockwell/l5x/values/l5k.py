"""L5K text to initial values: `[1.50000000e+000,[7,0],[0,5000,0]]`.

It has the values of all members in memory order, see `layouts`.
"""

from __future__ import annotations

import re
from itertools import chain, repeat
from typing import Any

from scanrack.ladder.model.types import DINT, DataType, Elementary, Structure, count_of

from ..xml.elements import number_of
from .initials import ValueReading, nested, scalar
from .value_texts import ValueTextError, unquoted_or_raise

_DEEPEST = 64  # maximum depth of brackets


_TOKEN = re.compile(
    r"\s*(?:(?P<mark>[\[\],])|(?P<string>'(?:[^'$]++|\$.)*+')|(?P<value>[^\[\],'\s]+))", re.DOTALL
)


UNREAD: Any = object()
"""The value of a member whose memory layout is unknown."""


class OtherVersionError(ValueTextError):
    """The data belong to another version of their type, or to a type with an unknown memory layout."""


_NUL = "$00"
"""A padding character after the LEN of a string."""


def from_l5k(text: str, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    """Return an initial value as in `Tag.initial`; None for the type's own.

    Raises:
        OtherVersionError: the number of values differs from the type's.
        ValueTextError: the text can't be read.
    """
    text = text.strip()
    if not text:
        return None
    return _l5k_value(_l5k_tree(text), kind, dims, how)


def _l5k_tree(text: str) -> Any:
    outer: list[Any] = []
    open_lists = [outer]
    position = 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            if not text[position:].strip():
                break
            raise ValueTextError(f"{text[position : position + 20]!r} is not L5K data")
        position = match.end()
        mark = match["mark"]
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
            open_lists[-1].append(match["string"] or match["value"])
    if len(open_lists) != 1 or len(outer) != 1:
        raise ValueTextError("L5K data are not one value")
    return outer[0]


def _l5k_value(tree: Any, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    if dims:
        return _l5k_array(tree, kind, dims, how)
    if isinstance(kind, Elementary):
        if not isinstance(tree, str):
            raise _other_version(kind)
        return scalar(tree, kind, how)
    return _l5k_string(tree, kind, how) if kind.is_string else _l5k_structure(tree, kind, how)


def _l5k_array(tree: Any, kind: DataType, dims: tuple[int, ...], how: ValueReading) -> Any:
    flat: list[Any] = [tree]
    for _ in dims:
        flat = [item for part in flat if isinstance(part, list) for item in part]
    if len(flat) > count_of(dims):
        raise ValueTextError(f"{len(flat)} values for an array of {count_of(dims)}")
    values = [_l5k_value(item, kind, (), how) for item in flat]
    if all(value is None for value in values):
        return None
    return nested(values + [None] * (count_of(dims) - len(values)), kind, dims)


def _l5k_string(tree: Any, kind: Structure, how: ValueReading) -> str | None:
    if not (isinstance(tree, list) and len(tree) == 2 and all(isinstance(part, str) for part in tree)):
        raise _other_version(kind)
    length, text = tree[0], tree[1][1:-1] if tree[1][0] == "'" else tree[1]
    size = number_of(length)
    if size is None:
        raise _other_version(kind)
    most_characters = min(size, kind.members[1].dims[0])
    characters = unquoted_or_raise(_without_padding(text, most_characters))[:most_characters]
    return characters if characters or how.keep else None


def _without_padding(text: str, most: int) -> str:
    """Return a literal without padding zeros at its end, down to `most` characters."""
    count = max(0, len(text) // len(_NUL) - most)  # an escaped character has at most this many letters
    end = len(text) - count * len(_NUL)
    is_padding = text[end:] == _NUL * count and text[end - 1 : end] != "$"
    return text[:end] if is_padding else text


def _l5k_structure(tree: Any, kind: Structure, how: ValueReading) -> Any:
    """Return members in memory order."""
    parts = how.layouts.parts(kind)
    if not isinstance(tree, list) or len(tree) != len(parts) or not how.layouts.is_complete(kind):
        raise _other_version(kind)
    values: dict[str, Any] = {}
    for part, inner in zip(parts, tree, strict=True):
        if isinstance(part, tuple):
            word = _l5k_value(inner, DINT, (), _KEPT)
            values.update(
                (member.name, on) for member, bit in part if (on := bool(word >> bit & 1)) or how.keep
            )
            continue
        try:
            value = _l5k_value(inner, part.type, part.dims, how)
        except OtherVersionError:
            if how.layouts.has_members(part.type):
                raise
            value = UNREAD
            how.unread.append(part.type.name)
        if value is not None:
            values[part.name] = value
    return values or None


def filled(value: Any, other: Any) -> Any:
    """Return a value with `UNREAD` members replaced by the members of another form."""
    if value is UNREAD:
        return other
    if isinstance(value, dict):
        members = other if isinstance(other, dict) else {}
        filled_values = {name: filled(inner_value, members.get(name)) for name, inner_value in value.items()}
        return {name: inner_value for name, inner_value in filled_values.items() if inner_value is not None}
    if isinstance(value, list):
        others = chain(other if isinstance(other, list) else (), repeat(None))
        return [filled(element, inner) for element, inner in zip(value, others, strict=False)]
    return value


_KEPT = ValueReading(keep=True)


def _other_version(kind: DataType) -> OtherVersionError:
    return OtherVersionError(f"its data are of another version of {kind.name}")
