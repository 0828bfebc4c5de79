"""Statements of structured text in the tree, with the same operands as rungs.

A routine has rungs or statements. A block is a sequence of statements; IF, CASE, FOR, WHILE, REPEAT and
regions contain blocks. `str()` of a statement is its text, with one statement per line and four spaces per
level.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, fields
from itertools import chain
from typing import Any, ClassVar

from scanrack.io_images.dataclass import dataclass

from .tree import Address, Block, Instruction, Number, NumberedLine, Operand, Origin, Statement, comment_lines

INDENT = "    "

BLOCKS = 32
"""Maximum depth of blocks."""

LOOPS = 12
"""Maximum depth of loops; Python allows 20."""


@dataclass(frozen=True, slots=True)
class Assignment(Statement):
    """`target := value;`."""

    target: Address
    value: Operand
    retentive: bool = True  # False for `[:=]`, whose target prescan clears

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"{self.target} {':=' if self.retentive else '[:=]'} {self.value};"


@dataclass(frozen=True, slots=True)
class Invocation(Statement):
    """An instruction as a statement: `TONR(Fill);`."""

    instruction: Instruction

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"{self.instruction};"


@dataclass(frozen=True, slots=True)
class Exit(Statement):
    """`EXIT;`: leaves the innermost loop."""

    head = "EXIT;"


@dataclass(frozen=True, slots=True)
class Return(Statement):
    """`RETURN;`: leaves the routine."""

    head = "RETURN;"


@dataclass(frozen=True, slots=True)
class Empty(Statement):
    """`;`: no operation, or the position of a comment after the last statement in a block."""

    head = ";"


@dataclass(frozen=True, slots=True)
class If(Statement):
    """IF, ELSIF, ELSE."""

    arms: tuple[Arm, ...]  # the first one with a true condition runs
    otherwise: Block | None = None  # the block of ELSE, None without one

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"IF {self.arms[0].condition} THEN"

    def numbered(self) -> Iterator[NumberedLine]:
        """See `Statement`."""
        for number, arm in enumerate(self.arms):
            yield arm.line, f"{'ELSIF' if number else 'IF'} {arm.condition} THEN"
            yield from _indented(arm.body)
        if self.otherwise is not None:
            yield 0, "ELSE"
            yield from _indented(self.otherwise)
        yield 0, "END_IF;"


@dataclass(frozen=True, slots=True)
class Arm:
    """A condition of IF or ELSIF, with its block."""

    condition: Operand
    body: Block
    line: int = field(default=0, compare=False)  # line of its keyword in the routine, see `Statement`
    origin: Origin = field(default=Origin(), compare=False)


@dataclass(frozen=True, slots=True)
class Range:
    """Labels in a CASE from `low` to `high`, inclusive; both are equal for a single label."""

    low: Number
    high: Number

    def __str__(self) -> str:
        return str(self.low) if self.low == self.high else f"{self.low}..{self.high}"


@dataclass(frozen=True, slots=True)
class Choice:
    """Labels in a CASE, with their block."""

    labels: tuple[Range, ...]
    body: Block
    comment: str = ""

    def numbered(self, *, last: bool) -> Iterator[NumberedLine]:
        """Yield its lines."""
        yield from comment_lines(self.comment)
        yield 0, f"{', '.join(map(str, self.labels))}:"
        yield from _indented(self.body or (Empty(),), closed=last)


@dataclass(frozen=True, slots=True)
class Case(Statement):
    """CASE: runs the first choice that contains the selector's value."""

    selector: Operand
    choices: tuple[Choice, ...]
    otherwise: Block | None = None  # the block of ELSE, None without one

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"CASE {self.selector} OF"

    def numbered(self) -> Iterator[NumberedLine]:
        """See `Statement`."""
        yield self.line, self.head
        for number, choice in enumerate(self.choices, start=1):
            last = number == len(self.choices)
            yield from ((line, INDENT + text) for line, text in choice.numbered(last=last))
        if self.otherwise is not None:
            yield 0, "ELSE"
            yield from _indented(self.otherwise)
        yield 0, "END_CASE;"


class Enclosing(Statement):
    """A statement with one block between its head and its end."""

    __slots__ = ()
    body: Block
    end: ClassVar[str]

    def numbered(self) -> Iterator[NumberedLine]:
        """See `Statement`."""
        yield self.line, self.head
        yield from _indented(self.body)
        yield 0, self.end


