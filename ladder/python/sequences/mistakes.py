"""Checks a class's source for statements without effect and undeclared fields.

    dwell("2 s")                a wait that is never awaited: it does nothing
    self.start.rises            the same
    self.part()                 an `async def` that never runs, or a function that returns a wait
    pause = dwell("2 s")        a wait in a variable that nothing reads
    self.pause = dwell("2 s")   the same in a field
    self.start = True           would hide an input, an axis or a sequence
    self.lmp = True             a field that the class does not declare

A command has an effect without `await`: `self.axis.halt()` is executed. A wait that is stored and read is
accepted, because it may be awaited later.
"""

from __future__ import annotations

import ast
import difflib
import inspect
import linecache
import sys
from collections.abc import Iterator, Mapping
from functools import lru_cache
from types import FunctionType
from typing import Any, NamedTuple

from scanrack.io_images.annotations import declared
from scanrack.io_images.site import Site

from .declaring import SequenceMethod, functions_in
from .parts import Part
from .signals import Input
from .waits import Wait

WAITS = ("all_of", "first_of", "within")
"""Functions that return waits, in addition to the classes of waits."""

OF_INPUTS = ("falls", "off", "on", "rises")
"""Attributes of an input that are waits."""

PROBE = "captured"
"""The method of an axis that returns a wait, not a command."""

_OURS = "scanrack."

SETTING_UP = ("__init__", "__post_init__")
"""Methods whose assignments declare fields."""


class _File(NamedTuple):
    """A Python file: functions by name and first line, and the attributes that other statements read."""

    bodies: Mapping[tuple[str, int], ast.AST]
    read: frozenset[str]


class _MistakeError(TypeError):
    """A mistake in a class, with its file and line."""

    def __init__(self, file: str, line: int, text: str) -> None:
        super().__init__(f"{file}:{line}: {text}")
        self.site = Site(file=file, line=line)


def check_statements(cls: type) -> None:
    """Raise a TypeError for a statement without effect or an undeclared field in a class's methods."""
    fields = _fields(cls)
    for function in _functions(cls):
        body = _body_of(function)
        if body is not None:
            scope = _Scope(cls, function.__globals__, fields)
            _check_body(scope, function.__code__.co_filename, body)


def _check_body(scope: _Scope, file: str, body: ast.AST) -> None:
    """Raise a _MistakeError for the first mistake in the body of a function."""
    names_read, attributes_read = _names_read(body), _file(file).read
    for node in ast.walk(body):
        mistake = (
            _unawaited_wait(scope, node)
            or _hidden_part(scope, node)
            or _undeclared_field(scope, node)
            or _unread_wait(scope, node, names_read, attributes_read)
        )
        if mistake:
            raise _MistakeError(file, getattr(node, "lineno", 1), mistake)


def _unawaited_wait(scope: _Scope, node: ast.AST) -> str:
    """Return the mistake in a statement that is a wait; "" if there is none."""
    if not (isinstance(node, ast.Expr) and scope.is_wait(node.value)):
        return ""
    text = ast.unparse(node.value)
    return f"`{text}` is never awaited and does nothing: write `await {text}`"


def _hidden_part(scope: _Scope, node: ast.AST) -> str:
    """Return the mistake in an assignment to a part of the class; "" if there is none."""
    for target in _targets(node):
        declaration = scope.of_self(target)
        if isinstance(declaration, Part | SequenceMethod) and not hasattr(type(declaration), "__set__"):
            text, kind = ast.unparse(target), type(declaration).__name__
            return f"`{text} = ...` would hide {text}, which the class declares as {kind}"
    return ""


def _undeclared_field(scope: _Scope, node: ast.AST) -> str:
    """Return the mistake in an assignment to an undeclared field; "" if there is none."""
    if not (isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)):
        return ""
    if not (isinstance(node.value, ast.Name) and node.value.id == "self") or scope.fields is None:
        return ""
    if node.attr in scope.fields:
        return ""
    text, name = f"self.{node.attr}", scope.owner.__name__
    close = difflib.get_close_matches(node.attr, sorted(scope.fields), n=1)
    meant = f"did you mean self.{close[0]}, or " if close else ""
    return f"{name} has no field `{text}`: {meant}declare it in the body of {name}"


def _fields(cls: type) -> frozenset[str] | None:
    """Return the declared names of a class and its bases; None if its source does not show them."""
    names = set(dir(cls))
    for kind in cls.__mro__:
        names.update(declared(vars(kind)))
        for name in SETTING_UP:
            function = vars(kind).get(name)
            if not isinstance(function, FunctionType):
                continue
            body = _body_of(function)
            if body is None:
                return None
            nodes = [node for node in ast.walk(body) if isinstance(node, ast.Attribute)]
            names.update(node.attr for node in nodes if isinstance(node.ctx, ast.Store))
    sets_its_own = any("__setattr__" in vars(kind) for kind in cls.__mro__[:-1])
    return None if sets_its_own else frozenset(names)


