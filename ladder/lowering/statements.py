"""Lowering of structured text.

FOR becomes an assignment before the loop, a condition before each pass and an assignment after each pass.
Other statements keep their structure. The message about an instruction that structured text lacks gives its
replacement.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from ..instructions.statements import CASE, CONDITION, EXIT, RETURN, assignment
from ..model.operand_checks import OperandError, described, is_arithmetic, is_logical, is_string, mismatch
from ..model.operands import Calculation, Constant, Group, Place, Resolved, as_number, constant, width_of
from ..model.resolver import AddressError, Resolver, missing_in
from ..model.statements import (
    Assignment,
    Case,
    Choice,
    Empty,
    Exit,
    For,
    If,
    Invocation,
    Region,
    Repeat,
    Return,
    While,
    too_deep,
)
from ..model.tree import Address, Block, Instruction, Operand, Operation, Origin, Statement, number
from ..state.lowered import Act, Arms, Body, Loop, LoweredLine, LoweredRoutine, LoweredStep, Selection


class Lowerer(Protocol):
    """The part of `rungs.Lowering` that lower-level modules use."""

    resolver: Resolver

    def at(self, number: int, origin: Origin, text: str) -> None:
        """Start a line."""

    def site(self, text: str) -> int:
        """Add an instruction of the current line to the sites; return its number."""

    def step(self, instruction: Instruction) -> LoweredStep:
        """Lower an instruction."""

    def report(self, text: str, remedy: str, *, tag: str = "") -> None:
        """Add a problem with the current line."""

    def note_flags(self, operand: Operand) -> None:
        """Enable the status flags if an operand names one."""

    def note_written(self, operand: Operand, resolved: Place | Group) -> None:
        """Note a written operand."""


class StatementLowering:
    """Lowers one routine of statements."""

    def __init__(self, lowering: Lowerer) -> None:
        self._lowering = lowering
        self._lines: list[LoweredLine] = []
        self._parameters: tuple[Place, ...] | None = None
        self._loops = 0

    def routine(self, name: str, statements: Block) -> LoweredRoutine:
        """Lower a routine."""
        deep = too_deep(statements)
        if deep:
            self._lowering.at(0, Origin(), "")
            self._lowering.report(deep, "use fewer, or a separate routine")
            return LoweredRoutine(name, (), {}, None, ())
        body = self.body(statements)
        return LoweredRoutine(name, tuple(self._lines), {}, self._parameters, body)

    def take_lines(self) -> list[LoweredLine]:
        """Return the lines added since the last call."""
        lines, self._lines = self._lines, []
        return lines

    def body(self, block: Block) -> Body:
        """Lower statements; `take_lines` returns their lines."""
        lowered: list[Any] = []
        for statement in block:
            if isinstance(statement, Region):
                lowered += self.body(statement.body)
            elif not isinstance(statement, Empty):
                lower = _LOWER[type(statement)]
                lowered.append(lower(self, statement))
        return tuple(lowered)

    # --- lines

    def _line(
        self, statement: Statement, text: str, resolve: Callable[[], tuple[Any, ...]], line: int = 0
    ) -> LoweredLine:
        """Lower a line to one step with the spec and operands from `resolve`; report refused operands."""
        number = line or statement.line
        origin = Origin(statement.origin.file, statement.origin.line + number - statement.line)
        self._lowering.at(number, origin, text)
        site = self._lowering.site(text)
        try:
            spec, *operands = resolve()
        except (AddressError, OperandError) as error:
            self._lowering.report(str(error), error.remedy, tag=missing_in(error))
            spec, operands = CONDITION, []
        return self._add_line(
            number, origin, text, LoweredStep(spec, tuple(operands), site), statement.comment
        )

    def _add_line(
        self, number: int, origin: Origin, text: str, step: LoweredStep, comment: str
    ) -> LoweredLine:
        """Add and return a line with one step."""
        line = LoweredLine(number, (step,), origin, text, comment)
        self._lines.append(line)
        return line

    def _assignment(self, statement: Assignment) -> Act:
        return Act(
            self._assigned(statement, statement.head, statement.target, statement.value, statement.retentive)
        )

    def _assigned(
        self, statement: Statement, text: str, target: Address, value: Operand, retentive: bool = True
    ) -> LoweredLine:
        """Lower the assignment of a value, in a statement or of the counter in FOR, to a line."""

        def resolve() -> tuple[Any, ...]:
            place = self._target(target)
            return assignment(place, retentive=retentive), place, self._value(place, value)

        return self._line(statement, text, resolve)

    def _condition(self, statement: Statement, text: str, condition: Operand, line: int = 0) -> LoweredLine:
        return self._line(statement, text, lambda: (CONDITION, self._logical(condition)), line)

    def _invocation(self, statement: Invocation) -> Act:
        """Lower an instruction.

        Note the operands of SBR, and report an instruction that only rungs have.
        """
        called = statement.instruction
        self._lowering.at(statement.line, statement.origin, statement.head)
        first = not self._lines
        step = self._lowering.step(called)
        if step.name == "SBR":
            self._parameters = step.operands
            if not first:
                self._lowering.report("SBR is not first", "make it the first statement")
        elif step.spec.instead:
            self._lowering.report(f"{step.name} is not an instruction of structured text", step.spec.instead)
        return Act(self._add_line(statement.line, statement.origin, statement.head, step, statement.comment))

    def _if(self, statement: If) -> Arms:
        """Lower IF; each arm has a line with its condition."""
        arms = []
        for position, arm in enumerate(statement.arms):
            text = f"{'ELSIF' if position else 'IF'} {arm.condition} THEN"
            head = self._condition(statement, text, arm.condition, arm.line)
            arms.append((head, self.body(arm.body)))
        return Arms(tuple(arms), self.body(statement.otherwise or ()))

    def _case(self, statement: Case) -> Selection:
        """Lower CASE; the widest type among its selector and labels determines the width of comparisons."""
        labels: list[Constant] = []

        def resolve() -> tuple[Any, ...]:
            selector = self._arithmetic(statement.selector)
            for choice in statement.choices:
                for bounds in choice.labels:
                    labels.extend((constant(bounds.low.value), constant(bounds.high.value)))
            return (CASE, selector, *labels)

        line = self._line(statement, statement.head, resolve)
        width = width_of(*self._operands(line))
        choices = tuple((_ranges(choice), self.body(choice.body)) for choice in statement.choices)
        return Selection(line, width, choices, self.body(statement.otherwise or ()))

    def _loop_body(self, block: Block) -> Body:
        self._loops += 1
        body = self.body(block)
        self._loops -= 1
        return body

    def _for(self, statement: For) -> Loop:
        """Lower FOR to a loop; the counter starts before the test and advances after the body."""
        count, step, text = statement.count, statement.step or number(1), statement.head
        start = self._assigned(statement, text, count, statement.first)
        self._check_counter(start)
        test = self._line(statement, text, lambda: (CONDITION, self._pass_condition(statement, step)))
        body = self._loop_body(statement.body)
        advance = self._assigned(statement, text, count, Operation("+", (count, step)))
        return Loop(start, test, body, advance, until=None)

    def _check_counter(self, start: LoweredLine) -> None:
        operands = self._operands(start)
        if operands and not (isinstance(operands[0], Place) and operands[0].type.is_integer):
            counter = described(operands[0])
            self._lowering.report(f"FOR counts in {counter}; must be an integer", "use a SINT, INT or DINT")

    def _pass_condition(self, statement: For, step: Operand) -> Resolved:
        """Return the condition for another pass of FOR: the counter has not passed the last value."""
        count, last = self._arithmetic(statement.count), self._arithmetic(statement.last)
        increment = self._arithmetic(step)
        up, down = Calculation("<=", (count, last)), Calculation(">=", (count, last))
        if isinstance(increment, Constant):
            return up if increment.value >= 0 else down
        zero = constant(0)
        rising = Calculation("AND", (Calculation(">=", (increment, zero)), up))
        falling = Calculation("AND", (Calculation("<", (increment, zero)), down))
        return Calculation("OR", (rising, falling))

    def _while(self, statement: While) -> Loop:
        test = self._condition(statement, statement.head, statement.condition)
        body = self._loop_body(statement.body)
        return Loop(start=None, test=test, body=body, advance=None, until=None)

    def _repeat(self, statement: Repeat) -> Loop:
        body = self._loop_body(statement.body)
        until = self._condition(statement, statement.tail, statement.until, statement.until_line)
        return Loop(start=None, test=None, body=body, advance=None, until=until)

    def _exit(self, statement: Exit) -> Act:
        line = self._line(statement, statement.head, lambda: (EXIT,))
        if not self._loops:
            self._lowering.report("EXIT is outside of a loop", "write RETURN to leave the routine")
        return Act(line)

    def _return(self, statement: Return) -> Act:
        return Act(self._line(statement, statement.head, lambda: (RETURN,)))

    # --- operands

    @staticmethod
    def _operands(line: LoweredLine) -> tuple[Any, ...]:
        (step,) = line.nodes
        assert isinstance(step, LoweredStep)
        return step.operands

    def _resolved(self, operand: Operand) -> Resolved:
        self._lowering.note_flags(operand)
        return self._lowering.resolver.operand(operand)

    def _target(self, operand: Address) -> Place | Group:
        """Return the target of an assignment, and note that it is written.

        Raise an OperandError for a structure or an array, except a string.
        """
        resolved = self._resolved(operand)
        if isinstance(resolved, Group) and not is_string(resolved):
            raise OperandError(
                f"{operand} is {described(resolved)}, which is not assigned as a whole",
                "assign its parts, or COP it",
            )
        assert isinstance(resolved, (Place, Group))
        self._lowering.note_written(operand, resolved)
        return resolved

    def _value(self, target: Place | Group, operand: Operand) -> Resolved:
        """Return the value to assign; the target determines whether it is a string, a bit or a number."""
        if isinstance(target, Group):
            resolved = self._resolved(operand)
            if not is_string(resolved):
                raise mismatch(operand, resolved, "a string", "assign a string to a string")
            return resolved
        return self._logical(operand) if target.type.is_bool else self._arithmetic(operand)

    def _logical(self, operand: Operand) -> Resolved:
        resolved = self._resolved(operand)
        if not is_logical(resolved):
            raise mismatch(operand, resolved, "a bit or a condition", "compare it, as in count <> 0")
        return resolved

    def _arithmetic(self, operand: Operand) -> Resolved:
        resolved = as_number(self._resolved(operand))
        if not is_arithmetic(resolved):
            raise mismatch(operand, resolved, "a number", "decide with IF: IF bit THEN n := 1; END_IF;")
        return resolved


def _ranges(choice: Choice) -> tuple[tuple[Constant, Constant], ...]:
    return tuple((constant(label.low.value), constant(label.high.value)) for label in choice.labels)


_LOWER: Mapping[type[Statement], Callable[[StatementLowering, Any], Any]] = {
    Assignment: StatementLowering._assignment,
    Invocation: StatementLowering._invocation,
    If: StatementLowering._if,
    Case: StatementLowering._case,
    For: StatementLowering._for,
    While: StatementLowering._while,
    Repeat: StatementLowering._repeat,
    Exit: StatementLowering._exit,
    Return: StatementLowering._return,
}
