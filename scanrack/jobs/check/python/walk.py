"""The statements of a Python program in order of execution, each with its condition.

if self.step == "feed" and ready:          `ready` has the value last assigned to it
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
        entry: the function in which the walk started.
        when: the condition as written.
        reached: the condition without the parts that are always true.
        free: the condition in terms of inputs and fields.
        depth: number of additional nested calls to follow.
    """

    entry: str
    when: Condition = TRUE
    reached: Condition = TRUE
    free: Condition = TRUE
    depth: int = 4

    def inside(self, tested: Condition, free: Condition) -> WalkPlace:
        """Return the place where a condition is true."""
        when, reached = AllOf((self.when, tested)), all_of(self.reached, tested)
        return replace(self, when=when, reached=reached, free=AllOf((self.free, free)))

    def outside(self, tested: Condition, free: Condition) -> WalkPlace:
        """Return the place where a condition is false."""
        return self.inside(negated(tested), negated(free))


Statement = tuple[ast.Assign | ast.AugAssign | ast.Call, WalkPlace]
"""An assignment, or a call that is not followed, with its place."""


class Walk:
    """Walks over the functions that no other function calls, and into the functions that they call.

    Attributes:
        function: the function that the walk has reached.
        local: the meaning of its local names at the current statement.
        options: the possible values of expressions.
        names: names of values in conditions.
    """

    def __init__(self, reader: Reader) -> None:
        self.reader = reader
        self.functions = {function.name: function for function, _ in functions_in(reader.tree)}
        self.names = ConditionNames()
        self.options = Options(reader, self.functions, self.values)
        self.local = LocalNames(self.options)
        self.function: Function  # set by `statements`

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
        """Yield the assignments and calls of a statement and its bodies.

        Each case starts with the same names.
        """
        match node:
            case ast.If():
                yield from self._if(node, place)
            case ast.Match(subject=subject, cases=cases):
                for case in cases:
                    names_before = self.local.copy()
                    yield from self._body(case.body, place.inside(self._case(subject, case), TRUE))
                    self.local.swap(names_before)
            case ast.For(target=target, iter=iterable, body=body):
                for value in self._passes(iterable):
                    self.local.bind(target, value)
                    yield from self._body(body, place)
            case ast.While(body=body) | ast.With(body=body) | ast.Try(body=body):
                yield from self._body(body, place)
            case ast.Assign() | ast.AugAssign():
                yield node, place
            case ast.Expr(value=ast.Call() as call):
                yield from self._call(call, place)

    def _if(self, node: ast.If, place: WalkPlace) -> Iterator[Statement]:
        """Yield the statements of both arms. A local name may have either arm's value afterwards."""
        tested, free = condition(node.test, self.names), self.free(node.test)
        names_before = self.local.copy()
        yield from self._body(node.body, place.inside(tested, free))
        names_after_body = self.local.swap(names_before)
        yield from self._body(node.orelse, place.outside(tested, free))
        self.local.join(names_after_body, node.test)

    def _case(self, subject: ast.expr, case: ast.match_case) -> Condition:
        """Return the condition that selects a case."""
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
            options = self.options.evaluate(closed, {}).options
        except UnknownError:
            return [None]
        rows = options[0] if len(options) == 1 and isinstance(options[0], tuple | list) else ()
        if not 0 < len(rows) <= LOOP_PASSES:
            return [None]
        return [ast.Subscript(closed, ast.Constant(index), ast.Load()) for index in range(len(rows))]

    def _call(self, call: ast.Call, place: WalkPlace) -> Iterator[Statement]:
        """Yield the statements of a called function; for a function from elsewhere, yield the call."""
        called = self.functions.get(callee_of(call))
        if called is None or not place.depth:
            yield call, place
            return
        caller, caller_names = self.function, self.local.enter(called, call)
        self.function = called
        yield from self._body(called.body, replace(place, depth=place.depth - 1))
        self.function = caller
        self.local.swap(caller_names)

    def free(self, test: ast.expr) -> Condition:
        """Return an expression as a condition on inputs and fields."""
        return condition(self.local.inputs(test), ConditionNames())


def callee_of(call: ast.Call) -> str:
    """Return the name of a called function, without the object it belongs to."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else ast.unparse(call.func)
