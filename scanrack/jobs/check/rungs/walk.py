"""Each instruction of a ladder program with the condition under which it acts.

XIC(A)[XIC(B)OTL(C),XIO(B)]OTE(D);    OTL(C): A and B;   OTE(D): A and (B or not B)
IF A THEN C := 1; END_IF;             C := 1: A
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from scanrack.ladder.model.operands import Calculation, Constant, Place
from scanrack.ladder.model.spec import InstructionKind
from scanrack.ladder.state.lowered import (
    Act,
    AddOnCall,
    Arms,
    Body,
    Loop,
    LoweredLine,
    LoweredProgram,
    LoweredRoutine,
    LoweredStep,
    Node,
    Parallel,
    Selection,
)

from ..facts import FileLine
from ..logic import TRUE, UNKNOWN, AllOf, AnyOf, Condition, all_of, negated, never, of_any_number
from ..written import place_at
from .conditions import Conditions
from .number_ranges import target_of


@dataclass(frozen=True, slots=True)
class Point:
    """An instruction, with the conditions under which it acts.

    Attributes:
        place: line of the instruction.
        text: the instruction as written in the program.
        condition: the condition under which it is reached.
        own: the condition that it tests; TRUE for an output.
        value: the condition that it assigns to a bit; TRUE for any other instruction.
        argument: whether it copies an argument of an add-on instruction.
        guards: whether it is in an ELSE that is unreachable only because of the present values of a number.
    """

    routine: LoweredRoutine
    line: LoweredLine
    step: LoweredStep
    place: FileLine
    text: str
    condition: Condition
    own: Condition
    argument: bool = False
    value: Condition = TRUE
    guards: bool = False

    @property
    def is_rung(self) -> bool:
        """Whether it is in a rung rather than in structured text."""
        return self.routine.body is None

    @property
    def power(self) -> Condition:
        """The condition under which it writes a number or sets a bit."""
        return self.condition if self.value == TRUE else AllOf((self.condition, self.value))

    @property
    def target(self) -> Place | None:
        """The only number that it writes; None for other instructions."""
        return target_of(self.step)


class Walker:
    """Walks over routines and collects their points.

    Args:
        conditions: makes the conditions of the program.
        file: file of the program, for lines that do not name another one.
    """

    def __init__(self, conditions: Conditions, lowered: LoweredProgram, file: Path) -> None:
        self._conditions, self._lowered, self._file = conditions, lowered, file
        self._routine: LoweredRoutine
        self._points: list[Point] = []
        self._guards = False

    def points(self, routine: LoweredRoutine) -> list[Point]:
        """Return the points of a routine, in order of execution."""
        self._routine, self._points = routine, []
        if routine.body is None:
            for line in routine.lines:
                self._conditions.begin()
                self._series(line, line.nodes, TRUE)
        else:
            self._conditions.begin()
            self._body(routine.body, TRUE if routine.chart is None else UNKNOWN)
        return self._points

    # --- rungs

    def _series(self, line: LoweredLine, nodes: Sequence[Node], before: Condition) -> Condition:
        """Walk over a series; return the condition that it tests."""
        decided: Condition = TRUE
        for node in nodes:
            reached = all_of(before, decided)
            if isinstance(node, Parallel):
                own: Condition = AnyOf(tuple([self._series(line, leg, reached) for leg in node.legs]))
            else:
                own = self._step(line, node, reached)
            decided = all_of(decided, own)
        return decided

    def _step(self, line: LoweredLine, step: LoweredStep, reached: Condition) -> Condition:
        own = self._conditions.decided(step) if step.kind is InstructionKind.INPUT else TRUE
        for call in step.operands:
            if isinstance(call, AddOnCall):
                for copies in (*call.inputs, *call.outputs):
                    self._copies(line, copies, reached)
                own = UNKNOWN  # EnableOut
        is_bit = step.name in (":=", "[:=]") and isinstance(step.operands[1], Calculation | Place)
        target = step.operands[0] if is_bit else None
        value: Condition = TRUE
        if isinstance(target, Place) and target.type.is_bool:
            value = self._conditions.condition(step.operands[1])
        self._points.append(self._point(line, step, reached, own, value=value))
        self._conditions.names.note(step)
        return own

    def _point(
        self,
        line: LoweredLine,
        step: LoweredStep,
        reached: Condition,
        own: Condition,
        *,
        argument: bool = False,
        value: Condition = TRUE,
    ) -> Point:
        place, text = place_at(line.origin, self._file), self._lowered.sites[step.site].instruction
        guards = self._guards and not argument
        return Point(self._routine, line, step, place, text, reached, own, argument, value, guards)

    def _copies(self, line: LoweredLine, nodes: Sequence[Node], reached: Condition) -> None:
        """Note the copies of arguments, which also happen on a false rung."""
        own_truth: Condition = TRUE
        for node in nodes:
            if isinstance(node, LoweredStep):
                value = own_truth if node.name == "OTE" else TRUE
                self._points.append(self._point(line, node, UNKNOWN, TRUE, argument=True, value=value))
                own_truth = self._conditions.decided(node)

    # --- structured text

    def _body(self, body: Body, reached: Condition) -> None:
        for statement in body:
            match statement:
                case Act(line):
                    self._act(line, reached)
                case Arms():
                    self._arms(statement, reached)
                case Selection():
                    self._selection(statement, reached)
                case Loop():
                    self._loop(statement, reached)

    def _act(self, line: LoweredLine, reached: Condition) -> Condition:
        return self._series(line, line.nodes, reached)

    def _arms(self, arms: Arms, reached: Condition) -> None:
        for line, body in arms.arms:
            decided = self._act(line, reached)
            names = self._conditions.names.copy()
            self._body(body, all_of(reached, decided))
            self._conditions.names = names  # the next arm is reached without running this one
            reached = all_of(reached, negated(decided))
        self._otherwise(arms.otherwise, reached)
        if any(body for _, body in arms.arms) or arms.otherwise:
            self._conditions.names.forget()

    def _selection(self, selection: Selection, reached: Condition) -> None:
        self._act(selection.line, reached)
        (step,) = selection.line.nodes
        assert isinstance(step, LoweredStep)
        selector, otherwise = step.operands[0], reached
        choices = []
        for labels, body in selection.choices:
            chosen = AnyOf(
                tuple(
                    all_of(
                        self._conditions.compared(selector, ">=", low),
                        self._conditions.compared(selector, "<=", high),
                    )
                    for low, high in labels
                )
            )
            choices.append((all_of(otherwise, chosen), body))
            otherwise = all_of(otherwise, negated(chosen))
        for condition, body in choices:
            self._body(body, condition)
        self._otherwise(selection.otherwise, otherwise)

    def _otherwise(self, body: Body, reached: Condition) -> None:
        """Walk over an ELSE; it is a guard if only the present values of a number make it unreachable."""
        outer = self._guards
        self._guards = outer or (never(reached) and not never(of_any_number(reached)))
        self._body(body, reached)
        self._guards = outer

    def _loop(self, loop: Loop, reached: Condition) -> None:
        if loop.start is not None:
            self._act(loop.start, reached)
        self._conditions.names.forget()  # an earlier pass may have written what the body writes
        first = self._first_pass(loop)
        decided = self._act(loop.test, all_of(reached, first)) if loop.test is not None else TRUE
        self._body(loop.body, all_of(reached, decided) if loop.start is None else reached)
        for line in (loop.advance, loop.until):
            if line is not None:
                self._act(line, reached)
        self._conditions.names.forget()

    def _first_pass(self, loop: Loop) -> Condition:
        """Return the condition of a FOR's first pass: the count has its first value."""
        (start,) = loop.start.nodes if loop.start is not None else (None,)
        if not isinstance(start, LoweredStep) or not isinstance(start.operands[1], Constant):
            return TRUE
        return self._conditions.compared(start.operands[0], "=", start.operands[1])
