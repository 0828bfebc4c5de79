"""Conditions in a Python program text.

A name keeps its value until the next wait or assignment. Then `ConditionNames.forget` renames all values.
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
"""Number assigned to the first text. Later texts get lower numbers, which no program uses as steps."""


class ConditionNames:
    """Names the values of expressions in conditions; equal names stand for equal values.

    Attributes:
        turn: number of the current period in which no value changes.
    """

    def __init__(self) -> None:
        self.turn = self._last_turn = 0
        self._texts: dict[object, int] = {}

    def forget(self) -> None:
        """Give every value a new name from now on."""
        self._last_turn += 1
        self.turn = self._last_turn

    def name_of(self, node: ast.expr) -> str:
        """Return the name of an expression's value."""
        return f"{ast.unparse(node)}#{self.turn}"

    def number(self, value: object) -> float | None:
        """Return a number for a constant (equal constants share a number), or None for None."""
        if isinstance(value, int | float):
            return value
        return None if value is None else self._texts.setdefault(value, TEXTS - len(self._texts))


def is_plain(node: ast.expr) -> bool:
    """Whether an expression is a name, or an attribute of one, so that reading it runs no code."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name)


def condition(node: ast.expr, names: ConditionNames) -> Condition:
    """Return an expression as a condition; a name becomes a bit, and unreadable parts are unknown."""
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
                _comparison(sides[index], op, sides[index + 1], names) for index, op in enumerate(ops)
            )
            return parts[0] if len(parts) == 1 else AllOf(parts)
    return Bit(names.name_of(node)) if is_plain(node) else UNKNOWN


def _comparison(left: ast.expr, op: ast.cmpop, right: ast.expr, names: ConditionNames) -> Condition:
    """Return a comparison of two expressions as a condition."""
    relation = RELATIONS.get(type(op))
    left_constant, right_constant = constant_of(left), constant_of(right)
    if relation is None:
        return UNKNOWN
    if left_constant is not None and right_constant is not None:
        return _constant_comparison(left_constant, relation, right_constant)
    if left_constant is not None:
        return _with_constant(right, MIRRORED[relation], left_constant.value, names)
    if right_constant is not None:
        return _with_constant(left, relation, right_constant.value, names)
    is_same = is_plain(left) and ast.unparse(left) == ast.unparse(right)
    return FixedTruth(relation in ("=", "<=", ">=")) if is_same else UNKNOWN


def _with_constant(node: ast.expr, relation: str, value: object, names: ConditionNames) -> Condition:
    """Return a comparison with a constant as a condition."""
    number = names.number(value) if is_plain(node) else None
    is_equality = relation in ("=", "<>")
    if isinstance(value, bool) and is_plain(node) and is_equality:
        return Bit(names.name_of(node), value == (relation == "="))
    is_number = isinstance(value, int | float)
    if number is None or not (is_number or is_equality):
        return UNKNOWN
    return Compare(names.name_of(node) + ("" if is_number else " as text"), relation, number, whole=False)


def _constant_comparison(left: ast.Constant, relation: str, right: ast.Constant) -> Condition:
    """Return the result of comparing two constants; unknown if their types differ."""
    a, b = left.value, right.value
    if type(a) is not type(b) or not isinstance(a, int | float | str):
        return UNKNOWN
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
