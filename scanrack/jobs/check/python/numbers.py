"""Ranges of the numbers in the text of a Python program."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from types import MappingProxyType

from scanrack.io_images.amci3601 import BlendSegment

from ..ranges import ANY, OPERATIONS, Range, exactly, joined
from .expression_options import Options
from .reader import Function, Reader, UnknownError

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
"""Levels of names behind a name."""


class Numbers:
    """The numbers of a text.

    Args:
        stored: expressions that the text assigns, by the name of a field or of a local variable; None
            among them for a value that is not known.
    """

    def __init__(self, reader: Reader, stored: Mapping[str, Sequence[ast.expr | None]]) -> None:
        self._reader, self._stored = reader, stored

    def of(self, node: ast.expr, given: Mapping[str, tuple[Range, ...]] = NONE, depth: int = DEPTH) -> Range:
        """Return the range of an expression.

        Args:
            given: ranges of parameters, by name.
        """
        return joined(*self.choices(node, given, depth))

    def sequence(self, node: ast.expr) -> Sequence[object] | None:
        """Return the elements of a sequence that the text determines; None if it does not."""
        try:
            found = self._reader.value(node) if not isinstance(node, ast.Tuple | ast.List) else None
        except UnknownError:
            found = self._evaluated(node)
        if isinstance(node, ast.Tuple | ast.List):
            found = self._evaluated(node)
        return found if isinstance(found, tuple | list) else None

    def _evaluated(self, node: ast.expr) -> object:
        """Return the value of an expression whose calls only make sequences; None for another one."""
        for each in ast.walk(node):
            called = (
                self._reader.names.get(ast.unparse(each.func), ast.unparse(each.func))
                if isinstance(each, ast.Call)
                else None
            )
            if called is not None and called is not BlendSegment and called not in ("range", "tuple", "list"):
                return None
            if isinstance(each, ast.Await | ast.Lambda | ast.Pow):
                return None
        try:
            return eval(compile(ast.Expression(node), self._reader.file, "eval"), dict(self._reader.names))
        except Exception:
            return None  # a name of the function, or a segment that is refused when it is made

    def choices(
        self, node: ast.expr, given: Mapping[str, tuple[Range, ...]] = NONE, depth: int = DEPTH
    ) -> tuple[Range, ...]:
        """Return the ranges of the values that an expression gets one after the other."""
        if isinstance(node, ast.IfExp):
            return (*self.choices(node.body, given, depth), *self.choices(node.orelse, given, depth))
        if isinstance(node, ast.Name) and node.id in given:
            return given[node.id]
        try:
            return _of_values(self._reader.possible(node))
        except UnknownError:
            pass
        if depth and isinstance(node, ast.Name | ast.Attribute) and ast.unparse(node) in self._stored:
            values = self._stored[ast.unparse(node)]
            if values and None not in values:
                return tuple(
                    each
                    for value in values
                    if value is not None
                    for each in self.choices(value, given, depth - 1)
                )
        found = self._range(node, given, depth)
        return (found,) if found != ANY else self._options_of(node)

    def _options_of(self, node: ast.expr) -> tuple[Range, ...]:
        """Return what elements of tables may be, and what helpers make of them."""
        stored = {
            name: [each for each in values if each is not None] for name, values in self._stored.items()
        }
        try:
            return _of_values(Options(self._reader, NO_FUNCTIONS, stored).of(node, {}).options)
        except UnknownError:
            return (ANY,)

    def _range(self, node: ast.expr, given: Mapping[str, tuple[Range, ...]], depth: int) -> Range:
        if depth == 0:
            return ANY
        match node:
            case ast.Name(name) if name in self._reader.loops:
                return self._of_loop(name, given, depth)
            case ast.UnaryOp(ast.USub(), operand):
                return OPERATIONS["NEG"](self.of(operand, given, depth - 1))
            case ast.BinOp(left, op, right) if type(op) in OPERATORS:
                return OPERATIONS[OPERATORS[type(op)]](
                    self.of(left, given, depth - 1), self.of(right, given, depth - 1)
                )
            case ast.Call(func=ast.Name(name), args=args) if args and not node.keywords:
                return self._of_call(name, [self.of(each, given, depth - 1) for each in args])
        return ANY

    def _of_loop(self, name: str, given: Mapping[str, tuple[Range, ...]], depth: int) -> Range:
        """Return the range of the variable of `for i in range(...)`."""
        iterable, at = self._reader.loops[name]
        if not (isinstance(iterable, ast.Call) and ast.unparse(iterable.func) == "range") or at is not None:
            return ANY
        bounds = [self.of(each, given, depth - 1) for each in iterable.args]
        if not all(each.is_constant for each in bounds):
            return ANY
        passes = range(*(int(each.least) for each in bounds))
        return Range(min(passes), max(passes)) if passes else ANY

    @staticmethod
    def _of_call(name: str, ranges: Sequence[Range]) -> Range:
        if name in ("min", "max") and len(ranges) > 1:
            pick = min if name == "min" else max
            return Range(pick(each.least for each in ranges), pick(each.most for each in ranges), False)
        if name == "abs":
            return OPERATIONS["ABS"](ranges[0])
        return OPERATIONS["TRN"](ranges[0]) if name in ("int", "round") else ANY


def _of_values(values: Sequence[object]) -> tuple[Range, ...]:
    numbers = [each for each in values if isinstance(each, int | float)]
    if not numbers or len(numbers) < len(values):
        raise UnknownError
    return tuple(map(exactly, numbers))
