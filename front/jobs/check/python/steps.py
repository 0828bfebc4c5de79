"""The steps of a function of the scan: a text, a number or an enumeration says the step.

if self.mode == "feed" and status.MOVE_COMPLETE:
axis.outputs.load(Idle().to_image())        the command is taken back in step feed
self.mode = "cut"                           from feed to cut
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

from ....io_images.amci3601 import CommandMsw, StatusMsw
from ..facts import FileLine, Step, StepAction
from ..logic import (
    TRUE,
    AllOf,
    AnyOf,
    Bit,
    Compare,
    Condition,
    FixedTruth,
    base_of,
    leaves,
    negated,
    steps_in,
)
from .conditions import ConditionNames, condition, constant_of
from .images import Images
from .reader import Function, Reader, functions_in
from .scans import KINDS

MOVING = ("MOVING_CW", "MOVING_CCW")
OFF_AT_END = (*MOVING, "POSITION_INVALID")
"""Status bits that are off when a motion has ended; of the others none says so while it is off."""

TELLING = re.compile(r"now_ns|number|position|" + "|".join(each.name or "" for each in StatusMsw))
"""In texts of values that may say that a motion has ended, or that time has passed."""

BITS = {
    "move_to": CommandMsw.ABSOLUTE_MOVE,
    "move_by": CommandMsw.RELATIVE_MOVE,
    "home": CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW,
    "set_position": CommandMsw.PRESET_POSITION,
    "run": CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW,
    "run_blend": CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW,
}
"""Bits of the command word by command."""

ALL = 0xFFFF
DEPTH = 4
"""Functions in functions that are followed."""


class PythonSteps:
    """The steps of a text."""

    def __init__(self, reader: Reader, images: Images, slots: Sequence[int]) -> None:
        self._reader, self._images, self._slots = reader, images, slots
        self._names = ConditionNames()
        self._functions = {function.name: function for function, _ in functions_in(reader.tree)}
        self._function: Function
        self._depth = 0

    def actions(self) -> Iterator[StepAction]:
        """Yield what the program does in its steps."""
        called = {_callee(node) for node in ast.walk(self._reader.tree) if isinstance(node, ast.Call)}
        for name, function in self._functions.items() if self._machines else ():
            if name not in called:
                self._function = function
                yield from self._body(function.body, TRUE)

    # --- statements

    def _body(self, body: Sequence[ast.stmt], reached: Condition) -> Iterator[StepAction]:
        for node in body:
            yield from self._statement(node, reached)
            if isinstance(node, ast.If) and not node.orelse and isinstance(node.body[-1], ast.Return):
                reached = AllOf((reached, negated(condition(node.test, self._names))))

    def _statement(self, node: ast.stmt, reached: Condition) -> Iterator[StepAction]:
        match node:
            case ast.If(test=test, body=body, orelse=orelse):
                own = condition(test, self._names)
                yield from self._body(body, AllOf((reached, own)))
                yield from self._body(orelse, AllOf((reached, negated(own))))
            case ast.Match(subject=subject, cases=cases):
                for each in cases:
                    yield from self._body(each.body, AllOf((reached, self._chosen(subject, each))))
            case ast.For(body=body) | ast.While(body=body) | ast.With(body=body) | ast.Try(body=body):
                yield from self._body(body, reached)
            case ast.Assign(targets=[target], value=value):
                yield from self._assigned(node, target, value, reached)
            case ast.Expr(value=ast.Call() as call):
                yield from self._called(call, reached)

    def _chosen(self, subject: ast.expr, case: ast.match_case) -> Condition:
        patterns = case.pattern.patterns if isinstance(case.pattern, ast.MatchOr) else [case.pattern]
        parts: list[Condition] = [
            condition(ast.Compare(subject, [ast.Eq()], [each.value]), self._names)
            for each in patterns
            if isinstance(each, ast.MatchValue)
        ]
        guard = TRUE if case.guard is None else condition(case.guard, self._names)
        return AllOf((AnyOf(tuple(parts)), guard)) if len(parts) == len(patterns) else guard

    def _assigned(
        self, node: ast.Assign, target: ast.expr, value: ast.expr, reached: Condition
    ) -> Iterator[StepAction]:
        text = ast.unparse(target)
        step = _step(value)
        if text in self._machines and step is not None:
            yield self._action(node, text, reached, goes=step)
        if (
            isinstance(target, ast.Subscript)
            and isinstance(target.slice, ast.Constant)
            and target.slice.value == 0
        ):
            slot = self._slot(target.value)
            if slot:
                yield from self._everywhere(node, reached, slot, "", 0)

    def _called(self, call: ast.Call, reached: Condition) -> Iterator[StepAction]:
        method = call.func.attr if isinstance(call.func, ast.Attribute) else ""
        slot = self._slot(call.func.value) if isinstance(call.func, ast.Attribute) else ""
        inner = self._functions.get(_callee(call))
        if inner is not None and self._depth < DEPTH:
            outer, self._function, self._depth = self._function, inner, self._depth + 1
            yield from self._body(inner.body, reached)
            self._function, self._depth = outer, self._depth - 1
        elif slot and method == "load" and call.args:
            kind = self._kind(call.args[0])
            yield from self._everywhere(call, reached, slot, kind, int(BITS.get(kind, 0)))
        elif slot and method in ("clear", "set_bit"):
            yield from self._everywhere(call, reached, slot, "", 0)

    def _everywhere(
        self, node: ast.expr | ast.stmt, reached: Condition, slot: str, kind: str, sets: int
    ) -> Iterator[StepAction]:
        """Yield a write of the command word, for each machine."""
        for machine in self._machines:
            action = self._action(node, machine, reached)
            yield StepAction(
                machine,
                action.steps,
                action.place,
                None,
                action.ends,
                action.moves,
                slot,
                kind,
                f"the command {kind}",
                sets,
                ALL & ~sets,
            )

    def _action(
        self, node: ast.expr | ast.stmt, machine: str, reached: Condition, *, goes: Step | None = None
    ) -> StepAction:
        steps = self._machines[machine]
        numbers = {self._number(step): step for step in steps}
        there = steps_in(reached, machine, frozenset(numbers))
        ends = any(map(self._says_end, leaves(reached)))
        moves = any(
            isinstance(each, Bit) and each.on and _last(each.name) in MOVING for each in leaves(reached)
        )
        found = None if there is None else frozenset(numbers[each] for each in there)
        return StepAction(machine, found, FileLine(self._reader.file, node.lineno), goes, ends, moves)

    def _number(self, step: Step) -> float:
        return float(self._names.number(step) or 0)

    # --- what texts mean

    @cached_property
    def _machines(self) -> dict[str, frozenset[Step]]:
        """The names that only get constants and that are compared with them: their steps."""
        found = {
            text: frozenset(step for step in map(_step, values) if step is not None)
            for text, values in self._values.items()
            if all(_step(each) is not None for each in values)
        }
        compared: dict[str, set[Step]] = {}
        for node in ast.walk(self._reader.tree):
            if isinstance(node, ast.Compare) and len(node.comparators) == 1:
                step = _step(node.comparators[0])
                compared.setdefault(ast.unparse(node.left), set()).update(() if step is None else (step,))
        return {text: steps | compared.get(text, set()) for text, steps in found.items() if len(steps) > 1}

    @cached_property
    def _values(self) -> Mapping[str, list[ast.expr]]:
        """What the text assigns, by target."""
        found: dict[str, list[ast.expr]] = {}
        for node in ast.walk(self._reader.tree):
            if isinstance(node, ast.Assign):
                for target in node.targets:
                    found.setdefault(ast.unparse(target), []).append(node.value)
            elif isinstance(node, ast.AugAssign):
                found.setdefault(ast.unparse(node.target), []).append(node)  # type: ignore[arg-type]  # no constant
        return found

    def _slot(self, node: ast.expr) -> str:
        """Return the axis whose outputs an expression is; "" if it is none."""
        kind, slot = self._images.what(node, self._images.locals_of(self._function))
        if slot is None and len(self._slots) == 1:
            slot = self._slots[0]
        return f"slot {slot}" if kind == "outputs" and slot in self._slots else ""

    def _kind(self, loaded: ast.expr) -> str:
        """Return the command that an image is; "" for another one."""
        text = ast.unparse(loaded)
        name = text.partition(".")[0]
        texts = [text, *(ast.unparse(each) for each in self._values.get(name, ()))]
        for each in texts:
            if each.startswith("Move("):
                return "move_to" if "ABSOLUTE" in each else "move_by"
            kind = KINDS.get(each.partition("(")[0], "")
            if kind:
                return kind
        return ""

    def _says_end(self, part: Condition) -> bool:
        """Whether a part of a condition may say that a motion has ended, or that time has passed."""
        if isinstance(part, FixedTruth):
            return False
        if not isinstance(part, Bit):
            return not (isinstance(part, Compare) and base_of(part.name) in self._machines)
        name = _last(part.name)
        if name in StatusMsw.__members__:
            return name not in MOVING if part.on else name in OFF_AT_END
        return part.on and any(map(self._tells, self._values.get(base_of(part.name), ())))

    def _tells(self, value: ast.expr) -> bool:
        """Whether a value may depend on time, or on the inputs of a 3601."""
        local = self._images.locals_of(self._function)
        parts = (self._images.what(each, local) for each in ast.walk(value) if isinstance(each, ast.expr))
        reads = any(kind == "inputs" and (slot is None or slot in self._slots) for kind, slot in parts)
        return reads or TELLING.search(ast.unparse(value)) is not None


def _callee(call: ast.Call) -> str:
    """Return the name of what is called, without what it belongs to."""
    return call.func.attr if isinstance(call.func, ast.Attribute) else ast.unparse(call.func)


def _last(name: str) -> str:
    return base_of(name).rpartition(".")[2]


def _step(node: ast.AST) -> Step | None:
    """Return the step that an expression is; None for another one."""
    found = constant_of(node) if isinstance(node, ast.expr) else None
    value = None if found is None else found.value
    return value if isinstance(value, str | int | float) and not isinstance(value, bool) else None
