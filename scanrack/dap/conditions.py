"""Conditions and expressions of the query language, compiled to a function of one scan.

    "Position > 4000 and rose(Start)"   ->   lambda: Position > 4000 and rose_1(Start)

Names are tags of the program, read from the variables of its compiled scan, and words and bits of images. A
condition therefore costs a scan little more than the comparison.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import CellType, CodeType, FunctionType
from typing import Any, NamedTuple, Protocol

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedInput, VisitError
from scanrack.io_images.addresses import parse_address
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.times import parse_time
from scanrack.ladder.debug.tag_values import source_of
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.model.operands import Place
from scanrack.traces.query.expression import number_of
from scanrack.traces.query.grammar import GRAMMAR

Read = Callable[[], Any]


class Surroundings(NamedTuple):
    """What an expression reads beside the tags of a program."""

    words: Mapping[int, ModuleWords]  # of the modules, by slot
    image: Callable[[int, str, int], int]  # a word of an image: slot, "I" or "O", word
    now_ns: Read  # the time of the scan, ns
    scan: Read  # its number


class Values(Protocol):
    """The present values of a program."""

    tags: Any
    """By name; a mapping as far as `in` and `[]`."""

    def source(self, name: str) -> str:
        """Return the expression of Python that reads a tag; an ExpressionError if it is no single value."""

    @property
    def cells(self) -> Mapping[str, CellType]:
        """What the expressions name."""


class EngineValues:
    """Those of a ladder program, read from the variables of its compiled scan."""

    def __init__(self, engine: WatchedEngine) -> None:
        self.engine, self.tags = engine, engine.tags

    @property
    def cells(self) -> Mapping[str, CellType]:
        """See `Values`."""
        return self.engine.memory.cells

    def source(self, name: str) -> str:
        """See `Values`."""
        where = self.tags.where(name)
        if isinstance(where, Place) and not where.can_fault:
            return source_of(self.engine.lowered.layout, where)
        if isinstance(self.tags[name], str):
            return f"__tags[{name!r}]"
        raise ExpressionError(f"{name} is not a single value: compare one of its members or elements")


class NamedValues:
    """Those of a program without rungs, by name."""

    def __init__(self, tags: Mapping[str, Any]) -> None:
        self.tags = tags
        self.cells: Mapping[str, CellType] = {}

    def source(self, name: str) -> str:
        """See `Values`."""
        return f"__tags[{name!r}]"


class ExpressionError(ValueError):
    """An expression that can't be evaluated in one scan."""


class _Edge:
    """The value of the scan before; the first one is no edge."""

    def __init__(self) -> None:
        self._before: Any = None

    def rose(self, value: Any) -> bool:
        before, self._before = self._before, value
        return before is not None and bool(value) and not before

    def fell(self, value: Any) -> bool:
        before, self._before = self._before, value
        return before is not None and bool(before) and not value

    def changed(self, value: Any) -> bool:
        before, self._before = self._before, value
        return before is not None and bool(value != before)


def compiled(text: str, values: Values, around: Surroundings) -> Read:
    """Return the function that evaluates an expression after a scan.

    Raises:
        ExpressionError: it can't be parsed, names an unknown tag, or needs more than one scan.
    """
    writer = _Writer(values, around)
    try:
        source = writer.transform(_parser().parse(text))
    except UnexpectedInput as error:
        at = getattr(error, "column", 0)
        raise ExpressionError(f"{text!r}, column {max(1, at)}: not an expression of a query") from error
    except RecursionError as error:
        raise ExpressionError("the expression is nested too deeply") from error
    except VisitError as error:
        raise ExpressionError(f"{text!r}: {error.orig_exc}") from error
    cells = {**values.cells, **{name: CellType(value) for name, value in writer.own.items()}}
    return _function([*writer.first, f"return {source}"], cells)


@cache
def _parser() -> Lark:
    return Lark(GRAMMAR, start="condition", parser="lalr", maybe_placeholders=False)


def _function(statements: Sequence[str], cells: Mapping[str, CellType]) -> Read:
    body = "".join(f"  {each}\n" for each in statements)
    text = f"def outer({', '.join(cells)}):\n def take():\n{body}"
    outer = next(
        each for each in compile(text, "<expression>", "exec").co_consts if isinstance(each, CodeType)
    )
    code = next(each for each in outer.co_consts if isinstance(each, CodeType))
    return FunctionType(code, {"abs": abs}, "take", None, tuple(cells[name] for name in code.co_freevars))


@v_args(inline=True)
class _Writer(Transformer[Token, str]):
    """Writes Python, bottom up.

    Attributes:
        own: its variables beside those of the program.
        first: statements before the expression.
    """

    def __init__(self, values: Values, around: Surroundings) -> None:
        super().__init__()
        self._values, self._around = values, around
        self.first: list[str] = []
        self.own: dict[str, Any] = {
            "__image": around.image,
            "__now": around.now_ns,
            "__scan": around.scan,
            "__tags": values.tags,
        }

    def any_of(self, *parts: str) -> str:
        return f"({' or '.join(parts)})"

    def all_of(self, *parts: str) -> str:
        return f"({' and '.join(parts)})"

    def negation(self, part: str) -> str:
        return f"(not {part})"

    def held(self, _part: str, _time: Token) -> str:
        raise ExpressionError("'for' needs several scans: ask scanrack query")

    def edge(self, name: Token, part: str) -> str:
        own = f"edge{len(self.own)}"
        self.own[f"__{own}"] = getattr(_Edge(), name)
        self.first.append(f"{own} = __{own}({part})")  # in every scan, whatever stands before it
        return own

    def compare(self, left: str, sign: Token, right: str) -> str:
        return f"({left} {sign} {right})"

    def arithmetic(self, left: str, sign: Token, right: str) -> str:
        return f"({left} {sign} {right})"

    def signed(self, sign: Token, part: str) -> str:
        return f"({sign}{part})"

    def absolute(self, part: str) -> str:
        return f"abs({part})"

    def duration(self, token: Token) -> str:
        return str(parse_time(token))

    def number(self, token: Token) -> str:
        return repr(number_of(token))

    def text(self, token: Token) -> str:
        return repr(str(token)[1:-1])

    def name(self, token: Token) -> str:
        name = str(token)
        if name in ("time", "scan"):
            return "__now()" if name == "time" else "__scan()"
        if name.lower() in ("true", "false"):
            return name.capitalize()
        return self._values.source(name) if name in self._values.tags else self._image(name)

    def _image(self, name: str) -> str:
        try:
            at = parse_address(name, self._around.words)
        except ValueError as error:
            raise ExpressionError(f"no tag, word or bit {name}") from error
        word = f"__image({at.slot}, {at.image!r}, {at.word})"
        return word if at.bit is None else f"({word} >> {at.bit} & 1)"
