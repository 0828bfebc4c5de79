"""Calls in a program with sequences that an axis refuses because of their constants, or that fail.

self.axis.move_to(9_000_000, ...)     refused: out of range
self.axis.move_to(4000, speed=200)    refused by the module: below the starting speed
self.axis.moveto(4000)                fails: no such method
dwell("2 seconds")                    fails: not a valid time
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from inspect import Signature, getattr_static, signature
from typing import Any

from scanrack.io_images.times import parse_time
from scanrack.ladder.python.axis3601 import Axis3601, Command, ErrorId
from scanrack.ladder.python.sequences import dwell, steady, until, within
from scanrack.ladder.python.sequences.signals import Signal

from ..facts import FileLine, Violation
from ..module_kinds import FROM_STARTING_SPEED
from .nodes import field_of, missing, nodes_in, unpacks
from .reader import NEUTRAL, Reader, UnknownError, variants

_VALUES = (ast.Constant, ast.Compare, ast.BoolOp, ast.UnaryOp)
"""Expressions that are evaluated immediately, although a wait needs a function."""

SEARCH = "home"
"""The method of an axis that starts a home search."""


class Calls:
    """The calls in a program text.

    Args:
        axes: axes of the program by name.
        classes: the class of the program and its bases. Calls in other classes are ignored.
    """

    def __init__(self, reader: Reader, axes: Mapping[str, Axis3601], classes: Collection[type]) -> None:
        self._reader, self._classes = reader, list(classes)
        statements = [node for node in reader.tree.body if not _is_other_class(node, reader.names, classes)]
        self._calls = list(nodes_in(statements, ast.Call))
        self._commands = [(axes[_owner(call)], call) for call in self._calls if _owner(call) in axes]

    def searches(self) -> Iterator[tuple[FileLine, Axis3601]]:
        """Yield the calls that start a home search, with their axes."""
        for axis, call in self._commands:
            if _method(call) == SEARCH:
                yield self._reader.place(call), axis

    def refused(self) -> Iterator[Violation]:
        """Yield the commands with refused constants."""
        for axis, call in self._commands:
            text = self._refusal(axis, call)
            if text:
                yield Violation(self._reader.place(call), f"{_method(call)}: {text}")

    def failing(self) -> Iterator[Violation]:
        """Yield the calls that raise an exception when they run."""
        for axis, call in self._commands:
            text = _misfit(axis, call) or _fraction(call)
            if text:
                yield Violation(self._reader.place(call), text)
        for call in self._calls:
            kind = self._reader.names.get(getattr(call.func, "id", ""))
            text = self._time_problem(kind, call) if kind in (dwell, steady) else ""
            if kind in (until, steady) and not text:
                text = self._condition_problem(call)
            if text:
                yield Violation(self._reader.place(call), text)

    def short_waits(self, scan_ns: int) -> Iterator[tuple[str, ast.Call, str]]:
        """Yield the waits for a time of 0 or of less than a scan, each as rule, call and problem."""
        for call, time_ns in self._times():
            if time_ns == 0:
                yield "preset-zero", call, f"{ast.unparse(call)} does not wait: its time is 0"
            elif 0 < time_ns < scan_ns:
                text = f"{ast.unparse(call)} is shorter than a scan, {scan_ns / 1e6:g} ms"
                yield "preset-unit", call, text

    def _times(self) -> Iterator[tuple[ast.Call, int]]:
        """Yield the waits for a known time, with the time in ns."""
        for call in self._calls:
            kind = self._reader.names.get(getattr(call.func, "id", ""))
            if kind in (dwell, steady, within) and not unpacks(call):
                with suppress(UnknownError, TypeError, ValueError):
                    node = _bound(signature(kind), call).get("time")
                    if node is not None:
                        yield call, parse_time(str(self._reader.value(node)))

    def _refusal(self, axis: Axis3601, call: ast.Call) -> str:
        """Return the reason why the constants of a command are refused; "" if they are accepted."""
        starting_speed = axis.starting_speed
        arguments = self._arguments(axis, call, {**NEUTRAL, "speed": starting_speed})
        for variant in variants(arguments) if arguments else ():
            try:
                command = getattr(axis, _method(call))(**variant)
            except (TypeError, ValueError):  # the call itself fails, which is reported elsewhere
                return ""
            if isinstance(command, Command) and command.error_id & ErrorId.PARAMETER:
                return command.detail
            speed = variant.get("speed")
            if _method(call) in FROM_STARTING_SPEED and isinstance(speed, int) and speed < starting_speed:
                return f"speed {speed} is below the starting speed of {axis.name}, {starting_speed}"
        return ""

    def _arguments(
        self, axis: Axis3601, call: ast.Call, neutral: Mapping[str, object]
    ) -> Mapping[str, Sequence[object]] | None:
        """Return the values to try for each argument; None if an unknown argument has no neutral value.

        Args:
            neutral: legal values for unknown arguments, by name.
        """
        method = getattr(axis, _method(call), None)
        if not callable(method) or unpacks(call) or _misfit(axis, call):
            return None
        arguments: dict[str, Sequence[object]] = {}
        for name, node in _bound(signature(method), call).items():
            try:
                arguments[name] = self._reader.possible(node)
            except UnknownError:
                if name not in neutral:
                    return None
                arguments[name] = (neutral[name],)
        return arguments

    def _condition_problem(self, call: ast.Call) -> str:
        """Return a message if a wait receives a value instead of a function; "" if not, or if unknown."""
        if not call.args:
            return ""
        argument = call.args[0]
        name = field_of(argument)
        field = getattr_static(self._classes[0], name, None) if name and self._classes else None
        if isinstance(argument, _VALUES) or isinstance(field, bool | int | float | Signal):
            text, wait = ast.unparse(argument), ast.unparse(call.func)
            return f"{wait}: `{text}` is evaluated once, before the wait; give a function: lambda: {text}"
        return ""

    def _time_problem(self, kind: Any, call: ast.Call) -> str:
        """Return the problem with a wait's time; "" if the time is valid or unknown."""
        if unpacks(call):
            return ""
        try:
            node = _bound(signature(kind), call).get("time")
            if node is not None:
                dwell(self._reader.value(node))  # type: ignore[arg-type]  # whatever the user has written
        except UnknownError:
            return ""
        except (TypeError, ValueError) as error:
            return f"{kind.__name__}: {error}"
        return ""


