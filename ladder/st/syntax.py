"""Recursive descent over structured text without comments, see `grammar`.

Statements become trees of marks, operands and other trees; expressions become operands at once. The parser
records each test of the next terminal, so that a message can list all terminals that are allowed there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, NoReturn

from scanrack.io_images.dataclass import dataclass

from ..model.errors import RungTextError
from ..model.expressions import parse_expression
from ..model.operators import FUNCTION_NAMES
from ..model.quoting import unquoted
from ..model.statements import BLOCKS
from ..model.tree import (
    LEVELS,
    Address,
    BitStep,
    Characters,
    MemberStep,
    Number,
    Operand,
    Operation,
    Step,
    SubscriptStep,
)
from .grammar import BINDING, END, OPERANDS, OPERATORS, PARTS, STATEMENTS, TERMINAL, TERMS, UNARY

MOST_OPEN = LEVELS * 3 // 2
"""Maximum number of brackets and operators around an operand; the level limit may be reached earlier."""

TOO_MANY_LEVELS = f"at most {LEVELS} levels of operators and subscripts", "more: compute it in parts"


class Mark(str):
    """The text of a terminal, with its type and its position in the text."""

    __slots__ = ("start", "type")
    type: str
    start: int

    @classmethod
    def of(cls, kind: str, text: str, start: int) -> Mark:
        """Return a mark."""
        mark = cls(text)
        mark.type, mark.start = kind, start
        return mark


@dataclass(frozen=True, slots=True)
class Node:
    """A statement or choice: its marks, operands, nodes and lists of statements, in order."""

    kind: str
    children: Sequence[Any]
    start: int
    end: int


class Body(NamedTuple):
    """The statements of a block."""

    nodes: list[Node]
    end: int | None  # position of the terminal after the block; None if a choice of a CASE follows


class Conditional(NamedTuple):
    """An IF or ELSIF."""

    mark: Mark
    condition: Operand
    body: Body


class LabeledBody(NamedTuple):
    """A choice of a CASE."""

    ranges: list[tuple[Number, Number]]
    colon: Mark
    body: Body


class MisplacedError(Exception):
    """An error at a position in the text; if `actual` is None, the text at that position is used."""

    def __init__(self, position: int, expected: str, actual: str | None = None) -> None:
        self.position, self.expected, self.actual = position, expected, actual


def marks_of(text: str) -> list[Mark]:
    """Return the terminals of a text; the last is the end, or a mark without a type for invalid text."""
    marks: list[Mark] = []
    position = 0
    while position < len(text):
        match = TERMINAL.match(text, position)
        if match is None:
            return [*marks, Mark.of("", text[position], position)]
        kind, value = match.lastgroup or "", match.group()
        if kind != "SPACE":
            marks.append(Mark.of(value.upper() if kind == "KEYWORD" else kind, value, position))
        position = match.end()
    return [*marks, Mark.of(END, "", len(text.rstrip()))]


class Syntax:
    """Reads the statements of one text; raises a MisplacedError for an error."""

    def __init__(self, text: str) -> None:
        self._marks = marks_of(text)
        self._index = 0
        self._tried: set[str] = set()  # terminals that were tried at the current mark
        self._open = 0  # number of brackets and operators around the current operand
        self._blocks = 0  # number of blocks around the current mark
        self._begin = 0  # start of the current statement or UNTIL, for errors in its expression

    def all_statements(self) -> list[Node]:
        """Read all statements."""
        block = self._block()
        self._expect(END)
        return block

    # --- marks

    def _next(self, *kinds: str) -> bool:
        """Record that terminals were tried; return whether one of them is next."""
        self._tried.update(kinds)
        return self._marks[self._index].type in kinds

    def _step(self) -> Mark:
        """Return the next mark and move past it, unless it is the last one."""
        mark = self._marks[self._index]
        self._index = min(self._index + 1, len(self._marks) - 1)
        self._tried.clear()
        return mark

    def _skip(self, kind: str) -> bool:
        """Move past a terminal if it is next; return whether it was."""
        is_next = self._next(kind)
        if is_next:
            self._step()
        return is_next

    def _expect(self, *kinds: str) -> Mark:
        """Return one of these terminals and move past it; raise a MisplacedError if none is next."""
        if not self._next(*kinds):
            self._fail()
        return self._step()

    def _fail(self) -> NoReturn:
        """Raise a MisplacedError at the current mark, which names the terminals that were tried."""
        mark = self._marks[self._index]
        if not mark.type:
            raise MisplacedError(mark.start, "structured text", str(mark))
        raise MisplacedError(mark.start, expected(self._tried), str(mark) or "the end of the text")

    # --- statements

    def _block(self) -> list[Node]:
        """Read statements up to a terminal that can't begin a statement."""
        nodes = []
        self._blocks += 1
        while self._next(*STATEMENTS):
            if self._blocks > BLOCKS + 1:
                position = self._marks[self._index].start
                raise MisplacedError(position, f"at most {BLOCKS} nested statements", "another one")
            mark = self._step()
            self._begin = mark.start
            kind, children = _STATEMENTS[mark.type](self, mark)
            last = self._marks[self._index - 1]
            nodes.append(Node(kind, children, mark.start, last.start + len(last)))
        self._blocks -= 1
        return nodes

    def _body(self, *ends: str) -> tuple[Body, Mark]:
        """Read a block and one of the terminals that may end it; return both."""
        nodes = self._block()
        end = self._expect(*ends)
        return Body(nodes, end.start), end

    def _ended(self, *children: Any) -> list[Any]:
        """Read the semicolon of a statement; return its children."""
        self._expect("SEMI")
        return list(children)

    def _named(self, name: Mark) -> tuple[str, list[Any]]:
        """Read an assignment or an invocation."""
        if self._skip("LPAR"):
            return "invocation", self._ended(name, *self._arguments())
        steps = self._steps()
        mark = self._expect("ASSIGN", "NON_RETENTIVE")
        return "assignment", self._ended(name, *steps, mark, self._expression())

    def _arguments(self) -> list[Any]:
        """Read the arguments of an invocation up to its closing parenthesis; an omitted one has no name."""
        arguments: list[Any] = []
        if self._skip("RPAR"):
            return arguments
        arguments.append(self._expression())
        while self._expect("COMMA", "RPAR").type == "COMMA":
            if self._next("COMMA", "RPAR"):
                arguments.append(Address(""))  # omitted, as in GSV(WallClockTime,,DateTime,Now)
            elif self._next("PERCENT"):
                arguments.append(Address(str(self._step())))  # a keyword of a motion instruction: `%ofTime`
            else:
                arguments.append(self._expression())
        return arguments

    def _if(self, mark: Mark) -> tuple[str, list[Any]]:
        """Read an IF after its first keyword; each IF or ELSIF is an arm, and a missing ELSE is None."""
        arms: list[Conditional] = []
        while mark.type in ("IF", "ELSIF"):
            self._begin = mark.start
            condition = self._expression()
            self._expect("THEN")
            body, following = self._body("ELSIF", "ELSE", "END_IF")
            arms.append(Conditional(mark, condition, body))
            mark = following
        otherwise = self._body("END_IF")[0] if mark.type == "ELSE" else None
        return "if", self._ended(arms, otherwise)

    def _case(self, mark: Mark) -> tuple[str, list[Any]]:
        """Read a CASE after its keyword; a missing ELSE is None."""
        selector = self._expression()
        self._expect("OF")
        choices: list[LabeledBody] = []
        while self._next("NUMBER", "MINUS"):
            choices.append(self._choice())
        otherwise = None
        if self._skip("ELSE"):
            otherwise, _ = self._body("END_CASE")
        else:
            self._expect("END_CASE")
        return "case", self._ended(mark, selector, choices, otherwise)

    def _choice(self) -> LabeledBody:
        """Read a choice of a CASE; its statements end before the next label, ELSE, or END_CASE."""
        ranges = [self._range()]
        while self._skip("COMMA"):
            ranges.append(self._range())
        colon = self._expect("COLON")
        nodes = self._block()
        end = None if self._next("NUMBER", "MINUS") else self._marks[self._index].start
        return LabeledBody(ranges, colon, Body(nodes, end))

    def _range(self) -> tuple[Number, Number]:
        """Read a range of numbers, or one number as both ends."""
        low = self._label()
        return low, self._label() if self._skip("DOTS") else low

    def _label(self) -> Number:
        """Read a number with its sign."""
        if self._skip("MINUS"):
            return _negative(number_of(self._expect("NUMBER")))
        return number_of(self._expect("NUMBER"))

    def _for(self, mark: Mark) -> tuple[str, list[Any]]:
        """Read a FOR after its keyword; the step is None without BY."""
        name = self._expect("BASE")
        count = Address(str(name), self._steps())
        self._expect("ASSIGN")
        first = self._expression()
        self._expect("TO")
        last = self._expression()
        step = self._expression() if self._skip("BY") else None
        self._expect("DO")
        body, _ = self._body("END_FOR")
        return "for", self._ended(mark, name, count, first, last, step, body)

    def _while(self, mark: Mark) -> tuple[str, list[Any]]:
        condition = self._expression()
        self._expect("DO")
        body, _ = self._body("END_WHILE")
        return "while", self._ended(mark, condition, body)

    def _repeat(self, _mark: Mark) -> tuple[str, list[Any]]:
        body, until = self._body("UNTIL")
        self._begin = until.start
        condition = self._expression()
        self._expect("END_REPEAT")
        return "repeat", self._ended(body, until, condition)

    def _region(self, mark: Mark) -> tuple[str, list[Any]]:
        return "region", [mark, self._body("END_REGION")[0]]

    # --- expressions

    def _expression(self, binding: int = 0) -> Operand:
        """Read an expression whose operators bind tighter than `binding`."""
        left = self._unary(power=binding == BINDING["POWER"])
        while self._next(*OPERATORS):
            operator = self._marks[self._index]
            level = BINDING[operator.type]
            if level <= binding:
                break
            self._step()
            name = operator.type if operator.type == "AND" else operator.upper()
            left = Operation(name, (left, self._inner(level)))
        return left

    def _unary(self, *, power: bool) -> Operand:
        """Read an operand and the operators before it; an exponent may have only minus signs."""
        if not power and self._skip("NOT"):
            return Operation("NOT", (self._inner(UNARY),))
        if not self._skip("MINUS"):
            return self._primary()
        positive = self._next("NUMBER")
        operand = self._inner(BINDING["POWER"] if power else UNARY)
        if positive and isinstance(operand, Number):
            return _negative(operand)
        return Operation("NEG", (operand,))

    def _inner(self, binding: int = 0) -> Operand:
        """Read an expression inside another."""
        self._open += 1
        if self._open > MOST_OPEN:
            raise MisplacedError(self._begin, *TOO_MANY_LEVELS)
        operand = self._expression(binding)
        self._open -= 1
        return operand

    def _primary(self) -> Operand:
        """Read a number, a string, an address, a function call, or an expression in parentheses."""
        mark = self._expect(*OPERANDS - {"NOT", "MINUS"})
        if mark.type == "NUMBER":
            return number_of(mark)
        if mark.type == "STRING":
            return _characters(mark)
        if mark.type == "BASE":
            return self._function(mark) if self._skip("LPAR") else Address(str(mark), self._steps())
        operand = self._inner()
        self._expect("RPAR")
        return operand

    def _function(self, mark: Mark) -> Operand:
        """Read the only argument of a function, after the opening parenthesis."""
        operand = self._inner()
        self._expect("RPAR")
        name = FUNCTION_NAMES.get(mark.upper())
        if name is None:
            raise MisplacedError(mark.start, f"a function ({', '.join(sorted(FUNCTION_NAMES))})", str(mark))
        return Operation(name, (operand,))

    def _steps(self) -> tuple[Step, ...]:
        """Read the members, bits and subscripts after the name of a tag."""
        steps: list[Step] = []
        while self._next("MEMBER", "BIT", "COMPUTED", "LSQB"):
            mark = self._step()
            if mark.type == "MEMBER":
                steps.append(MemberStep(mark.lstrip(". \t\n")))
            elif mark.type == "BIT":
                steps.append(BitStep(number_of(mark, mark[1:])))
            elif mark.type == "COMPUTED":
                steps.append(BitStep(self._inner()))
                self._expect("RSQB")
            else:
                indices = [self._inner()]
                while self._expect("COMMA", "RSQB").type == "COMMA":
                    indices.append(self._inner())
                steps.append(SubscriptStep(tuple(indices)))
        return tuple(steps)


