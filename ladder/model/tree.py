"""The tree that all front ends build and all back ends run.

A program consists of tags and routines. A routine consists of rungs, or of statements of structured text
(`statements`). A rung is a series. A series consists of instructions and branches, and each leg of a branch
is a series. Operands are addresses, numbers, strings and, in CPT, CMP and subscripts, expressions. `str()` of
any node is its rung text.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.records import record

from . import hooks
from .quoting import quoted

# --- operands


@record
class Number:
    """A number as written. Numbers are equal if their texts are, so a NaN equals itself."""

    value: int | float = field(compare=False)
    text: str

    def __str__(self) -> str:
        return self.text


def number(value: int | float) -> Number:
    """Return a number node for a Python number.

    >>> str(number(5)), str(number(2.5)), str(number(-1e-9))
    ('5', '2.5', '-1.0e-09')
    """
    text = repr(value)
    if isinstance(value, float) and "e" in text and "." not in text:
        text = text.replace("e", ".0e")
    return Number(value, text)


@dataclass(frozen=True, slots=True)
class Characters:
    """A string; its text is in single quotes (see `quoting`)."""

    value: str

    def __str__(self) -> str:
        return quoted(self.value)


@dataclass(frozen=True, slots=True)
class Unknown:
    """The `?` of exported rungs in place of a tag's value."""

    def __str__(self) -> str:
        return "?"


@record
class MemberStep:
    """A member: `.ACC`."""

    name: str

    def __str__(self) -> str:
        return f".{self.name}"


@record
class SubscriptStep:
    """Subscripts: `[i,j]`."""

    indices: tuple[Operand, ...]

    def __str__(self) -> str:
        return f"[{','.join(map(str, self.indices))}]"


@record
class BitStep:
    """A bit: `.5` or `.[expression]`."""

    index: Operand

    def __str__(self) -> str:
        return f".{self.index}" if isinstance(self.index, Number) else f".[{self.index}]"


@dataclass(frozen=True, slots=True)
class WordStep:
    """The element of a data file: `:0` in `N7:0`, `.0` in `I:1.0`."""

    index: int
    mark: str

    def __str__(self) -> str:
        return f"{self.mark}{self.index}"


@dataclass(frozen=True, slots=True)
class SlashStep:
    """`/14`, the bit of a data file's word."""

    index: int

    def __str__(self) -> str:
        return f"/{self.index}"


Step = MemberStep | SubscriptStep | BitStep | WordStep | SlashStep


@record
class Address:
    """A tag or a part of one; `Local:1:I`, `I:1` and `S:FS` are also names."""

    name: str
    steps: tuple[Step, ...] = ()

    def __str__(self) -> str:
        return self.name + "".join(map(str, self.steps))

    def member(self, name: str) -> Address:
        """Return the address of a member."""
        return Address(self.name, (*self.steps, MemberStep(name)))


@dataclass(frozen=True, slots=True)
class Operation:
    """An operator or a function with its operands."""

    name: str  # `+ - * / ** MOD AND OR XOR = <> < <= > >=`, `NEG NOT`, or a function
    operands: tuple[Operand, ...]

    def __str__(self) -> str:
        return _text_at(self, 0)


Operand = Number | Characters | Unknown | Address | Operation

PRECEDENCE = (
    ("OR",),
    ("XOR",),
    ("AND",),
    ("=", "<>"),
    ("<", "<=", ">", ">="),
    ("+", "-"),
    ("*", "/", "MOD"),
    ("NEG", "NOT"),
    ("**",),
)
"""Operators from loosest to tightest [1756-RM003N p. 265 and 232]."""

LEVEL = {operator: level for level, operators in enumerate(PRECEDENCE) for operator in operators}
ATOM = len(PRECEDENCE)
WORDS = ("MOD", "AND", "OR", "XOR")
"""Operators that are words, and need spaces around them."""


def _text_at(node: Operand, level: int) -> str:
    """Return the text of a node, in parentheses if it binds less tightly than `level`."""
    if not isinstance(node, Operation):
        negative = isinstance(node, Number) and node.text.startswith("-")
        return f"({node})" if negative and level > LEVEL["+"] else str(node)
    strength = LEVEL.get(node.name, ATOM)
    text = _operation_text(node, strength)
    return f"({text})" if strength < level else text


def _operation_text(node: Operation, strength: int) -> str:
    """Return the text of an operation without outer parentheses; `strength` is its level."""
    if node.name == "NEG":
        inner = _text_at(node.operands[0], strength)
        return f"-({inner})" if inner[0] in "-0123456789" else f"-{inner}"
    if node.name == "NOT":
        return f"NOT {_text_at(node.operands[0], strength)}"
    if strength == ATOM:
        return f"{node.name}({_text_at(node.operands[0], 0)})"
    left, right = _text_at(node.operands[0], strength), _text_at(node.operands[1], strength + 1)
    if node.name == "/" and not left.endswith(")") and _ends_in_file(node.operands[0]):
        left = f"({left})"  # O:1.5/3 is a bit of O:1.5
    return f"{left} {node.name} {right}" if node.name in WORDS else f"{left}{node.name}{right}"