@dataclass(frozen=True, slots=True)
class For(Enclosing):
    """FOR: a block that runs once per value of a counter."""

    count: Address
    first: Operand
    last: Operand  # evaluated before each pass
    step: Operand | None  # evaluated and added after each pass, None = 1
    body: Block
    end = "END_FOR;"

    @property
    def head(self) -> str:
        """See `Statement`."""
        by = "" if self.step is None else f" BY {self.step}"
        return f"FOR {self.count} := {self.first} TO {self.last}{by} DO"


@dataclass(frozen=True, slots=True)
class While(Enclosing):
    """WHILE: a block that repeats as long as a condition is true before each pass."""

    condition: Operand
    body: Block
    end = "END_WHILE;"

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"WHILE {self.condition} DO"


@dataclass(frozen=True, slots=True)
class Repeat(Statement):
    """REPEAT: a block that repeats until a condition is true after a pass."""

    body: Block
    until: Operand
    until_line: int = field(default=0, compare=False)  # line of UNTIL in the routine, see `Statement`

    head = "REPEAT"

    @property
    def tail(self) -> str:
        """The line of the condition."""
        return f"UNTIL {self.until}"

    def numbered(self) -> Iterator[NumberedLine]:
        """See `Statement`."""
        yield self.line, self.head
        yield from _indented(self.body)
        yield self.until_line, self.tail
        yield 0, "END_REPEAT;"


@dataclass(frozen=True, slots=True)
class Region(Enclosing):
    """`#region name`: a named block without effect."""

    name: str
    body: Block
    end = "#endregion"

    @property
    def head(self) -> str:
        """See `Statement`."""
        return f"#region {self.name}".rstrip()


def numbered_lines(block: Block, *, closed: bool = True) -> Iterator[NumberedLine]:
    """Yield a block's lines with comments. If not `closed`, a comment at the end needs an empty statement."""
    for number, statement in enumerate(block, start=1):
        if isinstance(statement, Empty) and statement.comment and closed and number == len(block):
            yield from comment_lines(statement.comment)
        else:
            yield from statement.numbered_with_comment()


def block_lines(block: Block) -> Iterator[str]:
    """Yield the text of a block, line by line."""
    yield from (text for _, text in numbered_lines(block))


def _indented(block: Block, *, closed: bool = True) -> Iterator[NumberedLine]:
    yield from ((line, INDENT + text) for line, text in numbered_lines(block, closed=closed))


# --- walks


def blocks_in(statement: Statement) -> tuple[Block, ...]:
    """Return the blocks directly inside a statement."""
    if isinstance(statement, If):
        return (*(arm.body for arm in statement.arms), *_some(statement.otherwise))
    if isinstance(statement, Case):
        return (*(choice.body for choice in statement.choices), *_some(statement.otherwise))
    if isinstance(statement, (For, While, Repeat, Region)):
        return (statement.body,)
    return ()


def _some(block: Block | None) -> tuple[Block, ...]:
    return () if block is None else (block,)


def statements_in(block: Block) -> Iterator[Statement]:
    """Yield all statements of a block in text order, including nested ones."""
    for statement in block:
        yield statement
        for inner in blocks_in(statement):
            yield from statements_in(inner)


def operands_in(statement: Statement) -> tuple[Operand, ...]:
    """Return the operands of a statement, except those in its blocks."""
    values = [getattr(statement, attribute.name) for attribute in fields(statement)]
    return tuple(chain.from_iterable(map(_operands, values)))


def _operands(value: Any) -> Iterator[Operand]:
    """Yield the operands in the value of a statement's attribute, except those in its blocks."""
    if isinstance(value, Operand):
        yield value
    elif isinstance(value, Instruction):
        yield from value.operands
    elif isinstance(value, tuple):  # of arms, choices or statements
        yield from (arm.condition for arm in value if isinstance(arm, Arm))


def too_deep(block: Block) -> str | None:
    """Return the reason if a block is nested too deeply; otherwise None."""
    todo: list[tuple[Statement, int, int]] = [(outermost, 0, 0) for outermost in block]
    while todo:
        statement, blocks, loops = todo.pop()
        inner = blocks_in(statement)
        loops += isinstance(statement, (For, While, Repeat))
        if inner and blocks == BLOCKS:
            return f"statements are nested more than {BLOCKS} deep"
        if loops > LOOPS:
            return f"loops are nested more than {LOOPS} deep"
        todo += [(nested, blocks + 1, loops) for body in inner for nested in body]
    return None
