"""Reads and writes rungs: the words between SOR and EOR.

The words after a mnemonic, up to the next mnemonic, are its operands. `BST ... NXB ... BND` is a branch with
two legs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import NoReturn

from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_expression
from scanrack.ladder.model.spec import Spec, Use
from scanrack.ladder.model.tree import (
    BRANCHES,
    Address,
    Branch,
    Characters,
    Element,
    Instruction,
    Number,
    Operand,
    Operation,
    Series,
    Unknown,
    number,
)

from .addresses import AddressTextError, is_address, parse, text_of

BEGIN, NEXT, END = "BST", "NXB", "BND"
"""Words of a branch."""

FILES = frozenset({Use.SOURCE, Use.DESTINATION, Use.TABLE, Use.ARRAY})
"""Uses of an operand that is a file, which exports write with `#`."""

_WORDS = frozenset({Use.IGNORED, Use.SHOWN, Use.ANYTHING, Use.PARAMETERS, Use.TEXT})
"""Uses that accept any word as the operand."""

_HEX = re.compile(r"(?:16#|0x)([0-9A-F]+)|([0-9A-F]+)h|(?=[0-9]*[A-F])([0-9A-F]{4})", re.IGNORECASE)
"""Hexadecimal numbers: `0FF0h`, `16#FF0`, and masks of four digits, `FFFF`."""
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:E[+-]?\d+)?", re.IGNORECASE)
_NAME = re.compile(r"[A-Z_]\w*", re.IGNORECASE)
_IN_EXPRESSION = re.compile(r"#?[A-Z]{1,3}\d{0,3}(?::(?:\d+|\[[^\]]+\]))?(?:\.\w+)?(?:/\w+)?", re.IGNORECASE)

_PLACEHOLDER = re.compile(r"slc_(\d{1,4})")  # a placeholder for an address in an expression

ROUTINE_WORD = re.compile(r"(?:U:?)?(\d{1,3})", re.IGNORECASE)
"""The operand of JSR."""

ROUTINE = "U"
"""Prefix of a routine's name, before the number of its ladder file."""


class RungError(LadderError):
    """A rung can't be read; the column is counted from 1 at SOR."""

    def __init__(self, text: str, column: int, remedy: str) -> None:
        self.column, self.remedy = column, remedy
        super().__init__(text)


class RungReader:
    """Reads rungs, with specs by name in capitals."""

    def __init__(self, specs: Mapping[str, Spec]) -> None:
        self._specs = specs

    def read(self, words: Sequence[str]) -> Series:
        """Read a rung; raise a RungError if it is invalid."""
        self._words = list(words)
        self._columns: list[int] = []  # of the words
        column = len("SOR ") + 1
        for word in words:
            self._columns.append(column)
            column += len(word) + 1
        self._end = column
        self._index = 0  # of the next word
        self._depth = 0  # of branches
        series = self._series()
        if self._index < len(self._words):
            self._fail(f"{self._words[self._index]} is outside of a branch", "begin the branch with BST")
        return series

    def _fail(self, text: str, remedy: str, index: int | None = None) -> NoReturn:
        """Raise a RungError at the word with this index, by default the next word."""
        if index is None:
            index = self._index
        column = self._columns[index] if index < len(self._columns) else self._end
        raise RungError(text, column, remedy)

    def _peek(self) -> str:
        """Return the next word in capitals; "" at the end."""
        return self._words[self._index].upper() if self._index < len(self._words) else ""

    def _series(self) -> Series:
        """Read elements up to the end of the rung or of a leg."""
        elements: list[Element] = []
        while (word := self._peek()) and word not in (NEXT, END):
            elements.append(self._branch() if word == BEGIN else self._instruction())
        return tuple(elements)

    def _branch(self) -> Branch:
        """Read a branch from BST to BND; refuse one that is nested too deep or has no BND."""
        if self._depth == BRANCHES:
            self._fail(f"the rung has more than {BRANCHES} nested branches", "use several rungs")
        self._depth += 1
        self._index += 1
        legs = [self._series()]
        while self._peek() == NEXT:
            self._index += 1
            legs.append(self._series())
        if self._peek() != END:
            self._fail("the branch has no BND", "end it with BND")
        self._index += 1
        self._depth -= 1
        return Branch(tuple(legs))

    def _instruction(self) -> Instruction:
        """Read a mnemonic and its operands.

        The operands end at a mnemonic, a word of a branch, or the end. After all operands, a word that could
        be the mnemonic of an unknown instruction also ends them.
        """
        start = self._index
        name = self._peek()
        spec = self._specs.get(name)
        if spec is None:
            self._fail(f"no instruction {name}", f"stub it: {name} = 'false'")
        self._index += 1
        needed = len(spec.operands) - spec.optional
        while (word := self._peek()) and word not in (BEGIN, NEXT, END):
            is_complete = self._index - start > needed and not spec.variadic
            if word in self._specs or (is_complete and self._looks_like_mnemonic(word)):
                break
            self._index += 1
        words = self._words[start + 1 : self._index]
        if name == "CPT" and len(words) > 2:  # the expression has blanks
            words = [words[0], " ".join(words[1:])]
        operands = self._operands(spec, words, start + 1)
        self._check_count(spec, len(operands), start)
        return Instruction(spec.name, tuple(operands))

    def _looks_like_mnemonic(self, word: str) -> bool:
        """Return whether a word could be the mnemonic of an unknown instruction."""
        is_name = _NAME.fullmatch(word) is not None and len(word) <= 4
        return is_name and not is_address(word) and _HEX.fullmatch(word) is None

    def _check_count(self, spec: Spec, count: int, index: int) -> None:
        """Refuse an instruction with the wrong number of operands; `index` is the word to report."""
        expected = spec.expected_count(count)
        if expected:
            self._fail(f"{spec.name} takes {expected} operands, {count} are given", "correct the rung", index)

    def _operands(self, spec: Spec, words: Sequence[str], first_index: int) -> list[Operand]:
        """Return the operands of an instruction from its words, which begin at an index."""
        if spec.name == "JSR":
            return [self._routine(words[0], first_index)] if words else []
        operands: list[Operand] = []
        for position, word in enumerate(words):
            try:
                operands.append(read_operand(spec.use_at(position) or Use.IGNORED, word))
            except LadderError as error:
                self._fail(str(error), "write an address, a number or an expression", first_index + position)
        return operands

    def _routine(self, word: str, index: int) -> Address:
        """Return the address of the routine that JSR calls."""
        digits = ROUTINE_WORD.fullmatch(word)
        if digits is None:
            self._fail(f"{word} is not a ladder file", "write its number, as in JSR U:3", index)
        return Address(routine_name(int(digits[1])))


