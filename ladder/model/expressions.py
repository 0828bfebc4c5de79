r"""Expressions and addresses as text.

address    = [ "\" program "." ] name
             { "." name | "." bit | ".[" expression "]" | "[" expression { "," expression } "]" }
| ("I" | "O") ":" slot [ "." word ] [ "/" bit ] | file ":" element [ "/" bit ] { "." name }
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import lru_cache
from typing import NoReturn

from .operators import FUNCTION_NAMES
from .scanner import Scanner
from .tree import (
    LEVEL,
    LEVELS,
    SUBSCRIPT,
    Address,
    BitStep,
    MemberStep,
    Number,
    Operand,
    Operation,
    SlashStep,
    Step,
    SubscriptStep,
    WordStep,
    levels_of,
)

NAME = re.compile(r"[A-Za-z_]\w*")
_OF_MODULE = r"(?::\d{1,5})?:(?:[IOCSiocs]|[Ss][IOCioc])\d{0,2}(?!\w)"
TAG_NAME = rf"(?:[A-Za-z_]\w*(?:{_OF_MODULE})?|&\w+{_OF_MODULE})"
"""Names of tags, such as `Run`, and of modules: `Rack:3:O`, `Drive:I1`, `Local:1:C`, `Gate:SI`.

Exports print `&4DA5D0F8:I` for a module without a name.
"""

TAG_BASE = rf"[Ss]:[A-Za-z]+|\\[A-Za-z_]\w*\.[A-Za-z_]\w*|{TAG_NAME}"
r"""Regular expression for the beginning of an address: a tag, `S:FS`, `\Program.Tag`."""

_BASE = re.compile(TAG_BASE)
_FILE = re.compile(r":(\d+)")
_SLOT_FILE = re.compile(r"[IiOo]:\d{1,5}(?!\d)")
_WORD = re.compile(r"\.(\d+)")
_SLASH = re.compile(r"/(\d+|[A-Za-z]\w*)")
_DIGITS = re.compile(r"\d+")
_NUMBER = re.compile(
    r"(?P<radix>16|8|2)#(?P<digits>[0-9A-Fa-f_]+)"
    r"|(?P<special>1\.(?:\$|#[A-Za-z]+)0*)"
    r"|(?P<time>[Tt](?:[Ii][Mm][Ee])?#[0-9_.A-Za-z]+)"
    r"|(?P<real>\d+\.\d*(?:[eE][+-]?\d+)?|\.\d+(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)|(?P<integer>\d+)"
)
_INFINITE = ("1.$", "1.#INF")
_NOT_A_NUMBER = ("1.#QNAN", "1.#SNAN", "1.#NAN", "1.#IND")
"""Notations of NaN in exports."""

_TIME_PART = re.compile(r"([0-9_]+(?:\.[0-9_]*)?)(d|h|ms|m|s)", re.IGNORECASE)
_PART_MS = {"d": 86_400_000, "h": 3_600_000, "m": 60_000, "s": 1_000, "ms": 1}
"""Units of a time such as T#1m30s, in ms."""
_OPERATOR = re.compile(r"\*\*|<>|<=|>=|[-+*/<>=]|&&?|\|\|?|(?:MOD|AND|OR|XOR)\b", re.IGNORECASE)
_SIGNS = {"&": "AND", "&&": "AND", "|": "OR", "||": "OR"}  # signs for operators that print as words
_NOT = re.compile(r"NOT\b", re.IGNORECASE)
_FUNCTION = re.compile(rf"(?:{'|'.join(FUNCTION_NAMES)})\s*\(", re.IGNORECASE)


_INDEX_DIGITS = 9  # maximum digits of an element or bit number; a longer one is never in range

MOST_DIGITS = 100
"""Maximum number of digits in a number, including leading zeros and underscores."""

_HIGHEST = (1 << 64) - 1  # highest integer that can be written


