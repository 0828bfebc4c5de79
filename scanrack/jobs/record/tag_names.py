"""Finds the recorded values of a Python program: attributes of objects in its module, fields of its class.

Every scan looks up `line.step` in the module, so that a replaced object is found. Types come from
annotations, or else from the first values.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from difflib import get_close_matches
from enum import Enum, Flag
from types import FunctionType, ModuleType
from typing import Any, get_type_hints
from weakref import WeakKeyDictionary

from scanrack.io_images.annotations import declared
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.tag_names import TEXT, NamesByPattern
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.loop.scan import ScanLogic

DEPTH = 4
"""Largest depth of nested objects."""

PLAIN_TYPES: Mapping[type, str] = {bool: "BOOL", int: "LINT", float: "LREAL", str: TEXT}
"""Recorded types of Python values."""


@dataclass(frozen=True, slots=True)
class NamedValue:
    """A value of a Python program."""

    name: str
    type: str  # BOOL, LINT, LREAL, ENUM or TEXT
    source: str
    members: tuple[Enum, ...] = field(default=())  # members of an ENUM, in order


def namespace_of(logic: ScanLogic) -> dict[str, Any]:
    """Return the namespace of the module in which a logic is defined.

    An instance of a logic class gets the name of its class in lower case: `line` for `Line`.

    Raises:
        ValueError: the program is of a kind without a module of values.
    """
    if isinstance(logic, Logic):
        return {type(logic).__name__.lower(): logic}
    function = inspect.unwrap(logic)
    function = getattr(function, "__func__", function)
    if isinstance(function, FunctionType):
        return function.__globals__
    raise ValueError(f"{type(logic).__name__} has no tags: they are those of a ladder program or a module")


def named_values(namespace: Mapping[str, Any], patterns: Sequence[str]) -> list[NamedValue]:
    """Return the values in a module that match patterns, without duplicates, in the order of the patterns.

    Raises:
        ValueError: a pattern matches nothing, or matches a value that can't be recorded.
    """
    known = list(_all_values(namespace))
    names = NamesByPattern(tag.name for tag in known)
    chosen: dict[str, NamedValue] = {}
    for pattern in patterns:
        matches = [known[index] for index in names.indexes(pattern)]
        matches = matches or [_at_address(namespace, known, pattern)]
        chosen.update(
            (matching_tag.name, matching_tag) for matching_tag in matches if matching_tag.name not in chosen
        )
    return list(chosen.values())


def _at_address(namespace: Mapping[str, Any], known: Sequence[NamedValue], text: str) -> NamedValue:
    if _is_address(text):
        try:
            value = eval(text, dict(namespace))
        except (AttributeError, LookupError, NameError, TypeError):
            pass
        else:
            named = _named(text, None, value)
            if named is not None:
                return named
            raise ValueError(
                f"tag {text!r} is {type(value).__name__}; recorded are bool, int, float, str and Enum"
            )
    close = get_close_matches(text, [tag.name for tag in known], 1)
    hint = f"; did you mean {close[0]}?" if close else ""
    raise ValueError(f"no tag matches {text!r}{hint}")


def _is_address(text: str) -> bool:
    """Return whether a text consists of names, attributes and constant subscripts."""
    try:
        node = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError):
        return False
    while isinstance(node, ast.Attribute | ast.Subscript):
        if isinstance(node, ast.Subscript) and not isinstance(node.slice, ast.Constant):
            return False
        node = node.value
    return isinstance(node, ast.Name)


def _all_values(namespace: Mapping[str, Any]) -> Iterator[NamedValue]:
    hints = declared(namespace)
    for name, value in namespace.items():
        if isinstance(value, Logic):
            yield from _fields(name, value)
        elif not name.startswith("_"):
            yield from _below(name, hints.get(name), value, DEPTH, frozenset())


def _fields(name: str, logic: Logic) -> Iterator[NamedValue]:
    """Yield the fields of a logic: from the body of its class, and from the instance."""
    hints = _hints(logic)
    bodies = [vars(kind) for kind in reversed(type(logic).__mro__) if kind is not Logic]
    fields = {
        field_name: value
        for body in bodies
        for field_name, value in body.items()
        if not hasattr(value, "__get__")
    }
    for attribute in dict.fromkeys([*fields, *vars(logic)]):
        if not attribute.startswith("_"):
            inner = getattr(logic, attribute)
            yield from _below(
                f"{name}.{attribute}", hints.get(attribute), inner, DEPTH - 1, frozenset({id(logic)})
            )


def _below(name: str, hint: object, value: object, depth: int, above: frozenset[int]) -> Iterator[NamedValue]:
    """Yield a value, or the values of an object's attributes."""
    named = _named(name, hint, value)
    if named is not None:
        yield named
    elif depth and _is_own(value) and id(value) not in above:
        hints = _hints(value)
        names = dict.fromkeys([*hints, *getattr(value, "__dict__", ())])
        for attribute in names:
            if not attribute.startswith("_") and hasattr(value, attribute):
                inner = getattr(value, attribute)
                yield from _below(
                    f"{name}.{attribute}", hints.get(attribute), inner, depth - 1, above | {id(value)}
                )


def _named(name: str, hint: object, value: object) -> NamedValue | None:
    """Return a value with its type; None if it is not recorded as a whole."""
    kind = hint if isinstance(hint, type) and (hint in PLAIN_TYPES or issubclass(hint, Enum)) else type(value)
    if issubclass(kind, Flag):
        return NamedValue(name, "LINT", f"{name}._value_")
    if issubclass(kind, Enum):
        return NamedValue(name, "ENUM", name, tuple(kind))
    plain = next((PLAIN_TYPES[base] for base in kind.__mro__ if base in PLAIN_TYPES), None)
    return None if plain is None else NamedValue(name, plain, name)


def _is_own(value: object) -> bool:
    """Return whether a value is a user's object: not a class, function, module or library object."""
    if isinstance(value, type | ModuleType) or callable(value):
        return False
    top = type(value).__module__.partition(".")[0]
    return top not in sys.stdlib_module_names and top != __name__.partition(".")[0]


def _hints(value: object) -> Mapping[str, object]:
    """Return the annotations of an object's attributes, except those that can't be resolved."""
    kind = type(value)
    if kind not in _KNOWN:
        try:
            _KNOWN[kind] = get_type_hints(kind)
        except (NameError, TypeError, AttributeError):
            _KNOWN[kind] = {}
    return _KNOWN[kind]


_KNOWN: WeakKeyDictionary[type, Mapping[str, object]] = WeakKeyDictionary()
"""The annotations of classes: reading them takes longer than all values of a scan."""
