"""What an instruction lacked in a scan: the false contacts before it, and the values they read.

In series, it lacked all false contacts; in a branch, the false contacts of the leg with the fewest. For a
statement, it lacked the first false condition around it; for an expression, the parts that keep it false.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from itertools import chain
from typing import Any, TypeVar

from scanrack.io_images.dataclass import dataclass

from ..interpreter.place_values import COMPARISONS
from ..model.operands import Calculation, Place
from ..model.operators import RELATIONS
from ..state.lowered import (
    Act,
    AddOnCall,
    Arms,
    Body,
    Call,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)
from ..state.memory import Value
from .causes import decides, prefix
from .cells import places_in
from .crossref import Mention
from .executed import Execution, LineRun, Read, StepRun

Lack = list[tuple[Read, StepRun]]
"""Reads with the wrong value, each with its instruction."""

_T = TypeVar("_T")


@dataclass(slots=True)
class Lacking:
    """Finds what instructions lacked in an executed scan."""

    lowered: LoweredProgram
    execution: Execution
    _runs: dict[tuple[int, str], StepRun] = field(default_factory=dict)

    def of(self, mention: Mention) -> Lack:
        """Return what an instruction lacked; [] if it lacked nothing and wrote the present value."""
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
        """Yield the reads of the false contacts before an instruction."""
        if entry.parent is not None:
            yield from self._of_run(entry.parent)
            return
        false_reads = [pair for node in prefix(entry) for pair in self._false(node, entry.run)]
        yield from false_reads
        if false_reads:
            return
        if entry.power and entry.step.name == ":=":
            yield from ((read, entry) for read in _blamed(entry))
        if entry.run.caller is not None:
            yield from self._of_run(entry.run.caller)

    def _false(self, node: Node, run: LineRun) -> list[tuple[Read, StepRun]]:
        """Return the reads of the false contacts of a part of a rung."""
        if isinstance(node, Parallel):
            return _fewest(
                [[pair for element in leg for pair in self._false(element, run)] for leg in node.legs]
            )
        entry = run.steps.get(id(node))
        if entry is None or not decides(node) or entry.truth is not False:
            return []
        return [(read, entry) for read in _blamed(entry)]

    def _of_absent(self, step: LoweredStep, instance: str) -> Iterator[tuple[Read, StepRun]]:
        """Yield what kept an instruction from running: a condition around it, or a call without power."""
        key, routine, line = _place_of(self.lowered, step)
        for head, required in _heads(routine.body or (), line) or ():
            entry = self._run_of(head.steps[-1], instance)
            if entry is not None and bool(entry.truth) is not required:
                yield from ((read, entry) for read in _blamed(entry))
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
    instance_text = call.instance.text
    return routine in call.routines and instance in (instance_text, f"{entry.instance}.{instance_text}")


def _place_of(lowered: LoweredProgram, step: LoweredStep) -> tuple[str, LoweredRoutine, LoweredLine]:
    """Return the name of an instruction's routine, in capitals, and its rung or line."""
    for key, routine in lowered.routines.items():
        for line in routine.lines:
            if any(candidate is step for candidate in line.all_steps):
                return key, routine, line
    raise LookupError(step.name)


_Head = tuple[LoweredLine, bool]
"""A condition around a statement, and the value that the statement needs to run."""


def _heads(body: Body, line: LoweredLine) -> list[_Head] | None:
    """Return the conditions around a line of structured text, outermost first; None if it is not there."""
    for statement in body:
        if isinstance(statement, Act):
            if statement.line is line:
                return []
            continue
        for heads, inner in _bodies(statement):
            inner_heads = _heads(inner, line)
            if inner_heads is not None:
                return [*heads, *inner_heads]
    return None


def _bodies(statement: Arms | Selection | Loop) -> Iterator[tuple[list[_Head], Body]]:
    """Yield the bodies of a statement, each with the conditions under which it runs."""
    if isinstance(statement, Arms):
        passed: list[_Head] = []
        for head, inner in statement.arms:
            yield [*passed, (head, True)], inner
            passed.append((head, False))
        yield passed, statement.otherwise
    elif isinstance(statement, Selection):
        for inner in (*(choice for _, choice in statement.choices), statement.otherwise):
            yield [(statement.line, True)], inner
    else:
        yield [(statement.condition, True)], statement.body


def _fewest(options: Sequence[list[_T]]) -> list[_T]:
    """Return the option that lacks the fewest values; [] if one of them lacks nothing."""
    return min(options, key=len) if all(options) else []


def _blamed(entry: StepRun) -> list[Read]:
    """Return the reads that make a condition false, or give an assigned expression the wrong value."""
    values = {read.text: read.value for read in entry.reads}
    is_set = entry.step.name == ":="
    expressions = [operand for operand in entry.step.operands if isinstance(operand, Calculation)]
    if len(expressions) != 1:
        return list(entry.reads)
    required = is_set or not entry.truth
    texts = {place.text for place in _at_fault(expressions[0], required, values)}
    return [read for read in entry.reads if read.text in texts] or list(entry.reads)


def _at_fault(part: Any, required: bool, values: Mapping[str, Value]) -> list[Place]:
    """Return the smallest set of places that keep an expression from its required value."""
    if isinstance(part, Place):
        return [part] if bool(values.get(part.text, not required)) is not required else []
    if not isinstance(part, Calculation):
        return []
    if part.name == "NOT":
        return _at_fault(part.operands[0], not required, values)
    if part.name in ("AND", "OR", "&"):
        parts = [_at_fault(operand, required, values) for operand in part.operands]
        all_needed = (part.name != "OR") is required
        return list(chain.from_iterable(parts)) if all_needed else _fewest(parts)
    if part.name in RELATIONS and _holds(part, values) is required:
        return []
    return list(places_in(part))


def _holds(part: Calculation, values: Mapping[str, Value]) -> bool | None:
    """Return whether a relation of plain operands holds; None if it is unknown."""
    sides = [
        values.get(operand.text) if isinstance(operand, Place) else getattr(operand, "value", None)
        for operand in part.operands
    ]
    if any(not isinstance(side, (int, float)) for side in sides):
        return None
    left, right = sides
    assert left is not None
    assert right is not None
    return COMPARISONS[part.name](left, right)
