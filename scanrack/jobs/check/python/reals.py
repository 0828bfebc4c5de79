"""Calculated fractions that a text compares for equality: `self.total == 0.3` after `self.total += 0.1`.

Copies, constants and whole numbers are exact; 0 may be asked of a divisor, and `!= 0` of anything.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from ..facts import Facts, FileLine
from .conditions import constant_of
from .reader import Function, Reader, functions_in

DEPTH = 6


def note_reals(reader: Reader, facts: Facts) -> None:
    """Note the comparisons of a calculated fraction for equality."""
    reals = _PythonReals(reader.tree)
    for function, _ in functions_in(reader.tree):
        for node in ast.walk(function):
            if isinstance(node, ast.Compare) and len(node.ops) == 1:
                one, op, other = node.left, node.ops[0], node.comparators[0]
                if isinstance(op, ast.Eq | ast.NotEq) and reals.differ(one, other, function, op):
                    says = "hardly ever equals" if isinstance(op, ast.Eq) else "nearly always differs from"
                    text = f"`{ast.unparse(node)}`: a calculated fraction {says} another number"
                    facts.remark("real-equality", FileLine(reader.file, node.lineno), text)


class _PythonReals:
    def __init__(self, tree: ast.Module) -> None:
        self._tree = tree
        self._attributes = dict(_assigned(tree))
        self._divisors = {
            ast.unparse(node.right)
            for node in ast.walk(tree)
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod)
        }

    def differ(self, one: ast.expr, other: ast.expr, function: Function, op: ast.cmpop) -> bool:
        """Whether one of two values is a calculated fraction that is not exact."""
        sides = (one, other)
        constants = [constant_of(each) for each in sides]
        if any(each is not None and not isinstance(each.value, int | float) for each in constants):
            return False
        if any(each is not None and not each.value for each in constants) and (
            isinstance(op, ast.NotEq) or any(ast.unparse(each) in self._divisors for each in sides)
        ):
            return False
        local = dict(_assigned(function))
        copies = [
            ast.unparse(each) == ast.unparse(source)
            for copy, each in ((one, other), (other, one))
            for source in (*local.get(ast.unparse(copy), ()), *self._attributes.get(ast.unparse(copy), ()))
        ]
        return not any(copies) and any(self._is_calculated(each, local, DEPTH) for each in sides)

    def _is_calculated(self, node: ast.expr, local: dict[str, list[ast.expr]], depth: int) -> bool:
        """Whether an expression has a division, or a fraction in its arithmetic."""
        if isinstance(node, ast.BinOp):
            if isinstance(node.op, ast.Div):
                return True
            sides = (node.left, node.right)
            if not isinstance(node.op, ast.Add | ast.Sub | ast.Mult):
                return False
            return any(_is_fraction(each) or self._is_calculated(each, local, depth) for each in sides)
        if isinstance(node, ast.UnaryOp):
            return self._is_calculated(node.operand, local, depth)
        if not isinstance(node, ast.Name | ast.Attribute) or depth == 0:
            return False
        found = local if isinstance(node, ast.Name) else self._attributes
        return any(self._is_calculated(each, local, depth - 1) for each in found.get(ast.unparse(node), ()))


def _assigned(tree: ast.AST) -> Iterator[tuple[str, list[ast.expr]]]:
    """Yield the targets of a text with all that it assigns to them."""
    found: dict[str, list[ast.expr]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            for target in node.targets:
                found.setdefault(ast.unparse(target), []).append(node.value)
        elif isinstance(node, ast.AnnAssign) and node.value is not None:
            found.setdefault(ast.unparse(node.target), []).append(node.value)
        elif isinstance(node, ast.AugAssign):
            value = ast.BinOp(node.target, node.op, node.value)
            found.setdefault(ast.unparse(node.target), []).append(value)
    yield from found.items()


def _is_fraction(node: ast.expr) -> bool:
    found = constant_of(node)
    return found is not None and isinstance(found.value, float) and found.value != int(found.value)