class ExpressionParser(Scanner):
    """A recursive descent parser for expressions and addresses."""

    _open = 0  # nested levels around the current position

    def whole_expression(self) -> Operand:
        """Read an outermost expression."""
        start = self.at
        operand = self.expression()
        if levels_of(operand) > LEVELS:
            self._refuse_levels(start)
        return operand

    def _refuse_levels(self, start: int) -> NoReturn:
        self.at = start
        self.fail(f"at most {LEVELS} levels of operators and subscripts", "more: compute it in parts")

    def _inner(self, levels: int, level: int = 0) -> Operand:
        """Read a nested expression with operators that bind at `level` or tighter."""
        self._open += levels
        if self._open > LEVELS:
            self._refuse_levels(self.at)
        operand = self.expression(level)
        self._open -= levels
        return operand

    def expression(self, level: int = 0) -> Operand:
        """Read an expression with operators that bind at `level` or tighter."""
        left = self._unary()
        while True:
            match = _OPERATOR.match(self.text, self.at)
            name = match.group().upper() if match else ""
            name = _SIGNS.get(name, name)
            strength = LEVEL.get(name, -1)
            if match is None or strength < level:
                return left
            self._move_to(match.end())
            left = Operation(name, (left, self.expression(strength + 1)))

    def _unary(self) -> Operand:
        """Read an operand, with an optional minus or NOT before it."""
        if self.text.startswith("-", self.at):
            return self._negative()
        negation = _NOT.match(self.text, self.at)
        if negation:
            self._move_to(negation.end())
            return Operation("NOT", (self._inner(1, LEVEL["NOT"]),))
        return self._primary()

    def _negative(self) -> Operand:
        """Read a minus and its operand. A minus and a number are one literal, except before **."""
        start = self.at
        self.skip("-")
        literal = _NUMBER.match(self.text, self.at)
        if literal:
            number = self._number()
            if not self.text.startswith("**", self.at):
                is_nan = number.value != number.value
                value = number.value if is_nan else -number.value
                return Number(value, f"-{number.text}")
            self.at = start
            self.skip("-")
        return Operation("NEG", (self._inner(1, LEVEL["NEG"]),))

    def _primary(self) -> Operand:
        """Read a parenthesized expression, a number, a function or an address."""
        if self.skip("("):
            inner = self._inner(1)
            if not self.skip(")"):
                self.fail("an operator or )")
            return inner
        if _NUMBER.match(self.text, self.at):
            return self._number()
        function = _FUNCTION.match(self.text, self.at)
        if function:
            name = FUNCTION_NAMES[function.group().rstrip("( \t\n").upper()]
            self._move_to(function.end())
            inner = self._inner(1)
            if not self.skip(")"):
                self.fail(f"an operator or ) of {name}")
            return Operation(name, (inner,))
        return self.address()

    def _number(self) -> Number:
        """Read a number in any notation; its text is in the printed form."""
        literal = _NUMBER.match(self.text, self.at)
        if literal is None:
            self.fail("a number")
        start = self.at
        text = literal.group()
        if literal["special"]:
            text = text.upper().rstrip("0")
            value: int | float = self._special(text)
        elif literal["time"]:
            value = self._time(text)
            text = text.upper()
        elif literal["real"]:
            value = float(text)
        elif literal["integer"]:
            value = self._integer(10, text, start)
            text = str(value)
        else:
            value = self._integer(int(literal["radix"]), literal["digits"], start)
            text = f"{literal['radix']}#{literal['digits'].upper()}"
        self._move_to(literal.end())
        return Number(value, text)

    def _special(self, text: str) -> float:
        """Return infinity or NaN from the text that exports print."""
        if text in _INFINITE:
            return math.inf
        if text not in _NOT_A_NUMBER:
            self.fail(f"a number, {', '.join(_INFINITE + _NOT_A_NUMBER)}", text)
        return math.nan

    def _time(self, text: str) -> int:
        """Return a time such as T#1m30s in ms."""
        parts = text.partition("#")[2]
        matches = list(_TIME_PART.finditer(parts))
        if "".join(match.group() for match in matches) != parts:
            self.fail("a time such as T#5s or T#1m30s", text)
        total = sum(Decimal(match[1].replace("_", "")) * _PART_MS[match[2].lower()] for match in matches)
        if total != int(total):
            self.fail("a time of whole milliseconds", text)
        return int(total)

    def _integer(self, radix: int, digits: str, start: int) -> int:
        """Return an integer; fail at `start` if a digit is invalid or the integer does not fit in 64 bits."""
        if len(digits) > MOST_DIGITS:
            self.at = start
            self.fail("a number of at most 64 bits", f"one of {len(digits)} digits")
        try:
            value = int(digits, radix)
        except ValueError:
            self.at = start
            self.fail(f"digits of radix {radix} after {radix}#")
        if value > _HIGHEST:
            self.at = start
            self.fail("a number of at most 64 bits", digits)
        if radix != 10 and 1 << 31 <= value < 1 << 32:
            value -= 1 << 32  # a DINT of that bit pattern
        return value

    def address(self) -> Address:
        """Read an address: a tag, module or data file, and all its steps."""
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
        self._skip_space()
        return Address(base.group(), tuple(steps))

    def _file_steps(self, base: str) -> tuple[Step, ...]:
        """Read the steps of a data file address."""
        if _SLOT_FILE.fullmatch(base):
            pattern, mark = _WORD, "."
        else:
            pattern, mark = _FILE, ":"
        element = pattern.match(self.text, self.at)
        if element is None:
            return (self._slash(),) if mark == "." and self.text.startswith("/", self.at) else ()
        self.at = element.end()
        word = WordStep(self._index(element.group(1)), mark)
        if self.text.startswith("/", self.at):
            return (word, self._slash())
        return (word,)

    def _slash(self) -> Step:
        """Read / and a bit's number or name."""
        match = _SLASH.match(self.text, self.at)
        if match is None:
            self.fail("a bit after /")
        self.at = match.end()
        bit = match.group(1)
        return SlashStep(self._index(bit)) if bit.isdigit() else MemberStep(bit)

    def _index(self, digits: str) -> int:
        if len(digits) > _INDEX_DIGITS:
            self.fail(f"a number of at most {_INDEX_DIGITS} digits", digits)
        return int(digits)

    def _step(self) -> Step | None:
        """Read one step of an address: subscripts, a bit or a member; return None at its end."""
        text = self.text
        if text.startswith("[", self.at):
            return self._subscripts()
        if not text.startswith(".", self.at):
            return None
        self.at += 1
        if text.startswith("[", self.at):
            self._move_to(self.at + 1)
            index = self._inner(SUBSCRIPT)
            self._close_subscript()
            return BitStep(index)
        digits = _DIGITS.match(text, self.at)
        if digits:
            number = self._index(digits.group())
            self.at = digits.end()
            return BitStep(Number(number, str(number)))
        name = NAME.match(text, self.at)
        if name is None:
            self.fail("a member or a bit after .")
        self.at = name.end()
        return MemberStep(name.group())

    def _subscripts(self) -> SubscriptStep:
        """Read the subscripts in brackets."""
        self._move_to(self.at + 1)
        indices = [self._inner(SUBSCRIPT)]
        while self.skip(","):
            indices.append(self._inner(SUBSCRIPT))
        self._close_subscript()
        return SubscriptStep(tuple(indices))

    def _close_subscript(self) -> None:
        if not self.text.startswith("]", self.at):
            self.fail("an operator or ] of the subscript")
        self.at += 1


@lru_cache(maxsize=1024)
def parse_address(text: str) -> Address:
    """Read an address in the form that `tags[...]` and aliases accept, or raise a RungTextError.

    >>> str(parse_address("Local:1:I.Data[0].14"))
    'Local:1:I.Data[0].14'
    """
    parser = ExpressionParser(text, file="", line=1, rung=None)
    address = parser.address()
    if not parser.ended():
        parser.fail("the end of the address")
    return address


def parse_expression(text: str) -> Operand:
    """Read an expression, a number or an address, or raise a RungTextError."""
    parser = ExpressionParser(text, file="", line=1, rung=None)
    operand = parser.whole_expression()
    if not parser.ended():
        parser.fail("an operator or the end")
    return operand
