"""Facts of a program with sequences, from the declarations of its class and from its text.

    axis = Axis3601(1, Configuration(...))        the configuration of slot 1
    start = Input("Local:2:I.Data.0")             a place, which the rack has or has not
    await self.axis.move_to(9_000_000, ...)       a command with constants; unknown values are legal
    while True: self.count += 1                   a loop that never waits

No sequence runs. The class is attached to images without modules.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator, Mapping
from inspect import signature
from pathlib import Path
from typing import Any

from ....io_images.amci3601 import Acceleration, Direction
from ....ladder.axis3601 import Axis3601, Command, ErrorId
from ....ladder.sequences import Logic, fresh, parts_of
from ....ladder.sequences.signals import Signal
from ...config.rackspec import RackSpec
from ..bare_slots import bare_slots
from .facts import Facts, Place, Remark, Sent, UsesBit
from .python_facts import Reader, UnknownError

NEUTRAL: Mapping[str, object] = {
    "direction": Direction.CW,
    "shape": Acceleration.CONSTANT,
    "position": 0,
    "distance": 1,
    "speed": 1,
    "acceleration": 1,
    "deceleration": 1,
    "register": 1,
    "numerator": 1,
    "denominator": 1,
}
"""A legal value for each argument of a command, in place of an unknown one."""

SEARCH = "home"
"""The method of an axis that starts a home search."""

_PROBLEM = re.compile(r"(?P<file>.*?):(?P<line>\d+): (?P<text>.*)")
"""The message of `Logic` about a declaration."""

_WAITS = (ast.Await, ast.AsyncWith, ast.AsyncFor)
_LEAVES = (ast.Break, ast.Return, ast.Raise)


def sequence_facts(path: Path, program: Logic, spec: RackSpec) -> Facts:
    """Read the facts of a program with sequences.

    Args:
        path: its file.
        program: an instance of its class.
        spec: the rack.
    """
    logic = fresh(program)
    facts = Facts(not_seen=["values that the program computes"])
    facts.misplaced.extend(_misplaced(logic, spec, path))
    if not facts.misplaced:
        facts.uses_bit = _uses_bit(logic)
    axes = {each.name: each for each in parts_of(logic) if isinstance(each, Axis3601)}
    for axis in axes.values():
        words = tuple(axis.configuration.to_image().words.tolist())
        facts.configurations.append(Sent(_place(axis.declared, path), axis.slot, words))
    tree = ast.parse(path.read_text("utf-8"))
    reader = Reader(str(path), tree, vars(sys.modules[type(program).__module__]))
    for axis, call in _commands(tree, axes):
        place = Place(str(path), call.lineno)
        if _method(call) == SEARCH:
            facts.searches.append(Sent(place, axis.slot))
        refused = _refusal(axis, call, reader)
        if refused:
            facts.out_of_range.append(Remark(place, refused))
    facts.endless.extend(Remark(Place(str(path), line), text) for line, text in _endless(tree))
    return facts


def _misplaced(logic: Logic, spec: RackSpec, path: Path) -> Iterator[Remark]:
    """Yield what the class declares and the rack does not have, or what two own."""
    slots = bare_slots({slot.number: slot.words for slot in spec.slot})
    try:
        logic.__attach_logic__(slots)
    except ValueError as error:
        for line in str(error).splitlines():
            match = _PROBLEM.fullmatch(line)
            if match is None:
                yield Remark(Place(str(path), 1), line)
            else:
                yield Remark(Place(match["file"], int(match["line"])), match["text"])


def _uses_bit(logic: Logic) -> UsesBit:
    """Return whether the class declares a bit, or the word that it is in."""
    places = {
        (each.at.slot, each.at.image, each.at.word, each.at.bit)
        for each in parts_of(logic)
        if isinstance(each, Signal) and each.at is not None
    }

    def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
        return not places.isdisjoint({(slot, image, word, bit), (slot, image, word, None)})

    return uses


def _place(declared: str, path: Path) -> Place:
    file, _, line = declared.rpartition(":")
    return Place(file, int(line)) if line.isdecimal() else Place(str(path), 1)


def _commands(tree: ast.Module, axes: Mapping[str, Axis3601]) -> Iterator[tuple[Axis3601, ast.Call]]:
    """Yield the calls of methods of the program's axes, such as `self.axis.move_to(...)`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            owner = node.func.value
            of_self = isinstance(owner, ast.Attribute) and getattr(owner.value, "id", "") == "self"
            if of_self and isinstance(owner, ast.Attribute) and owner.attr in axes:
                yield axes[owner.attr], node


def _method(call: ast.Call) -> str:
    return call.func.attr if isinstance(call.func, ast.Attribute) else ""


def _refusal(axis: Axis3601, call: ast.Call, reader: Reader) -> str:
    """Return why an axis refuses the constants of a command; empty if it takes them."""
    method = getattr(axis, _method(call), None)
    unpacked = any(isinstance(each, ast.Starred) for each in call.args) or None in (
        each.arg for each in call.keywords
    )
    if not callable(method) or unpacked:
        return ""
    given = dict(zip(signature(method).parameters, call.args, strict=False))
    given |= {str(each.arg): each.value for each in call.keywords}
    arguments: dict[str, Any] = {}
    for name, node in given.items():
        try:
            arguments[name] = reader.value(node)
        except UnknownError:
            if name not in NEUTRAL:
                return ""
            arguments[name] = NEUTRAL[name]
    try:
        command = method(**arguments)
    except (TypeError, ValueError):  # the call itself fails, at its line
        return ""
    wrong = isinstance(command, Command) and command.error_id & ErrorId.PARAMETER
    return f"{_method(call)}: {command.detail}" if wrong else ""


def _endless(tree: ast.Module) -> Iterator[tuple[int, str]]:
    """Yield the loops of `async def` functions that have no end and no await."""
    for function in ast.walk(tree):
        if isinstance(function, ast.AsyncFunctionDef):
            for loop in ast.walk(function):
                if isinstance(loop, ast.While) and _always(loop.test) and not _ends_or_waits(loop):
                    yield loop.lineno, f"{function.name} never waits in this loop: the watchdog ends it"


def _always(test: ast.expr) -> bool:
    return isinstance(test, ast.Constant) and bool(test.value)


def _ends_or_waits(loop: ast.While) -> bool:
    return any(isinstance(node, (*_WAITS, *_LEAVES)) for node in ast.walk(loop))
