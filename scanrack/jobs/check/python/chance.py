"""Calls whose results differ from run to run: random numbers, clocks, files, threads."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from types import ModuleType
from typing import Any

CHANCE = frozenset(
    {
        "random",
        "secrets",
        "uuid",
        "time",
        "datetime",
        "asyncio",
        "threading",
        "socket",
        "subprocess",
        "multiprocessing",
    }
)
"""Modules with results that differ from run to run, or with waits on the wall clock."""

CHANCE_OF = frozenset({("os", "urandom"), ("os", "getpid"), ("os", "times"), ("numpy", "random")})
"""Functions of other modules with results that differ from run to run."""


def is_chance(call: ast.Call, names: Mapping[str, Any]) -> bool:
    """Whether the result of a call differs from run to run.

    Args:
        names: global names of the module, with their values.
    """
    name = ast.unparse(call.func)
    function = resolved(call.func, names)
    function_module = getattr(function, "__module__", None) or _module_of_instance(function)
    root = names.get(name.partition(".")[0])
    root_module = root.__name__ if isinstance(root, ModuleType) else ""
    class_module = str(getattr(root, "__module__", "")) if isinstance(root, type) else ""
    packages = {
        (function_module or "").partition(".")[0].lstrip("_"),
        class_module,
        root_module.partition(".")[0],
    }
    is_listed = (root_module, name.rpartition(".")[2]) in CHANCE_OF or name in ("open", "input")
    return is_listed or not CHANCE.isdisjoint(packages)


def resolved(node: ast.expr, names: Mapping[str, Any]) -> object:
    """Return the object that a name or a dotted name refers to in the module; None if it is unknown."""
    if isinstance(node, ast.Name):
        return names.get(node.id)
    if isinstance(node, ast.Attribute):
        owner = resolved(node.value, names)
        return getattr(owner, node.attr, None) if isinstance(owner, ModuleType | type) else None
    return None


def _module_of_instance(method: object) -> str:
    """Return the module that defines the class of a bound method's instance; "" if unknown."""
    return getattr(type(getattr(method, "__self__", None)), "__module__", "") if method is not None else ""
