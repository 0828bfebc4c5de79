"""The conditions around a line of Python, and the values of names in the conditions and the line.

Values are looked up without running the program's code: locals, globals, attributes in an object's
dictionary or slots, and properties of scanrack's own objects, such as `status.MOVE_COMPLETE`.
"""

from __future__ import annotations

import ast
import inspect
import linecache
from collections import ChainMap
from collections.abc import Iterator, Mapping
from enum import Enum
from functools import cache
from importlib.util import decode_source
from pathlib import Path
from types import FrameType, MemberDescriptorType
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.ladder.python.sequences import Input, InputWord, Output
from scanrack.runtime.loop.faults import is_the_users

PLAIN = bool, int, float, str, type(None), Enum
LONGEST = 60
"""Maximum number of characters in a shown value."""


Condition = tuple[str, tuple[str, ...]]
"""The source text of a condition, and the names in it."""


@dataclass(frozen=True, slots=True)
class Stands:
    """The conditions around a line."""

    inside: tuple[Condition, ...]  # innermost first
    names: tuple[str, ...]  # names and attributes that the line reads, such as `line.step`


NOTHING = Stands((), ())


@cache
def stands_in(file: str, number: int) -> Stands:
    """Return the conditions around a line; none if the file can't be parsed as Python."""
    try:
        text = decode_source(Path(file).read_bytes())
        tree = ast.parse(text)
    except (OSError, SyntaxError, ValueError):
        return NOTHING
    statements = list(_statements_around(tree, number))
    conditions = [_condition(statement, number, text) for statement in reversed(statements)]
    is_simple = bool(statements) and not hasattr(statements[-1], "body")
    names = tuple(names_read(statements[-1])) if is_simple else ()
    return Stands(tuple(condition for condition in conditions if condition is not None), names)


def source_line(file: str, number: int) -> str:
    """Return a line of a file without the spaces around it; empty if it can't be read."""
    return linecache.getline(file, number).strip()


def _statements_around(node: ast.AST, number: int) -> Iterator[ast.stmt]:
    """Yield the statements that contain a line, from the outermost inward."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.stmt) and child.lineno <= number <= (child.end_lineno or child.lineno):
            yield child
            yield from _statements_around(child, number)
        elif isinstance(child, ast.ExceptHandler | ast.match_case) and _body_contains(child, number):
            yield from _statements_around(child, number)


def _body_contains(part: ast.ExceptHandler | ast.match_case, number: int) -> bool:
    return part.body[0].lineno <= number <= (part.body[-1].end_lineno or number)


def _condition(statement: ast.stmt, number: int, text: str) -> Condition | None:
    """Return the condition under which an if or while runs a line inside it; None if it has no condition."""
    if not isinstance(statement, ast.If | ast.While) or number < statement.body[0].lineno:
        return None
    body_ends = statement.body[-1].end_lineno or number
    word = "if" if isinstance(statement, ast.If) else "while"
    test = " ".join((ast.get_source_segment(text, statement.test) or "").split())
    if number <= body_ends:
        return f"{word} {test}", tuple(names_read(statement.test))
    is_elif = len(statement.orelse) == 1 and isinstance(statement.orelse[0], ast.If)
    return None if is_elif else (f"else of {word} {test}", tuple(names_read(statement.test)))


def names_read(node: ast.AST) -> Iterator[str]:
    """Yield the names and attributes that are read in an expression or statement, without duplicates."""
    seen: dict[str, None] = {}
    for part in ast.walk(node):
        if isinstance(part, ast.Attribute | ast.Name) and isinstance(part.ctx, ast.Load):
            text = ast.unparse(part)
            if all(identifier.isidentifier() for identifier in text.split(".")):
                seen.setdefault(text)
    yield from seen


def values_of(names: tuple[str, ...], frame: FrameType) -> dict[str, str]:
    """Return the values of names in a frame as text. Names without a plain value are left out."""
    values = {}
    for name in names:
        try:
            value = _value(name.split("."), frame)
        except (AttributeError, LookupError, TypeError, ValueError):
            continue  # no value here, or none that can be read without running the program's code
        if isinstance(value, PLAIN):
            values[name] = _shown(value)
    return values


def _shown(value: object) -> str:
    text = str(value) if isinstance(value, Enum) else repr(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def _value(path: list[str], frame: FrameType) -> object:
    """Return the value of a dotted name, split into its parts; for an `Input`, the value that it reads."""
    first, *attributes = path
    spaces: Mapping[str, Any] = ChainMap(frame.f_locals, frame.f_globals)
    value: object = spaces[first]
    for name in attributes:
        value = _attribute(value, name)
    return value.read() if isinstance(value, Input) else value


def _attribute(value: object, name: str) -> object:
    """Return an attribute without running the program's code."""
    if isinstance(value, type):
        raise AttributeError(name)  # MoveKind.ABSOLUTE explains itself
    attribute = inspect.getattr_static(value, name)
    if isinstance(attribute, MemberDescriptorType):
        return attribute.__get__(value)
    if isinstance(attribute, Output | InputWord):
        return attribute.__get__(value, type(value))
    if isinstance(attribute, property):
        file = getattr(getattr(attribute.fget, "__code__", None), "co_filename", "")
        if not file or is_the_users(file):
            raise AttributeError(name)
        return getattr(value, name)
    return attribute
