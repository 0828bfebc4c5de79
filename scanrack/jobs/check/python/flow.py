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
                self._note_division(node)
            for call in nodes_in(statement, ast.Call):
                if is_chance(call, self._reader.names):
                    text = f"`{ast.unparse(call.func)}()`: two runs of the logic would differ"
                    self._reader.remark("not-deterministic", call, text)
        Scopes(self._reader).note()

    # --- conditions and lines

    def _body(self, body: Sequence[ast.stmt], reached: Condition) -> None:
        """Note the mistakes in statements reached under a condition, and the first unreachable one."""
        for index, statement in enumerate(body):
            self._statement(statement, reached)
            if index + 1 < len(body) and _never_ends(statement):
                text = f"line {statement.lineno} never continues to this line"
                self._reader.remark("unreachable", body[index + 1], text)
                return
            if isinstance(statement, ast.If) and not statement.orelse and _leaves(statement.body):
                reached = _both(reached, negated(condition(statement.test, self._names)))

    def _statement(self, node: ast.stmt, reached: Condition) -> None:
        """Note the mistakes in a statement and its bodies.

        Values receive new names where they may have changed.
        """
        match node:
            case ast.If(test, body, orelse):
                tested = self._test(test, reached)
                turn = self._names.turn
                self._body(body, _both(reached, tested))
                is_changed = self._names.turn != turn
                self._names.turn = turn  # the second arm starts with the same values as the first
                self._body(orelse, _both(reached, negated(tested)))
                if is_changed:
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
        """Note mistakes in the bodies of a statement. Any value may have changed before each body."""
        for body in bodies:
            self._names.forget()
            self._body(body, TRUE)

    def _test(self, test: ast.expr, reached: Condition) -> Condition:
        """Note a test that is always or never true; return its condition, or UNKNOWN after a note."""
        tested = condition(test, self._names)
        remark = constant_condition(tested)
        if remark is None and tested != UNKNOWN and never(AllOf((reached, tested))) and not never(reached):
            remark = "contradiction", "never holds here: the conditions before it exclude it"
        if remark is None:
            self._expressions(test)
            return tested
        rule, problem = remark
        self._reader.remark(rule, test, f"`{ast.unparse(test)}` {problem}")
        return UNKNOWN

    def _expressions(self, node: ast.AST) -> None:
        """Note conditions in a statement's expressions, as in `until`, that are always or never true."""
        inner_ids: set[int] = set()  # parts of expressions that are already checked
        for expression in nodes_in(node, ast.BoolOp, ast.IfExp, ast.Compare):
            if id(expression) in inner_ids:
                continue
            inner_ids |= {id(inner) for inner in ast.walk(expression)}
            test = expression.test if isinstance(expression, ast.IfExp) else expression
            tested = condition(test, self._names)
            is_literal = isinstance(tested, FixedTruth) and not isinstance(expression, ast.Compare)
            remark = None if tested == UNKNOWN or is_literal else constant_condition(tested)
            if remark is not None:
                rule, problem = remark
                self._reader.remark(rule, expression, f"`{ast.unparse(test)}` {problem}")

    # --- numbers

    def _note_division(self, node: ast.BinOp) -> None:
        """Note a division by 0, or a division that always results in 0."""
        if not isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod):
            return
        divisor = self._reader.number(node.right)
        is_whole = isinstance(node.op, ast.FloorDiv) and isinstance(divisor, int)
        if is_whole and self._is_smaller(node.left, int(divisor or 0)):
            self._reader.remark("integer-zero", node, f"`{ast.unparse(node)}` is always 0")
        if divisor == 0:
            self._reader.remark("division-by-zero", node, f"`{ast.unparse(node)}` divides by 0")

    def _is_smaller(self, dividend: ast.expr, divisor: int) -> bool:
        """Whether the dividend, a literal or a remainder, is smaller than the divisor."""
        match dividend:
            case ast.Name() | ast.Attribute():
                return False  # a named value may be small on purpose
            case ast.BinOp(op=ast.Mod(), right=modulus):
                number = self._reader.number(modulus)
                return isinstance(number, int) and 0 < number <= divisor
        number = self._reader.number(dividend)
        return isinstance(number, int) and 0 < number < divisor


def _both(reached: Condition, condition: Condition) -> Condition:
    """Return the condition that both are true; omit an unknown second condition."""
    if reached == TRUE:
        return condition
    return reached if condition in (TRUE, UNKNOWN) else all_of(reached, condition)


def _leaves(body: Sequence[ast.stmt]) -> bool:
    return bool(body) and (isinstance(body[-1], _LEAVES) or _never_ends(body[-1]))


def _never_ends(node: ast.stmt) -> bool:
    """Whether the code after a statement is unreachable."""
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
