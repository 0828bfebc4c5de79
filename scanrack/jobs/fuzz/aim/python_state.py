"""The plain values that a Python program keeps from scan to scan.

They are flags, texts, integers and members of an Enum, in the program's object and its globals, in dicts
there, and in objects of the program's own classes, up to two objects deep.
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
"""Types of values, beside the classes of Enum that the program knows."""

DEEP = 2
"""Number of objects on the way to a value."""

MOST_HOLDERS, MOST_FIELDS = 50, 200
"""Largest number of objects, and of values in one of them."""


def namespace_of(logic: ScanLogic) -> dict[str, Any]:
    """Return the globals of a program's module."""
    if isinstance(logic, FunctionType):
        return logic.__globals__
    return vars(sys.modules.get(type(logic).__module__, sys))


def fields_reader(logic: ScanLogic, module: Mapping[str, Any]) -> Callable[[], dict[Hashable, Hashable]]:
    """Return a function that reads the present values, by place and name.

    Objects that the program makes later are not read.
    """
    holders = list(enumerate(islice(_holders(logic, module), MOST_HOLDERS)))
    plain = PLAIN | {each for each in module.values() if isinstance(each, type) and issubclass(each, Enum)}
    shared = [
        name for name, value in module.items() if value.__class__ in plain and not name.startswith("__")
    ]

    return _FieldsReader(holders, shared, module, plain)


class _FieldsReader:
    """Reads values again where an object in their place is another one than before.

    A call returns the values: the same dict as long as nothing has changed. Objects are compared by identity,
    since a program's own classes may define equality in any way.
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
    """Yield the dicts of values, each once."""
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
            waiting += [(depth + 1, each) for each in (*holder.values(), *shared)]


def _holder(value: object, module: str, *, is_logic: bool) -> Mapping[str, Any] | None:
    """Return the dict of an object's values: itself, or its fields if its class is of the program."""
    if type(value) is dict:
        return value
    if isinstance(value, type | FunctionType) or not (is_logic or type(value).__module__ == module):
        return None
    return getattr(value, "__dict__", None)