def _ends_in_file(node: Operand) -> bool:
    """Return whether the text ends in a data file address, after which `/` would select a bit."""
    if isinstance(node, Operation):
        return LEVEL.get(node.name, ATOM) != ATOM and _ends_in_file(node.operands[-1])
    return isinstance(node, Address) and (
        ":" in node.name or any(isinstance(step, WordStep) for step in node.steps)
    )


# --- rungs and statements


@record
class Instruction:
    """An instruction with its operands, under its canonical name (EQU, not EQ)."""

    name: str
    operands: tuple[Operand, ...] = ()

    def __str__(self) -> str:
        return f"{self.name}({','.join(map(str, self.operands))})"


@record
class Branch:
    """Parallel legs, each a series; an empty leg is a wire."""

    legs: tuple[Series, ...]

    def __str__(self) -> str:
        return f"[{','.join(map(series_text, self.legs))}]"


Element = Instruction | Branch
Series = tuple[Element, ...]


def series_text(series: Series) -> str:
    """Return the rung text of a series."""
    return "".join(map(str, series))


@record
class Origin:
    """File and line of a rung; "" and 0 if unknown."""

    file: str = ""
    line: int = 0


@record
class Rung:
    """A series with its comment; the origin does not affect equality."""

    series: Series
    comment: str = ""
    origin: Origin = field(default=Origin(), compare=False)

    def __str__(self) -> str:
        return f"{series_text(self.series)};"

    def _repr_html_(self) -> str:
        """Return the rung's drawing for a notebook."""
        return hooks.rung_svg(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class Statement:
    """A statement of structured text; the kinds are in `statements`."""

    comment: str = ""
    line: int = field(default=0, compare=False)  # from 1; 0 without text. Not part of its identity
    origin: Origin = field(default=Origin(), compare=False)

    @property
    def head(self) -> str:
        """The statement's text on one line, without inner blocks."""
        raise NotImplementedError

    def numbered(self) -> Iterator[NumberedLine]:
        """Yield its lines, without its comment."""
        yield self.line, self.head

    def numbered_with_comment(self) -> Iterator[NumberedLine]:
        """Yield its comment, then its lines."""
        yield from comment_lines(self.comment)
        yield from self.numbered()

    def __str__(self) -> str:
        return "\n".join(text for _, text in self.numbered_with_comment())


Block = tuple[Statement, ...]

NumberedLine = tuple[int, str]
"""The line number in the original text (0 if nothing runs there), and the printed line."""


def comment_lines(comment: str) -> Iterator[NumberedLine]:
    """Yield the lines of a comment."""
    yield from ((0, f"// {line}".rstrip()) for line in comment.split("\n") if comment)


def instructions_of(series: Series) -> Iterator[Instruction]:
    """Yield the instructions of a series in order of execution."""
    for element in series:
        if isinstance(element, Instruction):
            yield element
        else:
            for leg in element.legs:
                yield from instructions_of(leg)


BRANCHES = 32
"""Maximum nesting depth of branches; Studio 5000 draws six."""

LEVELS = 100
"""Maximum number of levels in an operand: one per operator or function, `SUBSCRIPT` per subscript."""

SUBSCRIPT = 3


def too_deep(series: Series) -> str | None:
    """Return the reason if a series is nested too deeply; otherwise None.

    >>> too_deep((Instruction("CPT", (Address("A"), number(1))),)) is None
    True
    """
    todo: list[tuple[Element, int]] = [(outermost, 0) for outermost in series]
    while todo:
        element, branches = todo.pop()
        if isinstance(element, Branch):
            if branches == BRANCHES:
                return f"branches are nested more than {BRANCHES} deep"
            todo += [(inner, branches + 1) for leg in element.legs for inner in leg]
        elif any(levels_of(operand) > LEVELS for operand in element.operands):
            return f"an operand of {element.name} has more than {LEVELS} levels of operators and subscripts"
    return None


def _operands_of(step: Step) -> Sequence[Operand]:
    """Return the operands in a step: subscripts, or the number of a bit."""
    if isinstance(step, SubscriptStep):
        return step.indices
    return (step.index,) if isinstance(step, BitStep) else ()


def levels_of(operand: Operand) -> int:
    """Return the levels of an operand (see `LEVELS`), without recursion, because operands can be deep."""
    if not isinstance(operand, Operation) and not (isinstance(operand, Address) and operand.steps):
        return 0
    deepest = 0
    todo: list[tuple[Operand, int]] = [(operand, 0)]
    while todo:
        node, above = todo.pop()
        deepest = max(deepest, above)
        if isinstance(node, Operation):
            todo += [(inner, above + 1) for inner in node.operands]
        elif isinstance(node, Address):
            todo += [(inner, above + SUBSCRIPT) for step in node.steps for inner in _operands_of(step)]
    return deepest


def addresses_in(operand: Operand) -> Iterator[Address]:
    """Yield the addresses in an operand and its subscripts from left to right, without recursion."""
    todo: list[Operand] = [operand]
    while todo:
        node = todo.pop()
        if isinstance(node, Operation):
            todo += reversed(node.operands)
        elif isinstance(node, Address):
            yield node
            todo += reversed([inner for step in node.steps for inner in _operands_of(step)])
