"""Finds the false contacts that kept an instruction from acting in a scan, and the values they read.

An instruction lacks all false contacts in series with it. In a branch, only the false contacts of the leg
with the fewest count. A statement lacks the first false condition around it. An expression lacks the parts
that keep it false.
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
from .causes import decides, nodes_before
from .cells import places_in
from .crossref import Mention
from .executed import Execution, LineRun, Read, StepRun

Lack = list[tuple[Read, StepRun]]
"""Reads with the wrong value, each with its instruction."""

_T = TypeVar("_T")


@dataclass(slots=True)
class Lacking:
    """Finds the values that instructions lacked in an executed scan."""

    lowered: LoweredProgram
    execution: Execution
    _runs: dict[tuple[int, str], StepRun] = field(default_factory=dict)

    def lack_of(self, mention: Mention) -> Lack:
        """Return the reads with wrong values; [] if the instruction ran and wrote the current value."""
        step = mention.step
        assert step is not None
        entry = self._run_of(step, mention.instance)
        return list(
            self._before_run(entry) if entry is not None else self._of_missing_run(step, mention.instance)
        )

    def _run_of(self, step: LoweredStep, instance: str) -> StepRun | None:
        """Return the last run of an instruction in the scan, or None."""
        return self._all_runs().get((id(step), instance))

    def _all_runs(self) -> Mapping[tuple[int, str], StepRun]:
        """Return the last runs of all instructions, by id of the step and instance."""
        if not self._runs:
            for run in self.execution.runs.values():
                for entry in run.steps.values():
                    self._runs[id(entry.step), entry.instance] = entry
        return self._runs

    def _before_run(self, entry: StepRun) -> Iterator[tuple[Read, StepRun]]:
        """Yield the reads of the false contacts before an instruction."""
        if entry.parent is not None:
            yield from self._before_run(entry.parent)
            return
        false_reads = [pair for node in nodes_before(entry) for pair in self._false_contacts(node, entry.run)]
        yield from false_reads
        if false_reads:
            return
        if entry.power and entry.step.name == ":=":
            yield from ((read, entry) for read in _wrong_reads(entry))
        if entry.run.caller is not None:
            yield from self._before_run(entry.run.caller)

    def _false_contacts(self, node: Node, run: LineRun) -> list[tuple[Read, StepRun]]:
        """Return the reads of the false contacts in a part of a rung; in a branch, of the nearest leg."""
        if isinstance(node, Parallel):
            return _fewest(
                [
                    [pair for element in leg for pair in self._false_contacts(element, run)]
                    for leg in node.legs
                ]
            )
        entry = run.steps.get(id(node))
        if entry is None or not decides(node) or entry.truth is not False:
            return []
        return [(read, entry) for read in _wrong_reads(entry)]

    def _of_missing_run(self, step: LoweredStep, instance: str) -> Iterator[tuple[Read, StepRun]]:
        """Yield the reads that kept an instruction from running: in a condition around it or its call."""
        key, routine, line = _location_of(self.lowered, step)
        for head, required in _heads(routine.body or (), line) or ():
            entry = self._run_of(head.steps[-1], instance)
            if entry is not None and bool(entry.truth) is not required:
                yield from ((read, entry) for read in _wrong_reads(entry))
                return
        for caller in self._callers(key, instance):
            yield from self._before_run(caller)
            return

    def _callers(self, routine: str, instance: str) -> Iterator[StepRun]:
        """Yield the runs of instructions that call a routine."""
        for entry in list(self._all_runs().values()):
            called = entry.step.operands[0] if entry.step.operands else None
            if _calls_routine(called, routine, entry, instance):
                yield entry


def _calls_routine(operand: object, routine: str, entry: StepRun, instance: str) -> bool:
    """Return whether an operand calls a routine; for an add-on routine, with this instance."""
    if isinstance(operand, Call):
        return operand.routine == routine
    if not isinstance(operand, AddOnCall):
        return False
    called_instance = operand.instance.text
    return routine in operand.routines and instance in (
        called_instance,
        f"{entry.instance}.{called_instance}",
    )


def _location_of(lowered: LoweredProgram, step: LoweredStep) -> tuple[str, LoweredRoutine, LoweredLine]:
    """Return the uppercase name of an instruction's routine, the routine, and the rung or line."""
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
    """Return the option that lacks the fewest values; [] if an option lacks nothing."""
    return min(options, key=len) if all(options) else []


def _wrong_reads(entry: StepRun) -> list[Read]:
    """Return the reads that make a condition false or an assigned expression's value wrong."""
    values = {read.text: read.value for read in entry.reads}
    is_set = entry.step.name == ":="
    expressions = [operand for operand in entry.step.operands if isinstance(operand, Calculation)]
    if len(expressions) != 1:
        return list(entry.reads)
    required = is_set or not entry.truth
    texts = {place.text for place in _wrong_places(expressions[0], required, values)}
    return [read for read in entry.reads if read.text in texts] or list(entry.reads)


def _wrong_places(expression: Any, required: bool, values: Mapping[str, Value]) -> list[Place]:
    """Return the smallest set of places that keep an expression from having its required value."""
    if isinstance(expression, Place):
        return [expression] if bool(values.get(expression.text, not required)) is not required else []
    if not isinstance(expression, Calculation):
        return []
    if expression.name == "NOT":
        return _wrong_places(expression.operands[0], not required, values)
    if expression.name in ("AND", "OR", "&"):
        wrong_in_operands = [_wrong_places(operand, required, values) for operand in expression.operands]
        all_needed = (expression.name != "OR") is required
        return list(chain.from_iterable(wrong_in_operands)) if all_needed else _fewest(wrong_in_operands)
    if expression.name in RELATIONS and _relation_truth(expression, values) is required:
        return []
    return list(places_in(expression))


def _relation_truth(relation: Calculation, values: Mapping[str, Value]) -> bool | None:
    """Return whether a relation of plain operands is true; None if it is unknown."""
    sides = [
        values.get(operand.text) if isinstance(operand, Place) else getattr(operand, "value", None)
        for operand in relation.operands
    ]
    if any(not isinstance(side, (int, float)) for side in sides):
        return None
    left, right = sides
    assert left is not None
    assert right is not None
    return COMPARISONS[relation.name](left, right)
