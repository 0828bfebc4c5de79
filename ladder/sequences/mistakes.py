"""Statements without effect, found in the source of a class when it is made.

    dwell("2 s")            a wait that is never awaited: it does nothing
    self.start.rises        likewise
    self.part()             an `async def` that never runs, or a function that returns a wait
    pause = dwell("2 s")    a wait in a variable that nothing reads
    self.start = True       would hide an input, an axis or a sequence

A command has an effect without `await`: `self.axis.halt()` is carried out. A wait that is kept and read is no
mistake: it may be awaited later, or only in some case.
"""

from __future__ import annotations

import ast
import inspect
import linecache
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from types import FunctionType
from typing import Any, NamedTuple

from .declaring import SequenceMethod
from .parts import Part
from .signals import Input
from .waits import Wait

WAITS = ("all_of", "first_of", "within")
"""Functions whose call is a wait, beside the classes of waits."""

OF_INPUTS = ("falls", "off", "on", "rises")
"""Attributes of an input that are waits."""

PROBE = "captured"
"""The method of an axis that is a wait, and no command."""

_OURS = "scanrack."

Bodies = Mapping[tuple[str, int], ast.AST]
"""The functions of a file by name and first line, as code objects have them."""


def check_statements(cls: type) -> None:
    """Refuse statements without effect in the methods of a class.

    Raises:
        TypeError: there is one; its file and line.
    """
    for function in _functions(cls):
        body = _body_of(function)
        if body is not None:
            _check_body(_Scope(cls, function.__globals__), function.__code__.co_filename, body)


def _check_body(scope: _Scope, file: str, body: ast.AST) -> None:
    read = _names_read(body)
    for node in ast.walk(body):
        mistake = _statement(scope, node) or _hidden(scope, node) or _unread(scope, node, read)
        if mistake:
            raise TypeError(f"{file}:{getattr(node, 'lineno', '?')}: {mistake}")


def _statement(scope: _Scope, node: ast.AST) -> str:
    """Return what is wrong with a statement that is a wait; empty if it is none."""
    if not (isinstance(node, ast.Expr) and scope.is_wait(node.value)):
        return ""
    text = ast.unparse(node.value)
    return f"`{text}` is never awaited and does nothing: write `await {text}`"


def _hidden(scope: _Scope, node: ast.AST) -> str:
    """Return what is wrong with an assignment to a part of the class; empty if it is none."""
    for target in _targets(node):
        declared = scope.of_self(target)
        if isinstance(declared, Part | SequenceMethod) and not hasattr(type(declared), "__set__"):
            text, kind = ast.unparse(target), type(declared).__name__
            return f"`{text} = ...` would hide {text}, which the class declares as {kind}"
    return ""


def _unread(scope: _Scope, node: ast.AST, read: frozenset[str]) -> str:
    """Return what is wrong with a wait in a variable that nothing reads; empty if it is none."""
    value = getattr(node, "value", None)
    if value is None or not scope.is_wait(value):
        return ""
    for target in _targets(node):
        if isinstance(target, ast.Name) and target.id not in read:
            text = ast.unparse(value)
            return f"`{target.id} = {text}` is never awaited and does nothing: write `await {text}`"
    return ""


def _names_read(body: ast.AST) -> frozenset[str]:
    """Return the variables that are read in a function, or are not its own."""
    alone = {id(node.value) for node in ast.walk(body) if isinstance(node, ast.Expr)}
    names = set()
    for node in ast.walk(body):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and id(node) not in alone:
            names.add(node.id)
        elif isinstance(node, ast.Global | ast.Nonlocal):
            names.update(node.names)
    return frozenset(names)


def _targets(node: ast.AST) -> list[ast.expr]:
    if isinstance(node, ast.Assign):
        return node.targets
    return [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign | ast.NamedExpr) else []


def _functions(cls: type) -> Iterator[FunctionType]:
    """Yield the methods of a class, then the `async def` functions ahead of it in its module."""
    for each in vars(cls).values():
        function = each.function if isinstance(each, SequenceMethod) else each
        if isinstance(function, FunctionType):
            yield function
    module = sys.modules.get(cls.__module__)
    for each in getattr(module, "__dict__", {}).values():
        if inspect.iscoroutinefunction(each) and each.__module__ == cls.__module__:
            yield each


def _body_of(function: FunctionType) -> ast.AST | None:
    """Return the text of a function; None if there is no source, or another than was loaded."""
    code = function.__code__
    return _bodies_of(code.co_filename).get((code.co_name, code.co_firstlineno))


def _bodies_of(file: str) -> Bodies:
    linecache.checkcache(file)
    return _parsed("".join(linecache.getlines(file)))


@lru_cache(maxsize=4)
def _parsed(source: str) -> Bodies:
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return {}
    functions = [each for each in ast.walk(tree) if isinstance(each, ast.FunctionDef | ast.AsyncFunctionDef)]
    return {(each.name, _first_line(each)): each for each in functions}


def _first_line(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the line at which a function begins: that of its first decorator."""
    return min((decorator.lineno for decorator in function.decorator_list), default=function.lineno)


class _Scope(NamedTuple):
    """What names mean in a method.

    Attributes:
        owner: the class.
        names: the global names.
    """

    owner: type
    names: Mapping[str, Any]

    def of_self(self, node: ast.expr) -> Any:
        """Return what `self.name` is in the class; None for any other expression."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
            return inspect.getattr_static(self.owner, node.attr, None)
        return None

    def is_wait(self, node: ast.expr) -> bool:
        """Return whether an expression is a wait, or a coroutine, by its text."""
        if isinstance(node, ast.Attribute):
            return node.attr in OF_INPUTS and isinstance(self.of_self(node.value), Input)
        if not isinstance(node, ast.Call):
            return False
        if isinstance(node.func, ast.Name):
            return self._makes_wait(self.names.get(node.func.id))
        if not isinstance(node.func, ast.Attribute):
            return False
        if node.func.attr == PROBE:
            return hasattr(self.of_self(node.func.value), PROBE)
        return self._makes_wait(self.of_self(node.func))

    def _makes_wait(self, called: Any) -> bool:
        return _is_ours(called) or inspect.iscoroutinefunction(called) or self._returns_wait(called)

    def _returns_wait(self, called: Any) -> bool:
        """Return whether a function of the user's returns a wait of ours at its every `return`."""
        body = _body_of(called) if isinstance(called, FunctionType) else None
        if body is None:
            return False
        returns = [node.value for node in ast.walk(body) if isinstance(node, ast.Return)]
        names = {name: each for name, each in called.__globals__.items() if _is_ours(each)}
        scope = _Scope(self.owner, names)
        return bool(returns) and all(value is not None and scope.is_wait(value) for value in returns)


def _is_ours(called: Any) -> bool:
    """Return whether something is a kind of wait, or one of `WAITS`."""
    if isinstance(called, type):
        return issubclass(called, Wait)
    return getattr(called, "__module__", "").startswith(_OURS) and getattr(called, "__name__", "") in WAITS