def number_of(mark: Mark, text: str | None = None) -> Number:
    """Return the number in a mark, or in a part of its text."""
    try:
        return _literal(str(mark if text is None else text))
    except RungTextError as error:
        raise MisplacedError(mark.start, error.expected, str(mark)) from None


@lru_cache(maxsize=1024)
def _literal(text: str) -> Number:
    text = text if "#" in text else text.replace("_", "")
    literal = parse_expression(f"0{text}" if text.startswith(".") else text)
    assert isinstance(literal, Number)
    return literal


def _negative(positive: Number) -> Number:
    return Number(-positive.value, f"-{positive.text}")


def _characters(mark: Mark) -> Characters:
    """Return the characters of a string literal; raise a MisplacedError for an invalid escape."""
    try:
        return Characters(unquoted(mark[1:-1]))
    except ValueError as error:
        raise MisplacedError(mark.start, "escapes of characters", str(error)) from None


def expected(terminals: set[str]) -> str:
    """Return the allowed terminals as text for a message."""
    names = set(terminals)
    words: list[str] = []
    for word, group, sign in (
        ("an operator", OPERATORS, "OR"),
        ("a statement", STATEMENTS, "IF"),
        ("an expression", OPERANDS, "NOT"),
    ):
        if sign in names:
            names -= group
            words.append(word)
    if words or names - PARTS:
        names -= PARTS
    listed = sorted(dict.fromkeys(TERMS.get(name, name) for name in names))
    return " or ".join(words + listed)


_STATEMENTS: Mapping[str, Callable[[Syntax, Mark], tuple[str, list[Any]]]] = {
    "BASE": Syntax._named,
    "IF": Syntax._if,
    "CASE": Syntax._case,
    "FOR": Syntax._for,
    "WHILE": Syntax._while,
    "REPEAT": Syntax._repeat,
    "REGION": Syntax._region,
    "EXIT": lambda syntax, _mark: ("exit", syntax._ended()),
    "RETURN": lambda syntax, _mark: ("return", syntax._ended()),
    "SEMI": lambda _syntax, _mark: ("empty", []),
}