def _unread_wait(scope: _Scope, node: ast.AST, names: frozenset[str], attributes: frozenset[str]) -> str:
    """Return the mistake in a statement that stores a wait that nothing reads; "" if there is none."""
    value = getattr(node, "value", None)
    if value is None or not scope.is_wait(value):
        return ""
    for target in _targets(node):
        is_read = True
        if isinstance(target, ast.Name):
            is_read = target.id in names
        elif isinstance(target, ast.Attribute):
            is_read = target.attr in attributes
        if not is_read:
            text = ast.unparse(value)
            return f"`{ast.unparse(target)} = {text}` is never awaited and does nothing: write `await {text}`"
    return ""


def _names_read(body: ast.AST) -> frozenset[str]:
    """Return the names that a body reads; a statement that is only a name does not read it."""
    unused = {id(node.value) for node in ast.walk(body) if isinstance(node, ast.Expr)}
    names = set()
    for node in ast.walk(body):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and id(node) not in unused:
            names.add(node.id)
        elif isinstance(node, ast.Global | ast.Nonlocal):
            names.update(node.names)
    return frozenset(names)


def _targets(node: ast.AST) -> list[ast.expr]:
    """Return the targets of an assignment; [] for another node."""
    if isinstance(node, ast.Assign):
        return node.targets
    return [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign | ast.NamedExpr) else []


def sources_of(cls: type) -> dict[str, str]:
    """Return the text of each file that defines methods of a class or functions of their modules.

    An edit of a running program compares this text with the edited text, because the file has changed by
    then.
    """
    functions = list(_functions(cls))
    for names in [function.__globals__ for function in functions]:
        functions += [function for function in names.values() if inspect.iscoroutinefunction(function)]
    files = dict.fromkeys(function.__code__.co_filename for function in functions)
    return {file: "".join(linecache.getlines(file)) for file in files}


def _functions(cls: type) -> Iterator[FunctionType]:
    """Yield the methods of a class, then the `async def` functions before it in its module."""
    yield from functions_in(cls)
    module = sys.modules.get(cls.__module__)  # still being executed: it has only what precedes the class
    for value in getattr(module, "__dict__", {}).values():
        if inspect.iscoroutinefunction(value) and value.__module__ == cls.__module__:
            yield value


def _body_of(function: FunctionType) -> ast.AST | None:
    """Return the source of a function; None if it is missing or has changed since loading."""
    code = function.__code__
    return _file(code.co_filename).bodies.get((code.co_name, code.co_firstlineno))


def _file(name: str) -> _File:
    """Return the functions in the current version of a file, and the attributes that it reads."""
    linecache.checkcache(name)
    return _parsed("".join(linecache.getlines(name)))


@lru_cache(maxsize=4)
def _parsed(source: str) -> _File:
    """Return the functions in a source and the attributes that it reads; none for a SyntaxError."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return _File({}, frozenset())
    nodes = list(ast.walk(tree))
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    unused = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
    loads = (node for node in nodes if isinstance(node, ast.Attribute) and id(node) not in unused)
    attributes_read = frozenset(attribute.attr for attribute in loads if isinstance(attribute.ctx, ast.Load))
    return _File({(function.name, first_line(function)): function for function in functions}, attributes_read)


def first_line(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Return the first line of a function, including decorators."""
    return min((decorator.lineno for decorator in function.decorator_list), default=function.lineno)


class _Scope(NamedTuple):
    """The meaning of names in a method; `fields` has the declared names, or None, see `_fields`."""

    owner: type
    names: Mapping[str, Any]
    fields: frozenset[str] | None = None

    def of_self(self, node: ast.expr) -> Any:
        """Return the class attribute of an expression `self.name`; None for other expressions."""
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "self":
            return inspect.getattr_static(self.owner, node.attr, None)
        return None

    def is_wait(self, node: ast.expr) -> bool:
        """Return whether an expression is a wait or a coroutine, judging by its text."""
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
        """Return whether every `return` of a user's function returns a wait."""
        body = _body_of(called) if isinstance(called, FunctionType) else None
        if body is None:
            return False
        returns = [node.value for node in ast.walk(body) if isinstance(node, ast.Return)]
        names = {name: value for name, value in called.__globals__.items() if _is_ours(value)}
        scope = _Scope(self.owner, names)
        return bool(returns) and all(value is not None and scope.is_wait(value) for value in returns)


def _is_ours(called: Any) -> bool:
    """Return whether an object is a class of waits or one of `WAITS`."""
    if isinstance(called, type):
        return issubclass(called, Wait)
    return getattr(called, "__module__", "").startswith(_OURS) and getattr(called, "__name__", "") in WAITS
