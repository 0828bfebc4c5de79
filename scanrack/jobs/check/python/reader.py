"""Reads a Python program text without calling its code.

A command is a call of a class in `io_images.amci3601` by its name:

    Move(MoveKind.ABSOLUTE, STATIONS[line.station], speed=5000, acceleration=1, deceleration=1)

Constants and global names have known values. `STATIONS[...]`, and the variable of a loop over `STATIONS`, may
be any of the table's values. Anything else is unknown and counts as legal.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from inspect import signature
from types import MappingProxyType
from typing import Any

from scanrack.io_images import amci3601
from scanrack.io_images.amci3601 import Acceleration, Direction, MoveKind

from ..facts import Facts, FileLine, UsesBit, Violation
from .nodes import FUNCTIONS, Function, given_to, is_stored, missing, names_in, nodes_in, unpacks

NEUTRAL: Mapping[str, object] = {
    "kind": MoveKind.ABSOLUTE,
    "direction": Direction.CW,
    "shape": Acceleration.CONSTANT,
    **dict.fromkeys(("target", "value", "position"), 0),
    **dict.fromkeys(("speed", "acceleration", "deceleration", "starting_speed"), 1),
    **dict.fromkeys(("distance", "register", "numerator", "denominator"), 1),
}
"""Legal values that replace unknown required arguments of a command's class or an axis's method."""

COMMAND_CLASSES = (
    *("Move", "FindHome", "Manual", "PresetPosition", "PresetEncoder", "ResetErrors", "Resume", "RunBlend"),
)
"""Classes that set a command bit in word 0."""

CHECKED = (*COMMAND_CLASSES, "Configuration")
"""Classes whose arguments are checked."""

ZEROING = frozenset({"Idle", "Hold", "ImmediateStop", "Image"})
"""Classes that set no command bit in word 0."""

WRITING = frozenset({"clear", "set_bit", "words", "raw"})
"""Attributes of an image that are used to write it."""

NO_FIELDS: Mapping[str, object] = MappingProxyType({})

_VALUES = (ast.Constant, ast.Name, ast.Attribute, ast.UnaryOp, ast.BinOp, ast.unaryop, ast.operator, ast.Load)


class UnknownError(Exception):
    """The text does not determine the value of an argument."""


class Reader:
    """Reads a Python program text.

    Args:
        names: global names of its module, with their values.
        facts: the facts of the program.
        fields: values of `self` that the program never changes, by name.
    """

    def __init__(
        self,
        file: str,
        tree: ast.Module,
        names: Mapping[str, Any],
        facts: Facts,
        fields: Mapping[str, object] = NO_FIELDS,
    ) -> None:
        self.file, self.tree, self.names, self.facts, self.fields = file, tree, names, facts, fields
        functions = list(nodes_in(tree, *FUNCTIONS, ast.Lambda))
        self.local = {name for function in functions for name in _bound_names(function)}
        self.loops = dict(_loops(functions))

    def place(self, node: ast.expr | ast.stmt | ast.arg) -> FileLine:
        """Return the line of a node."""
        return FileLine(self.file, node.lineno)

    def remark(self, rule: str, node: ast.expr | ast.stmt | ast.arg, text: str) -> None:
        """Add a mistake that is visible in a single line."""
        self.facts.remark(rule, self.place(node), text)

    def remark_unless_in(self, names: Collection[str], node: ast.Attribute) -> None:
        """Note an attribute that its owner does not have."""
        if node.attr not in names:
            self.remark("unknown-attribute", node, missing(ast.unparse(node), node.attr, names))

    def calls(self) -> Iterator[tuple[str, ast.Call]]:
        """Yield the calls of command classes, each with the name of the class."""
        for node in nodes_in(self.tree, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in CHECKED and (name not in self.names or self.names[name] is _class(name)):
                yield name, node

    def make(self, kind: str, call: ast.Call) -> object | None:
        """Return a command made from the known arguments; None if it needs an unknown argument.

        Raises:
            ValueError: an argument is out of range.
        """
        arguments: dict[str, Sequence[object]] = {}
        for name, node in given_to(signature(_class(kind)).parameters, call).items():
            try:
                arguments[name] = self.possible(node)
            except UnknownError:
                if kind == "Configuration":
                    return None
                if name in NEUTRAL:
                    arguments[name] = (NEUTRAL[name],)
        try:
            commands = [] if unpacks(call) else [_class(kind)(**variant) for variant in variants(arguments)]
        except TypeError:  # the call itself fails, or an argument is unknown
            return None
        return commands[0] if commands else None

    def known(self, kind: str, call: ast.Call) -> Mapping[str, object]:
        """Return the arguments of a call that have a single value."""
        values = {}
        for name, node in given_to(signature(_class(kind)).parameters, call).items():
            with suppress(UnknownError):
                values[name] = self.value(node)
        return values

    def possible(self, node: ast.expr) -> Sequence[object]:
        """Return the possible values of an expression: one value, or the elements of its source sequence.

        Raises:
            UnknownError: the text does not determine them.
        """
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
            return self._elements(node.value)
        if isinstance(node, ast.Name) and node.id in self.loops:
            iterable, position = self.loops[node.id]
            elements = self._elements(iterable)
            return elements if position is None else [_item(element, position) for element in elements]
        return (self.value(node),)

    def _elements(self, node: ast.expr) -> Sequence[object]:
        """Return the elements of a sequence; raise UnknownError if the text does not determine them."""
        if isinstance(node, ast.Tuple | ast.List):
            return [
                self._elements(elt) if isinstance(elt, ast.Tuple | ast.List) else self.value(elt)
                for elt in node.elts
            ]
        elements = self.value(node)
        if not isinstance(elements, tuple | list) or not elements:
            raise UnknownError
        return elements

    def value(self, node: ast.expr) -> object:
        """Return the value of an expression that consists of constants and global names.

        Raises:
            UnknownError: it contains other names or operations, or can't be evaluated.
        """
        if isinstance(node, ast.Attribute) and getattr(node.value, "id", "") == "self":
            if node.attr not in self.fields:
                raise UnknownError
            return self.fields[node.attr]
        for part in ast.walk(node):
            is_local = isinstance(part, ast.Name) and part.id in self.local
            if is_local or isinstance(part, ast.Pow) or not isinstance(part, _VALUES):
                raise UnknownError
        try:
            return eval(compile(ast.Expression(node), self.file, "eval"), dict(self.names))
        except (NameError, AttributeError, TypeError, ArithmeticError) as error:
            raise UnknownError from error

    def number(self, node: ast.expr) -> int | float | None:
        """Return the value of an expression if it is a known number; otherwise None."""
        try:
            number = self.value(node)
        except UnknownError:
            return None
        return number if isinstance(number, int | float) else None

    def commands_never_cleared(self) -> Iterator[Violation]:
        """Yield the last command of a program that never clears word 0."""
        commands = [(call.lineno, kind) for kind, call in self.calls() if kind in COMMAND_CLASSES]
        if commands and not self._may_zero():
            line, kind = max(commands)
            text = f"{kind} sets its command bit, but nothing clears it: no Idle, word 0 is never zeroed"
            yield Violation(FileLine(self.file, line), text)

    def _may_zero(self) -> bool:
        """Whether the program may write word 0 by means other than a command."""
        attributes = (node.attr for node in nodes_in(self.tree, ast.Attribute))
        return (
            any(map(is_stored, nodes_in(self.tree, ast.Subscript)))
            or not ZEROING.isdisjoint(names_in(self.tree))
            or not WRITING.isdisjoint(attributes)
        )

    def uses_bit(self, terminals: Set[str]) -> UsesBit | None:
        """Return a function that tests whether the program names a terminal; None if it names none."""
        words = {node.value for node in nodes_in(self.tree, ast.Constant)}
        words |= {node.attr for node in nodes_in(self.tree, ast.Attribute)}
        if words.isdisjoint(terminals):
            return None
        return lambda _slot, _image, name, _word, _bit: name in words


def functions_in(tree: ast.Module) -> Iterator[tuple[Function, ast.ClassDef | None]]:
    """Yield the functions of a module and the methods of its classes, with their class."""
    for node in tree.body:
        owner = node if isinstance(node, ast.ClassDef) else None
        for statement in (node,) if owner is None else owner.body:
            if isinstance(statement, Function):
                yield statement, owner


def variants(arguments: Mapping[str, Sequence[object]]) -> Iterator[dict[str, Any]]:
    """Yield sets of arguments: first all first values, then each other value with the others at their first.

    >>> list(variants({"a": (1, 2), "b": (3,)}))
    [{'a': 1, 'b': 3}, {'a': 2, 'b': 3}]
    """
    first_values = {name: values[0] for name, values in arguments.items()}
    yield first_values
    for name, values in arguments.items():
        for value in values[1:]:
            yield {**first_values, name: value}


def _loops(functions: Sequence[ast.AST]) -> Iterator[tuple[str, tuple[ast.expr, int | None]]]:
    """Yield the variables that a single loop sets, each with the loop's sequence and its index in a row."""
    stored = Counter(node.id for node in filter(is_stored, nodes_in(functions, ast.Name)))
    arguments = {node.arg for node in nodes_in(functions, ast.arg)}
    for loop in nodes_in(functions, ast.For):
        targets = loop.target.elts if isinstance(loop.target, ast.Tuple) else [loop.target]
        for position, target in enumerate(targets):
            if isinstance(target, ast.Name) and stored[target.id] == 1 and target.id not in arguments:
                yield target.id, (loop.iter, None if target is loop.target else position)


def _item(row: object, index: int) -> object:
    if not isinstance(row, tuple | list) or index >= len(row):
        raise UnknownError
    return row[index]


def _class(name: str) -> Any:
    return getattr(amci3601, name)


def _bound_names(function: Function | ast.Lambda) -> Iterator[str]:
    """Yield the names that a function binds."""
    yield from (node.arg for node in nodes_in(function, ast.arg))
    yield from (node.id for node in nodes_in(function, ast.Name) if is_stored(node))
