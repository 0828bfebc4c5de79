"""Loops of sequences that never wait.

while True: self.count += 1         no end and no await
while not self.start: pass          an input is constant for the whole scan
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator

_WAITS = (ast.Await, ast.AsyncWith, ast.AsyncFor)
_LEAVES = (ast.Break, ast.Return, ast.Raise)
_OF_IMAGES = ("set_bit", "load", "clear", "to_image")
_FIXED_FORMS = (ast.UnaryOp, ast.BoolOp, ast.Compare, ast.Constant, ast.Name, ast.Attribute)


def endless(tree: ast.Module, inputs: Collection[str]) -> Iterator[tuple[int, str]]:
    """Yield the loops of `async def` functions that have no end and no await: line and problem.

    Args:
        inputs: the names of inputs, which are constant for the whole scan.
    """
    for function in ast.walk(tree):
        if isinstance(function, ast.AsyncFunctionDef):
            for loop in ast.walk(function):
                if isinstance(loop, ast.While) and _stays(loop.test, inputs) and not _ends_or_waits(loop):
                    yield loop.lineno, f"{function.name} never waits in this loop: the watchdog ends it"


def fixed_loops(tree: ast.Module, parts: Collection[str] = ()) -> Iterator[tuple[int, str]]:
    """Yield loops without a wait in which nothing changes what they test: line and problem.

    Args:
        parts: fields that the scan keeps as they are: inputs, axes.
    """
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))
    for function in functions:
        for loop in ast.walk(function):
            if isinstance(loop, ast.While) and not _ends_or_waits(loop) and _is_fixed(loop, parts):
                text = f"nothing in this loop changes `{ast.unparse(loop.test)}`: the watchdog ends it"
                yield loop.lineno, f"{function.name}: {text}"


def _is_fixed(loop: ast.While, parts: Collection[str]) -> bool:
    """Whether nothing in a loop changes what it tests, which is no constant."""
    nodes = [node for each in loop.body for node in ast.walk(each)]
    stored = {
        ast.unparse(node)
        for node in nodes
        if isinstance(node, ast.Name | ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store)
    }
    read = [node for node in ast.walk(loop.test) if isinstance(node, ast.expr)]
    calls = [node for node in nodes if isinstance(node, ast.Call) and not _is_of_part(node, parts)]
    names = [node for node in read if isinstance(node, ast.Name | ast.Attribute | ast.Subscript)]
    is_local = all(isinstance(node, ast.Name) for node in names)
    is_plain = all(isinstance(node, (*_FIXED_FORMS, ast.Subscript)) for node in read)
    return bool(names) and is_plain and not {*map(ast.unparse, names)} & stored and (is_local or not calls)


def _is_of_part(call: ast.Call, parts: Collection[str]) -> bool:
    """Whether this calls a method of a part, such as an axis, or one of an image."""
    owner = call.func.value if isinstance(call.func, ast.Attribute) else None
    is_part = isinstance(owner, ast.Attribute) and owner.attr in parts
    return is_part or (isinstance(call.func, ast.Attribute) and call.func.attr in _OF_IMAGES)


def skips_wait(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield `continue` in a loop before anything is awaited or changed: line and problem."""
    functions = (node for node in ast.walk(tree) if isinstance(node, ast.AsyncFunctionDef))
    for function in functions:
        for loop in ast.walk(function):
            if isinstance(loop, ast.While) and isinstance(loop.test, ast.Constant):
                for node in loop.body:
                    if not isinstance(node, ast.If) or not _only_continues(node):
                        break
                    test = ast.unparse(node.test)
                    yield node.lineno, f"{function.name} never waits while `{test}`: the watchdog ends it"


def _only_continues(node: ast.If) -> bool:
    """Whether a statement begins the next pass, and its condition can't change until then."""
    leaves = [each for each in ast.walk(node.test) if isinstance(each, ast.expr)]
    is_fixed = all(isinstance(each, _FIXED_FORMS) for each in leaves)
    return is_fixed and len(node.body) == 1 and isinstance(node.body[0], ast.Continue)


def _stays(test: ast.expr, inputs: Collection[str]) -> bool:
    """Return whether a condition can't change within a scan and may hold: it is a constant, or of inputs."""
    if isinstance(test, ast.Constant):
        return bool(test.value)
    leaves = [node for node in ast.walk(test) if isinstance(node, ast.expr)]
    names = [node for node in leaves if isinstance(node, ast.Name)]
    parts = [node.attr for node in leaves if isinstance(node, ast.Attribute)]
    return (
        all(isinstance(node, _FIXED_FORMS) for node in leaves)
        and all(node.id == "self" for node in names)
        and bool(parts)
        and all(part in inputs for part in parts)
    )


def _ends_or_waits(loop: ast.While) -> bool:
    return any(isinstance(node, (*_WAITS, *_LEAVES)) for node in ast.walk(loop))
