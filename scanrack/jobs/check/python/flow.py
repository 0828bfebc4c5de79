"""Mistakes within one function of a Python program: its conditions, lines and numbers."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from ..logic import TRUE, UNKNOWN, AllOf, Condition, FixedTruth, all_of, constant_condition, negated, never
from .chance import is_chance
from .conditions import ConditionNames, condition
from .nodes import bodies_of, nodes_in
from .reader import Reader, functions_in
from .scopes import Scopes

_LEAVES = (ast.Return, ast.Raise, ast.Break, ast.Continue)


class Flow:
    """Notes the mistakes of each function in a text."""

    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._names = ConditionNames()

    def note(self) -> None:
        """Note the mistakes of all functions."""
        for function, _ in functions_in(self._reader.tree):
            self._names.forget()
            self._body(function.body, TRUE)
        for statement in self._reader.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                continue  # not part of the logic
            for node in nodes_in(statement, ast.BinOp):
                self._number(node)
            for call in nodes_in(statement, ast.Call):
                if is_chance(call, self._reader.names):
                    text = f"`{ast.unparse(call.func)}()`: two runs of the logic would differ"
                    self._reader.remark("not-deterministic", call, text)
        Scopes(self._reader).note()

    # --- conditions and lines

    def _body(self, body: Sequence[ast.stmt], reached: Condition) -> None:
        for index, statement in enumerate(body):
            self._statement(statement, reached)
            if index + 1 < len(body) and _never_ends(statement):
                text = f"line {statement.lineno} never goes on to this line"
                self._reader.remark("unreachable", body[index + 1], text)
                return
            if isinstance(statement, ast.If) and not statement.orelse and _leaves(statement.body):
                reached = _both(reached, negated(condition(statement.test, self._names)))

    def _statement(self, node: ast.stmt, reached: Condition) -> None:
        match node:
            case ast.If(test, body, orelse):
                own = self._test(test, reached)
                turn = self._names.turn
                self._body(body, _both(reached, own))
                self._names.turn, after = turn, self._names.turn
                self._body(orelse, _both(reached, negated(own)))
                if after != turn:
                    self._names.forget()
            case ast.While(test, body, orelse):
                self._names.forget()
                if not isinstance(test, ast.Constant) or not test.value:
                    self._test(test, TRUE)
                self._body(body, TRUE)
                self._branches(orelse)
            case ast.For() | ast.AsyncFor() | ast.With() | ast.AsyncWith() | ast.Try() | ast.Match():
                self._branches(*bodies_of(node))
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                return
            case _:
                self._expressions(node)
                self._names.forget()

    def _branches(self, *bodies: Sequence[ast.stmt]) -> None:
        """Note mistakes in the given bodies of a statement; before each body, any value may have changed."""
        for body in bodies:
            self._names.forget()
            self._body(body, TRUE)

    def _test(self, test: ast.expr, reached: Condition) -> Condition:
        """Note a test that always or never holds; return its condition."""
        own = condition(test, self._names)
        remark = constant_condition(own)
        if remark is None and own != UNKNOWN and never(AllOf((reached, own))) and not never(reached):
            remark = "contradiction", "never holds here: the conditions before it exclude it"
        if remark is None:
            self._expressions(test)
            return own
        rule, says = remark
        self._reader.remark(rule, test, f"`{ast.unparse(test)}` {says}")
        return UNKNOWN

    def _expressions(self, node: ast.AST) -> None:
        """Note mistakes in conditions in a statement's expressions, such as those of `until` and `and`."""
        outer: set[int] = set()
        for expression in nodes_in(node, ast.BoolOp, ast.IfExp, ast.Compare):
            if id(expression) in outer:
                continue
            outer |= {id(inner) for inner in ast.walk(expression)}
            tested = expression.test if isinstance(expression, ast.IfExp) else expression
            own = condition(tested, self._names)
            is_literal = isinstance(own, FixedTruth) and not isinstance(expression, ast.Compare)
            remark = None if own == UNKNOWN or is_literal else constant_condition(own)
            if remark is not None:
                self._reader.remark(remark[0], expression, f"`{ast.unparse(tested)}` {remark[1]}")

    # --- numbers

    def _number(self, node: ast.BinOp) -> None:
        """Note a division by 0, or one that always gives 0."""
        is_division = isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod)
        divisor = self._reader.number(node.right) if is_division else None
        is_whole = isinstance(node.op, ast.FloorDiv) and isinstance(divisor, int)
        if is_whole and self._is_cut(node.left, int(divisor or 0)):
            self._reader.remark("integer-zero", node, f"`{ast.unparse(node)}` is always 0")
        if divisor == 0:
            self._reader.remark("division-by-zero", node, f"`{ast.unparse(node)}` divides by 0")

    def _is_cut(self, dividend: ast.expr, divisor: int) -> bool:
        """Whether the dividend, a constant or a remainder, is smaller than the divisor."""
        is_rest = isinstance(dividend, ast.BinOp) and isinstance(dividend.op, ast.Mod)
        most = dividend.right if is_rest and isinstance(dividend, ast.BinOp) else dividend
        divided = self._reader.number(most)
        is_literal = not isinstance(dividend, ast.Name | ast.Attribute)  # a named value may be small
        return is_literal and isinstance(divided, int) and 0 < divided <= divisor - (not is_rest)


def _both(one: Condition, other: Condition) -> Condition:
    return other if one == TRUE else one if other in (TRUE, UNKNOWN) else all_of(one, other)


def _leaves(body: Sequence[ast.stmt]) -> bool:
    return bool(body) and (isinstance(body[-1], _LEAVES) or _never_ends(body[-1]))


def _never_ends(node: ast.stmt) -> bool:
    """Whether the code after a statement is never reached."""
    if isinstance(node, _LEAVES):
        return True
    if isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and node.test.value:
        return not any(_breaks(statement) for statement in node.body)
    if isinstance(node, ast.If):
        return bool(node.orelse) and _leaves(node.body) and _leaves(node.orelse)
    return False


def _breaks(node: ast.AST) -> bool:
    """Whether a statement leaves its innermost loop."""
    if isinstance(node, ast.Break):
        return True
    if isinstance(node, ast.For | ast.While | ast.AsyncFor):
        return any(map(_breaks, node.orelse))
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda):
        return False
    return any(map(_breaks, ast.iter_child_nodes(node)))
