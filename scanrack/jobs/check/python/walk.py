"""The statements of a Python program in order of execution, each with the condition under which it acts.

if self.step == "feed" and ready:          `ready` means what was assigned to it before
    self.step = "cut"
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from ..logic import TRUE, AllOf, AnyOf, Condition, all_of, negated
from .conditions import ConditionNames, condition
from .expression_options import Options
from .local_names import LocalNames
from .nodes import Function, nodes_in
from .reader import Reader, UnknownError, functions_in

LOOP_PASSES = 16
"""Maximum number of loop passes that are followed one by one."""


@dataclass(frozen=True, slots=True)
class WalkPlace:
    """The conditions of a statement.

    Attributes:
        entry: the function at which the walk has started.
        when: the condition as the text has it.
        reached: the same without the parts that always hold.
        free: the same in terms of inputs and fields.
        depth: how many more calls are followed.
    """

    entry: str
    when: Condition = TRUE
    reached: Condition = TRUE
    free: Condition = TRUE
    depth: int = 4

    def inside(self, own: Condition, free: Condition) -> WalkPlace:
        """Return the place inside a condition."""
        when, reached = AllOf((self.when, own)), all_of(self.reached, own)
        return replace(self, when=when, reached=reached, free=AllOf((self.free, free)))

    def outside(self, own: Condition, free: Condition) -> WalkPlace:
        """Return the place where a condition does not hold."""
        return self.inside(negated(own), negated(free))


Statement = tuple[ast.Assign | ast.AugAssign | ast.Call, WalkPlace]
"""A statement that ends the walk's way through functions and conditions, with its place."""


class Walk:
    """Walks over the functions that no other function calls, and into those that they call.

    Attributes:
        function: the function that the walk has reached.
        local: the meaning of its local names there.
        options: the possible values of expressions.
        names: names of values in conditions.
    """

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        self.functions = {function.name: function for function, _ in functions_in(reader.tree)}
        self.names = ConditionNames()
        self.options = Options(reader, self.functions, self.values)
        self.local = LocalNames(self.options)
        self.function: Function

    @cached_property
    def values(self) -> Mapping[str, list[ast.expr]]:
        """The values that the text assigns, by target."""
        assigned: dict[str, list[ast.expr]] = {}
        for node in nodes_in(self.reader.tree, ast.Assign, ast.AugAssign):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    assigned.setdefault(ast.unparse(target), []).append(node.value)
            else:
                assigned.setdefault(ast.unparse(node.target), []).append(node)  # type: ignore[arg-type]  # no constant
        return assigned

    def statements(self) -> Iterator[Statement]:
        """Yield the assignments, and the calls of methods and functions from elsewhere."""
        callees = set(map(callee_of, nodes_in(self.reader.tree, ast.Call)))
        for name, function in self.functions.items():
            if name not in callees:
                self.local.begin()
                self.function = function
                yield from self._body(function.body, WalkPlace(name))

    def _body(self, body: Sequence[ast.stmt], place: WalkPlace) -> Iterator[Statement]:
        for node in body:
            yield from self._statement(node, place)
            if isinstance(node, ast.If) and not node.orelse and isinstance(node.body[-1], ast.Return):
                place = place.outside(condition(node.test, self.names), self.free(node.test))

    def _statement(self, node: ast.stmt, place: WalkPlace) -> Iterator[Statement]:
        match node:
            case ast.If():
                yield from self._if(node, place)
            case ast.Match(subject=subject, cases=cases):
                for case in cases:
                    before = self.local.copy()
                    yield from self._body(case.body, place.inside(self._chosen(subject, case), TRUE))
                    self.local.swap(before)
            case ast.For(target=target, iter=iterable, body=body):
                for value in self._passes(iterable):
                    self.local.bind(target, value)
                    yield from self._body(body, place)
            case ast.While(body=body) | ast.With(body=body) | ast.Try(body=body):
                yield from self._body(body, place)
            case ast.Assign() | ast.AugAssign():
                yield node, place
            case ast.Expr(value=ast.Call() as call):
                yield from self._called(call, place)

    def _if(self, node: ast.If, place: WalkPlace) -> Iterator[Statement]:
        own, free = condition(node.test, self.names), self.free(node.test)
        before = self.local.copy()
        yield from self._body(node.body, place.inside(own, free))
        after = self.local.swap(before)
        yield from self._body(node.orelse, place.outside(own, free))
        self.local.join(after, node.test)

    def _chosen(self, subject: ast.expr, case: ast.match_case) -> Condition:
        """Return the condition under which a case is chosen."""
        patterns = case.pattern.patterns if isinstance(case.pattern, ast.MatchOr) else [case.pattern]
        parts: list[Condition] = [
            condition(ast.Compare(subject, [ast.Eq()], [pattern.value]), self.names)
            for pattern in patterns
            if isinstance(pattern, ast.MatchValue)
        ]
        guard = TRUE if case.guard is None else condition(case.guard, self.names)
        return AllOf((AnyOf(tuple(parts)), guard)) if len(parts) == len(patterns) else guard

    def _passes(self, iterable: ast.expr) -> Sequence[ast.expr | None]:
        """Return the value of the loop variable in each pass; a single None if it is unknown."""
        closed = self.local.closed(iterable)
        try:
            options = self.options.of(closed, {}).options
        except UnknownError:
            return [None]
        rows = options[0] if len(options) == 1 and isinstance(options[0], tuple | list) else ()
        if not 0 < len(rows) <= LOOP_PASSES:
            return [None]
        return [ast.Subscript(closed, ast.Constant(index), ast.Load()) for index in range(len(rows))]

    def _called(self, call: ast.Call, place: WalkPlace) -> Iterator[Statement]:
        inner = self.functions.get(callee_of(call))
        if inner is None or not place.depth:
            yield call, place
            return
        outer, caller = self.local.enter(inner, call), self.function
        self.function = inner
        yield from self._body(inner.body, replace(place, depth=place.depth - 1))
        self.function = caller
        self.local.swap(outer)

    def free(self, test: ast.expr) -> Condition:
        """Return an expression as a condition on inputs and fields."""
        return condition(self.local.inputs(test), ConditionNames())


def callee_of(call: ast.Call) -> str:
    """Return the name of a called function, without the object it belongs to."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else ast.unparse(call.func)
