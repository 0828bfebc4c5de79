"""The meaning of a function's local names at a place in its text."""

from __future__ import annotations

import ast
import copy
from collections.abc import Mapping, Sequence

from ..logic import INPUT
from .expression_options import Options
from .nodes import Function, given_to, parameters_of
from .reader import UnknownError

MOST = 400
"""Maximum number of nodes of an expression that is followed."""

Names = dict[str, ast.expr | None]


class LocalNames:
    """The local names at a place, each with an expression without local names, or None if unknown."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._names: Names = {}

    def begin(self) -> None:
        """Start a function."""
        self._names = {}

    def copy(self) -> Names:
        """Return the names at the current place."""
        return dict(self._names)

    def swap(self, names: Names) -> Names:
        """Switch to the names of another place; return the names of the current place."""
        self._names, previous = names, self._names
        return previous

    def join(self, after_body: Names, test: ast.expr) -> None:
        """Join the names after the body of an `if` statement with the current names, after its `else`."""
        for name in {*after_body, *self._names}:
            body_value, else_value = after_body.get(name), self._names.get(name)
            if body_value is None or else_value is None:
                self._names[name] = None
            elif body_value is not else_value and ast.dump(body_value) != ast.dump(else_value):
                self._names[name] = ast.IfExp(self.closed(test), body_value, else_value)

    def forget(self, name: str) -> None:
        """Make the value of a name unknown."""
        self._names[name] = None

    def bind(self, target: ast.expr, value: ast.expr | None) -> None:
        """Set the value of a target; None if it is unknown."""
        if isinstance(target, ast.Tuple):
            parts = [None] * len(target.elts) if value is None else self.parts(value, len(target.elts))
            for element, part in zip(target.elts, parts, strict=True):
                self.bind(element, part)
        elif isinstance(target, ast.Name):
            self._names[target.id] = None if value is None else _short(self.closed(value))

    def parts(self, value: ast.expr, count: int) -> Sequence[ast.expr]:
        """Return the elements of a value that is being unpacked."""
        if isinstance(value, ast.Tuple) and len(value.elts) == count:
            return [self.closed(elt) for elt in value.elts]
        closed = self.closed(value)
        return [
            ast.copy_location(ast.Subscript(closed, ast.Constant(index), ast.Load()), value)
            for index in range(count)
        ]

    def enter(self, function: Function, call: ast.Call) -> Names:
        """Enter a called function; return the names at the call."""
        parameters = parameters_of(function)
        arguments = {name: _short(self.closed(value)) for name, value in given_to(parameters, call).items()}
        return self.swap({**arguments, **{name: None for name in parameters if name not in arguments}})

    def closed(self, node: ast.expr) -> ast.expr:
        """Return an expression with local names replaced by their meaning."""
        expression = _Closing(self._names).visit(_copy(node))
        assert isinstance(expression, ast.expr)
        return expression

    def inputs(self, node: ast.expr) -> ast.expr:
        """Return an expression like `closed`, with bits of input images replaced by names."""
        expression = _InputNames(self._options).visit(self.closed(node))
        assert isinstance(expression, ast.expr)
        return expression


class _Closing(ast.NodeTransformer):
    """Replaces local names with their meaning."""

    def __init__(self, names: Mapping[str, ast.expr | None]) -> None:
        self._names = names

    def visit_Name(self, node: ast.Name) -> ast.expr:
        value = self._names.get(node.id)
        return ast.copy_location(_copy(value), node) if value is not None else node

    def visit_Lambda(self, node: ast.Lambda) -> ast.expr:
        return node


class _InputNames(ast.NodeTransformer):
    """Replaces `scan.slot[2].inputs.bit(0, 3)` with the name of an input."""

    def __init__(self, options: Options) -> None:
        self._options = options

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Replace a read of an input bit; keep any other call, and a bit at an unknown position."""
        image = node.func.value if isinstance(node.func, ast.Attribute) and node.func.attr == "bit" else None
        if not isinstance(image, ast.Attribute) or image.attr != "inputs":
            return node
        try:
            position = [self._options.evaluate(arg, {}).options[0] for arg in node.args]
        except UnknownError:
            return node
        return ast.copy_location(ast.Name(f"{INPUT}{ast.unparse(image)}.{position}", ast.Load()), node)


def _short(node: ast.expr) -> ast.expr | None:
    """Return an expression; None if it is too long to follow."""
    return node if sum(1 for _ in ast.walk(node)) < MOST else None


def _copy(node: ast.expr) -> ast.expr:
    """Return a copy of an expression, because a transformer changes its nodes."""
    return copy.deepcopy(node)
