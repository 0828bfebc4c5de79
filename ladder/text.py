"""Rung text to tree; tree to rung text is `str()` of a node.

    rung       = series ";"
    series     = { instruction | branch }
    branch     = "[" series { "," series } "]"
    instruction = name "(" [ operand { "," operand } ] ")"
    operand    = expression | string | "?"
    address    = name { "." name | "." bit | ".[" expression "]" | "[" expression { "," expression } "]" }
               | ("I" | "O") ":" slot [ "." word ] [ "/" bit ] | file ":" element [ "/" bit ] { "." name }

White space may stand anywhere between these; the text of a tree has none. Names of
tags keep their case; names of instructions print in capitals and under one name.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NoReturn

from .errors import RungTextError
from .instructions import BY_NAME, BYTE_ORDERS, FUNCTION_NAMES, Spec, Use
from .tree import (
    LEVEL,
    PRECEDENCE,
    Address,
    BitStep,
    Branch,
    Characters,
    Element,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Operation,
    Origin,
    Rung,
    Series,
    SlashStep,
    Step,
    SubscriptStep,
    Unknown,
    WordStep,
)

_SPACE = re.compile(r"\s*")
_NAME = re.compile(r"[A-Za-z_]\w*")
_BASE = re.compile(r"[Ll]ocal:\d+:[IiOo]|[Ss]:[A-Za-z]+|[A-Za-z_]\w*")
_PLAIN = re.compile(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*\s*(?=[,)])")
_FILE = re.compile(r":(\d+)")
_SLOT_FILE = re.compile(r"[IiOo]:\d+")
_WORD = re.compile(r"\.(\d+)")
_SLASH = re.compile(r"/(\d+|[A-Za-z]\w*)")
_DIGITS = re.compile(r"\d+")
_NUMBER = re.compile(
    r"(?P<radix>16|8|2)#(?P<digits>[0-9A-Fa-f_]+)"
    r"|(?P<real>\d+\.\d*(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)|(?P<integer>\d+)"
)
_OPERATOR = re.compile(r"\*\*|<>|<=|>=|[-+*/<>=]|(?:MOD|AND|OR|XOR)\b", re.IGNORECASE)
_NOT = re.compile(r"NOT\b", re.IGNORECASE)
_FUNCTION = re.compile(rf"(?:{'|'.join(FUNCTION_NAMES)})\s*\(", re.IGNORECASE)
_MODE = re.compile(r"REVERSE|WORD|HIGH/?LOW|[012]", re.IGNORECASE)
_STRING = re.compile(r"'([^'\n]*)'")
_NUMBERED = {"0": BYTE_ORDERS[0], "1": BYTE_ORDERS[1], "2": BYTE_ORDERS[2], "HIGHLOW": BYTE_ORDERS[2]}


def parse_rung(
    text: str,
    *,
    file: str = "",
    line: int = 1,
    rung: int | None = 0,
    comment: str = "",
    specs: Mapping[str, Spec] = BY_NAME,
) -> Rung:
    """Read the text of one rung, with or without its semicolon.

    >>> str(parse_rung("XIC(Start) [XIO(Stop) , XIC(Jog)] OTE(Run)"))
    'XIC(Start)[XIO(Stop),XIC(Jog)]OTE(Run);'

    Args:
        text: the rung.
        file: where it is from, for messages.
        line: its first line there.
        rung: its number in its routine.
        comment: what is said of it.
        specs: the instructions that there are, by name in capitals.

    Raises:
        RungTextError: it is no rung; where, and what was expected.
    """
    parser = RungParser(text, file=file, line=line, rung=rung, specs=specs)
    series = parser.series()
    parser.skip(";")
    if not parser.ended():
        parser.fail("an instruction, a branch or ;")
    return Rung(series, comment, Origin(file, line))


def parse_address(text: str) -> Address:
    """Read an address, as `tags[...]` and aliases take it.

    >>> str(parse_address("Local:1:I.Data[0].14"))
    'Local:1:I.Data[0].14'

    Raises:
        RungTextError: it is no address.
    """
    parser = RungParser(text, file="", line=1, rung=None)
    address = parser.address()
    if not parser.ended():
        parser.fail("the end of the address")
    return address


def parse_expression(text: str) -> Operand:
    """Read an expression, a number or an address.

    Raises:
        RungTextError: it is none.
    """
    parser = RungParser(text, file="", line=1, rung=None)
    operand = parser.expression()
    if not parser.ended():
        parser.fail("an operator or the end")
    return operand


class RungParser:
    """Reads from a text at a position that moves on.

    Args:
        text: what is read.
        file: where it is from, for messages.
        line: number of its first line.
        rung: number of the rung, None if it is no rung.
        specs: the instructions that there are, by name in capitals.
    """

    def __init__(
        self, text: str, *, file: str, line: int, rung: int | None, specs: Mapping[str, Spec] = BY_NAME
    ) -> None:
        self.text, self.at = text.rstrip(), 0
        self._file, self._line, self._rung = file, line, rung
        self._specs = specs
        self._space()

    # --- rungs

    def series(self) -> Series:
        """Read instructions and branches as far as they go."""
        elements: list[Element] = []
        text = self.text
        while self.at < len(text):
            here = text[self.at]
            if here == "[":
                elements.append(self._branch())
            elif here.isalpha() or here == "_":
                elements.append(self._instruction())
            else:
                break
        return tuple(elements)

    def _branch(self) -> Branch:
        self.skip("[")
        legs = [self.series()]
        while self.skip(","):
            legs.append(self.series())
        if not self.skip("]"):
            self.fail("an instruction, , or ] of the branch")
        return Branch(tuple(legs))

    def _instruction(self) -> Instruction:
        start = self.at
        name = self._match(_NAME) or self.fail("an instruction")
        spec = self._specs.get(name.upper())
        if spec is None:
            self.at = start
            self.fail(f"an instruction; there is no {name}")
        if not self.skip("("):
            if spec.operands[spec.optional :]:
                self.fail(f"( after {spec.name}")
            return Instruction(spec.name)
        operands = self._operands(spec)
        self._check_count(spec, operands, start)
        return Instruction(spec.name, operands)

    def _operands(self, spec: Spec) -> tuple[Operand, ...]:
        operands: list[Operand] = []
        if self.skip(")"):
            return ()
        while True:
            use = spec.operands[min(len(operands), len(spec.operands) - 1)] if spec.operands else None
            operands.append(self._operand(use))
            if self.skip(")"):
                return tuple(operands)
            if not self.skip(","):
                self.fail(f", or ) in {spec.name}")

    def _check_count(self, spec: Spec, operands: tuple[Operand, ...], start: int) -> None:
        most = len(spec.operands)
        least = most - spec.optional - spec.variadic
        if len(operands) < least or (len(operands) > most and not spec.variadic):
            wanted = str(most) if least == most else f"{least} to {most}"
            found = f"{len(operands)}"
            self.at = start
            self.fail(f"{wanted} operands of {spec.name}", found)

    # --- operands

    def _operand(self, use: Use | None) -> Operand:
        plain = _PLAIN.match(self.text, self.at)
        if plain:
            self.at = plain.end()
            name, *members = plain.group().rstrip().split(".")
            return Address(name, tuple(map(MemberStep, members)))
        if use is Use.MODE:
            mode = (self._match(_MODE) or self.fail(f"one of {', '.join(BYTE_ORDERS)}")).upper()
            return Address(_NUMBERED.get(mode, mode))
        if self.skip("?"):
            return Unknown()
        string = _STRING.match(self.text, self.at)
        if string:
            self._move_to(string.end())
            return Characters(string.group(1))
        return self.expression()

    def expression(self, level: int = 0) -> Operand:
        """Read an expression whose operators bind at `level` or tighter."""
        left = self._unary()
        while True:
            found = _OPERATOR.match(self.text, self.at)
            name = found.group().upper() if found else ""
            own = LEVEL.get(name, -1)
            if found is None or own < level:
                return left
            self._move_to(found.end())
            left = Operation(name, (left, self.expression(own + 1)))

    def _unary(self) -> Operand:
        if self.text.startswith("-", self.at):
            return self._negative()
        negation = _NOT.match(self.text, self.at)
        if negation:
            self._move_to(negation.end())
            return Operation("NOT", (self.expression(LEVEL["NOT"]),))
        return self._primary()

    def _negative(self) -> Operand:
        start = self.at
        self.skip("-")
        literal = _NUMBER.match(self.text, self.at)
        if literal:
            number = self._number()
            if not self.text.startswith("**", self.at):
                return Number(-number.value, f"-{number.text}")
            self.at = start
            self.skip("-")
        return Operation("NEG", (self.expression(LEVEL["NEG"]),))

    def _primary(self) -> Operand:
        if self.skip("("):
            inner = self.expression()
            if not self.skip(")"):
                self.fail("an operator or )")
            return inner
        if _NUMBER.match(self.text, self.at):
            return self._number()
        function = _FUNCTION.match(self.text, self.at)
        if function:
            name = FUNCTION_NAMES[function.group().rstrip("( \t\n").upper()]
            self._move_to(function.end())
            inner = self.expression()
            if not self.skip(")"):
                self.fail(f"an operator or ) of {name}")
            return Operation(name, (inner,))
        return self.address()

    def _number(self) -> Number:
        literal = _NUMBER.match(self.text, self.at)
        if literal is None:
            self.fail("a number")
        start = self.at
        text = literal.group()
        if literal["real"]:
            value: int | float = float(text)
        elif literal["integer"]:
            value, text = int(text), str(int(text))
        else:
            value = self._of_radix(int(literal["radix"]), literal["digits"], start)
            text = f"{literal['radix']}#{literal['digits'].upper()}"
        self._move_to(literal.end())
        return Number(value, text)

    def _of_radix(self, radix: int, digits: str, start: int) -> int:
        try:
            value = int(digits, radix)
        except ValueError:
            self.at = start
            self.fail(f"digits of radix {radix} after {radix}#")
        if 1 << 31 <= value < 1 << 32:
            value -= 1 << 32  # a DINT of that bit pattern
        return value

    def address(self) -> Address:
        """Read an address."""
        start = self.at
        base = _SLOT_FILE.match(self.text, self.at) or _BASE.match(self.text, self.at)
        if base is None:
            self.fail("a tag, a number or a string" if self._rung is not None else "a tag")
        self.at = base.end()
        steps = list(self._file_steps(base.group()))
        while step := self._step():
            steps.append(step)
        if self.at < len(self.text) and self.text[self.at] == ":":
            self.at = start
            self.fail("a tag (Local:1:I, I:1, N7:0, S:FS)")
        self._space()
        return Address(base.group(), tuple(steps))

    def _file_steps(self, base: str) -> tuple[Step, ...]:
        """Steps of the data file notation."""
        if _SLOT_FILE.fullmatch(base):
            pattern, mark = _WORD, "."
        else:
            pattern, mark = _FILE, ":"
        element = pattern.match(self.text, self.at)
        if element is None:
            return (self._slash(),) if mark == "." and self.text.startswith("/", self.at) else ()
        self.at = element.end()
        word = WordStep(int(element.group(1)), mark)
        if self.text.startswith("/", self.at):
            return (word, self._slash())
        return (word,)

    def _slash(self) -> Step:
        found = _SLASH.match(self.text, self.at)
        if found is None:
            self.fail("a bit after /")
        self.at = found.end()
        what = found.group(1)
        return SlashStep(int(what)) if what.isdigit() else MemberStep(what)

    def _step(self) -> Step | None:
        text = self.text
        if text.startswith("[", self.at):
            return self._subscripts()
        if not text.startswith(".", self.at):
            return None
        self.at += 1
        if text.startswith("[", self.at):
            self._move_to(self.at + 1)
            index = self.expression()
            self._close_subscript()
            return BitStep(index)
        digits = _DIGITS.match(text, self.at)
        if digits:
            self.at = digits.end()
            return BitStep(Number(int(digits.group()), str(int(digits.group()))))
        name = _NAME.match(text, self.at)
        if name is None:
            self.fail("a member or a bit after .")
        self.at = name.end()
        return MemberStep(name.group())

    def _subscripts(self) -> SubscriptStep:
        self._move_to(self.at + 1)
        indices = [self.expression()]
        while self.skip(","):
            indices.append(self.expression())
        self._close_subscript()
        return SubscriptStep(tuple(indices))

    def _close_subscript(self) -> None:
        if not self.text.startswith("]", self.at):
            self.fail("an operator or ] of the subscript")
        self.at += 1

    # --- position

    def ended(self) -> bool:
        """Whether all has been read."""
        return self.at == len(self.text)

    def skip(self, mark: str) -> bool:
        """Move past `mark` and white space, if it stands here."""
        if not self.text.startswith(mark, self.at):
            return False
        self._move_to(self.at + len(mark))
        return True

    def fail(self, expected: str, found: str | None = None) -> NoReturn:
        """Raise: something else was expected here."""
        before = self.text[: self.at]
        line = self._line + before.count("\n")
        column = self.at - (before.rfind("\n") + 1) + 1
        if found is None:
            shown = re.match(r"\w+|.", self.text[self.at :])
            found = shown.group() if shown else "the end of the text"
        raise RungTextError(expected, found, file=self._file, line=line, column=column, rung=self._rung)

    def _match(self, pattern: re.Pattern[str]) -> str | None:
        found = pattern.match(self.text, self.at)
        if found is None:
            return None
        self._move_to(found.end())
        return found.group()

    def _move_to(self, at: int) -> None:
        match = _SPACE.match(self.text, at)
        self.at = match.end() if match else at

    def _space(self) -> None:
        self._move_to(self.at)


assert set(LEVEL) == {name for names in PRECEDENCE for name in names}