def routine_name(file: int) -> str:
    """Return the name of a ladder file's routine.

    >>> routine_name(3)
    'U3'
    """
    return f"{ROUTINE}{file}"


def read_operand(use: Use, word: str) -> Operand:
    """Read an operand of an instruction; raise a LadderError if it is invalid."""
    if use is Use.LABEL:
        return Address(re.sub(r"\W", "_", word.upper()))
    if word == "?":
        return Unknown()
    if '"' in word and re.fullmatch(r'"[^"]*"', word) is None:
        raise AddressTextError(f"{word} has a quotation mark inside")
    if is_address(word):
        return parse(word, file=use in FILES)
    if _NUMBER.fullmatch(word) or _HEX.fullmatch(word):
        return _number(word)
    if use in (Use.EXPRESSION, Use.CONDITION):
        return _expression(word)
    if use in _WORDS:
        return Characters(word.strip('"'))
    raise AddressTextError(f"{word!r} is neither an address nor a number")


def _number(word: str) -> Number:
    """Return a decimal or hexadecimal number; a hexadecimal one above 7FFF is a negative word."""
    digits = _HEX.fullmatch(word)
    if digits is None:
        return number(float(word) if re.search(r"[.eE]", word) else int(word))
    value = int(digits.group(1) or digits.group(2) or digits.group(3), 16)
    if 1 << 15 <= value < 1 << 16:
        return number(value - (1 << 16))  # words are signed
    return Number(value, f"16#{value:X}")


def _expression(text: str) -> Operand:
    """Read an expression; RSLogix 500 divides with `|`, because `/` selects a bit.

    The parser of expressions can't read addresses of data files, so they become placeholders.
    """
    addresses: list[Address] = []

    def placeholder(match: re.Match[str]) -> str:
        if not is_address(match[0]):
            return match[0]
        addresses.append(parse(match[0]))
        return f"slc_{len(addresses) - 1}"

    expression = parse_expression(_IN_EXPRESSION.sub(placeholder, text).replace("|", "/"))
    return _with_addresses(expression, addresses)


def _with_addresses(operand: Operand, addresses: Sequence[Address]) -> Operand:
    """Return an expression with addresses in place of placeholders."""
    if isinstance(operand, Operation):
        return Operation(operand.name, tuple(_with_addresses(inner, addresses) for inner in operand.operands))
    if not isinstance(operand, Address):
        return operand
    placeholder = _PLACEHOLDER.fullmatch(str(operand))
    if placeholder is None or int(placeholder[1]) >= len(addresses):
        raise AddressTextError(f"{operand} is not an address of a data file")
    return addresses[int(placeholder[1])]


# --- back to text


def rung_text(series: Series, specs: Mapping[str, Spec]) -> str:
    """Return a rung in the notation of exports, without SOR and EOR."""
    return " ".join(_element_text(element, specs) for element in series)


def _element_text(element: Element, specs: Mapping[str, Spec]) -> str:
    """Return an instruction or a branch in the notation of exports."""
    if isinstance(element, Branch):
        legs = f" {NEXT} ".join(rung_text(leg, specs) for leg in element.legs)
        return " ".join(f"{BEGIN} {legs} {END}".split())
    spec = specs.get(element.name)
    words = [element.name]
    for index, operand in enumerate(element.operands):
        use = spec.use_at(index) if spec else None
        words.append(_operand_text(element.name, use, operand))
    return " ".join(words)


def _operand_text(name: str, use: Use | None, operand: Operand) -> str:
    """Return an operand in the notation of exports; inverse of `read_operand`."""
    if name == "JSR" and isinstance(operand, Address):
        return f"U:{operand.name[len(ROUTINE) :]}"
    if use is Use.LABEL and isinstance(operand, Address):
        return operand.name.replace("_", ":")
    if isinstance(operand, Characters):
        return f'"{operand.value}"'
    if isinstance(operand, Number) and operand.text.startswith("16#"):
        return f"0{operand.text[3:]}h"
    if isinstance(operand, Operation):
        return _expression_text(operand)
    return text_of(operand, file=use in FILES)


def _expression_text(operand: Operand) -> str:
    """Return an expression, fully parenthesized, with `|` for division."""
    if not isinstance(operand, Operation):
        return text_of(operand)
    operand_texts = [_expression_text(part) for part in operand.operands]
    if len(operand_texts) == 1:
        sign = {"NEG": "-", "NOT": "NOT "}.get(operand.name)
        return f"{sign}({operand_texts[0]})" if sign else f"{operand.name}({operand_texts[0]})"
    name = "|" if operand.name == "/" else operand.name
    return f"({operand_texts[0]} {name} {operand_texts[1]})"
