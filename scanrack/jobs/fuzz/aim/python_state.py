"""Reads the plain values that a Python program stores between scans: flags, texts, integers, Enum members.

The values are in the program's object and its globals. They are also in dicts and objects of the program's
own classes, up to two objects deep.
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
"""Types of plain values, in addition to the program's Enum classes."""

DEEP = 2
"""Maximum number of objects on the path to a value."""

MOST_HOLDERS, MOST_FIELDS = 50, 200
"""Maximum number of objects, and of values in one object."""


def namespace_of(logic: ScanLogic) -> dict[str, Any]:
    """Return the globals of a program's module."""
    if isinstance(logic, FunctionType):
        return logic.__globals__
    return vars(sys.modules.get(type(logic).__module__, sys))


def fields_reader(logic: ScanLogic, module: Mapping[str, Any]) -> Callable[[], dict[Hashable, Hashable]]:
    """Return a function that reads the current values, by place and name.

    It does not read objects that the program creates later.
    """
    holders = list(enumerate(islice(_holders(logic, module), MOST_HOLDERS)))
    plain_types = PLAIN | {
        value for value in module.values() if isinstance(value, type) and issubclass(value, Enum)
    }
    global_names = [
        name for name, value in module.items() if value.__class__ in plain_types and not name.startswith("__")
    ]
    return _FieldsReader(holders, global_names, module, plain_types)


class _FieldsReader:
    """Reads the values, and returns the same dict until one of them changes.

    Objects are compared by identity, because a program's own classes can define equality in any way.
    """

    def __init__(
        self,
        holders: Sequence[tuple[int, Mapping[str, Any]]],
        global_names: Sequence[str],
        module: Mapping[str, Any],
        plain_types: Collection[object],
    ) -> None:
        self._holders, self._global_names = holders, global_names
        self._module, self._plain_types = module, plain_types
        self._last_fields: list[list[Any]] = [[] for _ in holders]
        self._last_globals: list[Any] = []
        self._values: dict[Hashable, Hashable] = {}

    def __call__(self) -> dict[Hashable, Hashable]:
        """Return the current plain values, in the same dict as before if nothing has changed."""
        get, has_changed = self._module.get, False
        global_values = [*map(get, self._global_names)]
        last = self._last_globals
        if len(global_values) != len(last) or not all(map(is_, global_values, last)):
            self._last_globals, has_changed = global_values, True
        for place, holder in self._holders:
            last = self._last_fields[place]
            if len(holder) != len(last) or not all(map(is_, holder.values(), last)):
                self._last_fields[place], has_changed = [*holder.values()], True
        if has_changed:
            self._values = self._plain_values()
        return self._values

    def _plain_values(self) -> dict[Hashable, Hashable]:
        """Return the current plain values, by place and name for fields and by name for globals."""
        plain_types = self._plain_types
        values: dict[Hashable, Hashable] = {
            (place, name): value
            for place, holder in self._holders
            for name, value in holder.items()
            if value.__class__ in plain_types
        }
        for name, value in zip(self._global_names, self._last_globals, strict=True):
            if value.__class__ in plain_types:
                values[name] = value
        return values


def _holders(logic: ScanLogic, module: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Yield once the dict or fields of each object that can have plain values."""
    module_name = str(module.get("__name__", ""))
    queue: list[tuple[int, Any]] = [(0, logic)]
    if isinstance(logic, FunctionType):
        queue = [(0, value) for name, value in module.items() if not name.startswith("__")]
    seen_ids: set[int] = set()
    for depth, value in queue:  # grows in the loop
        holder = _holder(value, module_name, is_logic=value is logic)
        if holder is None or id(holder) in seen_ids or len(holder) > MOST_FIELDS:
            continue
        seen_ids.add(id(holder))
        yield holder
        if depth < DEEP:
            class_fields = () if type(value) is dict else vars(type(value)).values()
            queue += [(depth + 1, inner) for inner in (*holder.values(), *class_fields)]


def _holder(value: object, module_name: str, *, is_logic: bool) -> Mapping[str, Any] | None:
    """Return a dict itself, or the fields of an object of the program's own class; otherwise None."""
    if type(value) is dict:
        return value
    if isinstance(value, type | FunctionType) or not (is_logic or type(value).__module__ == module_name):
        return None
    return getattr(value, "__dict__", None)
