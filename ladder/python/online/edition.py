"""The source and the functions of a logic class: one edition of a program."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from enum import Enum
from functools import cached_property
from types import FunctionType, ModuleType
from typing import Any

from ..sequences.declaring import functions_in
from ..sequences.logic import Logic
from ..sequences.mistakes import first_line
from ..sequences.parts import Part
from .points import Function

_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class Edition:
    """One version of a program, to compare with another version."""

    def __init__(self, kind: type[Logic]) -> None:
        self.kind = kind
        self._trees: dict[str, ast.Module] = {}

    @cached_property
    def modules(self) -> dict[str, dict[str, Any]]:
        """The globals of its functions' modules, by module name."""
        modules = {method.__module__: method.__globals__ for method in self._methods()}
        for names in list(modules.values()):
            for value in names.values():
                if isinstance(value, FunctionType) and value.__code__.co_filename in self._sources:
                    modules.setdefault(value.__module__, value.__globals__)
        return modules

    def function(self, module: str, name: str) -> FunctionType | None:
        """Return a function by its module and qualified name."""
        for method in self._methods():
            if (method.__module__, method.__qualname__) == (module, name):
                return method
        value = self.modules.get(module, {}).get(name)
        return value if isinstance(value, FunctionType) and value.__qualname__ == name else None

    def tree(self, function: FunctionType) -> Function | None:
        """Return the syntax tree of a function; None if its source is missing."""
        code = function.__code__
        name_and_line = code.co_name, code.co_firstlineno
        for node in ast.walk(self._tree(code.co_filename)):
            if isinstance(node, _FUNCTIONS) and (node.name, first_line(node)) == name_and_line:
                return node  # type: ignore[return-value]  # a function that is not async has no awaits
        return None

    @cached_property
    def stored(self) -> frozenset[str]:
        """The names of the fields that its functions assign."""
        return frozenset(
            node.attr
            for node in self._nodes()
            if isinstance(node, ast.Attribute) and not isinstance(node.ctx, ast.Load)
        )

    @cached_property
    def rebound(self) -> frozenset[str]:
        """The module globals that its functions assign, by name."""
        return frozenset(
            name for node in self._nodes() if isinstance(node, ast.Global) for name in node.names
        )

    def changed_from(self, previous: Edition) -> frozenset[str]:
        """Return the names that differ from an earlier edition; attributes begin with a dot.

        These are functions, and constants of the class and its modules. Fields keep their values.
        """
        constants, old = self._constants(), previous._constants()
        changed = {name for name in {*constants, *old} if not _same(constants.get(name), old.get(name))}
        bodies, old_bodies = self._bodies(), previous._bodies()
        functions = {name for name in {*bodies, *old_bodies} if bodies.get(name) != old_bodies.get(name)}
        return frozenset(changed | functions | {f".{function}" for function in functions})

    def constants(self) -> dict[str, Any]:
        """Return the values in the class body that are not assigned by any function."""
        constants: dict[str, Any] = {}
        for kind in reversed(self.kind.__mro__[: self.kind.__mro__.index(Logic)]):
            constants.update((name, value) for name, value in vars(kind).items() if is_plain(name, value))
        return {name: value for name, value in constants.items() if name not in self.stored}

    def constant(self, text: str) -> Any:
        """Return the constant that the text `self.NAME` or `NAME` refers to; None if it is not a constant."""
        constants = self._constants()
        return constants.get(text.removeprefix("self")) if text.startswith("self.") else constants.get(text)

    def _constants(self) -> dict[str, Any]:
        """Return all constants by name; names of class constants begin with a dot."""
        constants = {f".{name}": value for name, value in self.constants().items()}
        for names in self.modules.values():
            constants.update((name, value) for name, value in names.items() if is_plain(name, value))
        return constants

    def _bodies(self) -> dict[str, str]:
        """Return the syntax of each function as text, by name; "" for a function without source."""
        functions = {method.__name__: method for method in self._methods()}
        for module, names in self.modules.items():
            functions_here = (value for value in names.values() if isinstance(value, FunctionType))
            functions.update(
                (function.__name__, function) for function in functions_here if function.__module__ == module
            )
        trees = {name: self.tree(function) for name, function in functions.items()}
        return {name: "" if tree is None else ast.dump(tree) for name, tree in trees.items()}

    @cached_property
    def _sources(self) -> dict[str, str]:
        """The text of each file when the classes were loaded."""
        sources: dict[str, str] = {}
        for kind in reversed(self.kind.__mro__):
            sources.update(vars(kind).get("_logic_sources", {}))
        return sources

    def _nodes(self) -> Iterator[ast.AST]:
        for file in self._sources:
            yield from ast.walk(self._tree(file))

    def _tree(self, file: str) -> ast.Module:
        """Return the syntax of a file, parsed once."""
        if file not in self._trees:
            self._trees[file] = ast.parse(self._sources.get(file, ""))
        return self._trees[file]

    def _methods(self) -> Iterator[FunctionType]:
        """Yield the functions of the class and its bases, up to `Logic`."""
        for kind in self.kind.__mro__:
            if kind is Logic:
                return
            yield from functions_in(kind)


def is_plain(name: str, value: Any) -> bool:
    """Return whether an attribute of a class or module is a constant or an initial value."""
    if name.startswith(("_logic_", "__")) or isinstance(value, type | ModuleType | Part | Logic):
        return False
    return not callable(value) and not hasattr(type(value), "__get__")


def _same(a: Any, b: Any) -> bool:
    """Return whether constants have equal types and values; enum members are reloaded, so compare names."""
    if isinstance(a, Enum) and isinstance(b, Enum):
        return (type(a).__qualname__, a.name) == (type(b).__qualname__, b.name)
    if type(a) is not type(b):
        return False
    try:
        return bool(a == b)
    except Exception:  # raised by a user's __eq__
        return False
