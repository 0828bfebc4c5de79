"""The parser of rung text; `str()` turns a node back into text.

    rung       = series ";"
    series     = { instruction | branch }
    branch     = "[" series { "," series } "]"
    instruction = name "(" [ operand { "," operand } ] ")"
    operand    = expression | string | "?"

Expressions and addresses are in `expressions`. White space is allowed anywhere between these elements; text
printed from a tree has none. Names of tags keep their case; names of instructions print
in capitals, in their canonical form.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from typing_extensions import override

from ..instructions import BY_NAME
from ..model.expressions import NAME, ExpressionParser
from ..model.quoting import unquoted
from ..model.spec import BYTE_ORDER_OF, BYTE_ORDERS, Spec, Use
from ..model.tree import (
    BRANCHES,
    Address,
    Branch,
    Characters,
    Element,
    Instruction,
    MemberStep,
    Operand,
    Origin,
    Rung,
    Series,
    Unknown,
)

_WORDS = re.compile(r"(?:[A-Za-z_]\w*|%)(?:[ -]+[\w%]+)++(?=\s*[,)])|%\w+(?=\s*[,)])")
"""A keyword that is not a name, such as `Units per sec`, `% of Maximum` and `Download Input Parameters`."""

_PLAIN = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*+\s*(?=[,)])")
_MODE = re.compile(r"REVERSE|WORD|HIGH/?LOW|[012]", re.IGNORECASE)
_STRING = re.compile(r"'((?:[^'$\n]++|\$[^\n])*+)'")


def parse_rung(
    text: str,
    *,
    file: str = "",
    line: int = 1,
    rung: int | None = 0,
    comment: str = "",
    specs: Mapping[str, Spec] = BY_NAME,
) -> Rung:
    """Read one rung, with or without its semicolon.

    >>> str(parse_rung("XIC(Start) [XIO(Stop) , XIC(Jog)] OTE(Run)"))
    'XIC(Start)[XIO(Stop),XIC(Jog)]OTE(Run);'

    Args:
        file: the rung's file, for messages.
        line: the rung's first line in the file.
        rung: the rung's number in its routine.
        specs: the known instructions, by name in capitals.

    Raises:
        RungTextError: a syntax error; the message has the position and the expected text.
    """
    parser = RungParser(text, file=file, line=line, rung=rung, specs=specs)
    series = parser.series()
    parser.skip(";")
    if not parser.ended():
        parser.fail("an instruction, a branch or ;")
    return Rung(series, comment, Origin(file, line))


class RungParser(ExpressionParser):
    """Reads rungs that use the instructions `specs`, by name in capitals."""

    def __init__(
        self, text: str, *, file: str, line: int, rung: int | None, specs: Mapping[str, Spec] = BY_NAME
    ) -> None:
        super().__init__(text, file=file, line=line, rung=rung)
        self._specs = specs
        self._branches = 0

    def series(self) -> Series:
        """Read a series up to a character that can't continue it."""
        elements: list[Element] = []
        text = self.text
        while self.at < len(text):
            character = text[self.at]
            if character == "[":
                elements.append(self._branch())
            elif character.isalpha() or character == "_":
                elements.append(self._instruction())
            else:
                break
        return tuple(elements)

    def _branch(self) -> Branch:
        """Read a branch; fail if branches are nested too deeply."""
        if self._branches == BRANCHES:
            self.fail(f"at most {BRANCHES} nested branches", "another one")
        self._branches += 1
        self.skip("[")
        legs = [self.series()]
        while self.skip(","):
            legs.append(self.series())
        if not self.skip("]"):
            self.fail("an instruction, , or ] of the branch")
        self._branches -= 1
        return Branch(tuple(legs))

    def _instruction(self) -> Instruction:
        """Read an instruction; fail if it is unknown or the number of operands is wrong."""
        start = self.at
        name = self._match(NAME) or self.fail("an instruction")
        spec = self._specs.get(name.upper())
        if spec is None:
            self.at = start
            self.fail(f"an instruction; {name} is unknown")
        if not self.skip("("):
            if spec.operands[spec.optional :]:
                self.fail(f"( after {spec.name}")
            return Instruction(spec.name)
        operands = self._operands(spec)
        self._check_count(spec, operands, start)
        return Instruction(spec.name, operands)

    def _operands(self, spec: Spec) -> tuple[Operand, ...]:
        """Read operands up to the closing parenthesis."""
        operands: list[Operand] = []
        if self.skip(")"):
            return ()
        while True:
            operands.append(self._operand(spec.use_at(len(operands))))
            if self.skip(")"):
                return tuple(operands)
            if not self.skip(","):
                self.fail(f", or ) in {spec.name}")

    def _check_count(self, spec: Spec, operands: tuple[Operand, ...], start: int) -> None:
        if expected := spec.expected_count(len(operands)):
            self.at = start
            self.fail(f"{expected} operands of {spec.name}", str(len(operands)))

    def _operand(self, use: Use | None) -> Operand:
        """Read an operand; its use determines whether it can be a keyword, a byte order or omitted."""
        if use in (Use.LABEL, Use.ANYTHING) and self.text.startswith((",", ")"), self.at):
            return Address("")  # as in GSV(WallClockTime,,DateTime,Now)
        if use in (Use.KEYWORD, Use.LABEL, Use.ANYTHING) and (words := _WORDS.match(self.text, self.at)):
            self._move_to(words.end())
            return Address(words.group())
        plain = _PLAIN.match(self.text, self.at)
        if plain:
            self.at = plain.end()
            name, *members = plain.group().rstrip().split(".")
            return Address(name, tuple(map(MemberStep, members)))
        if use is Use.MODE:
            mode = self._match(_MODE) or self.fail(f"one of {', '.join(BYTE_ORDERS)}")
            return Address(BYTE_ORDER_OF[mode.upper()])
        if self.skip("?"):
            return Unknown()
        return self.whole_expression()

    @override
    def _primary(self) -> Operand:
        string = _STRING.match(self.text, self.at)
        return self._characters(string) if string else super()._primary()

    def _characters(self, literal: re.Match[str]) -> Characters:
        """Read a matched string literal; fail if it has an invalid escape."""
        try:
            value = unquoted(literal.group(1))
        except ValueError as error:
            self.fail("escapes of characters", str(error))
        self._move_to(literal.end())
        return Characters(value)
