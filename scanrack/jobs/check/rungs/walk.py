"""Finds the condition under which each instruction of a ladder program acts.

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
        condition: the condition under which the instruction is reached.
        own: the condition that the instruction tests; TRUE for an output.
        value: the condition that the instruction assigns to a bit; TRUE for any other instruction.
        argument: whether the instruction copies an argument of an add-on instruction.
        guards: whether it is in an ELSE that is unreachable only because of the constants assigned to a
            number.
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
        conditions: converts instructions to conditions.
        file: file of the program, for lines that do not name a different file.
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

    def _series(self, line: LoweredLine, nodes: Sequence[Node], reached: Condition) -> Condition:
        """Walk over a series; return the condition that it tests.

        Args:
            reached: the condition under which the series is reached.
        """
        series: Condition = TRUE
        for node in nodes:
            node_reached = all_of(reached, series)
            if isinstance(node, Parallel):
                legs = [self._series(line, leg, node_reached) for leg in node.legs]
                series = all_of(series, AnyOf(tuple(legs)))
            else:
                series = all_of(series, self._step(line, node, node_reached))
        return series

    def _step(self, line: LoweredLine, step: LoweredStep, reached: Condition) -> Condition:
        """Note an instruction and its add-on arguments; return the condition that it tests."""
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
        """Return the point of an instruction, with its line, its text, and whether it is in a guard."""
        place, text = place_at(line.origin, self._file), self._lowered.sites[step.site].instruction
        routine, guards = self._routine, self._guards and not argument
        return Point(
            routine, line, step, place, text, reached, own, argument=argument, value=value, guards=guards
        )

    def _copies(self, line: LoweredLine, nodes: Sequence[Node], reached: Condition) -> None:
        """Note the copies of arguments, which also happen on a false rung."""
        source: Condition = TRUE  # the condition of the contact before an OTE
        for node in nodes:
            if isinstance(node, LoweredStep):
                value = source if node.name == "OTE" else TRUE
                self._points.append(self._point(line, node, UNKNOWN, TRUE, argument=True, value=value))
                source = self._conditions.decided(node)

    # --- structured text

    def _body(self, body: Body, reached: Condition) -> None:
        """Note the instructions in statements that are reached under a condition."""
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
        """Note the arms of an IF. An arm is reached if its test is true and all earlier tests are false."""
        for line, body in arms.arms:
            tested = self._act(line, reached)
            names = self._conditions.names.copy()
            self._body(body, all_of(reached, tested))
            self._conditions.names = names  # the next arm is reached without running this arm
            reached = all_of(reached, negated(tested))
        self._otherwise(arms.otherwise, reached)
        if any(body for _, body in arms.arms) or arms.otherwise:
            self._conditions.names.forget()

    def _selection(self, selection: Selection, reached: Condition) -> None:
        """Note the choices of a CASE. A choice is reached if its labels match and no earlier ones do."""
        self._act(selection.line, reached)
        (step,) = selection.line.nodes
        assert isinstance(step, LoweredStep)
        compared, selector, otherwise = self._conditions.compared, step.operands[0], reached
        choices = []  # before any body, because a body may write the selector
        for labels, body in selection.choices:
            ranges = [
                all_of(compared(selector, ">=", low), compared(selector, "<=", high)) for low, high in labels
            ]
            chosen = AnyOf(tuple(ranges))
            choices.append((all_of(otherwise, chosen), body))
            otherwise = all_of(otherwise, negated(chosen))
        for condition, body in choices:
            self._body(body, condition)
        self._otherwise(selection.otherwise, otherwise)

    def _otherwise(self, body: Body, reached: Condition) -> None:
        """Walk over an ELSE. It is a guard if only a number's assigned constants make it unreachable."""
        outer = self._guards
        self._guards = outer or (never(reached) and not never(of_any_number(reached)))
        self._body(body, reached)
        self._guards = outer

    def _loop(self, loop: Loop, reached: Condition) -> None:
        """Note a loop. Values receive new names before its test and after its end."""
        if loop.start is not None:
            self._act(loop.start, reached)
        self._conditions.names.forget()  # an earlier pass may have changed the same values
        first_pass = self._first_pass(loop)
        tested = self._act(loop.test, all_of(reached, first_pass)) if loop.test is not None else TRUE
        # the test of a FOR is noted for the first count only, so it does not limit the body
        self._body(loop.body, all_of(reached, tested) if loop.start is None else reached)
        for line in (loop.advance, loop.until):
            if line is not None:
                self._act(line, reached)
        self._conditions.names.forget()

    def _first_pass(self, loop: Loop) -> Condition:
        """Return the condition of a FOR's first pass, in which the count has its first value."""
        (start,) = loop.start.nodes if loop.start is not None else (None,)
        if not isinstance(start, LoweredStep) or not isinstance(start.operands[1], Constant):
            return TRUE
        return self._conditions.compared(start.operands[0], "=", start.operands[1])
