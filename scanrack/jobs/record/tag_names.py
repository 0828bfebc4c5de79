"""Finds the values of a Python program: attributes of objects in its module, and fields of its class.

A value is read by its name in the module, such as `line.step`, so that a replaced object is found. Its type
comes from an annotation, or else from its first value.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
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
"""Maximum depth of nested objects."""

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
    """Return the names of a program: its module's names, or an instance of `Line` under the name `line`.

    Raises:
        ValueError: the program is neither a function nor a `Logic`.
    """
    if isinstance(logic, Logic):
        return {type(logic).__name__.lower(): logic}
    function = inspect.unwrap(logic)
    function = getattr(function, "__func__", function)
    if isinstance(function, FunctionType):
        return function.__globals__
    raise ValueError(f"{type(logic).__name__} has no tags: only a ladder program or a Python module has tags")


def named_values(namespace: Mapping[str, Any], patterns: Sequence[str]) -> list[NamedValue]:
    """Return the values in a module that match patterns, without duplicates, in the order of the patterns.

    Raises:
        ValueError: a pattern matches nothing, or matches a value that can't be recorded.
    """
    values = list(_all_values(namespace))
    names = NamesByPattern(value.name for value in values)
    matches: dict[str, NamedValue] = {}
    for pattern in patterns:
        matching = [values[index] for index in names.indexes(pattern)]
        for value in matching or [_value_at(namespace, values, pattern)]:
            matches.setdefault(value.name, value)
    return list(matches.values())


def _value_at(namespace: Mapping[str, Any], known: Sequence[NamedValue], text: str) -> NamedValue:
    """Return the value at an address such as `line.axes[0].step`; raise ValueError if there is none."""
    if _is_address(text):
        try:
            value = eval(text, dict(namespace))
        except (AttributeError, LookupError, NameError, TypeError):
            pass
        else:
            named_value = _value_of(text, None, value)
            if named_value is not None:
                return named_value
            raise ValueError(f"tag {text!r} is {type(value).__name__}: must be bool, int, float, str or Enum")
    matches = get_close_matches(text, [tag.name for tag in known], 1)
    hint = f"; did you mean {matches[0]}?" if matches else ""
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
    """Yield all values of a program: the fields of its `Logic` objects, and the values of public names."""
    hints = declared(namespace)
    for name, value in namespace.items():
        if isinstance(value, Logic):
            yield from _fields(name, value)
        elif not name.startswith("_"):
            yield from _values_in(name, hints.get(name), value, DEPTH, frozenset())


def _fields(name: str, logic: Logic) -> Iterator[NamedValue]:
    """Yield the fields of a logic from the body of its class and from the instance."""
    bodies = [vars(kind) for kind in reversed(type(logic).__mro__) if kind is not Logic]
    fields = [name for body in bodies for name, value in body.items() if not hasattr(value, "__get__")]
    attributes = dict.fromkeys([*fields, *vars(logic)])
    yield from _attributes(name, logic, attributes, DEPTH - 1, frozenset())


def _attributes(
    name: str, owner: object, attributes: Iterable[str], depth: int, outer_ids: frozenset[int]
) -> Iterator[NamedValue]:
    """Yield the values in the public attributes of an object; `outer_ids` are its containers' ids."""
    hints = _hints(owner)
    for attribute in attributes:
        if not attribute.startswith("_") and hasattr(owner, attribute):
            inner, ids = getattr(owner, attribute), outer_ids | {id(owner)}
            yield from _values_in(f"{name}.{attribute}", hints.get(attribute), inner, depth, ids)


def _values_in(
    name: str, hint: object, value: object, depth: int, outer_ids: frozenset[int]
) -> Iterator[NamedValue]:
    """Yield a value, or the values of an object's attributes."""
    named_value = _value_of(name, hint, value)
    if named_value is not None:
        yield named_value
    elif depth and _is_users_object(value) and id(value) not in outer_ids:
        attributes = dict.fromkeys([*_hints(value), *getattr(value, "__dict__", ())])
        yield from _attributes(name, value, attributes, depth - 1, outer_ids)


def _value_of(name: str, hint: object, value: object) -> NamedValue | None:
    """Return a value with its type; None if it can't be recorded as a single value."""
    kind = hint if isinstance(hint, type) and (hint in PLAIN_TYPES or issubclass(hint, Enum)) else type(value)
    if issubclass(kind, Flag):
        return NamedValue(name, "LINT", f"{name}._value_")
    if issubclass(kind, Enum):
        return NamedValue(name, "ENUM", name, tuple(kind))
    plain = next((PLAIN_TYPES[base] for base in kind.__mro__ if base in PLAIN_TYPES), None)
    return None if plain is None else NamedValue(name, plain, name)


def _is_users_object(value: object) -> bool:
    """Return whether a value is a user's object: not a class, function, module or library object."""
    if isinstance(value, type | ModuleType) or callable(value):
        return False
    package = type(value).__module__.partition(".")[0]
    return package not in sys.stdlib_module_names and package != __name__.partition(".")[0]


def _hints(value: object) -> Mapping[str, object]:
    """Return the annotations of an object's attributes, except those that can't be resolved."""
    kind = type(value)
    if kind not in _HINTS:
        try:
            _HINTS[kind] = get_type_hints(kind)
        except (NameError, TypeError, AttributeError):
            _HINTS[kind] = {}
    return _HINTS[kind]


_HINTS: WeakKeyDictionary[type, Mapping[str, object]] = WeakKeyDictionary()
"""The annotations of classes, cached because reading them takes longer than reading all values of a scan."""
