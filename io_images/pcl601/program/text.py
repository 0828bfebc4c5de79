"""Reads and writes the text format `pclt`.

    lines  one instruction or directive per line, in upper or lower case; a comment begins with ;
    names  labels: a letter, then up to 15 letters, digits or _
    .title "text"   .axis 0 to 99   .autostart on|off

The vendor's file format is not published.
"""

from __future__ import annotations

from collections.abc import Callable
from difflib import get_close_matches
from functools import cache
from typing import Any, NamedTuple

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from .grammar import grammar, keywords, names_of, row_rule
from .instructions import INSTRUCTIONS
from .model import Program, ProgramError, Step
from .operands import Number, OperandError, quoted, unquoted
from .structure import check_structure

_ROWS = {row_rule(index): row for index, row in enumerate(INSTRUCTIONS)}
_AXIS = Number(0, 99, 0, "an axis")


class _Directive(NamedTuple):
    name: str
    value: int | str


def parse_program(text: str) -> Program:
    r"""Read a program; raise a ProgramError with line, column and allowed words if it is invalid.

    >>> program = parse_program("dir cw\nmove 4000 ; out\nfinish\nend")
    >>> program.steps[1], program.size
    (Step(name='MOVE', values=(4000,)), 12)
    """
    steps: list[Step] = []
    lines: list[int] = []
    directives: dict[str, Any] = {}
    for number, line in enumerate(text.split("\n"), 1):
        content = _parse_line(number, line.rstrip("\r"))
        if isinstance(content, Step):
            steps.append(content)
            lines.append(number)
        elif content is not None:
            if content.name in directives:
                raise ProgramError(f".{content.name} is given twice", number, 1)
            directives[content.name] = content.value
    program = Program(tuple(steps), **directives)
    check_structure(program, lines)
    return program


def _parse_line(number: int, line: str) -> Step | _Directive | None:
    """Return the content of a line; None for a blank line or a comment."""
    try:
        return _content(_parser().parse(line))
    except UnexpectedInput as error:
        raise ProgramError(_reason(line, error), number, _column(line, error)) from error
    except _OperandAtError as error:
        raise ProgramError(str(error), number, error.column) from error


@cache
def _parser() -> Lark:
    return Lark(grammar(), parser="lalr", maybe_placeholders=False)


class _OperandAtError(Exception):
    """A value is invalid; the error has its column."""

    def __init__(self, reason: str, column: int) -> None:
        super().__init__(reason)
        self.column = column


def _content(tree: Tree[Token]) -> Step | _Directive | None:
    """Return the instruction or directive in a parsed line; None if the line has neither."""
    tokens = [token for token in tree.children if isinstance(token, Token)]
    if tree.data == "nothing":
        return None
    if tree.data == "directive":
        return _directive(tokens[0].lower()[1:], tokens[1])
    row = _ROWS[str(tree.data)]
    values = [token for token in tokens if token.type != "EQUALS"]
    return Step(
        row.name,
        tuple(_value(operand.value, token) for operand, token in zip(row.operands, values, strict=True)),
    )


def _directive(name: str, token: Token) -> _Directive:
    """Return a directive with its value: a text, an axis number, or whether ON is given."""
    if name == "title":
        return _Directive(name, _value(unquoted, token))
    if name == "axis":
        return _Directive(name, _value(_AXIS.value, token))
    return _Directive(name, token.upper() == "ON")


def _value(convert: Callable[[str], Any], token: Token) -> Any:
    """Return the value of a token; raise an _OperandAtError if it is invalid."""
    try:
        return convert(str(token))
    except OperandError as error:
        raise _OperandAtError(str(error), int(token.column or 1)) from error


def _column(line: str, error: UnexpectedInput) -> int:
    """Return the column of an error, from 1; for a line that ends too early, the column after its end."""
    if isinstance(error, UnexpectedToken) and error.token.type == "$END":
        return len(line.rstrip()) + 1
    return int(error.column)


def _reason(line: str, error: UnexpectedInput) -> str:
    """Return the error in a line, with the allowed words."""
    begin = _column(line, error) - 1
    words = line[begin:].split()
    if words and not line[:begin].strip():
        close_words = get_close_matches(words[0].upper(), list(keywords()), n=3)
        hint = f"; like it: {', '.join(close_words)}" if close_words else ""
        return f"{words[0]!r} begins no instruction and no directive{hint}"
    problem = f"{words[0]!r} is unexpected" if words else "the line ends too early"
    return f"{problem}; allowed here: {names_of(_allowed(error))}"


def _allowed(error: UnexpectedInput) -> set[str]:
    """Return the terminals that the line could continue with; an empty set if the parser does not know."""
    if isinstance(error, UnexpectedToken):
        return set(error.accepts or error.expected)
    return set(error.allowed) if isinstance(error, UnexpectedCharacters) else set()


def format_program(program: Program) -> str:
    """Return a program as text that `parse_program` reads, with one instruction per line."""
    lines = []
    if program.title is not None:
        lines.append(f".title {quoted(program.title)}")
    if program.axis is not None:
        lines.append(f".axis {program.axis}")
    if program.autostart is not None:
        lines.append(f".autostart {'on' if program.autostart else 'off'}")
    return "\n".join([*lines, *map(format_step, program.steps), ""])


def format_step(step: Step) -> str:
    """Return one instruction as text.

    >>> format_step(Step("IF INPUT", (1, 0)))
    'IF INPUT 1 = 0'
    """
    operands = zip(step.instruction.operands, step.values, strict=True)
    separator = " = " if step.name == "IF INPUT" else " "
    operands_text = separator.join(operand.written(value) for operand, value in operands)
    return f"{step.name} {operands_text}".strip()
