"""The parser of structured text; `str()` of statements is their text again.

Comments are cut out first. So are the marks of regions that do not nest with the statements, as Studio 5000
allows: they become comments. A comment that begins after a statement on the same line belongs to that
statement, any other to the next statement. After the last statement of a block it gets an empty statement.
lark parses the rest. Expressions become operands during parsing, so that deep ones need no recursion.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import pairwise
from typing import Any, NoReturn, cast

from lark import Lark, Token, Transformer, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError

from ...io_images.site import Site
from ..instructions import BY_NAME
from ..model.errors import RungTextError
from ..model.expressions import parse_expression
from ..model.operators import FUNCTION_NAMES
from ..model.quoting import unquoted
from ..model.spec import BYTE_ORDERS, Spec, Use
from ..model.statements import (
    BLOCKS,
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
from ..model.tree import (
    LEVELS,
    Address,
    BitStep,
    Block,
    Characters,
    Instruction,
    MemberStep,
    Number,
    Operand,
    Operation,
    Origin,
    Statement,
    SubscriptStep,
    levels_of,
)
from .grammar import GRAMMAR, OPERANDS, OPERATORS, PARTS, STATEMENTS, TERMS

_SKIPPED = re.compile(
    r"'(?:[^'$\n]|\$[^\n])*'?|(?P<region>#(?:end)?region\b[^\n]*)"
    r"|(?P<line>//[^\n]*)|(?P<block>\(\*.*?\*\)|/\*.*?\*/)|(?P<open>\(\*|/\*)",
    re.DOTALL | re.IGNORECASE,
)
"""Comments, and strings, closed or not, which may contain comment signs."""

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
        file: its file, for messages.
        line: number of its first line there.
        lines: numbers of all its lines there, if they are not consecutive.
        specs: the available instructions, by name in capitals.

    Raises:
        RungTextError: a syntax error; where, and what was expected.
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


class _MisplacedError(Exception):
    """An error at a token that the grammar accepts."""

    def __init__(self, token: Token, expected: str, found: str | None = None) -> None:
        self.token, self.expected, self.found = token, expected, found


class _Expressions(Transformer[Token, Any]):
    """Builds operands while parsing. A number stays a token until it is used."""

    def operation(self, children: list[Any]) -> Operand:
        """Two operands and an operator."""
        left, operator, right = children
        name = "AND" if operator == "&" else str(operator).upper()
        return Operation(name, (_value(left), _value(right)))

    def negation(self, children: list[Any]) -> Operand:
        """Minus; a number becomes negative."""
        operand = children[1]
        if isinstance(operand, Token):
            positive = _number(operand)
            return Number(-positive.value, f"-{positive.text}")
        return Operation("NEG", (operand,))

    def inversion(self, children: list[Any]) -> Operand:
        return Operation("NOT", (_value(children[1]),))

    def group(self, children: list[Any]) -> Operand:
        return cast(Operand, _value(children[0]))

    def function(self, children: list[Any]) -> Operand:
        name = FUNCTION_NAMES.get(children[0].upper())
        if name is None:
            raise _MisplacedError(children[0], f"a function ({', '.join(sorted(FUNCTION_NAMES))})")
        return Operation(name, (_value(children[1]),))

    def string(self, children: list[Any]) -> Operand:
        try:
            return Characters(unquoted(children[0][1:-1]))
        except ValueError as error:
            raise _MisplacedError(children[0], "escapes of characters", str(error)) from None

    def missing(self, _children: list[Any]) -> Address:
        """An omitted operand, as in GSV(WallClockTime,,DateTime,Now)."""
        return Address("")

    def word(self, children: list[Any]) -> Address:
        """A word of a motion instruction: `%ofTime`."""
        return Address(str(children[0]))

    def address(self, children: list[Any]) -> Address:
        """A tag with steps, or a truth value, see `tags.TRUTHS`."""
        return Address(str(children[0]), tuple(children[1:]))

    def member(self, children: list[Any]) -> MemberStep:
        return MemberStep(children[0].lstrip(". \t\n"))

    def bit(self, children: list[Any]) -> BitStep:
        return BitStep(_number(children[0].update(value=children[0][1:])))

    def computed_bit(self, children: list[Any]) -> BitStep:
        return BitStep(_value(children[1]))

    def subscript(self, children: list[Any]) -> SubscriptStep:
        return SubscriptStep(tuple(map(_value, children)))

    def range(self, children: list[Any]) -> Range:
        """Labels of a choice."""
        return Range(children[0], children[-1])

    def label(self, children: list[Any]) -> Number:
        """A number with its sign."""
        literal = _number(children[-1])
        return literal if len(children) == 1 else Number(-literal.value, f"-{literal.text}")


def _value(child: Any) -> Any:
    return _number(child) if isinstance(child, Token) else child


def _number(token: Token) -> Number:
    text = token if "#" in token else token.replace("_", "")
    try:
        literal = parse_expression(f"0{text}" if text.startswith(".") else str(text))
    except RungTextError as error:
        raise _MisplacedError(token, error.expected) from None
    assert isinstance(literal, Number)
    return literal


@cache
def _parser() -> Lark:
    return Lark(
        GRAMMAR,
        parser="lalr",
        lexer="basic",
        transformer=_Expressions(),
        propagate_positions=True,
        maybe_placeholders=False,
    )


class _Reader:
    """Reads one text. Lark's trees have mixed children: tokens, operands, trees of statements."""

    def __init__(
        self, text: str, file: str, lines: Sequence[int], specs: Mapping[str, Spec], *, regions: bool
    ) -> None:
        self._file, self._lines, self._specs, self._regions = file, lines, specs, regions
        self._comments: list[_Comment] = []
        self._whole = text
        self._text = _SKIPPED.sub(self._blank, text)
        self._comments.reverse()

    def _blank(self, found: re.Match[str]) -> str:
        """Store a comment and return white space of its length; leave other matches."""
        if found.lastgroup is None or (found.lastgroup == "region" and self._regions):
            return found.group()
        if found.lastgroup == "open":
            mark = "*)" if found.group() == "(*" else "*/"
            self._fail(found.start(), f"{mark} at the end of the comment", "the end of the text")
        inside = _INSIDE[found.lastgroup](found.group())
        text = "\n".join(line.strip() for line in inside.strip().splitlines())
        self._comments.append(_Comment(found.start(), text))
        return re.sub(r"[^\n]", " ", found.group())

    def block(self) -> Block:
        try:
            tree = _parser().parse(self._text)
            self._refuse_depth(tree)
            block = self._block(tree.children[0], len(self._text))
        except VisitError as error:
            if not isinstance(error.orig_exc, _MisplacedError):
                raise
            self._misplaced(error.orig_exc)
        except _MisplacedError as error:
            self._misplaced(error)
        except UnexpectedInput as error:
            self._unexpected(error)
        deep = too_deep(block)
        if deep:
            self._fail(0, "fewer", deep)
        return block

    def _refuse_depth(self, tree: Any) -> None:
        """Refuse blocks that nest too deep for recursion."""
        todo = [(tree, 0)]
        while todo:
            node, depth = todo.pop()
            if depth > BLOCKS + 1:
                what = f"at most {BLOCKS} statements in one another"
                self._fail(_start(node), what, "another one")
            deeper = depth + (node.data == "block")
            todo += [(each, deeper) for each in node.children if isinstance(each, Tree)]

    # --- statements

    def _block(self, tree: Any, end: int) -> Block:
        """Return a block; comments after its last statement, up to `end`, become an empty statement."""
        found = tuple(map(self._statement, tree.children))
        rest = self._comments_before(end)
        return (*found, Empty(comment=rest)) if rest else found

    def _statement(self, tree: Any) -> Statement:
        start = _start(tree)
        comment = self._comments_before(start)
        made = _MAKERS[tree.data](self, tree)
        after = self._comment_after(tree.meta.end_pos)
        line, origin = self._place(start)
        return replace(made, comment="\n".join(filter(None, (comment, after))), line=line, origin=origin)

    def _assignment(self, tree: Any) -> Statement:
        operator = next(
            number for number, each in enumerate(tree.children) if _is(each, "ASSIGN", "NON_RETENTIVE")
        )
        base, *steps = tree.children[:operator]
        target = self._checked(Address(str(base), tuple(steps)), base)
        value = self._checked(_value(tree.children[operator + 1]), base)
        return Assignment(target, value, retentive=_is(tree.children[operator], "ASSIGN"))

    def _invocation(self, tree: Any) -> Statement:
        name, *given = tree.children[:-1]
        spec = self._specs.get(name.upper())
        if spec is None:
            self._fail(name.start_pos, f"an instruction; there is no {name}")
        most = len(spec.operands)
        least = most - spec.optional - spec.variadic
        if len(given) < least or (len(given) > most and not spec.variadic):
            wanted = str(most) if least == most else f"{least} to {most}"
            self._fail(name.start_pos, f"{wanted} operands of {spec.name}", str(len(given)))
        uses = [*spec.operands, *[Use.PARAMETERS] * len(given)]
        operands = [self._argument(use, _value(each), name) for use, each in zip(uses, given, strict=False)]
        return Invocation(Instruction(spec.name, tuple(operands)))

    def _argument(self, use: Use, operand: Operand, name: Token) -> Operand:
        if use is Use.MODE:
            mode = str(operand).upper()
            mode = {**dict(zip("012", BYTE_ORDERS, strict=True)), "HIGHLOW": BYTE_ORDERS[2]}.get(mode, mode)
            if mode not in BYTE_ORDERS:
                self._fail(name.start_pos, f"one of {', '.join(BYTE_ORDERS)}", mode)
            return Address(mode)
        if operand == Address("") and use is not Use.LABEL:
            self._fail(name.start_pos, f"an operand at every place of {name.upper()}", "none")
        return cast(Operand, self._checked(operand, name))

    def _if(self, tree: Any) -> Statement:
        arms: list[Arm] = []
        otherwise = None
        children = tree.children
        for place, each in enumerate(children):
            if _is(each, "IF", "ELSIF"):
                condition = self._checked(_value(children[place + 1]), each)
                body = self._block(children[place + 3], children[place + 4].start_pos)
                arms.append(Arm(condition, body, *self._place(each.start_pos)))
            elif _is(each, "ELSE"):
                otherwise = self._block(children[place + 1], children[place + 2].start_pos)
        return If(tuple(arms), otherwise)

    def _case(self, tree: Any) -> Statement:
        children = tree.children
        selector = self._checked(_value(children[1]), children[0])
        choices: list[Choice] = []
        otherwise = None
        for each, following in pairwise(children):
            if isinstance(each, Tree) and each.data == "choice":
                end = following.start_pos if isinstance(following, Token) else None
                choices.append(self._choice(each, end))
            elif _is(each, "ELSE"):
                end_case = next(mark for mark in children if _is(mark, "END_CASE"))
                otherwise = self._block(following, end_case.start_pos)
        return Case(selector, tuple(choices), otherwise)

    def _choice(self, tree: Any, end: int | None) -> Choice:
        """Return a choice. Without `end`, comments after its block belong to the next choice."""
        colon = next(each for each in tree.children if _is(each, "COLON"))
        comment = self._comments_before(colon.start_pos)
        labels = tuple(each for each in tree.children if isinstance(each, Range))
        body = tree.children[-1]
        block = tuple(map(self._statement, body.children)) if end is None else self._block(body, end)
        return Choice(labels, () if block == (Empty(),) else block, comment)

    def _for(self, tree: Any) -> Statement:
        keywords = {each.type: number for number, each in enumerate(tree.children) if isinstance(each, Token)}
        children, mark = tree.children, tree.children[0]

        def operand(keyword: str) -> Any:
            return self._checked(_value(children[keywords[keyword] + 1]), mark)

        base, *steps = children[1 : keywords["ASSIGN"]]
        count = self._checked(Address(str(base), tuple(steps)), base)
        first, last = operand("ASSIGN"), operand("TO")
        step = operand("BY") if "BY" in keywords else None
        body = self._block(children[keywords["DO"] + 1], children[keywords["END_FOR"]].start_pos)
        return For(count, first, last, step, body)

    def _while(self, tree: Any) -> Statement:
        mark, condition, _do, body, end, _semi = tree.children
        return While(self._checked(_value(condition), mark), self._block(body, end.start_pos))

    def _repeat(self, tree: Any) -> Statement:
        _mark, body, until, condition, *_end = tree.children
        block = self._block(body, until.start_pos)
        line, _origin = self._place(until.start_pos)
        return Repeat(block, self._checked(_value(condition), until), line)

    def _region(self, tree: Any) -> Statement:
        head, body, end = tree.children
        return Region(head[len("#region") :].strip(), self._block(body, end.start_pos))

    # --- places, comments, refusals

    def _checked(self, operand: Any, mark: Token) -> Any:
        if levels_of(operand) > LEVELS:
            self._fail(
                mark.start_pos,
                f"at most {LEVELS} levels of operators and subscripts",
                "more: compute it in parts",
            )
        return operand

    def _place(self, at: int) -> tuple[int, Origin]:
        line = self._whole.count("\n", 0, at)
        return line + 1, Origin(self._file, self._lines[line])

    def _comments_before(self, end: int) -> str:
        found = []
        while self._comments and self._comments[-1].start < end:
            found.append(self._comments.pop().text)
        return "\n".join(found)

    def _comment_after(self, end: int) -> str:
        """Return the comments that begin on a statement's line."""
        found = []
        while self._comments:
            between = self._text[end : self._comments[-1].start]
            if between.strip() or "\n" in between:
                break
            found.append(self._comments.pop().text)
        return "\n".join(found)

    def _misplaced(self, error: _MisplacedError) -> NoReturn:
        self._fail(error.token.start_pos, error.expected, error.found or str(error.token))

    def _unexpected(self, error: UnexpectedInput) -> NoReturn:
        if isinstance(error, UnexpectedCharacters):
            at: Any = error.pos_in_stream
            self._fail(at, "structured text", self._text[at])
        assert isinstance(error, UnexpectedToken)
        token = error.token
        at = len(self._text.rstrip()) if token.type == "$END" else token.start_pos or 0
        found = "the end of the text" if token.type == "$END" else str(token)
        self._fail(at, _expected(error.accepts or error.expected), found)

    def _fail(self, at: int | None, expected: str, found: str | None = None) -> NoReturn:
        at = at or 0
        before = self._whole[:at]
        column = at - (before.rfind("\n") + 1) + 1
        line = self._lines[before.count("\n")]
        if found is None:
            shown = re.match(r"\w+|.", self._whole[at:])
            found = shown.group() if shown else "the end of the text"
        raise RungTextError(expected, found, Site(file=self._file, line=line, column=column))


def _is(node: object, *types: str) -> bool:
    return isinstance(node, Token) and node.type in types


def _start(tree: Any) -> int:
    return int(getattr(tree.meta, "start_pos", 0))


def _expected(terminals: Iterable[str]) -> str:
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


_MAKERS: Mapping[str, Callable[[_Reader, Any], Statement]] = {
    "assignment": _Reader._assignment,
    "invocation": _Reader._invocation,
    "if_": _Reader._if,
    "case": _Reader._case,
    "for_": _Reader._for,
    "while_": _Reader._while,
    "repeat": _Reader._repeat,
    "region": _Reader._region,
    "exit": lambda _reader, _tree: Exit(),
    "return_": lambda _reader, _tree: Return(),
    "empty": lambda _reader, _tree: Empty(),
}
