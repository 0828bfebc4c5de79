"""The structured text parser; `str()` of a statement returns its text.

The parser first removes comments. If regions do not nest properly with statements, which Studio 5000 allows,
their marks become comments. A comment after a statement on the same line belongs to that statement. Any other
comment belongs to the next statement or, at the end of a block, to an empty statement. `syntax` reads the
rest.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NoReturn, cast

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site

from ..instructions import BY_NAME
from ..model.errors import RungTextError
from ..model.spec import BYTE_ORDER_OF, BYTE_ORDERS, Spec, Use
from ..model.statements import (
    Arm,
    Assignment,
    Case,
    Choice,
    Empty,
    Exit,
    For,
    If,
    Invocation,
    Range,
    Region,
    Repeat,
    Return,
    While,
    too_deep,
)
from ..model.tree import LEVELS, Address, Block, Instruction, Operand, Origin, Statement, levels_of
from .syntax import TOO_MANY_LEVELS, Body, Conditional, LabeledBody, Mark, MisplacedError, Node, Syntax

_SKIPPED = re.compile(
    r"'(?:[^'$\n]++|\$[^\n])*+'?|(?P<region>#(?:end)?region\b[^\n]*)"
    r"|(?P<line>//[^\n]*)|(?P<block>\(\*.*?\*\)|/\*.*?\*/)|(?P<open>\(\*|/\*)",
    re.DOTALL | re.IGNORECASE,
)
"""Comments, and strings, which may contain comment signs; both may be unclosed."""

_INSIDE: Mapping[str, Callable[[str], str]] = {
    "line": lambda comment: comment[2:],
    "block": lambda comment: comment[2:-2],
    "region": str,
}
"""The text of a comment."""

_REGION = re.compile(r"#(?:end)?region\b", re.IGNORECASE)


def parse_statements(
    text: str,
    *,
    file: str = "",
    line: int = 1,
    lines: Sequence[int] = (),
    specs: Mapping[str, Spec] = BY_NAME,
) -> Block:
    """Read structured text.

    >>> print(parse_statements("if Run & (Level<5) then Valve:=1; end_if;")[0])
    IF Run AND Level<5 THEN
        Valve := 1;
    END_IF;

    Args:
        file: the file of the text, for messages.
        line: number of the text's first line in the file.
        lines: numbers of all lines of the text in the file, if they are not consecutive.
        specs: the available instructions, by name in capitals.

    Raises:
        RungTextError: the text has a syntax error; the message has the position and the expected text.
    """
    numbers = lines or range(line, line + text.count("\n") + 1)
    try:
        return _Reader(text, file, numbers, specs, regions=True).block()
    except RungTextError:
        if not _REGION.search(text):
            raise
    return _Reader(text, file, numbers, specs, regions=False).block()


@dataclass(frozen=True, slots=True)
class _Comment:
    """A comment and its position."""

    start: int
    text: str


class _Reader:
    """Reads one text and converts its nodes to statements.

    Each kind of node has a method that receives the children from the corresponding method of `Syntax`.
    """

    def __init__(
        self, text: str, file: str, lines: Sequence[int], specs: Mapping[str, Spec], *, regions: bool
    ) -> None:
        self._file, self._lines, self._specs, self._regions = file, lines, specs, regions
        self._comments: list[_Comment] = []
        self._full_text = text
        self._text = _SKIPPED.sub(self._blank, text)
        self._comments.reverse()  # the next comment is the last one

    def _blank(self, match: re.Match[str]) -> str:
        """Store a comment and return white space of its length; return other matches unchanged."""
        if match.lastgroup is None or (match.lastgroup == "region" and self._regions):
            return match.group()
        if match.lastgroup == "open":
            mark = "*)" if match.group() == "(*" else "*/"
            self._fail(match.start(), f"{mark} at the end of the comment", "the end of the text")
        inside = _INSIDE[match.lastgroup](match.group())
        text = "\n".join(line.strip() for line in inside.strip().splitlines())
        self._comments.append(_Comment(match.start(), text))
        return re.sub(r"[^\n]", " ", match.group())

    def block(self) -> Block:
        """Read the whole text; raise a RungTextError for an error or for too many nesting levels."""
        try:
            block = self._block(Body(Syntax(self._text).all_statements(), len(self._text)))
        except MisplacedError as error:
            self._fail(error.position, error.expected, error.actual)
        deep = too_deep(block)
        if deep:
            self._fail(0, "fewer", deep)
        return block

    # --- statements

    def _block(self, body: Body) -> Block:
        """Return a block; comments after its last statement, up to its end, become an empty statement."""
        statements = tuple(map(self._statement, body.nodes))
        comment = "" if body.end is None else self._comments_before(body.end)
        return (*statements, Empty(comment=comment)) if comment else statements

    def _statement(self, node: Node) -> Statement:
        """Create a statement with its position, and with the comments before it and at its end."""
        comment = self._comments_before(node.start)
        statement = _MAKERS[node.kind](self, node.children)
        trailing = self._comment_after(node.end)
        line, origin = self._position(node.start)
        return replace(
            statement, comment="\n".join(filter(None, (comment, trailing))), line=line, origin=origin
        )

    def _assignment(self, children: Sequence[Any]) -> Statement:
        base, *steps, operator, value = children
        target = self._checked(Address(str(base), tuple(steps)), base)
        return Assignment(target, self._checked(value, base), retentive=operator.type == "ASSIGN")

    def _invocation(self, children: Sequence[Any]) -> Statement:
        """Create an instruction's statement; fail for an unknown name or a wrong number of operands."""
        name, *arguments = children
        spec = self._specs.get(name.upper())
        if spec is None:
            self._fail(name.start, f"an instruction; {name} is unknown")
        if expected := spec.expected_count(len(arguments)):
            self._fail(name.start, f"{expected} operands of {spec.name}", str(len(arguments)))
        uses = [*spec.operands, *[Use.PARAMETERS] * len(arguments)]  # also for arguments beyond the operands
        operands = [
            self._argument(use, argument, name) for use, argument in zip(uses, arguments, strict=False)
        ]
        return Invocation(Instruction(spec.name, tuple(operands)))

    def _argument(self, use: Use, operand: Operand, name: Mark) -> Operand:
        """Return an operand in the form that its use requires; a MODE gets its usual spelling."""
        if use is Use.MODE:
            mode = str(operand).upper()
            if mode not in BYTE_ORDER_OF:
                self._fail(name.start, f"one of {', '.join(BYTE_ORDERS)}", mode)
            return Address(BYTE_ORDER_OF[mode])
        if operand == Address("") and use is not Use.LABEL:
            self._fail(name.start, f"an operand at every place of {name.upper()}", "none")
        return cast(Operand, self._checked(operand, name))

    def _if(self, children: Sequence[Any]) -> Statement:
        arms, otherwise = children
        return If(tuple(map(self._arm, arms)), otherwise and self._block(otherwise))

    def _arm(self, arm: Conditional) -> Arm:
        condition = self._checked(arm.condition, arm.mark)
        return Arm(condition, self._block(arm.body), *self._position(arm.mark.start))

    def _case(self, children: Sequence[Any]) -> Statement:
        mark, selector, choices, otherwise = children
        selector = self._checked(selector, mark)
        return Case(selector, tuple(map(self._choice, choices)), otherwise and self._block(otherwise))

    def _choice(self, choice: LabeledBody) -> Choice:
        comment = self._comments_before(choice.colon.start)
        labels = tuple(Range(low, high) for low, high in choice.ranges)
        block = self._block(choice.body)
        return Choice(labels, () if block == (Empty(),) else block, comment)

    def _for(self, children: Sequence[Any]) -> Statement:
        mark, name, count, first, last, step, body = children
        count = self._checked(count, name)
        first, last, step = (bound and self._checked(bound, mark) for bound in (first, last, step))
        return For(count, first, last, step, self._block(body))

    def _while(self, children: Sequence[Any]) -> Statement:
        mark, condition, body = children
        return While(self._checked(condition, mark), self._block(body))

    def _repeat(self, children: Sequence[Any]) -> Statement:
        body, until, condition = children
        block = self._block(body)
        line, _origin = self._position(until.start)
        return Repeat(block, self._checked(condition, until), line)

    def _region(self, children: Sequence[Any]) -> Statement:
        head, body = children
        return Region(head[len("#region") :].strip(), self._block(body))

    # --- positions, comments, errors

    def _checked(self, operand: Any, mark: Mark) -> Any:
        """Return an operand; fail at a mark if it has too many levels."""
        if levels_of(operand) > LEVELS:
            self._fail(mark.start, *TOO_MANY_LEVELS)
        return operand

    def _position(self, position: int) -> tuple[int, Origin]:
        """Return the line in the text, from 1, and the origin in the file."""
        line = self._full_text.count("\n", 0, position)
        return line + 1, Origin(self._file, self._lines[line])

    def _comments_before(self, end: int) -> str:
        """Remove and return the comments that begin before a position."""
        comments = []
        while self._comments and self._comments[-1].start < end:
            comments.append(self._comments.pop().text)
        return "\n".join(comments)

    def _comment_after(self, end: int) -> str:
        """Remove and return the comments that follow a statement on its line."""
        comments = []
        while self._comments:
            between = self._text[end : self._comments[-1].start]
            if between.strip() or "\n" in between:
                break
            comments.append(self._comments.pop().text)
        return "\n".join(comments)

    def _fail(self, position: int, expected: str, actual: str | None = None) -> NoReturn:
        """Raise a RungTextError at a position; by default, the actual text is the word there."""
        text_before = self._full_text[:position]
        column = position - (text_before.rfind("\n") + 1) + 1
        line = self._lines[text_before.count("\n")]
        if actual is None:
            shown = re.match(r"\w+|.", self._full_text[position:])
            actual = shown.group() if shown else "the end of the text"
        raise RungTextError(expected, actual, Site(file=self._file, line=line, column=column))


_MAKERS: Mapping[str, Callable[[_Reader, Sequence[Any]], Statement]] = {
    "assignment": _Reader._assignment,
    "invocation": _Reader._invocation,
    "if": _Reader._if,
    "case": _Reader._case,
    "for": _Reader._for,
    "while": _Reader._while,
    "repeat": _Reader._repeat,
    "region": _Reader._region,
    "exit": lambda _reader, _children: Exit(),
    "return": lambda _reader, _children: Return(),
    "empty": lambda _reader, _children: Empty(),
}
