"""What each sequence of a class does, in order: commands to axes, and locks.

A helper, `await self.stroke(self.feeder, 4000)`, is part of each sequence that calls it, with its arguments.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from inspect import signature
from typing import Any

from scanrack.io_images.amci3601 import BlendSegment
from scanrack.ladder.python.axis3601 import Axis3601

from ..facts import Command, Facts, FileLine
from ..ranges import ANY, Range, exactly, joined
from .nodes import Function, bodies_of, field_of, given_to, last_name, nodes_in, parents_in
from .numbers import Numbers
from .reader import Reader

ENDING = ("move_to", "move_by", "home", "run_blend", "configure", "program_blend", "set_position")
"""Commands that end by themselves; the next command must wait for the end."""

TAKING = (*ENDING, "run", "gear", "register")
"""Commands that take over an axis from another command."""

RELEASING = ("halt", "stop", "reset")
"""Commands that end another command."""

DEPTH = 8
"""Maximum depth of helpers that are followed."""

Method = tuple[Reader, Function]
"""A method with the reader of its file."""


@dataclass(slots=True)
class _Position:
    """The state of a walk over a sequence: its file, its locks, and what its names mean."""

    file: str
    unit: str
    axes: Mapping[str, str] = field(default_factory=dict)  # parameters that are axes
    numbers: Mapping[str, tuple[Range, ...]] = field(default_factory=dict)  # parameters that are numbers
    locks: tuple[str, ...] = ()
    sure: bool = True
    depth: int = DEPTH


class SequenceSummaries:
    """Summarizes the sequences of a class.

    Args:
        methods: methods of the class by name.
        axes: axes by name.
        locks: names of locks.
    """

    def __init__(
        self,
        methods: Mapping[str, Method],
        axes: Mapping[str, Axis3601],
        locks: Sequence[str],
        numbers: Mapping[str, Numbers],
        facts: Facts,
    ) -> None:
        self._methods, self._axes, self._locks = methods, axes, locks
        self._numbers, self._facts = numbers, facts
        self._taken: dict[str, dict[str, FileLine]] = {}  # by held lock: the locks taken then, and where
        self._owner = ""
        self._order = 0
        self._pending: dict[str, tuple[str, int]] = {}
        self._followed: set[int] = set()
        self.reached: dict[str, set[str]] = {}

    def follow(self, sequence: str, owner: str) -> None:
        """Note the actions of a sequence, under the name of its owner."""
        self._owner, self._pending = owner, {}
        self._call(sequence, _Position("", sequence), None)

    def _call(self, name: str, place: _Position, call: ast.Call | None) -> None:
        """Follow a method into its body."""
        if name not in self._methods or place.depth == 0:
            return
        reader, function = self._methods[name]
        self.reached.setdefault(name, set()).add(self._owner)
        inner = replace(place, file=reader.file, unit=name, depth=place.depth - 1, axes={}, numbers={})
        if call is not None:
            inner.axes, inner.numbers = self._arguments(function, call, place)
        self._body(function.body, inner)

    def _arguments(
        self, function: Function, call: ast.Call, place: _Position
    ) -> tuple[dict[str, str], dict[str, tuple[Range, ...]]]:
        """Return the axes and number ranges that a call passes to a helper, by parameter."""
        nodes_by_name = given_to([arg.arg for arg in function.args.args[1:]], call)
        axes = {name: axis for name, node in nodes_by_name.items() if (axis := self._axis(node, place))}
        self._followed |= {id(nodes_by_name[name]) for name in axes}
        choices = self._numbers[place.file].choices
        numbers = {name: choices(node, place.numbers) for name, node in nodes_by_name.items()}
        return axes, {name: ranges for name, ranges in numbers.items() if joined(*ranges).is_known}

    # --- statements

    def _body(self, body: Sequence[ast.stmt], place: _Position) -> None:
        for statement in body:
            self._statement(statement, place)
            if any(isinstance(inner, ast.Return) for inner in ast.walk(statement)):
                place = replace(place, sure=False)

    def _statement(self, node: ast.stmt, place: _Position) -> None:
        unsure = replace(place, sure=False)
        match node:
            case ast.If():
                self._expression(node.test, place)
                self._either(node, unsure)
            case ast.While():
                self._expression(node.test, place)
                self._body(node.body, place if isinstance(node.test, ast.Constant) else unsure)
            case ast.For():
                self._expression(node.iter, place)
                for inner in self._passes(node, place):
                    self._body(node.body, inner)
            case ast.Try():
                first, *others = bodies_of(node)
                self._body(first, place)
                self._branches(others, unsure)
            case ast.With() | ast.AsyncWith():
                self._body(node.body, self._with(node, place))
            case ast.Match():
                self._expression(node.subject, place)
                self._branches(bodies_of(node), unsure)
            case _:
                self._expression(node, place)
                self._named(node, place)

    def _either(self, node: ast.If, place: _Position) -> None:
        """Note the arms of a statement. A command stays pending only if it is pending after both arms."""
        before = dict(self._pending)
        self._body(node.body, place)
        after, self._pending = self._pending, before
        self._body(node.orelse, place)
        self._pending = {name: call for name, call in self._pending.items() if name in after}

    def _branches(self, bodies: Iterable[Sequence[ast.stmt]], place: _Position) -> None:
        """Note statement bodies that may not all run. No command is pending at the start of each."""
        for body in bodies:
            self._pending = {}
            self._body(body, place)

    def _passes(self, loop: ast.For, place: _Position) -> Iterator[_Position]:
        """Yield the state of each pass of a loop over axes, `for axis in (self.x, self.z)`; else just one."""
        elements = loop.iter.elts if isinstance(loop.iter, ast.Tuple | ast.List) else []
        axes = [self._axis(node, place) for node in elements]
        if isinstance(loop.target, ast.Name) and axes and all(axes):
            self._followed |= {id(node) for node in elements}
            for axis in axes:
                yield replace(place, axes={**place.axes, loop.target.id: axis})
        else:
            yield place

    def _named(self, node: ast.AST, place: _Position) -> None:
        """Follow a local name for an axis, as in `axis = self.x`."""
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                axis = self._axis(value, place)
                if axis:
                    self._followed.add(id(value))
                    place.axes = {**place.axes, name: axis}

    def escaped(self) -> set[str]:
        """Return the axes that the text passes to code that is not followed."""
        attributes = set()
        for _, function in self._methods.values():
            parents = parents_in(function)
            for node in nodes_in(function, ast.Attribute):
                is_used = isinstance(parents.get(id(node)), ast.Attribute) or id(node) in self._followed
                if field_of(node) in self._axes and not is_used:
                    attributes.add(node.attr)
        return attributes

    def _with(self, statement: ast.With | ast.AsyncWith, place: _Position) -> _Position:
        """Note the locks that a statement takes; return the state in its body."""
        for item in statement.items:
            self._expression(item.context_expr, place)
            name = field_of(item.context_expr)
            if name in self._locks:
                self._take(name, place.locks, FileLine(place.file, statement.lineno))
                place = replace(place, locks=(*place.locks, name))
        return place

    def _take(self, name: str, held: Sequence[str], at: FileLine) -> None:
        """Note that a sequence takes a lock; remark if its order can block sequences forever."""
        if name in held:
            text = f"{self._owner} takes {name}, which it holds: it waits for itself"
            self._facts.remark("lock-order", at, text)
            return
        for lock in held:
            reverse = self._way(name, lock)
            if reverse is not None:
                where = f"line {reverse.line} leads the other way"
                text = f"{self._owner} takes {name} while it holds {lock}: {where}"
                self._facts.remark("lock-order", at, text)
            self._taken.setdefault(lock, {}).setdefault(name, at)

    def _way(self, first: str, last: str) -> FileLine | None:
        """Return the start of a chain of lock orders from one lock to another; None if there is no chain."""
        seen, todo = {first}, list(self._taken.get(first, {}).items())
        while todo:
            name, line = todo.pop(0)
            if name == last:
                return line
            if name not in seen:
                seen.add(name)
                todo += [(lock, line) for lock in self._taken.get(name, {})]
        return None

    # --- expressions

    def _expression(self, node: ast.AST, place: _Position) -> None:
        """Note the commands in an expression, in order."""
        waits = list(nodes_in(node, ast.Await))
        awaited = {id(lock) for lock in nodes_in(waits, ast.Call)}
        in_one: dict[str, str] = {}
        for call in _calls(node):
            axis = self._commanded(call, place)
            helper = field_of(call.func)
            if axis and isinstance(call.func, ast.Attribute):
                self._command(axis, call.func.attr, call, place, awaited=id(call) in awaited, in_one=in_one)
            elif helper in self._methods:
                self._call(helper, place, call)
        others = (wait.value for wait in waits if not self._commanded(wait.value, place))
        if not all(isinstance(other, ast.Call) and last_name(other.func) == "dwell" for other in others):
            self._pending = {}

    def _commanded(self, node: ast.expr, place: _Position) -> str:
        """Return the axis whose method an expression calls; "" for another expression."""
        method = node.func if isinstance(node, ast.Call) else None
        return self._axis(method.value, place) if isinstance(method, ast.Attribute) else ""

    def _command(
        self,
        axis: str,
        kind: str,
        call: ast.Call,
        place: _Position,
        *,
        awaited: bool,
        in_one: dict[str, str],
    ) -> None:
        place_of_call = FileLine(place.file, call.lineno)
        self._order += 1
        values = self._values(axis, kind, call, place)
        command = Command(
            "register" if _is_registration(kind, values, call) else kind,
            axis,
            self._axes[axis].slot,
            place_of_call,
            f"{axis}.{kind}",
            {name: joined(*ranges) for name, ranges in values.items()},
            values,
            self._order,
            place.unit,
            self._owner,
            place.sure,
            frozenset(place.locks),
            segments=self._segments(call, place) if kind == "program_blend" else None,
        )
        self._facts.commands.append(command)
        self._interrupted(command, in_one)
        if command.kind in ENDING:
            in_one[axis] = command.kind
            if not awaited:
                self._pending[axis] = command.kind, call.lineno

    def _interrupted(self, command: Command, in_one: Mapping[str, str]) -> None:
        """Note a command that takes over an axis from a command that has not ended.

        Args:
            in_one: commands in the same wait, by axis.
        """
        axis, kind = command.axis, command.kind
        before = self._pending.pop(axis, None) if kind in (*TAKING, *RELEASING) else None
        if before is not None and kind in TAKING:
            text = f"{axis}.{kind} aborts {axis}.{before[0]} of line {before[1]}, which nothing waits for"
            self._facts.remark("move-interrupted", command.place, text)
        elif axis in in_one and kind in TAKING and kind != "register":
            text = f"{axis}.{kind} aborts {axis}.{in_one[axis]} in the same wait"
            self._facts.remark("move-interrupted", command.place, text)

    def _segments(self, call: ast.Call, place: _Position) -> tuple[tuple[Range, Range, Range], ...] | None:
        """Return length, speed and rate of a blend's segments; None if the text does not determine them."""
        segments_node = given_to(["segments"], call).get("segments")
        segments = self._numbers[place.file].sequence(segments_node) if segments_node is not None else None
        if segments is None or not all(isinstance(segment, BlendSegment) for segment in segments):
            return None
        return tuple(
            (exactly(segment.length), exactly(segment.speed), exactly(segment.rate))  # type: ignore[attr-defined]
            for segment in segments
        )

    def _values(self, axis: str, kind: str, call: ast.Call, place: _Position) -> dict[str, tuple[Range, ...]]:
        """Return the ranges of a command's arguments, as far as they are known."""
        bound = self._bound(axis, kind, call)
        segments = bound.pop("segments", None)
        numbers = self._numbers[place.file]
        choices = {name: numbers.choices(node, place.numbers) for name, node in bound.items()}
        path = None if segments is None else numbers.sequence(segments)
        if path is not None:
            choices["segments"] = (exactly(len(path)),)
        return {name: ranges for name, ranges in choices.items() if joined(*ranges) != ANY}

    def _bound(self, axis: str, kind: str, call: ast.Call) -> dict[str, ast.expr]:
        """Return the arguments of a command by parameter; empty if they do not fit."""
        method: Any = getattr(self._axes[axis], kind, None)
        named = {keyword.arg: keyword.value for keyword in call.keywords if keyword.arg is not None}
        try:
            return dict(signature(method).bind_partial(*call.args, **named).arguments)
        except TypeError:
            return {}

    def _axis(self, node: ast.expr, place: _Position) -> str:
        """Return the name of the axis in an expression; "" if the expression is not an axis."""
        if isinstance(node, ast.Name):
            return place.axes.get(node.id, "")
        name = field_of(node)
        return name if name in self._axes else ""


def _calls(node: ast.AST) -> Iterator[ast.Call]:
    """Yield the calls in an expression in order of execution, except those in a lambda."""
    if isinstance(node, ast.Lambda | ast.FunctionDef | ast.AsyncFunctionDef):
        return
    for child in ast.iter_child_nodes(node):
        yield from _calls(child)
    if isinstance(node, ast.Call):
        yield node


def _is_registration(kind: str, values: Mapping[str, object], call: ast.Call) -> bool:
    """Whether a command is a registration move, which has a distance from the edge."""
    return (kind == "run" and "register" in values) or any(
        keyword.arg == "register" for keyword in call.keywords
    )
