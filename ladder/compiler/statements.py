"""Structured text as Python code: IF is `if`, loops are `while`, and CASE compares its stored selector.

A condition that needs extra lines can't be in an `elif`. An IF with such a condition first selects its arm,
without nesting deeper for each ELSIF, and then runs it.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..model.operands import Constant
from ..state.lowered import Act, Arms, Body, Loop, LoweredLine, LoweredStep, Selection
from .rungs import RungWriter
from .terms import is_plain


class StatementWriter:
    """Writes the statements of one routine."""

    def __init__(self, rungs: RungWriter) -> None:
        self._rungs, self._writer = rungs, rungs.writer

    def body(self, body: Body) -> None:
        """Write statements."""
        for statement in body:
            if isinstance(statement, Act):
                self._act(statement.line)
            elif isinstance(statement, Arms):
                self._arms(statement)
            elif isinstance(statement, Selection):
                self._selection(statement)
            else:
                self._loop(statement)

    def _act(self, line: LoweredLine) -> None:
        """Write a single statement, and note whether it was true if its line is observed.

        A statement that can leave the routine is noted before it acts.
        """
        self._writer.begin(line)
        noted = self._is_noted(line)
        leaves = noted and _step_of(line).spec.leaves
        if leaves:
            self._note(line, "True")
        power = self._rungs.series(line.nodes, "True", needed=noted)
        if noted and not leaves:
            self._note(line, power)

    def _is_noted(self, line: LoweredLine) -> bool:
        return self._rungs.notes.place(line.number) is not None

    def _note(self, line: LoweredLine, power: str) -> None:
        """Write the note of a line's truth, which is also true if an earlier run in the scan was true."""
        note = self._rungs.notes.place(line.number)
        truth = "True" if power == "True" else f"{power} or {note} == (True,)"
        self._writer.line(f"{note} = ({truth},)")

    def _condition(self, line: LoweredLine) -> str:
        """Write the line of a condition, and its note if it is observed; return text for the condition."""
        text = self._head(line)
        if self._is_noted(line):
            text = self._rungs.values.keep(text)
            self._note(line, text)
        return text

    def _head(self, line: LoweredLine) -> str:
        """Begin the line of a condition or a selector; return text for its value."""
        self._writer.begin(line)
        step = _step_of(line)
        self._rungs.values.site = step.site
        assert step.spec.write is not None
        return str(step.spec.write(self._rungs, *step.operands))

    def _write_block(self, head: str, body: Body) -> None:
        with self._writer.block(head):
            self.body(body)

    # --- IF

    def _arms(self, arms: Arms) -> None:
        """Write IF, ELSIF and ELSE; the arm is selected first if a later condition needs extra lines."""
        lines = [line for line, _ in arms.arms]
        if all(map(self._is_one_expression, lines[1:])):
            for position, (line, body) in enumerate(arms.arms):
                self._write_block(f"{'elif' if position else 'if'} {self._condition(line)}:", body)
        else:
            chosen = self._choose(lines)
            for position, (_, body) in enumerate(arms.arms):
                self._write_block(f"{'elif' if position else 'if'} {chosen} == {position}:", body)
        if arms.otherwise:
            self._write_block("else:", arms.otherwise)

    def _choose(self, lines: Sequence[LoweredLine]) -> str:
        """Evaluate conditions in order; return a variable with the index of the first true one, or -1."""
        chosen = self._writer.lasting()
        self._writer.line(f"{chosen} = 0 if {self._condition(lines[0])} else -1")
        for position, line in enumerate(lines[1:], start=1):
            with self._writer.block(f"if {chosen} < 0:"):
                text = self._condition(line)
                self._writer.line(f"if {text}: {chosen} = {position}")
        return chosen

    def _is_one_expression(self, line: LoweredLine) -> bool:
        """Return whether a condition needs no extra lines."""
        return not self._is_noted(line) and is_plain(_step_of(line).operands[0])

    # --- CASE

    def _selection(self, selection: Selection) -> None:
        """Write CASE: the selector is stored, and compared with the ranges of each choice."""
        value = self._writer.lasting()
        self._writer.line(f"{value} = {self._head(selection.line)}")
        if self._is_noted(selection.line):
            self._note(selection.line, "True")
        word = "if"
        for ranges, body in selection.choices:
            tests = [self._in_range(value, low, high, selection.width) for low, high in ranges]
            self._write_block(f"{word} {' or '.join(tests)}:", body)
            word = "elif"
        if selection.otherwise:
            self._write_block("else:" if selection.choices else "if True:", selection.otherwise)

    def _in_range(self, value: str, low: Constant, high: Constant, width: int) -> str:
        """Return text for the test of a selector against a range, or against a single value."""
        least, most = (self._rungs.values.term(bound, width).text for bound in (low, high))
        return f"{value} == {least}" if least == most else f"{least} <= {value} <= {most}"

    # --- loops

    def _loop(self, loop: Loop) -> None:
        """Write a loop, whose passes the watchdog counts; a test that needs extra lines is in the body."""
        if loop.start is not None:
            self._act(loop.start)
        plain = loop.test is not None and self._is_one_expression(loop.test)
        head = self._head(loop.test) if plain and loop.test else "True"
        with self._writer.block(f"while {head}:"):
            if loop.test and not plain:
                self._leave(f"not ({self._condition(loop.test)})")
            self.body(loop.body)
            if loop.advance is not None:
                self._act(loop.advance)
            if loop.until is not None:
                self._leave(self._condition(loop.until))
            self._writer.line(f"jumped_back({loop.site})")

    def _leave(self, condition: str) -> None:
        """Write the end of a loop if a condition is true."""
        with self._writer.block(f"if {condition}:"):
            self._writer.line("break")


def _step_of(line: LoweredLine) -> LoweredStep:
    (step,) = line.nodes
    assert isinstance(step, LoweredStep)
    return step
