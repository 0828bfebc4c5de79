"""Mistakes that show in one function of a Python program: its conditions, its lines, its numbers."""

from __future__ import annotations

import ast
from collections.abc import Sequence

from ..facts import Facts, FileLine
from ..logic import TRUE, UNKNOWN, AllOf, Condition, FixedTruth, all_of, always, leaves, negated, never
from .chance import is_chance
from .conditions import ConditionNames, condition
from .reader import Reader, UnknownError, functions_in
from .scopes import Scopes

Function = ast.FunctionDef | ast.AsyncFunctionDef

_LEAVES = (ast.Return, ast.Raise, ast.Break, ast.Continue)


class Flow:
    """Notes the mistakes of the functions in a text."""

    def __init__(self, reader: Reader, facts: Facts) -> None:
        self._reader, self._facts = reader, facts
        self._names = ConditionNames()

    def note(self) -> None:
        """Note them all."""
        for function, _ in functions_in(self._reader.tree):
            self._names.forget()
            self._body(function.body, TRUE)
        for statement in self._reader.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                continue  # no part of the logic
            for node in ast.walk(statement):
                if isinstance(node, ast.expr):
                    self._number(node)
                if isinstance(node, ast.Call) and is_chance(node, self._reader.names):
                    text = f"`{ast.unparse(node.func)}()`: two runs of the logic would differ"
                    self._remark("not-deterministic", node, text)
        Scopes(self._reader, self._facts).note()

    def _remark(self, rule: str, node: ast.AST, text: str) -> None:
        self._facts.remark(rule, FileLine(self._reader.file, getattr(node, "lineno", 1)), text)

    # --- conditions and lines

    def _body(self, body: Sequence[ast.stmt], reached: Condition) -> None:
        for at, each in enumerate(body):
            self._statement(each, reached)
            if at + 1 < len(body) and _never_ends(each):
                text = f"line {each.lineno} never goes on to this line"
                self._remark("unreachable", body[at + 1], text)
                return
            if isinstance(each, ast.If) and not each.orelse and _leaves(each.body):
                reached = _both(reached, negated(condition(each.test, self._names)))

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
                self._names.forget()
                self._body(orelse, TRUE)
            case ast.For(body=body, orelse=orelse) | ast.AsyncFor(body=body, orelse=orelse):
                self._names.forget()
                self._body(body, TRUE)
                self._names.forget()
                self._body(orelse, TRUE)
            case ast.With(body=body) | ast.AsyncWith(body=body):
                self._names.forget()
                self._body(body, TRUE)
            case ast.Try():
                for block in (node.body, *(each.body for each in node.handlers), node.orelse, node.finalbody):
                    self._names.forget()
                    self._body(block, TRUE)
            case ast.Match(cases=cases):
                for each in cases:
                    self._names.forget()
                    self._body(each.body, TRUE)
            case ast.FunctionDef() | ast.AsyncFunctionDef() | ast.ClassDef():
                return
            case _:
                self._expressions(node)
                self._names.forget()

    def _test(self, test: ast.expr, reached: Condition) -> Condition:
        """Note a test that never holds, or always does; return its condition."""
        own = condition(test, self._names)
        text = ast.unparse(test)
        if never(own):
            rule = "contradiction" if len(list(leaves(own))) > 1 else "constant-condition"
            self._remark(rule, test, f"`{text}` never holds")
        elif always(own):
            self._remark("constant-condition", test, f"`{text}` always holds")
        elif own != UNKNOWN and never(AllOf((reached, own))) and not never(reached):
            self._remark(
                "contradiction", test, f"`{text}` never holds here: the conditions before it exclude it"
            )
        else:
            self._expressions(test)
            return own
        return UNKNOWN

    def _expressions(self, node: ast.AST) -> None:
        """Note the conditions in the expressions of a statement, such as those of `until` and `and`."""
        outer: set[int] = set()
        for each in ast.walk(node):
            if id(each) in outer or not isinstance(each, ast.BoolOp | ast.IfExp | ast.Compare):
                continue
            tested = each.test if isinstance(each, ast.IfExp) else each
            own = condition(tested, self._names)
            outer |= {id(inner) for inner in ast.walk(each)}
            several = len(list(leaves(own))) > 1
            if own == UNKNOWN or (isinstance(own, FixedTruth) and not isinstance(each, ast.Compare)):
                continue
            text = ast.unparse(tested)
            if never(own):
                self._remark(
                    "contradiction" if several else "constant-condition", each, f"`{text}` never holds"
                )
            elif always(own):
                self._remark("constant-condition", each, f"`{text}` always holds")

    # --- numbers

    def _number(self, node: ast.expr) -> None:
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div | ast.FloorDiv | ast.Mod):
            try:
                divisor = self._reader.value(node.right)
            except UnknownError:
                return
            if (
                isinstance(node.op, ast.FloorDiv)
                and isinstance(divisor, int)
                and self._is_cut(node.left, divisor)
            ):
                self._remark("integer-zero", node, f"`{ast.unparse(node)}` is always 0")
            if isinstance(divisor, int | float) and divisor == 0:
                self._remark("division-by-zero", node, f"`{ast.unparse(node)}` divides by 0")

    def _is_cut(self, dividend: ast.expr, divisor: int) -> bool:
        """Whether a constant, or the rest of a division, is smaller than a divisor."""
        is_rest = isinstance(dividend, ast.BinOp) and isinstance(dividend.op, ast.Mod)
        most = dividend.right if is_rest and isinstance(dividend, ast.BinOp) else dividend
        try:
            found = self._reader.value(most)
        except UnknownError:
            return False
        is_literal = not isinstance(dividend, ast.Name | ast.Attribute)  # the thousands of a name may be 0
        return is_literal and isinstance(found, int) and 0 < found <= divisor - (not is_rest)


def _both(one: Condition, other: Condition) -> Condition:
    return other if one == TRUE else one if other in (TRUE, UNKNOWN) else all_of(one, other)


def _leaves(body: Sequence[ast.stmt]) -> bool:
    return bool(body) and (isinstance(body[-1], _LEAVES) or _never_ends(body[-1]))


def _never_ends(node: ast.stmt) -> bool:
    """Whether what follows a statement is never reached."""
    if isinstance(node, _LEAVES):
        return True
    if isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and node.test.value:
        return not any(_breaks(each) for each in node.body)
    if isinstance(node, ast.If):
        return bool(node.orelse) and _leaves(node.body) and _leaves(node.orelse)
    return False


def _breaks(node: ast.AST) -> bool:
    """Whether a statement leaves the loop that it is directly in."""
    if isinstance(node, ast.Break):
        return True
    if isinstance(node, ast.For | ast.While | ast.AsyncFor):
        return any(map(_breaks, node.orelse))
    if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef | ast.Lambda):
        return False
    return any(map(_breaks, ast.iter_child_nodes(node)))
