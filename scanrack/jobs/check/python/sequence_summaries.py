"""The actions of each sequence of a class, in order: commands to axes, and locks.

A helper such as `await self.stroke(self.feeder, 4000)` is part of each sequence that calls it.
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
"""Commands that can take over an axis from another command."""

RELEASING = ("halt", "stop", "reset")
"""Commands that end another command."""

DEPTH = 8
"""Maximum depth of helpers that are followed."""

Method = tuple[Reader, Function]
"""A method with the reader of its file."""


@dataclass(slots=True)
class _Position:
    """The state of a walk over a sequence: its file, its locks, and the meaning of its names."""

    file: str
    unit: str  # the method
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
        numbers: numbers in each file, by its path.

    Attributes:
        reached: by method, the sequences that reach it.
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
        self.reached: dict[str, set[str]] = {}
        self._taken: dict[str, dict[str, FileLine]] = {}  # by held lock: the locks taken then, with lines
        self._followed: set[int] = set()  # ids of the nodes of axes whose use is analyzed
        self._order = 0  # number of commands so far
        self._owner = ""  # the sequence that is followed now
        # by axis: command that nothing awaits yet, and its line
        self._pending: dict[str, tuple[str, int]] = {}

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
        axes, numbers = {}, {}
        for name, node in given_to([arg.arg for arg in function.args.args[1:]], call).items():
            axis = self._axis(node, place)
            if axis:
                axes[name] = axis
                self._followed.add(id(node))
            ranges = self._numbers[place.file].choices(node, place.numbers)
            if joined(*ranges).is_known:
                numbers[name] = ranges
        return axes, numbers

    # --- statements

    def _body(self, body: Sequence[ast.stmt], place: _Position) -> None:
        for statement in body:
            self._statement(statement, place)
            if any(isinstance(inner, ast.Return) for inner in ast.walk(statement)):
                place = replace(place, sure=False)

    def _statement(self, node: ast.stmt, place: _Position) -> None:
        """Note the commands and locks of a statement.

        Commands in a body that may be skipped count as uncertain.
        """
        unsure = replace(place, sure=False)
        match node:
            case ast.If():
                self._expression(node.test, place)
                self._if(node, unsure)
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
                self._note_axis_name(node, place)

    def _if(self, node: ast.If, place: _Position) -> None:
        """Note the arms of a statement. A command stays pending only if it is pending after both arms."""
        pending_before = dict(self._pending)
        self._body(node.body, place)
        pending_after_body, self._pending = self._pending, pending_before
        self._body(node.orelse, place)
        self._pending = {axis: call for axis, call in self._pending.items() if axis in pending_after_body}

    def _branches(self, bodies: Iterable[Sequence[ast.stmt]], place: _Position) -> None:
        """Note statement bodies, some of which may not run. Each starts without a pending command."""
        for body in bodies:
            self._pending = {}
            self._body(body, place)

    def _passes(self, loop: ast.For, place: _Position) -> Iterator[_Position]:
        """Yield the state of each pass of a loop over axes, `for axis in (self.x, self.z)`.

        For any other loop, yield only the state before it.
        """
        elements = loop.iter.elts if isinstance(loop.iter, ast.Tuple | ast.List) else []
        axes = [self._axis(node, place) for node in elements]
        if isinstance(loop.target, ast.Name) and axes and all(axes):
            self._followed |= {id(node) for node in elements}
            for axis in axes:
                yield replace(place, axes={**place.axes, loop.target.id: axis})
        else:
            yield place

    def _note_axis_name(self, node: ast.AST, place: _Position) -> None:
        """Note a local name for an axis, as in `axis = self.x`."""
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                axis = self._axis(value, place)
                if axis:
                    self._followed.add(id(value))
                    place.axes = {**place.axes, name: axis}

    def escaped(self) -> set[str]:
        """Return the axes that the text passes to code outside the analysis."""
        attributes = set()
        for _, function in self._methods.values():
            parents = parents_in(function)
            for node in nodes_in(function, ast.Attribute):
                is_used = isinstance(parents.get(id(node)), ast.Attribute) or id(node) in self._followed
                if field_of(node) in self._axes and not is_used:
                    attributes.add(node.attr)
        return attributes

    def _with(self, statement: ast.With | ast.AsyncWith, place: _Position) -> _Position:
        """Note the locks that a statement acquires; return the state in its body."""
        for item in statement.items:
            self._expression(item.context_expr, place)
            name = field_of(item.context_expr)
            if name in self._locks:
                self._take(name, place.locks, FileLine(place.file, statement.lineno))
                place = replace(place, locks=(*place.locks, name))
        return place

    def _take(self, name: str, held_locks: Sequence[str], line: FileLine) -> None:
        """Note that a sequence acquires a lock; report an order of locks that can deadlock sequences."""
        if name in held_locks:
            text = f"{self._owner} takes {name}, which it holds already: it waits for itself"
            self._facts.remark("lock-order", line, text)
            return
        for held in held_locks:
            reverse = self._chain(name, held)
            if reverse is not None:
                order = f"line {reverse.line} takes them in the opposite order"
                self._facts.remark(
                    "lock-order", line, f"{self._owner} takes {name} while it holds {held}: {order}"
                )
            self._taken.setdefault(held, {}).setdefault(name, line)

    def _chain(self, first: str, last: str) -> FileLine | None:
        """Return the first line of a chain of lock orders from one lock to another; None without one."""
        visited, todo = {first}, list(self._taken.get(first, {}).items())
        while todo:
            name, first_line = todo.pop(0)
            if name == last:
                return first_line
            if name not in visited:
                visited.add(name)
                todo += [(lock, first_line) for lock in self._taken.get(name, {})]
        return None

    # --- expressions

    def _expression(self, node: ast.AST, place: _Position) -> None:
        """Note the commands in an expression, in order."""
        waits = list(nodes_in(node, ast.Await))
        awaited_ids = {id(call) for call in nodes_in(waits, ast.Call)}
        same_wait: dict[str, str] = {}
        for call in _calls(node):
            axis = self._commanded(call, place)
            helper = field_of(call.func)
            if axis and isinstance(call.func, ast.Attribute):
                is_awaited = id(call) in awaited_ids
                self._command(axis, call.func.attr, call, place, is_awaited=is_awaited, same_wait=same_wait)
            elif helper in self._methods:
                self._call(helper, place, call)
        others = (wait.value for wait in waits if not self._commanded(wait.value, place))
        if not all(isinstance(other, ast.Call) and last_name(other.func) == "dwell" for other in others):
            self._pending = {}  # such a wait may be for the end of any command

    def _commanded(self, node: ast.expr, place: _Position) -> str:
        """Return the axis whose method an expression calls; "" for any other expression."""
        method = node.func if isinstance(node, ast.Call) else None
        return self._axis(method.value, place) if isinstance(method, ast.Attribute) else ""

    def _command(
        self,
        axis: str,
        kind: str,
        call: ast.Call,
        place: _Position,
        *,
        is_awaited: bool,
        same_wait: dict[str, str],
    ) -> None:
        """Note a command to an axis, and a command that it interrupts.

        Args:
            same_wait: commands so far in the same wait, by axis. A command that ends by itself is added.
        """
        self._order += 1
        values = self._values(axis, kind, call, place)
        command = Command(
            "register" if _is_registration(kind, values, call) else kind,
            axis,
            self._axes[axis].slot,
            FileLine(place.file, call.lineno),
            f"{axis}.{kind}",
            values={name: joined(*ranges) for name, ranges in values.items()},
            choices=values,
            order=self._order,
            unit=place.unit,
            owner=self._owner,
            sure=place.sure,
            locks=frozenset(place.locks),
            segments=self._segments(call, place) if kind == "program_blend" else None,
        )
        self._facts.commands.append(command)
        self._note_interruption(command, same_wait)
        if command.kind in ENDING:
            same_wait[axis] = command.kind
            if not is_awaited:
                self._pending[axis] = command.kind, call.lineno

    def _note_interruption(self, command: Command, same_wait: Mapping[str, str]) -> None:
        """Note a command that takes over an axis from a command that has not ended.

        Args:
            same_wait: commands so far in the same wait, by axis.
        """
        axis, kind = command.axis, command.kind
        pending = self._pending.pop(axis, None) if kind in (*TAKING, *RELEASING) else None
        if kind not in TAKING:
            return
        if pending is not None:
            pending_kind, line = pending
            text = f"{axis}.{kind} aborts {axis}.{pending_kind} of line {line}, which nothing waits for"
            self._facts.remark("move-interrupted", command.place, text)
        elif axis in same_wait and kind != "register":
            text = f"{axis}.{kind} aborts {axis}.{same_wait[axis]} in the same wait"
            self._facts.remark("move-interrupted", command.place, text)

    def _segments(self, call: ast.Call, place: _Position) -> tuple[tuple[Range, Range, Range], ...] | None:
        """Return the length, speed and rate of a blend's segments; None if they are unknown."""
        segments_node = given_to(["segments"], call).get("segments")
        segments = self._numbers[place.file].sequence(segments_node) if segments_node is not None else None
        if segments is None or not all(isinstance(segment, BlendSegment) for segment in segments):
            return None
        return tuple(
            (exactly(segment.length), exactly(segment.speed), exactly(segment.rate))  # type: ignore[attr-defined]
            for segment in segments
        )

    def _values(self, axis: str, kind: str, call: ast.Call, place: _Position) -> dict[str, tuple[Range, ...]]:
        """Return the known ranges of a command's arguments."""
        bound = self._bound(axis, kind, call)
        segments = bound.pop("segments", None)
        numbers = self._numbers[place.file]
        choices = {name: numbers.choices(node, place.numbers) for name, node in bound.items()}
        elements = None if segments is None else numbers.sequence(segments)
        if elements is not None:
            choices["segments"] = (exactly(len(elements)),)
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
    has_keyword = any(keyword.arg == "register" for keyword in call.keywords)
    return has_keyword or (kind == "run" and "register" in values)
