"""What an instruction lacked in a scan: the contacts before it that were false, and what they had read.

Of contacts in series all that are false are named, of parallel legs those of the leg with the fewest; around
a statement the first condition that is not as it has to be; of an expression the parts that keep it false.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ..model.operands import Calculation, Place
from ..model.operators import RELATIONS
from ..model.spec import InstructionKind
from ..state.lowered import (
    AddOnCall,
    Arms,
    Body,
    Call,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)
from ..state.memory import Value
from .causes import decides, prefix
from .crossref import Mention
from .executed import Execution, LineRun, Read, StepRun

Lack = list[tuple[Read, StepRun]]
"""Reads that are other than they would have to be, each with its instruction."""


@dataclass(slots=True)
class Lacking:
    """Finds what instructions lacked in a scan as it was executed."""

    lowered: LoweredProgram
    execution: Execution
    _runs: dict[tuple[int, str], StepRun] = field(default_factory=dict)

    def of(self, mention: Mention) -> Lack:
        """Return what an instruction lacked; nothing if it had all, and has written the value as it is."""
        step = mention.step
        assert step is not None
        entry = self._run_of(step, mention.instance)
        return list(self._of_run(entry) if entry is not None else self._of_absent(step, mention.instance))

    def _run_of(self, step: LoweredStep, instance: str) -> StepRun | None:
        """Return the last run of an instruction in the scan, or None."""
        if not self._runs:
            for run in self.execution.runs.values():
                for entry in run.steps.values():
                    self._runs[id(entry.step), entry.instance] = entry
        return self._runs.get((id(step), instance))

    def _of_run(self, entry: StepRun) -> Iterator[tuple[Read, StepRun]]:
        """Yield the reads of the contacts before an instruction that are false."""
        if entry.parent is not None:
            yield from self._of_run(entry.parent)
            return
        own = [pair for node in prefix(entry) for pair in self._false(node, entry.run)]
        yield from own
        if not own and entry.power and entry.step.kind is not InstructionKind.INPUT:
            yield from ((each, entry) for each in (_blamed(entry) if entry.step.name == ":=" else ()))
        if not own and entry.run.caller is not None:
            yield from self._of_run(entry.run.caller)

    def _false(self, node: Node, run: LineRun) -> list[tuple[Read, StepRun]]:
        """Return the reads of the false contacts of a part of a rung."""
        if isinstance(node, Parallel):
            legs = [[pair for each in leg for pair in self._false(each, run)] for leg in node.legs]
            return min(legs, key=len) if all(legs) else []
        entry = run.steps.get(id(node))
        if entry is None or not decides(node) or entry.truth is not False:
            return []
        return [(each, entry) for each in _blamed(entry)]

    def _of_absent(self, step: LoweredStep, instance: str) -> Iterator[tuple[Read, StepRun]]:
        """Yield what kept an instruction from running: a condition around it, a call without power."""
        for key, routine in self.lowered.routines.items():
            line = next((each for each in routine.lines if any(one is step for one in each.all_steps)), None)
            if line is None:
                continue
            for head, required in _heads(routine.body or (), line):
                entry = self._run_of(head.steps[-1], instance)
                if entry is not None and bool(entry.truth) is not required:
                    yield from ((each, entry) for each in _blamed(entry))
                    return
            for caller in self._callers(key, instance):
                yield from self._of_run(caller)
                return

    def _callers(self, routine: str, instance: str) -> Iterator[StepRun]:
        self._run_of(_NO_STEP, "")
        for entry in list(self._runs.values()):
            called = entry.step.operands[0] if entry.step.operands else None
            if (isinstance(called, Call) and called.routine == routine) or (
                isinstance(called, AddOnCall) and _is_of(called, routine, entry, instance)
            ):
                yield entry


_NO_STEP: Any = object()


def _is_of(call: AddOnCall, routine: str, entry: StepRun, instance: str) -> bool:
    own = call.instance.text
    return routine in call.routines and instance in (own, f"{entry.instance}.{own}")


def _heads(body: Body, line: LoweredLine) -> Iterator[tuple[LoweredLine, bool]]:
    """Yield the conditions around a line of structured text, outermost first, each with what it has to be."""
    for each in body:
        if isinstance(each, Arms):
            for number, (head, inner) in enumerate(each.arms):
                if _contains(inner, line):
                    yield from ((before, False) for before, _ in each.arms[:number])
                    yield head, True
                    yield from _heads(inner, line)
            if _contains(each.otherwise, line):
                yield from ((head, False) for head, _ in each.arms)
                yield from _heads(each.otherwise, line)
        elif isinstance(each, Selection):
            for inner in (*(choice for _, choice in each.choices), each.otherwise):
                if _contains(inner, line):
                    yield each.line, True
                    yield from _heads(inner, line)
        elif isinstance(each, Loop) and _contains(each.body, line):
            yield each.condition, True
            yield from _heads(each.body, line)


def _contains(body: Body, line: LoweredLine) -> bool:
    for each in body:
        if isinstance(each, Arms):
            inner = [*(part for _, part in each.arms), each.otherwise]
        elif isinstance(each, Selection):
            inner = [*(part for _, part in each.choices), each.otherwise]
        elif isinstance(each, Loop):
            inner = [each.body]
        elif each.line is line:
            return True
        else:
            continue
        if any(_contains(part, line) for part in inner):
            return True
    return False


def _blamed(entry: StepRun) -> list[Read]:
    """Return the reads of a false condition, or of an assigned one, that make it so."""
    values = {each.text: each.value for each in entry.reads}
    is_set = entry.step.name == ":="
    expressions = [each for each in entry.step.operands if isinstance(each, Calculation)]
    if len(expressions) != 1:
        return list(entry.reads)
    required = is_set or not entry.truth
    texts = {place.text for place in _at_fault(expressions[0], required, values)}
    return [each for each in entry.reads if each.text in texts] or list(entry.reads)


def _at_fault(part: Any, required: bool, values: Mapping[str, Value]) -> list[Place]:
    """Return the places that keep an expression from its required value, as few as possible."""
    if isinstance(part, Place):
        return [part] if bool(values.get(part.text, not required)) is not required else []
    if not isinstance(part, Calculation):
        return []
    if part.name == "NOT":
        return _at_fault(part.operands[0], not required, values)
    if part.name in ("AND", "OR", "&"):
        parts = [_at_fault(each, required, values) for each in part.operands]
        all_needed = (part.name != "OR") is required
        if all_needed:
            return [place for each in parts for place in each]
        return min(parts, key=len) if all(parts) else []
    if part.name in RELATIONS:
        return [] if _holds(part, values) is required else list(_places(part))
    return list(_places(part))


_RELATIONS: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq, "<>": operator.ne,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
}  # fmt: skip


def _holds(part: Calculation, values: Mapping[str, Value]) -> bool | None:
    """Return whether a relation of plain operands holds; None if that is not known."""
    sides = [
        values.get(each.text) if isinstance(each, Place) else getattr(each, "value", None)
        for each in part.operands
    ]
    if any(not isinstance(each, (int, float)) for each in sides):
        return None
    one, other = sides
    assert one is not None
    assert other is not None
    return _RELATIONS[part.name](one, other)


def _places(part: Any) -> Iterator[Place]:
    if isinstance(part, Place):
        yield part
    elif isinstance(part, Calculation):
        for each in part.operands:
            yield from _places(each)
