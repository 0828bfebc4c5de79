"""The CDR layout of a message's fields, each at a multiple of its size from the message's start.

    scan  uint32   at 0
    lamp  bool     at 4
    speed float64  at 8       after three bytes of padding

This is version 1 of the encoding, as the prefix 00 01 00 00 of a payload states [OMG DDS-XTypes 1.3,
7.4.1.1]. Nested messages have no separate alignment.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from struct import calcsize
from typing import NamedTuple

PRIMITIVES: Mapping[str, str] = {
    "bool": "?",
    "byte": "B",
    "char": "B",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
    "float32": "f",
    "float64": "d",
}
"""Letters of the `struct` module by type in ros2msg."""

SIZES: Mapping[str, int] = {letter: calcsize(f"<{letter}") for letter in PRIMITIVES.values()}
"""Size of a value by its letter, bytes."""

DEPTH_MAX = 16
"""Maximum nesting of messages."""

_FIELD = re.compile(r"(?P<type>[\w/]+)(?:\[(?P<length>[1-9]\d{0,8})\])? (?P<name>\w+)")
_CONSTANT = re.compile(r"\w+ \w+ ?=")


class Leaf(NamedTuple):
    """A value in a message, or the elements of an array in a message."""

    path: tuple[str, ...]  # its name, preceded by the names of the enclosing messages
    letter: str  # its type in the `struct` module
    length: int  # number of elements; 1 for a single value
    offset: int  # its first byte

    @property
    def end(self) -> int:
        """The offset after the last byte."""
        return self.offset + self.length * SIZES[self.letter]


def _no_size(text: str) -> ValueError:
    return ValueError(f"field {text!r} has no fixed size, or an unknown type")


def _field(text: str) -> tuple[str, str, int]:
    """Return the type, name and length of a field."""
    match = _FIELD.fullmatch(text)
    if match is None:
        raise _no_size(text)
    return match["type"].rpartition("/")[2], match["name"], int(match["length"] or 1)


def leaves(
    lines: Sequence[str], messages: Mapping[str, Sequence[str]], offset: int, path: tuple[str, ...] = ()
) -> Iterator[Leaf]:
    """Yield the values of a message in order.

    >>> [(leaf.path, leaf.offset) for leaf in leaves(["bool on", "In in"], {"In": ["float64 speed"]}, 3)]
    [(('on',), 3), (('in', 'speed'), 8)]

    Args:
        lines: the message's fields, as in ros2msg.
        messages: messages that may be types of fields, by name.

    Raises:
        ValueError: a field has no fixed size or has an unknown type, or messages are nested too deeply.
    """
    if len(path) > DEPTH_MAX:
        raise ValueError(f"messages are nested more than {DEPTH_MAX} deep")
    for line in lines:
        text = line.partition("#")[0].strip()
        if not text or _CONSTANT.match(text):
            continue
        kind, name, length = _field(text)
        if kind in PRIMITIVES:
            letter = PRIMITIVES[kind]
            leaf = Leaf((*path, name), letter, length, -(-offset // SIZES[letter]) * SIZES[letter])
            yield leaf
            offset = leaf.end
            continue
        if kind not in messages:
            raise _no_size(text)
        for _ in range(length):
            begin = offset
            for leaf in leaves(messages[kind], messages, offset, (*path, name)):
                yield leaf
                offset = leaf.end
            if offset == begin:
                break  # empty messages take no bytes, however many there are
