"""Fields, inputs and outputs of a `Logic` class, and the code that reads and writes them."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scanrack.ladder.python.sequences import Input, InputWord, Logic, Output, OutputWord, parts_of
from scanrack.ladder.python.sequences.blocks import Block
from scanrack.ladder.python.sequences.logic import fields_of

from ..facts import Access, FileLine, OutputWrite, Role, Touch, Variable
from ..logic import INPUT, TRUE, AllOf, Bit, Condition, all_of, base_of, needed, negated, with_leaves
from ..written import declaration_lines, place_at
from .conditions import ConditionNames, condition
from .nodes import Function, bodies_of, field_of, is_loaded, nodes_in, targets_of
from .reader import Reader

DEPTH = 4
"""Maximum depth of helpers that are followed."""

ROLES = ((Output, Role.OUTPUT), (OutputWord, Role.OUTPUT), (Input, Role.INPUT), (InputWord, Role.INPUT))


def variables_of(logic: Logic, path: Path, is_recorded: Callable[[str], bool]) -> Iterator[Variable]:
    """Yield the fields and terminals of an instance."""
    lines = declaration_lines(path)
    for part in parts_of(logic):
        role = next((role for kind, role in ROLES if isinstance(part, kind)), None)
        if role is not None:
            yield Variable(part.name, place_at(part.declared, path), role, "bool", set=True)
    for name, value in fields_of(logic).items():
        is_set = not isinstance(value, bool) or value
        is_number = not isinstance(value, bool)
        place = FileLine(str(path), lines(name))
        yield Variable(name, place, Role.PLAIN, type(value).__name__, is_set, is_recorded(name) or is_number)


@dataclass(frozen=True, slots=True)
class _Place:
    """The conditions under which a statement runs.

    Attributes:
        reached: the tests around the statement.
        once: whether the statement runs only once.
        top: whether every run of the method reaches the statement.
    """

    reached: Condition = TRUE
    once: bool = False
    top: bool = False


class Accesses:
    """The accesses of a method to fields and terminals.

    Args:
        owners: the sequences that reach each method; "" is `every_scan`.
    """

    def __init__(
        self, reader: Reader, function: Function, owners: Mapping[str, set[str]], sequences: Sequence[str]
    ) -> None:
        self._reader, self._facts, self._function = reader, reader.facts, function
        self._owners = sorted(owners.get(function.name, {""}))
        self._starts_once = function.name == "__init__" or function.name in sequences
        self._names = ConditionNames()

    def note(self) -> None:
        """Note the accesses."""
        self._body(self._function.body, _Place(once=self._starts_once, top=True))

    def _body(self, body: Sequence[ast.stmt], place: _Place) -> None:
        for node in body:
            self._statement(node, place)
            if isinstance(node, ast.If) and not node.orelse and isinstance(node.body[-1], ast.Return):
                place = replace(place, top=False)

    def _statement(self, node: ast.stmt, place: _Place) -> None:
        """Note the accesses of a statement and its bodies.

        The conditions around a `while` do not count inside it.
        """
        inner = replace(place, top=False)
        match node:
            case ast.If(test=test):
                self._reads(test)
                tested = condition(test, self._names)
                self._body(node.body, replace(inner, reached=all_of(place.reached, tested)))
                self._body(node.orelse, replace(inner, reached=all_of(place.reached, negated(tested))))
            case ast.While(test=test):
                self._reads(test)
                self._bodies(node, _Place())
            case ast.For(iter=iterable) | ast.AsyncFor(iter=iterable):
                self._reads(iterable)
                self._bodies(node, replace(inner, once=False))
            case ast.With(items=items) | ast.AsyncWith(items=items):
                for item in items:
                    self._reads(item.context_expr)
                self._bodies(node, inner)
            case ast.Try():
                self._bodies(node, inner)
            case ast.Match(subject=subject):
                self._reads(subject)
                self._bodies(node, inner)
            case _:
                self._simple(node, place)

    def _bodies(self, node: ast.stmt, inner: _Place) -> None:
        for body in bodies_of(node):
            self._body(body, inner)

    def _simple(self, node: ast.stmt, place: _Place) -> None:
        """Note the accesses of a statement without bodies. Values receive new names afterwards."""
        self._reads(node)
        if isinstance(node, ast.AugAssign):
            self._write(node.target, Touch.BOTH, replace(place, top=False))
        declared = [node.target] if isinstance(node, ast.AnnAssign) else []
        value = node.value if isinstance(node, ast.Assign | ast.AnnAssign) else None
        for target in targets_of(node) or declared:
            for element in target.elts if isinstance(target, ast.Tuple | ast.List) else [target]:
                self._write(element, Touch.WRITE if element is not target else _use(value), place, value)
        self._names.forget()

    def _reads(self, node: ast.AST) -> None:
        for attribute in nodes_in(node, ast.Attribute):
            name = field_of(attribute)
            if name in self._facts.variables and is_loaded(attribute):
                self._add(Access(name, "", Touch.READ, self._reader.place(attribute)))

    def _write(self, target: ast.expr, use: Touch, place: _Place, value: ast.expr | None = None) -> None:
        """Note a write to a field or terminal; ignore other targets.

        In `every_scan`, also note the condition that switches an output on, and count a write that every
        run reaches as a default (COIL).
        """
        name = field_of(target)
        if name not in self._facts.variables:
            return
        needs = frozenset(Bit(bit.name.replace("self.", "", 1), bit.on) for bit in needed(place.reached))
        is_every_scan = self._function.name == "every_scan"
        is_default = place.top and is_every_scan and use is not Touch.BOTH
        use, line = Touch.COIL if is_default else use, self._reader.place(target)
        self._add(Access(name, "", use, line, needs=needs, once=place.once, default=is_default))
        if is_every_scan:
            self._switched(name, line, place.reached, value)

    def _switched(self, name: str, place: FileLine, reached: Condition, value: ast.expr | None) -> None:
        """Note the condition that switches an output on."""
        is_off = isinstance(value, ast.Constant) and not value.value
        if value is None or is_off or self._facts.variables[name].role is not Role.OUTPUT:
            return
        free = self._with_plain_names(AllOf((reached, condition(_unwrapped(value), self._names))))
        self._facts.outputs.append(OutputWrite(place, name, name, free))

    def _with_plain_names(self, power: Condition) -> Condition:
        """Return a condition with the prefix `INPUT` on inputs, and without turn suffixes."""

        def renamed(leaf: Condition) -> Condition:
            """Return a bit under its plain name; any other leaf unchanged."""
            if not isinstance(leaf, Bit):
                return leaf
            name = base_of(leaf.name).removeprefix("self.")
            variable = self._facts.variables.get(name)
            is_input = variable is not None and variable.role is Role.INPUT
            return Bit(f"{INPUT}{name}" if is_input else name, leaf.on)

        return with_leaves(power, renamed)

    def _add(self, access: Access) -> None:
        for owner in self._owners:
            self._facts.accesses.append(replace(access, unit=self._function.name, owner=owner))


def _use(value: ast.expr | None) -> Touch:
    if isinstance(value, ast.Constant) and isinstance(value.value, bool):
        return Touch.LATCH if value.value else Touch.UNLATCH
    return Touch.WRITE


def _unwrapped(value: ast.expr) -> ast.expr:
    """Return the argument of `bool(...)`; any other expression unchanged."""
    is_bool = isinstance(value, ast.Call) and ast.unparse(value.func) == "bool" and len(value.args) == 1
    return value.args[0] if is_bool and isinstance(value, ast.Call) else value


def called_twice(
    function: Function, blocks: Mapping[str, Block], methods: Mapping[str, Function]
) -> Iterator[tuple[ast.Call, str]]:
    """Yield repeated calls of a block in a method that every scan executes, and in its helpers."""
    earlier: dict[str, list[Arms]] = {}
    for call, arms in _with_helpers(_paths(function.body, ()), methods, DEPTH):
        name = field_of(call.func)
        if name in blocks:
            if not all(_exclude(arms, earlier_arms) for earlier_arms in earlier.get(name, ())):
                yield call, name
            earlier.setdefault(name, []).append(arms)


Arms = tuple[tuple[int, int], ...]
"""The arms of statements that contain a call, each as statement and arm number."""


def _paths(body: Sequence[ast.stmt], arms: Arms) -> Iterator[tuple[ast.Call, Arms]]:
    """Yield the calls in statements, each with the arms that contain it; `arms` contain all statements."""
    for node in body:
        tested = node.test if isinstance(node, ast.If) else node
        yield from ((call, arms) for call in nodes_in(tested, ast.Call))
        if isinstance(node, ast.If):
            yield from _paths(node.body, (*arms, (id(node), 0)))
            yield from _paths(node.orelse, (*arms, (id(node), 1)))


def _with_helpers(
    calls: Iterable[tuple[ast.Call, Arms]], methods: Mapping[str, Function], depth: int
) -> Iterator[tuple[ast.Call, Arms]]:
    """Yield calls, with each helper call followed by the calls inside it."""
    for call, arms in calls:
        yield call, arms
        helper = methods.get(field_of(call.func))
        if isinstance(helper, ast.FunctionDef) and depth:
            yield from _with_helpers(_paths(helper.body, arms), methods, depth - 1)


def _exclude(arms: Arms, other_arms: Arms) -> bool:
    """Whether two calls are in different arms of the same statement."""
    numbers = dict(arms)
    return any(numbers.get(statement, number) != number for statement, number in other_arms)
