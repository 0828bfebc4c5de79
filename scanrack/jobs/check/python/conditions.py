"""Conditions in a Python program text.

A name keeps its value from one wait or assignment to the next. `Names.forget` then renames every value.
"""

from __future__ import annotations

import ast

from ..logic import MIRRORED, UNKNOWN, AllOf, AnyOf, Bit, Compare, Condition, FixedTruth, negated

RELATIONS: dict[type[ast.cmpop], str] = {
    ast.Eq: "=",
    ast.NotEq: "<>",
    ast.Lt: "<",
    ast.LtE: "<=",
    ast.Gt: ">",
    ast.GtE: ">=",
    ast.Is: "=",
    ast.IsNot: "<>",
}

TEXTS = -(10**9)
"""The number of the first text; the others are below, where they are no numbers of steps."""


class ConditionNames:
    """Names the values of expressions in conditions; equal names mean equal values."""

    def __init__(self) -> None:
        self.turn = self._last = 0  # a turn is a time in which values do not change
        self._texts: dict[object, int] = {}

    def forget(self) -> None:
        """From now on, treat every value as a new one."""
        self._last += 1
        self.turn = self._last

    def of(self, node: ast.expr) -> str:
        """Return the name of a value."""
        return f"{ast.unparse(node)}#{self.turn}"

    def number(self, value: object) -> float | None:
        """Return a number for a constant, the same one for equal constants; None for None."""
        if isinstance(value, int | float):
            return value
        return None if value is None else self._texts.setdefault(value, TEXTS - len(self._texts))


def is_plain(node: ast.expr) -> bool:
    """Whether an expression is a name, or an attribute of one, so that reading it runs no code."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name)


def condition(node: ast.expr, names: ConditionNames) -> Condition:
    """Return an expression as a condition."""
    match node:
        case ast.Constant(value):
            return FixedTruth(bool(value))
        case ast.UnaryOp(ast.Not(), operand):
            return negated(condition(operand, names))
        case ast.BoolOp(op, values):
            parts = tuple(condition(part, names) for part in values)
            return AllOf(parts) if isinstance(op, ast.And) else AnyOf(parts)
        case ast.Compare(left, ops, comparators):
            sides = [left, *comparators]
            parts = tuple(
                _compared(sides[index], op, sides[index + 1], names) for index, op in enumerate(ops)
            )
            return parts[0] if len(parts) == 1 else AllOf(parts)
    return Bit(names.of(node)) if is_plain(node) else UNKNOWN


def _compared(one: ast.expr, op: ast.cmpop, other: ast.expr, names: ConditionNames) -> Condition:
    relation = RELATIONS.get(type(op))
    left, right = constant_of(one), constant_of(other)
    if relation is None:
        return UNKNOWN
    if left is not None and right is not None:
        return _of_constants(left, relation, right)
    if left is not None:
        return _with_constant(other, MIRRORED[relation], left.value, names)
    if right is not None:
        return _with_constant(one, relation, right.value, names)
    is_same = is_plain(one) and ast.unparse(one) == ast.unparse(other)
    return FixedTruth(relation in ("=", "<=", ">=")) if is_same else UNKNOWN


def _with_constant(node: ast.expr, relation: str, value: object, names: ConditionNames) -> Condition:
    """Return a comparison with a constant as a condition."""
    number = names.number(value) if is_plain(node) else None
    is_equality = relation in ("=", "<>")
    if isinstance(value, bool) and is_plain(node) and is_equality:
        return Bit(names.of(node), value == (relation == "="))
    is_number = isinstance(value, int | float)
    if number is None or not (is_number or is_equality):
        return UNKNOWN
    return Compare(names.of(node) + ("" if is_number else " as text"), relation, number, whole=False)


def _of_constants(one: ast.Constant, relation: str, other: ast.Constant) -> Condition:
    if type(one.value) is not type(other.value) or not isinstance(one.value, int | float | str):
        return UNKNOWN
    a, b = one.value, other.value
    results = {"=": a == b, "<>": a != b, "<": a < b, "<=": a <= b, ">": a > b, ">=": a >= b}  # type: ignore[operator]
    return FixedTruth(results[relation])


def constant_of(node: ast.expr) -> ast.Constant | None:
    """Return an expression as a constant, including negative numbers and members of enumerations."""
    match node:
        case ast.Constant():
            return node
        case ast.Attribute(value=ast.Name(id=kind), attr=name) if kind[0].isupper() and name.isupper():
            return ast.Constant(f"{kind}.{name}")
        case ast.UnaryOp(op=ast.USub(), operand=ast.Constant(value=int() | float() as value)):
            return ast.Constant(-value)
    return None
