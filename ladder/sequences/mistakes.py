"""Statements without effect, found in the source of a class when it is made.

    dwell("2 s")            a wait that is never awaited: it does nothing
    self.start.rises        likewise
    self.part()             an `async def` that never runs
    self.start = True       would hide an input, an axis or a sequence

A command has an effect without `await`: `self.axis.halt()` is carried out. Python warns of the
coroutines that are neither a statement nor awaited, at their line.
"""

from __future__ import annotations

import ast
import inspect
import linecache
from collections.abc import Iterator, Mapping
from types import FunctionType
from typing import Any

from .declaring import SequenceMethod
from .parts import Part
from .signals import Input

WAITS = ("all_of", "dwell", "first_of", "steady", "until", "within")
"""Functions and classes whose call is a wait."""

OF_INPUTS = ("falls", "off", "on", "rises")
"""Attributes of an input that are waits."""

PROBE = "captured"
"""The method of an axis that is a wait, and no command."""

_OURS = "scanrack."

Bodies = Mapping[tuple[str, int], tuple[ast.AST, ...]]
"""The functions of a file by name and first line, as code objects have them."""


def check_statements(cls: type) -> None:
    """Refuse statements without effect in the methods of a class.

    Raises:
        TypeError: there is one; its file and line.
    """
    bodies: dict[str, Bodies] = {}
    for function in _functions(cls):
        code = function.__code__
        file = code.co_filename
        if file not in bodies:
            bodies[file] = _bodies_of(file)
        for body in bodies[file].get((code.co_name, code.co_firstlineno), ()):
            _check_body(cls, function, body)


def _check_body(cls: type, function: FunctionType, body: ast.AST) -> None:
    for node in ast.walk(body):
        mistake = _mistake(cls, function, node)
        if mistake:
            raise TypeError(f"{function.__code__.co_filename}:{getattr(node, 'lineno', '?')}: {mistake}")


def _mistake(cls: type, function: FunctionType, node: ast.AST) -> str:
    """Return what is wrong with a statement; empty if nothing."""
    if isinstance(node, ast.Expr) and _is_wait(cls, function, node.value):
        text = ast.unparse(node.value)
        return f"`{text}` is never awaited and does nothing: write `await {text}`"
    for target in _targets(node):
        declared = _of_self(cls, target)
        if isinstance(declared, Part | SequenceMethod) and not hasattr(type(declared), "__set__"):
            text, kind = ast.unparse(target), type(declared).__name__
            return f"`{text} = ...` would hide {text}, which the class declares as {kind}"
    return ""


def _targets(node: ast.AST) -> list[ast.expr]:
    if isinstance(node, ast.Assign):
        return node.targets
    return [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign) else []


def _functions(cls: type) -> Iterator[FunctionType]:
    for each in vars(cls).values():
        function = each.function if isinstance(each, SequenceMethod) else each
        if isinstance(function, FunctionType):
            yield function


def _bodies_of(file: str) -> Bodies:
    """Return the functions of a file; none if there is no source, or another than was loaded."""
    linecache.checkcache(file)
    try:
        tree = ast.parse("".join(linecache.getlines(file)))
    except SyntaxError:
        return {}
    functions = [each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
    bodies: dict[tuple[str, int], tuple[ast.AST, ...]] = {}
    for each in functions:
        first = min((decorator.lineno for decorator in each.decorator_list), default=each.lineno)
        bodies[each.name, first] = (each,)
    return bodies


def _is_wait(cls: type, function: FunctionType, node: ast.expr) -> bool:
    if isinstance(node, ast.Attribute):
        return node.attr in OF_INPUTS and isinstance(_of_self(cls, node.value), Input)
    if not isinstance(node, ast.Call):
        return False
    if isinstance(node.func, ast.Name):
        return _makes_wait(function.__globals__.get(node.func.id))
    if not isinstance(node.func, ast.Attribute):
        return False
    if node.func.attr == PROBE:
        return hasattr(_of_self(cls, node.func.value), PROBE)
    return inspect.iscoroutinefunction(_of_self(cls, node.func))


def _of_self(cls: type, node: ast.expr) -> Any:
    """Return what `self.name` is in the class; None for any other expression."""
    if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
        return inspect.getattr_static(cls, node.attr, None)
    return None


def _makes_wait(called: Any) -> bool:
    ours = getattr(called, "__module__", "").startswith(_OURS) and getattr(called, "__name__", "") in WAITS
    return ours or inspect.iscoroutinefunction(called)
