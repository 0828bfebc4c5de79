"""Paths of requests: `91 05 'Local' 00`, `20 6B 25 00 01 00`, `28 03` [1756-PM020, request path]."""

from __future__ import annotations

import re
from dataclasses import field

from ..dataclass import dataclass
from .codes import BAD_SEGMENT, SYMBOL, CipRefusedError


@dataclass(frozen=True, slots=True)
class Instance:
    """A symbol identified by its number instead of its name."""

    number: int


PathStep = str | int | Instance
"""A name, a subscript, or a symbol's number."""


PROGRAM = "Program:"
"""Prefix of a program's name in paths."""

_PART = re.compile(r"(?P<name>[^.\[\]]+)(?:\[(?P<places>\d{1,9}(?:,\d{1,9}){0,2})\])?")


def steps_of(text: str) -> list[PathStep]:
    r"""Return the steps of a name.

    >>> steps_of("Recipe.Steps[2].Time"), steps_of(r"\Main.Run")
    (['Recipe', 'Steps', 2, 'Time'], ['Program:Main', 'Run'])

    Raises:
        ValueError: the text is not a name.
    """
    if text.startswith("\\"):
        text = PROGRAM + text[1:]
    steps: list[PathStep] = []
    if text.lower().startswith(PROGRAM.lower()):
        name, _, text = text.partition(".")
        steps = [name]
    for step_text in text.replace("/", ".").split(".") if text else ():
        match = _PART.fullmatch(step_text)
        if match is None:
            raise ValueError(f"{text!r} is not a name of a tag, such as Recipe.Steps[2].Time")
        steps.append(match["name"])
        steps += map(int, match["places"].split(",")) if match["places"] else ()
    return steps


@dataclass(slots=True)
class Path:
    """The content of a path."""

    numbers: dict[str, int] = field(default_factory=dict)  # class, instance, point, attribute
    steps: list[PathStep] = field(default_factory=list)
    ports: list[tuple[int, int]] = field(default_factory=list)  # port and link of a route


_SYMBOLIC, _KEY, _KEY_BYTES = 0x91, 0x34, 10
_LOGICAL = {0x20: "class", 0x24: "instance", 0x28: "element", 0x2C: "point", 0x30: "attribute"}


def parse_path(data: bytes) -> Path:
    """Read a padded path.

    >>> parse_path(bytes.fromhex("91 03 52756E 00 28 07")).steps
    ['Run', 7]

    Raises:
        CipRefusedError: the data is not a path.
    """
    path, offset = Path(), 0
    while offset < len(data):
        kind = data[offset]
        if kind == _SYMBOLIC:
            offset = _symbolic(path, data, offset)
        elif kind & 0xFC in _LOGICAL and kind & 3 != 3:
            offset = _logical(path, data, offset)
        elif kind == _KEY and offset + _KEY_BYTES <= len(data):
            offset += _KEY_BYTES
        elif 0 < kind < 0x10 and offset + 2 <= len(data):
            path.ports.append((kind, data[offset + 1]))
            offset += 2
        else:
            raise CipRefusedError(BAD_SEGMENT)
    return path


def _symbolic(path: Path, data: bytes, offset: int) -> int:
    """Add the steps of a name at an offset to a path; return the offset after it."""
    size = data[offset + 1] if offset + 1 < len(data) else 0
    begin = offset + 2
    text = data[begin : begin + size]
    if not size or len(text) < size or not text.isascii():
        raise CipRefusedError(BAD_SEGMENT)
    path.steps.extend(split_name(text.decode("ascii")))
    return begin + size + size % 2


def _logical(path: Path, data: bytes, offset: int) -> int:
    """Add the number at an offset to a path; return the offset after it."""
    size = 1 << (data[offset] & 3)
    start = offset + (1 if size == 1 else 2)
    if start + size > len(data):
        raise CipRefusedError(BAD_SEGMENT)
    value = int.from_bytes(data[start : start + size], "little")
    segment = _LOGICAL[data[offset] & 0xFC]
    if segment == "element":
        path.steps.append(value)
    else:
        path.numbers[segment] = value
        if segment == "instance" and path.numbers.get("class") == SYMBOL:
            path.steps.append(Instance(value))
    return start + size


def split_name(name: str) -> list[PathStep]:
    """Return the steps of a name that a client sends in one segment, such as `A.B[3]`.

    >>> split_name("Program:Main.Step[2].Time")
    ['Program:Main', 'Step', 2, 'Time']

    Raises:
        CipRefusedError: a subscript is not a number.
    """
    steps: list[PathStep] = []
    for step_text in name.split("."):
        stem, _, subscripts = step_text.partition("[")
        steps.append(stem)
        for subscript in subscripts.rstrip("]").split(",") if subscripts else ():
            if not subscript.strip().isdigit() or len(subscript) > 10:
                raise CipRefusedError(BAD_SEGMENT)
            steps.append(int(subscript))
    return steps
