"""Ranges of the numbers in a Python program text."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from contextlib import suppress
from types import MappingProxyType

from scanrack.io_images.amci3601 import BlendSegment

from ..ranges import ANY, OPERATIONS, Range, exactly, joined
from .expression_options import Options
from .nodes import Function, nodes_in
from .reader import Reader, UnknownError

OPERATORS: Mapping[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.FloorDiv: "/",
}

NONE: Mapping[str, tuple[Range, ...]] = MappingProxyType({})

NO_FUNCTIONS: Mapping[str, Function] = MappingProxyType({})

DEPTH = 8
"""Maximum number of names that are followed to find a value."""


class Numbers:
    """The numbers in a text.

    Args:
        stored: expressions that the text assigns, by the name of a field or local variable. None stands for
            an unknown value.
    """

    def __init__(self, reader: Reader, stored: Mapping[str, Sequence[ast.expr | None]]) -> None:
        self._reader, self._stored = reader, stored

    def range_of(
        self, node: ast.expr, parameters: Mapping[str, tuple[Range, ...]] = NONE, depth: int = DEPTH
    ) -> Range:
        """Return the range of an expression.

        Args:
            parameters: ranges of parameters, by name.
        """
        return joined(*self.choices(node, parameters, depth))

    def sequence(self, node: ast.expr) -> Sequence[object] | None:
        """Return the elements of a sequence; None if the text does not determine them."""
        is_listed = isinstance(node, ast.Tuple | ast.List)
        try:
            elements = self._evaluated(node) if is_listed else self._reader.value(node)
        except UnknownError:
            elements = self._evaluated(node)
        return elements if isinstance(elements, tuple | list) else None

    def _evaluated(self, node: ast.expr) -> object:
        """Return the value of an expression with no calls but sequence constructors; None for any other."""
        names = (ast.unparse(call.func) for call in nodes_in(node, ast.Call))
        callees = [self._reader.names.get(name, name) for name in names]
        if not all(kind is BlendSegment or kind in ("range", "tuple", "list") for kind in callees):
            return None
        if any(nodes_in(node, ast.Await, ast.Lambda, ast.Pow)):
            return None
        try:
            return eval(compile(ast.Expression(node), self._reader.file, "eval"), dict(self._reader.names))
        except Exception:
            return None  # a local name, or a segment that is refused

    def choices(
        self, node: ast.expr, parameters: Mapping[str, tuple[Range, ...]] = NONE, depth: int = DEPTH
    ) -> tuple[Range, ...]:
        """Return the range of each value that an expression can have.

        Try the arms of a conditional expression, a parameter, constants, assigned values, and a
        calculation, in this order.
        """
        if isinstance(node, ast.IfExp):
            body, orelse = (self.choices(arm, parameters, depth) for arm in (node.body, node.orelse))
            return (*body, *orelse)
        if isinstance(node, ast.Name) and node.id in parameters:
            return parameters[node.id]
        with suppress(UnknownError):
            return _exact_ranges(self._reader.possible(node))
        stored = self._stored_values(node) if depth else []
        if stored:
            return tuple(choice for value in stored for choice in self.choices(value, parameters, depth - 1))
        range_ = self._range(node, parameters, depth)
        return (range_,) if range_ != ANY else self._options_of(node)

    def _stored_values(self, node: ast.expr) -> list[ast.expr]:
        """Return all values that the text assigns to a name or attribute; empty if any value is unknown."""
        is_named = isinstance(node, ast.Name | ast.Attribute)
        values = self._stored.get(ast.unparse(node), ()) if is_named else ()
        return [] if None in values else [value for value in values if value is not None]

    def _options_of(self, node: ast.expr) -> tuple[Range, ...]:
        """Return the ranges of the options of an expression, such as the elements of tables."""
        stored = {
            name: [value for value in values if value is not None] for name, values in self._stored.items()
        }
        try:
            return _exact_ranges(Options(self._reader, NO_FUNCTIONS, stored).evaluate(node, {}).options)
        except UnknownError:
            return (ANY,)

    def _range(self, node: ast.expr, parameters: Mapping[str, tuple[Range, ...]], depth: int) -> Range:
        """Return the range of a calculation, of a call, or of a loop variable; ANY for anything else."""
        if depth == 0:
            return ANY
        match node:
            case ast.Name(name) if name in self._reader.loops:
                return self._loop_range(name, parameters, depth)
            case ast.UnaryOp(ast.USub(), operand):
                return OPERATIONS["NEG"](self.range_of(operand, parameters, depth - 1))
            case ast.BinOp(left, op, right) if type(op) in OPERATORS:
                sides = (self.range_of(side, parameters, depth - 1) for side in (left, right))
                return OPERATIONS[OPERATORS[type(op)]](*sides)
            case ast.Call(func=ast.Name(name), args=args) if args and not node.keywords:
                return self._call_range(name, [self.range_of(arg, parameters, depth - 1) for arg in args])
        return ANY

    def _loop_range(self, name: str, parameters: Mapping[str, tuple[Range, ...]], depth: int) -> Range:
        """Return the range of a loop variable in `for i in range(...)`; ANY for any other loop."""
        iterable, position = self._reader.loops[name]
        is_range = isinstance(iterable, ast.Call) and ast.unparse(iterable.func) == "range"
        if not isinstance(iterable, ast.Call) or not is_range or position is not None:
            return ANY
        bounds = [self.range_of(arg, parameters, depth - 1) for arg in iterable.args]
        if not all(bound.is_constant for bound in bounds):
            return ANY
        passes = range(*(int(bound.least) for bound in bounds))
        return Range(min(passes), max(passes)) if passes else ANY

    @staticmethod
    def _call_range(name: str, ranges: Sequence[Range]) -> Range:
        """Return the range of the result of a built-in function; ANY for any other function."""
        if name in ("min", "max") and len(ranges) > 1:
            pick = min if name == "min" else max
            least, most = pick(number.least for number in ranges), pick(number.most for number in ranges)
            return Range(least, most, False)
        if name == "abs":
            return OPERATIONS["ABS"](ranges[0])
        return OPERATIONS["TRN"](ranges[0]) if name in ("int", "round") else ANY


def _exact_ranges(values: Sequence[object]) -> tuple[Range, ...]:
    """Return a range for each value; raise UnknownError if a value is not a number, or without values."""
    numbers = [value for value in values if isinstance(value, int | float)]
    if not numbers or len(numbers) < len(values):
        raise UnknownError
    return tuple(map(exactly, numbers))
