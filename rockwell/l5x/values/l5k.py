"""Converts L5K text to initial values: `[1.50000000e+000,[7,0],[0,5000,0]]`.

The text contains the values of all members in memory order, see `layouts`.
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
    """The data belongs to another version of its type, or to a type with an unknown memory layout."""


_NUL = "$00"
"""A padding character, after the LEN characters of a string."""


def from_l5k(text: str, kind: DataType, dims: tuple[int, ...], reading: ValueReading) -> Any:
    """Return an initial value as in `Tag.initial`; None for the type's own initial value.

    Raises:
        OtherVersionError: the number of values differs from the type's.
        ValueTextError: the text can't be read.
    """
    text = text.strip()
    if not text:
        return None
    return _l5k_value(_l5k_tree(text), kind, dims, reading)


def _l5k_tree(text: str) -> Any:
    """Return the text of a single value, or texts in lists that are nested like the brackets.

    Raises:
        ValueTextError: the text is not one value.
    """
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


def _l5k_value(tree: Any, kind: DataType, dims: tuple[int, ...], reading: ValueReading) -> Any:
    """Return the value in a tree of texts, see `from_l5k`."""
    if dims:
        return _l5k_array(tree, kind, dims, reading)
    if isinstance(kind, Elementary):
        if not isinstance(tree, str):
            raise _other_version(kind)
        return scalar(tree, kind, reading)
    return _l5k_string(tree, kind, reading) if kind.is_string else _l5k_structure(tree, kind, reading)


def _l5k_array(tree: Any, kind: DataType, dims: tuple[int, ...], reading: ValueReading) -> Any:
    """Return the elements in nested lists, with zeros for missing ones at the end; None if all are zero."""
    flat: list[Any] = [tree]
    for _ in dims:  # each dimension has its own level of brackets
        flat = list(chain.from_iterable(branch for branch in flat if isinstance(branch, list)))
    if len(flat) > count_of(dims):
        raise ValueTextError(f"{len(flat)} values for an array of {count_of(dims)}")
    values = [_l5k_value(item, kind, (), reading) for item in flat]
    if all(value is None for value in values):
        return None
    return nested(values + [None] * (count_of(dims) - len(values)), kind, dims)


def _l5k_string(tree: Any, kind: Structure, reading: ValueReading) -> str | None:
    """Return the first LEN characters of a string, `[LEN,'text']`; None for an empty one."""
    if not isinstance(tree, list) or [type(member) for member in tree] != [str, str]:
        raise _other_version(kind)
    length_text, text = tree
    length = number_of(length_text)
    if length is None:
        raise _other_version(kind)
    if text[0] == "'":
        text = text[1:-1]
    most_characters = min(length, kind.members[1].dims[0])
    characters = unquoted_or_raise(_without_padding(text, most_characters))[:most_characters]
    return characters if characters or reading.keep_zeros else None


def _without_padding(text: str, most: int) -> str:
    """Return a literal without the padding at its end, but with at least `most` characters."""
    count = max(0, len(text) // len(_NUL) - most)  # no character is written with more letters than a padding
    end = len(text) - count * len(_NUL)
    is_padding = text[end:] == _NUL * count and text[end - 1 : end] != "$"
    return text[:end] if is_padding else text


def _l5k_structure(tree: Any, kind: Structure, reading: ValueReading) -> Any:
    """Return the values of members by name; None for zeros."""
    parts = reading.layouts.parts(kind)
    if not isinstance(tree, list) or len(tree) != len(parts) or not reading.layouts.is_complete(kind):
        raise _other_version(kind)
    values: dict[str, Any] = {}
    for part, inner in zip(parts, tree, strict=True):
        if isinstance(part, tuple):
            word = _l5k_value(inner, DINT, (), _WITH_ZEROS)
            bits = {member.name: bool(word >> bit & 1) for member, bit in part}
            values |= {name: is_set for name, is_set in bits.items() if is_set or reading.keep_zeros}
            continue
        try:
            value = _l5k_value(inner, part.type, part.dims, reading)
        except OtherVersionError:
            if reading.layouts.has_members(part.type):
                raise
            value = UNREAD
            reading.unread.append(part.type.name)
        if value is not None:
            values[part.name] = value
    return values or None


def filled(value: Any, source: Any) -> Any:
    """Return a value with `UNREAD` members taken from another form, or omitted if that form lacks them."""
    if value is UNREAD:
        return source
    if isinstance(value, dict):
        sources = source if isinstance(source, dict) else {}
        members = {name: filled(member, sources.get(name)) for name, member in value.items()}
        return {name: member for name, member in members.items() if member is not None}
    if isinstance(value, list):
        elements = chain(source if isinstance(source, list) else (), repeat(None))
        return list(map(filled, value, elements))
    return value


_WITH_ZEROS = ValueReading(keep_zeros=True)


def _other_version(kind: DataType) -> OtherVersionError:
    return OtherVersionError(f"its data are of another version of {kind.name}")
