"""The steps of a function of the scan. The step is a text, a number or a member of an enumeration.

if self.mode == "feed" and status.MOVE_COMPLETE:
axis.outputs.load(Idle().to_image())        step feed clears the command
self.mode = "cut"                           the step goes from feed to cut
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property

from scanrack.io_images.amci3601 import StatusMsw

from ..facts import Step, StepAction, StepUse
from ..logic import Bit, Compare, Condition, FixedTruth, base_of, is_only_of, leaves, steps_in
from ..module_kinds import MOVING, action_fields, shows_end
from .conditions import constant_of
from .images import Images
from .nodes import assignments_in, is_stored, last_name, nodes_in
from .scans import KINDS as CLASSES
from .walk import Walk, WalkPlace

END_SIGNS = re.compile(r"now_ns|number|position|" + "|".join(status.name or "" for status in StatusMsw))
"""Finds, in the text of a value, signs that a motion has ended or that time has passed."""

START = "__init__"

_WORKING = (ast.If, ast.IfExp, ast.Match, ast.BinOp, ast.BoolOp, ast.Compare)
"""Nodes in a step that depend on conditions other than the step."""


class PythonSteps:
    """The steps in a text.

    Args:
        slots: slots with 3601s.

    Attributes:
        changes: the assignments of steps that the walk has reached.
    """

    def __init__(self, walk: Walk, images: Images, slots: Sequence[int]) -> None:
        self._walk, self._images, self._slots = walk, images, slots
        self._reader = walk.reader
        self.changes: dict[StepAction, None] = {}  # a loop with several passes repeats them
        self._assigning: set[int] = set()  # lines with an assignment of a step that the walk has reached

    def note(self, node: ast.Assign, place: WalkPlace) -> None:
        """Note an assignment of a step."""
        target, step = ast.unparse(node.targets[0]), _step(node.value)
        is_change = len(node.targets) == 1 and target in self._machines and step is not None
        if is_change and place.entry != START:
            self._assigning.add(node.lineno)
            self.changes[self._action(node, target, place.reached, goes=step)] = None

    def commanding(
        self, node: ast.expr, reached: Condition, axis: str, sets: int, clears: int
    ) -> Iterator[StepAction]:
        """Yield an action for a write of the command word, for each machine."""
        for machine in self._machines:
            yield replace(self._action(node, machine, reached), axis=axis, **action_fields(sets, clears))

    def _action(
        self, node: ast.expr | ast.stmt, machine: str, reached: Condition, *, goes: Step | None = None
    ) -> StepAction:
        """Return an action of a machine at a node, with the steps and signs that its condition contains."""
        parts = list(leaves(reached))
        ends = any(map(self._shows_end, parts))
        moves = any(isinstance(part, Bit) and part.on and _last(part.name) in MOVING for part in parts)
        steps, place = self._possible_steps(reached, machine), self._reader.place(node)
        return StepAction(machine, steps, place, goes=goes, ends=ends, moves=moves, when=reached)

    def _possible_steps(self, reached: Condition, machine: str) -> frozenset[Step] | None:
        """Return the steps where a condition can be true; None for all."""
        number = self._walk.names.number
        numbers = {float(number(step) or 0): step for step in sorted(self._machines[machine], key=str)}
        possible_steps = steps_in(reached, machine, frozenset(numbers))
        return None if possible_steps is None else frozenset(numbers[step] for step in possible_steps)

    def in_steps(self, reached: Condition) -> dict[str, tuple[frozenset[Step] | None, bool]]:
        """Return the steps in which a condition can be true, and whether it always is there, by machine.

        The steps are None if the condition can be true in all of them.
        """
        return {
            machine: (self._possible_steps(reached, machine), is_only_of(reached, machine))
            for machine in self._machines
        }

    def use(self, machine: str, step: Step) -> StepUse | None:
        """Return how the program uses a step; None if the step may change in ways that are not analyzed."""
        name = machine.rpartition(".")[2]
        same_name = (text for text in self._walk.values if text != machine and text.endswith(f".{name}"))
        stored = self._stored.get(machine)  # None for an element, as of an image
        if stored is None or not stored <= self._assigning or any(same_name):
            return None
        bodies = [body for *tested, body in self._arms() if tested == [machine, step]]
        works = any(any(nodes_in(body, *_WORKING)) for body in bodies)
        return StepUse(bool(bodies), works, chosen=True)

    def first(self, machine: str) -> frozenset[Step]:
        """Return the steps in which a machine may start, as declared by the module, a class or `START`."""
        name = machine.rpartition(".")[2]
        bodies = [self._reader.tree.body]
        bodies += [node.body for node in self._reader.tree.body if isinstance(node, ast.ClassDef)]
        bodies += [self._walk.functions[START].body] if START in self._walk.functions else []
        declared = (pair for body in bodies for pair in assignments_in(body))
        steps = (_step(value) for target, value in declared if last_name(target) == name)
        return frozenset(step for step in steps if step is not None)

    @cached_property
    def _stored(self) -> dict[str, set[int]]:
        """The lines that assign each target, except those in the start function."""
        lines: dict[str, set[int]] = {}
        for function in self._walk.functions.values():
            for node in nodes_in(function, ast.Name, ast.Attribute) if function.name != START else ():
                if is_stored(node):
                    lines.setdefault(ast.unparse(node), set()).add(node.lineno)
        return lines

    def _arms(self) -> Iterator[tuple[str, Step | None, Sequence[ast.stmt]]]:
        """Yield the machine, step and body of each `if step == "feed":` and `case "feed":`."""
        for node in nodes_in(self._reader.tree, ast.If):
            for comparison in nodes_in(node.test, ast.Compare):
                if len(comparison.ops) == 1 and isinstance(comparison.ops[0], ast.Eq):
                    yield ast.unparse(comparison.left), _step(comparison.comparators[0]), node.body
        for match in nodes_in(self._reader.tree, ast.Match):
            for case in match.cases:
                for pattern in nodes_in(case.pattern, ast.MatchValue):
                    yield ast.unparse(match.subject), _step(pattern.value), case.body

    # --- meaning of texts

    @cached_property
    def _machines(self) -> dict[str, frozenset[Step]]:
        """Names that are assigned only constants, with all constants they are assigned or compared with."""
        compared: dict[str, set[Step | None]] = {}
        for node in nodes_in(self._reader.tree, ast.Compare):
            if len(node.comparators) == 1:
                compared.setdefault(ast.unparse(node.left), set()).add(_step(node.comparators[0]))
        machines: dict[str, frozenset[Step]] = {}
        for text, values in self._walk.values.items():
            assigned = set(map(_step, values))
            steps = frozenset(step for step in assigned | compared.get(text, set()) if step is not None)
            if None not in assigned and len(steps) > 1:
                machines[text] = steps
        return machines

    def kind(self, image: ast.expr) -> str:
        """Return the command in an image, such as "move_to"; "" if it has none, or if it is unknown."""
        name = ast.unparse(image).partition(".")[0]
        for value in (image, *self._walk.values.get(name, ())):
            text = ast.unparse(value)
            if text.startswith("Move("):
                return "move_to" if "ABSOLUTE" in text else "move_by"
            kind = CLASSES.get(text.partition("(")[0], "")
            if kind:
                return kind
        return ""

    def _shows_end(self, part: Condition) -> bool:
        """Whether a part of a condition may show that a motion has ended or that time has passed."""
        if isinstance(part, FixedTruth):
            return False
        if not isinstance(part, Bit):
            return not (isinstance(part, Compare) and base_of(part.name) in self._machines)
        name = _last(part.name)
        if name in StatusMsw.__members__:
            return shows_end(name, on=part.on)
        return part.on and any(map(self._may_show_end, self._walk.values.get(base_of(part.name), ())))

    def _may_show_end(self, value: ast.expr) -> bool:
        """Whether a value may depend on time, or on the inputs of a 3601."""
        local = self._images.locals_of(self._walk.function)
        kinds = (self._images.kind_of(node, local) for node in ast.walk(value) if isinstance(node, ast.expr))
        reads = any(kind == "inputs" and (slot is None or slot in self._slots) for kind, slot in kinds)
        return reads or END_SIGNS.search(ast.unparse(value)) is not None


def _last(name: str) -> str:
    return base_of(name).rpartition(".")[2]


def _step(node: ast.AST) -> Step | None:
    """Return the value of an expression as a step; None if it is not a step."""
    constant = constant_of(node) if isinstance(node, ast.expr) else None
    value = None if constant is None else constant.value
    return value if isinstance(value, str | int | float) and not isinstance(value, bool) else None
