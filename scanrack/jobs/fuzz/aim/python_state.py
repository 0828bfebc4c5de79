"""The plain values that a Python program keeps from scan to scan.

They are flags, texts, integers and Enum members. They are found in the program's object, its globals, dicts
in these, and objects of the program's own classes, up to two objects deep.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from enum import Enum
from itertools import islice
from operator import is_
from types import FunctionType
from typing import Any

from scanrack.runtime.loop.scan import ScanLogic

PLAIN = frozenset({bool, int, str, type(None)})
"""Types of the values, besides the Enum classes of the program."""

DEEP = 2
"""Largest number of objects on the path to a value."""

MOST_HOLDERS, MOST_FIELDS = 50, 200
"""Largest number of objects, and of values in one object."""


def namespace_of(logic: ScanLogic) -> dict[str, Any]:
    """Return the globals of a program's module."""
    if isinstance(logic, FunctionType):
        return logic.__globals__
    return vars(sys.modules.get(type(logic).__module__, sys))


def fields_reader(logic: ScanLogic, module: Mapping[str, Any]) -> Callable[[], dict[Hashable, Hashable]]:
    """Return a function that reads the current values, by place and name.

    Objects that the program creates later are not read.
    """
    holders = list(enumerate(islice(_holders(logic, module), MOST_HOLDERS)))
    plain = PLAIN | {
        value for value in module.values() if isinstance(value, type) and issubclass(value, Enum)
    }
    shared = [
        name for name, value in module.items() if value.__class__ in plain and not name.startswith("__")
    ]

    return _FieldsReader(holders, shared, module, plain)


class _FieldsReader:
    """Reads the values again only when an object that held one has been replaced by another.

    A call returns the same dict as long as nothing has changed. Objects are compared by identity, since a
    program's own classes may define equality in any way.
    """

    def __init__(
        self,
        holders: Sequence[tuple[int, Mapping[str, Any]]],
        shared: Sequence[str],
        module: Mapping[str, Any],
        plain: Collection[object],
    ) -> None:
        self._holders, self._shared, self._module, self._plain = holders, shared, module, plain
        self._seen: list[list[Any]] = [[] for _ in holders]
        self._seen_shared: list[Any] = []
        self._values: dict[Hashable, Hashable] = {}

    def __call__(self) -> dict[Hashable, Hashable]:
        get, fresh = self._module.get, False
        shared = [*map(get, self._shared)]
        if len(shared) != len(self._seen_shared) or not all(map(is_, shared, self._seen_shared)):
            self._seen_shared, fresh = shared, True
        for place, holder in self._holders:
            seen = self._seen[place]
            if len(holder) != len(seen) or not all(map(is_, holder.values(), seen)):
                self._seen[place], fresh = [*holder.values()], True
        if fresh:
            self._values = self._read()
        return self._values

    def _read(self) -> dict[Hashable, Hashable]:
        plain = self._plain
        values: dict[Hashable, Hashable] = {
            (place, name): value
            for place, holder in self._holders
            for name, value in holder.items()
            if value.__class__ in plain
        }
        for name, value in zip(self._shared, self._seen_shared, strict=True):
            if value.__class__ in plain:
                values[name] = value
        return values


def _holders(logic: ScanLogic, module: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield each dict of values once."""
    own = str(module.get("__name__", ""))
    waiting: list[tuple[int, Any]] = [(0, logic)]
    if isinstance(logic, FunctionType):
        waiting = [(0, value) for name, value in module.items() if not name.startswith("__")]
    seen: set[int] = set()
    for depth, value in waiting:
        holder = _holder(value, own, is_logic=value is logic)
        if holder is None or id(holder) in seen or len(holder) > MOST_FIELDS:
            continue
        seen.add(id(holder))
        yield holder
        if depth < DEEP:
            shared = () if type(value) is dict else vars(type(value)).values()
            waiting += [(depth + 1, inner) for inner in (*holder.values(), *shared)]


def _holder(value: object, module: str, *, is_logic: bool) -> Mapping[str, Any] | None:
    """Return a dict itself, or the fields of an object whose class belongs to the program; else None."""
    if type(value) is dict:
        return value
    if isinstance(value, type | FunctionType) or not (is_logic or type(value).__module__ == module):
        return None
    return getattr(value, "__dict__", None)