def _is_other_class(node: ast.stmt, names: Mapping[str, Any], classes: Collection[type]) -> bool:
    return isinstance(node, ast.ClassDef) and names.get(node.name) not in classes


def _owner(call: ast.Call) -> str:
    """Return `axis` for a call of `self.axis.method(...)`; "" for any other call."""
    return field_of(call.func.value) if isinstance(call.func, ast.Attribute) else ""


def _method(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else ""


def _bound(function: Signature, call: ast.Call) -> dict[str, ast.expr]:
    """Return the arguments of a call by parameter name; raise TypeError if they do not fit."""
    keywords = {str(keyword.arg): keyword.value for keyword in call.keywords}
    return dict(function.bind(*call.args, **keywords).arguments)


def _misfit(axis: Axis3601, call: ast.Call) -> str:
    """Return why a method of an axis can't be called with these arguments; "" if it can, or if unknown."""
    name = _method(call)
    method = getattr(axis, name, None)
    if not callable(method):
        return f"{axis.name} has {missing(name, name, dir(axis))}"
    if unpacks(call):
        return ""
    try:
        _bound(signature(method), call)
    except TypeError as error:
        parameters = signature(method).parameters.values()
        texts = [
            f"{parameter.name}=" if parameter.kind is parameter.KEYWORD_ONLY else parameter.name
            for parameter in parameters
        ]
        return f"{name}: {error}; its parameters are {', '.join(texts)}"
    return ""


def _fraction(call: ast.Call) -> str:
    """Return a message about a fractional argument of a command; "" if there is none."""
    for node in (*call.args, *(keyword.value for keyword in call.keywords)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div):
            return f"{_method(call)}: `{ast.unparse(node)}` is a fraction; use // for a whole number"
    return ""
