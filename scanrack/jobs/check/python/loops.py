"""Loops of sequences that never wait.

while True: self.count += 1         no end and no await
while not self.start: pass          an input does not change during a scan
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from typing import TypeGuard

from .nodes import FUNCTIONS, is_stored, names_in, nodes_in

_WAITS = (ast.Await, ast.AsyncWith, ast.AsyncFor)
_LEAVES = (ast.Break, ast.Return, ast.Raise)
_OF_IMAGES = ("set_bit", "load", "clear", "to_image")
_FIXED_FORMS = (ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Constant, ast.Name, ast.Attribute)
_VALUES = (ast.Name, ast.Attribute, ast.Subscript)


def endless(tree: ast.Module, inputs: Collection[str]) -> Iterator[tuple[int, str]]:
    """Yield the loops of `async def` functions that neither end nor await, each as line and problem.

    Args:
        inputs: names of inputs, which do not change during a scan.
    """
    for function in nodes_in(tree, ast.AsyncFunctionDef):
        for loop in nodes_in(function, ast.While):
            if _stays(loop.test, inputs) and not _ends_or_waits(loop):
                yield loop.lineno, f"{function.name} never waits in this loop: the watchdog ends it"


def fixed_loops(tree: ast.Module, parts: Collection[str] = ()) -> Iterator[tuple[int, str]]:
    """Yield loops that neither wait nor change the values that they test, each as line and problem.

    Args:
        parts: fields that do not change during a scan: inputs and axes.
    """
    for function in nodes_in(tree, *FUNCTIONS):
        for loop in nodes_in(function, ast.While):
            if not _ends_or_waits(loop) and _is_fixed(loop, parts):
                text = f"nothing in this loop changes `{ast.unparse(loop.test)}`: the watchdog ends it"
                yield loop.lineno, f"{function.name}: {text}"


def _is_fixed(loop: ast.While, parts: Collection[str]) -> bool:
    """Whether a loop tests something other than a constant, and nothing in the loop changes it."""
    tested = list(nodes_in(loop.test, *_VALUES))
    if not tested or not _has_only(loop.test, *_FIXED_FORMS, ast.Subscript):
        return False
    is_local = all(isinstance(node, ast.Name) for node in tested)
    if not is_local and not all(_is_of_part(call, parts) for call in nodes_in(loop.body, ast.Call)):
        return False  # a call may change a field
    stored = {ast.unparse(node) for node in nodes_in(loop.body, *_VALUES) if is_stored(node)}
    return stored.isdisjoint(map(ast.unparse, tested))


def _has_only(test: ast.expr, *forms: type[ast.expr]) -> bool:
    """Whether an expression consists only of these kinds of expressions."""
    return all(isinstance(node, forms) for node in nodes_in(test, ast.expr))


def _is_of_part(call: ast.Call, parts: Collection[str]) -> bool:
    """Whether a call is to a method of a part, such as an axis, or of an image."""
    owner = call.func.value if isinstance(call.func, ast.Attribute) else None
    is_part = isinstance(owner, ast.Attribute) and owner.attr in parts
    return is_part or (isinstance(call.func, ast.Attribute) and call.func.attr in _OF_IMAGES)


def skips_wait(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield each `continue` in a loop before anything is awaited or changed, as line and problem."""
    for function in nodes_in(tree, ast.AsyncFunctionDef):
        for loop in nodes_in(function, ast.While):
            for node in loop.body if isinstance(loop.test, ast.Constant) else ():
                if not _only_continues(node):
                    break
                test = ast.unparse(node.test)
                yield node.lineno, f"{function.name} never waits while `{test}`: the watchdog ends it"


def _only_continues(node: ast.stmt) -> TypeGuard[ast.If]:
    """Whether a statement only starts the next pass, under a condition that can't change before it."""
    match node:
        case ast.If(body=[ast.Continue()], test=test):
            return _has_only(test, *_FIXED_FORMS)
    return False


def _stays(test: ast.expr, inputs: Collection[str]) -> bool:
    """Whether a condition can be true and can't change within a scan: a constant, or only inputs."""
    if isinstance(test, ast.Constant):
        return bool(test.value)
    parts = {node.attr for node in nodes_in(test, ast.Attribute)}
    is_of_inputs = bool(parts) and parts.issubset(inputs) and set(names_in(test)) <= {"self"}
    return is_of_inputs and _has_only(test, *_FIXED_FORMS)


def _ends_or_waits(loop: ast.While) -> bool:
    return any(isinstance(node, (*_WAITS, *_LEAVES)) for node in ast.walk(loop))
