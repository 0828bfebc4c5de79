"""Reads the text of a sequential function chart in a program file.

    ROUTINE Fill SFC
    INPUTS Recipe                              // tags that receive the inputs of a call; RETURNS is similar
    NOTE any text
    INITIAL_STEP Idle                          // steps in order of execution
    END_STEP
    STEP Filling
        LimitHigh := 1000 + Allowed;           // PRE, LimitHigh and LimitLow may have expressions
        ACTION Open N                          // its tag and qualifier
            Valve := 1;
        END_ACTION
        ACTION Hurry D PRE := 2000;            // without a body: Boolean
        ACTION Stir R;
    END_STEP
    STOP Done
    TRANSITION Start FROM Idle TO Filling      // several names: simultaneous branches
        Button AND Ready
    END_TRANSITION
    END

Transitions are listed in order of priority. A condition can be `JSR(routine)` for a routine with EOT.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from scanrack.io_images.site import Site

from ..model.chart import PRESETS, Action, Chart, ChartStep, Qualifier, Transition
from ..model.errors import RungTextError
from ..model.expressions import parse_address
from ..model.spec import Spec
from ..model.statements import Assignment, Invocation
from ..model.tree import Address, Instruction, Operand, Origin
from ..st import parse_statements
from .linereader import LineReader

_NAME = r"[A-Za-z_]\w*"
_QUALIFIERS = "|".join(qualifier.value for qualifier in Qualifier)
_STEP = re.compile(rf"(INITIAL_STEP|STEP|STOP)\s+({_NAME})", re.IGNORECASE)
_ACTION = re.compile(
    rf"ACTION\s+({_NAME})\s+({_QUALIFIERS})(?:\s+INDICATOR\s+(\S+?))?(?:\s+PRE\s*:=\s*(.+?))?\s*(;?)",
    re.IGNORECASE,
)
_PRESET = re.compile(rf"({'|'.join(PRESETS)})\s*:=\s*(.+?)\s*;", re.IGNORECASE)
_TRANSITION = re.compile(
    rf"TRANSITION\s+({_NAME})\s+FROM\s+({_NAME}(?:\s*,\s*{_NAME})*+)\s+TO\s+({_NAME}(?:\s*,\s*{_NAME})*+)",
    re.IGNORECASE,
)
_LISTED = re.compile(r"(INPUTS|RETURNS)\s+(.+)", re.IGNORECASE)
_NOTE = re.compile(r"NOTE(?:\s+(.*))?", re.IGNORECASE)


class ChartReader(LineReader):
    """Reads the lines of one chart; elements are numbered in order."""

    end_shown = "'END'"

    def __init__(self, lines: list[str], start: int, end: int, file: str, specs: Mapping[str, Spec]) -> None:
        super().__init__(lines, start, end, file, specs)
        self._count = -1

    def chart(self) -> Chart:
        """Read the chart, or raise a RungTextError."""
        steps: list[ChartStep] = []
        transitions: list[Transition] = []
        listed: dict[str, tuple[Address, ...]] = {}
        notes: list[str] = []
        while (line := self._peek()) is not None:
            if match := _STEP.fullmatch(line):
                steps.append(self._step(match[1].upper(), match[2]))
            elif match := _TRANSITION.fullmatch(line):
                transitions.append(self._transition(match))
            elif match := _LISTED.fullmatch(line):
                listed[match[1].upper()] = tuple(parse_address(tag.strip()) for tag in match[2].split(","))
                self._line_index += 1
            elif match := _NOTE.fullmatch(line):
                notes.append(match[1] or "")
                self._line_index += 1
            else:
                self._fail("INITIAL_STEP, STEP, STOP, TRANSITION, INPUTS, RETURNS or NOTE")
        text = ("\n".join(notes),) if notes else ()
        return Chart(
            tuple(steps), tuple(transitions), listed.get("INPUTS", ()), listed.get("RETURNS", ()), text
        )

    def _next(self) -> tuple[int, Origin]:
        """Number the next element; return its number and its position."""
        self._count += 1
        return self._count, Origin(self._file, self._line_index + 1)

    def _step(self, word: str, name: str) -> ChartStep:
        """Read a step with its presets and actions, up to END_STEP; a STOP is a single line."""
        number, origin = self._next()
        self._line_index += 1
        if word == "STOP":
            return ChartStep(name, stop=True, number=number, origin=origin)
        presets: list[tuple[str, Operand]] = []
        actions: list[Action] = []
        while (line := self._peek()) is None or line.upper() != "END_STEP":
            if match := _PRESET.fullmatch(line or ""):
                member = next(preset for preset in PRESETS if preset.upper() == match[1].upper())
                presets.append((member, self._expression(match[2])))
                self._line_index += 1
            elif match := _ACTION.fullmatch(line or ""):
                actions.append(self._action(match))
            else:
                self._fail("ACTION, an expression of PRE, LimitHigh or LimitLow, or END_STEP")
        self._line_index += 1
        return ChartStep(
            name=name,
            actions=tuple(actions),
            initial=word == "INITIAL_STEP",
            presets=tuple(presets),
            number=number,
            origin=origin,
        )

    def _action(self, match: re.Match[str]) -> Action:
        """Read an action; its body ends with END_ACTION, unless the action ends with a semicolon."""
        number, origin = self._next()
        name, qualifier, indicator, preset, closed = match.groups()
        value = None if preset is None else self._expression(preset)
        self._line_index += 1
        body = None if closed else self._statements(*self._until("END_ACTION"))
        return Action(
            name=name,
            qualifier=Qualifier(qualifier.upper()),
            body=body,
            preset=value,
            indicator=indicator or "",
            number=number,
            origin=origin,
        )

    def _transition(self, match: re.Match[str]) -> Transition:
        """Read a transition with its condition, up to END_TRANSITION."""
        number, origin = self._next()
        sources, targets = (tuple(re.split(r"\s*,\s*", names)) for names in match.group(2, 3))
        self._line_index += 1
        start, end = self._until("END_TRANSITION")
        lines = self._lines[start:end]
        condition = condition_of(lines, list(range(start + 1, end + 1)), self._file, self._specs)
        return Transition(match[1], sources, targets, condition, number=number, origin=origin)

    def _until(self, word: str) -> tuple[int, int]:
        """Skip to the line after `word`; return the range of the lines before it."""
        start = self._line_index
        while (line := self._peek()) is None or line.upper() != word:
            if line is None:
                self._fail(word)
            self._line_index += 1
        self._line_index += 1
        return start, self._line_index - 1

    def _expression(self, text: str) -> Operand:
        return expression_of([text], [self._line_index + 1], self._file, self._specs)


def expression_of(lines: list[str], numbers: list[int], file: str, specs: Mapping[str, Spec]) -> Operand:
    """Read an expression of structured text; a final semicolon is optional."""
    statement = _single(lines, numbers, file, specs)
    if isinstance(statement, Assignment):
        return statement.value
    site = Site(file=file, line=numbers[0], column=1)
    raise RungTextError("an expression", repr(str(statement)), site)


def condition_of(
    lines: list[str], numbers: list[int], file: str, specs: Mapping[str, Spec]
) -> Operand | Instruction:
    """Read the condition of a transition: an expression, or a JSR."""
    statement = _single(lines, numbers, file, specs)
    return statement.instruction if isinstance(statement, Invocation) else statement.value


_CALL = re.compile(r"\s*JSR\s*\(", re.IGNORECASE)


def _single(
    lines: list[str], numbers: list[int], file: str, specs: Mapping[str, Spec]
) -> Assignment | Invocation:
    """Read a JSR or an expression as a statement; an expression becomes an assignment to a dummy tag."""
    text = "\n".join(lines).rstrip().removesuffix(";")
    numbers = numbers or [1]
    line_numbers = [*numbers, numbers[-1]]
    head = ""
    if not _CALL.match(text):
        head, line_numbers = "condition :=\n", [numbers[0], *line_numbers]
    block = parse_statements(f"{head}{text}\n;", file=file, lines=line_numbers, specs=specs)
    statements = [statement for statement in block if isinstance(statement, (Assignment, Invocation))]
    if len(statements) == 1:
        return statements[0]
    raise RungTextError("one expression", repr(text.strip()), Site(file=file, line=numbers[0], column=1))
