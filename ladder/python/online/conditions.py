"""Checks the functions in a wait, which continues only if the edited program has the same functions."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from types import CodeType, FunctionType, MethodType
from typing import Any

from ..sequences.branches import BranchWait, Several
from ..sequences.coroutine import Sequence
from ..sequences.parts import Part
from ..sequences.waits import Wait
from .edition import Edition

OURS = "scanrack."


class ConditionError(ValueError):
    """A wait that does not fit the edited program."""


def waits_in(wait: Wait[Any]) -> Iterator[Wait[Any]]:
    """Yield a wait and the waits inside it, but not the waits of its branches."""
    yield wait
    if isinstance(wait, Several):
        for inner in wait.waits:
            yield from waits_in(inner)


def branches_in(wait: Wait[Any]) -> Iterator[Sequence]:
    """Yield the running branches of a wait."""
    for inner in waits_in(wait):
        if isinstance(inner, BranchWait) and not inner._sequence.over:
            yield inner._sequence


Texts = dict[CodeType, str]
"""The syntax of waiting functions from an earlier edition, which has other line numbers."""


def check_wait(
    wait: Wait[Any], editions: tuple[Edition, Edition], changed: Iterable[Part], texts: Texts
) -> None:
    """Raise a ConditionError if a wait can't continue in an edited program.

    Args:
        editions: the current and the edited edition.
        changed: parts that the edit changes.
        texts: known syntax, to which the syntax of the wait's functions is added.
    """
    parts = list(changed)
    for inner in waits_in(wait):
        if not type(inner).__module__.startswith(OURS):
            raise ConditionError(f"{inner!r} is a wait of a class of the program, {type(inner).__name__}")
        for value in _values_of(inner):
            _check_value(value, editions, parts, texts)


def _values_of(wait: Wait[Any]) -> Iterator[Any]:
    """Yield the values in a wait's slots."""
    for kind in type(wait).__mro__:
        for name in getattr(kind, "__slots__", ()):
            if hasattr(wait, name):
                yield getattr(wait, name)


def _check_value(value: Any, editions: tuple[Edition, Edition], changed: list[Part], texts: Texts) -> None:
    """Check one value of a wait, such as a function, with its bound object and its cells."""
    if any(value is item for item in changed):
        raise ConditionError(f"it waits for {value.name}, whose declaration has changed")
    if value is not None and any(value is getattr(item, "read", None) for item in changed):
        raise ConditionError("it waits for an input whose declaration has changed")
    if isinstance(value, MethodType):
        _check_value(value.__self__, editions, changed, texts)
        value = value.__func__
    if not isinstance(value, FunctionType):
        return
    for cell in value.__closure__ or ():
        _check_value(cell.cell_contents, editions, changed, texts)
    if not value.__module__.startswith(OURS):
        _check_function(value, *editions, texts)


def _check_function(function: FunctionType, old: Edition, new: Edition, texts: Texts) -> None:
    """Raise a ConditionError unless the edited program has a function's syntax; store that syntax."""
    code = function.__code__
    name = "its condition" if code.co_name == "<lambda>" else f"its condition {code.co_name}"
    if "__class__" in code.co_freevars or set(code.co_names) & (old.rebound | new.rebound):
        raise ConditionError(f"{name} can't continue")
    old_text = texts.get(code) or _text_of(function, old)
    if old_text is None or old_text not in _texts_in(function, new):
        raise ConditionError(f"{name} has changed")
    texts[code] = old_text


def _text_of(function: FunctionType, edition: Edition) -> str | None:
    """Return the syntax of a function; None if its source is missing."""
    outer = _outer_function(function, edition)
    code = function.__code__
    if outer is None:
        return None
    first_line = code.co_firstlineno
    if "<locals>" not in code.co_qualname:
        return ast.dump(outer)
    positions = {(line, column) for line, _, column, _ in code.co_positions() if line}
    nodes = [
        node
        for node in ast.walk(outer)
        if isinstance(node, ast.Lambda | ast.FunctionDef)
        and node.lineno == first_line
        and _covers(node, positions)
    ]
    return ast.dump(nodes[0]) if len(nodes) == 1 else None


def _covers(node: ast.Lambda | ast.FunctionDef, positions: set[Any]) -> bool:
    """Return whether all positions of a code object are inside a node."""
    start, end = (node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0)
    return all(start <= position <= end for position in positions if position != (node.lineno, 0))


def _texts_in(function: FunctionType, edition: Edition) -> list[str]:
    """Return the syntax of each function in another edition that may correspond to a function."""
    outer = _outer_function(function, edition)
    if outer is None:
        return []
    if "<locals>" not in function.__code__.co_qualname:
        return [ast.dump(outer)]
    return [ast.dump(node) for node in ast.walk(outer) if isinstance(node, ast.Lambda | ast.FunctionDef)]


def _outer_function(function: FunctionType, edition: Edition) -> ast.AST | None:
    """Return the syntax tree of the outermost function around a function; None if it is missing."""
    top = function.__code__.co_qualname.partition(".<locals>")[0]
    definition = edition.function(function.__module__, top)
    return None if definition is None else edition.tree(definition)
