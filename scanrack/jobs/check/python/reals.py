"""Equality comparisons of calculated fractions, such as `self.total == 0.3` after `self.total += 0.1`.

Copies, constants and whole numbers are exact. A divisor may be compared with 0, and `!= 0` is always fine.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

from .conditions import constant_of
from .nodes import Function, assignments_in, nodes_in
from .reader import Reader, functions_in

DEPTH = 6


def note_reals(reader: Reader) -> None:
    """Note the equality comparisons of a calculated fraction."""
    reals = _PythonReals(reader.tree)
    for function, _ in functions_in(reader.tree):
        for node in nodes_in(function, ast.Compare):
            is_equality = len(node.ops) == 1 and isinstance(node.ops[0], ast.Eq | ast.NotEq)
            if is_equality and reals.is_inexact(node, function):
                is_equal = isinstance(node.ops[0], ast.Eq)
                relation = "hardly ever equals" if is_equal else "nearly always differs from"
                text = f"`{ast.unparse(node)}`: a calculated fraction {relation} another number"
                reader.remark("real-equality", node, text)


class _PythonReals:
    """Finds comparisons of calculated fractions in a text."""

    def __init__(self, tree: ast.Module) -> None:
        """Collect the values assigned to each target, and the expressions that the text divides by."""
        self._attributes = _assigned(tree)
        self._divisors = {
            ast.unparse(node.right)
            for node in nodes_in(tree, ast.BinOp)
            if isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod)
        }

    def is_inexact(self, node: ast.Compare, function: Function) -> bool:
        """Whether one of the compared values is a calculated fraction, which is not exact."""
        left, right = sides = (node.left, node.comparators[0])
        if self._is_exact(sides, node.ops[0]):
            return False
        local = _assigned(function)
        copies = self._copies(left, right, local) or self._copies(right, left, local)
        return not copies and any(self._is_calculated(side, local, DEPTH) for side in sides)

    def _is_exact(self, sides: Sequence[ast.expr], op: ast.cmpop) -> bool:
        """Whether a compared constant is not a number, or is a 0 that may be compared for equality."""
        constants = [constant.value for constant in map(constant_of, sides) if constant is not None]
        if not all(isinstance(constant, int | float) for constant in constants):
            return True
        may_be_zero = isinstance(op, ast.NotEq) or any(ast.unparse(side) in self._divisors for side in sides)
        return may_be_zero and not all(constants)

    def _copies(self, copy: ast.expr, source: ast.expr, local: Mapping[str, list[ast.expr]]) -> bool:
        """Whether one value is assigned from the other."""
        name = ast.unparse(copy)
        values = (*local.get(name, ()), *self._attributes.get(name, ()))
        return ast.unparse(source) in map(ast.unparse, values)

    def _is_calculated(self, node: ast.expr, local: Mapping[str, list[ast.expr]], depth: int) -> bool:
        """Whether an expression contains a division, or a fraction in its arithmetic."""
        match node:
            case ast.BinOp(op=ast.Div()):
                return True
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult(), right=right):
                sides = (left, right)
                return any(_is_fraction(side) or self._is_calculated(side, local, depth) for side in sides)
            case ast.UnaryOp(operand=operand):
                return self._is_calculated(operand, local, depth)
            case ast.Name() | ast.Attribute() if depth:
                assignments = local if isinstance(node, ast.Name) else self._attributes
                values = assignments.get(ast.unparse(node), ())
                return any(self._is_calculated(value, local, depth - 1) for value in values)
        return False


def _assigned(tree: ast.AST) -> dict[str, list[ast.expr]]:
    """Return all values that a text assigns to each target; for `x += 1`, the sum."""
    assignments: dict[str, list[ast.expr]] = {}
    for node in nodes_in(tree, ast.Assign, ast.AnnAssign, ast.AugAssign):
        if isinstance(node, ast.AugAssign):
            value = ast.BinOp(node.target, node.op, node.value)
            assignments.setdefault(ast.unparse(node.target), []).append(value)
        for target, assigned in assignments_in([node]):
            assignments.setdefault(ast.unparse(target), []).append(assigned)
    return assignments


def _is_fraction(node: ast.expr) -> bool:
    constant = constant_of(node)
    return (
        constant is not None and isinstance(constant.value, float) and constant.value != int(constant.value)
    )
