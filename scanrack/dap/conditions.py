"""Conditions and expressions of the query language, compiled to functions that evaluate them after a scan.

    "Position > 4000 and rose(Start)"   ->   lambda: Position > 4000 and rose_1(Start)

A name is a tag of the program, or a word or bit of an image. Tags are read from the variables of the compiled
scan. A condition therefore adds little more than its comparison to a scan.

A number can have the unit that the page shows for a tag: `Position > 4000 steps`. Times are converted to that
unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from types import CellType, CodeType, FunctionType, MappingProxyType
from typing import Any, NamedTuple, Protocol

from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedInput, VisitError
from scanrack.io_images.addresses import parse_address
from scanrack.io_images.module_words import ModuleWords
from scanrack.io_images.times import UNITS_NS, parse_time
from scanrack.ladder.debug.tag_values import source_of
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.model.operands import Place
from scanrack.ladder.model.types import TIMER
from scanrack.traces.query.expression import number_of
from scanrack.traces.query.grammar import GRAMMAR

Read = Callable[[], Any]

_SEVERAL = re.compile(r"^\s*(count|first|last|longest|shortest)\s*\(|\b(then|without|within)\b")
"""A pattern that matches queries about several scans."""


class ScanContext(NamedTuple):
    """Values that an expression reads in addition to the tags of a program."""

    words: Mapping[int, ModuleWords]  # of the modules, by slot
    image: Callable[[int, str, int], int]  # a word of an image: slot, "I" or "O", word
    now_ns: Read  # the time of the scan, ns
    scan: Read  # its number
    units: Mapping[str, str] = MappingProxyType({})  # of tags on the page, by name in capitals


class Values(Protocol):
    """The current values of a program."""

    tags: Any
    """Tags by name; supports only `in` and `[]`."""

    def source(self, name: str) -> str:
        """Return Python source that reads a tag; raise ExpressionError if it is not a single value."""

    def unit(self, name: str) -> str:
        """Return the unit of a tag's type, or "" if it has none."""

    @property
    def cells(self) -> Mapping[str, CellType]:
        """Return the variables used in expressions, by name."""


class EngineValues:
    """`Values` of a ladder program, read from the variables of its compiled scan."""

    def __init__(self, engine: WatchedEngine) -> None:
        self.engine, self.tags = engine, engine.tags

    @property
    def cells(self) -> Mapping[str, CellType]:
        """See `Values`."""
        return self.engine.memory.cells

    def source(self, name: str) -> str:
        """See `Values`."""
        place = self.tags.where(name)
        if isinstance(place, Place) and not place.can_fault:
            return source_of(self.engine.lowered.layout, place)
        if isinstance(self.tags[name], str):
            return f"__tags[{name!r}]"
        raise ExpressionError(f"{name} is not a single value: compare one of its members or elements")

    def unit(self, name: str) -> str:
        """See `Values`."""
        timer, _, member = name.upper().rpartition(".")
        is_time = member in ("PRE", "ACC") and timer in self.tags and self.tags.where(timer).type is TIMER
        return "ms" if is_time else ""


class NamedValues:
    """`Values` of a program without rungs, by name."""

    def __init__(self, tags: Mapping[str, Any]) -> None:
        self.tags = tags
        self.cells: Mapping[str, CellType] = {}

    def source(self, name: str) -> str:
        """See `Values`."""
        return f"__tags[{name!r}]"

    def unit(self, _name: str) -> str:
        """See `Values`."""
        return ""


class ExpressionError(ValueError):
    """An expression that can't be evaluated in one scan."""


class _Term(str):
    """Python source for a tag or for a number with a unit.

    Attributes:
        written: the number with its unit in the expression; "" for a tag.
        unit: the unit; "ns" for a time, "" for a tag without a unit.
    """

    written: str
    unit: str

    def __new__(cls, text: str, written: str, unit: str) -> _Term:
        term = super().__new__(cls, text)
        term.written, term.unit = written, unit
        return term


class _Edge:
    """A test for an edge since the previous scan; the first value is not an edge."""

    def __init__(self, name: str) -> None:
        self._test = _EDGES[name]
        self._last_value: Any = None

    def __call__(self, value: Any) -> bool:
        last_value, self._last_value = self._last_value, value
        return last_value is not None and bool(self._test(last_value, value))


_EDGES: Mapping[str, Callable[[Any, Any], Any]] = {
    "rose": lambda last_value, value: value and not last_value,
    "fell": lambda last_value, value: last_value and not value,
    "changed": lambda last_value, value: value != last_value,
}


def compiled(text: str, values: Values, around: ScanContext) -> Read:
    """Return the function that evaluates an expression after a scan.

    Raises:
        ExpressionError: the expression can't be parsed, names an unknown tag, or needs more than one scan.
    """
    writer = _Writer(values, around)
    try:
        source = writer.transform(_parser().parse(text))
    except UnexpectedInput as error:
        if _SEVERAL.search(text):
            raise ExpressionError(f"{text!r} needs several scans: use scanrack query") from error
        column = getattr(error, "column", 0)
        raise ExpressionError(f"{text!r}, column {max(1, column)}: not a query expression") from error
    except RecursionError as error:
        raise ExpressionError("the expression is nested too deeply") from error
    except VisitError as error:
        raise ExpressionError(f"{text!r}: {error.orig_exc}") from error
    if writer.unmatched:
        raise ExpressionError(f"{text!r}: compare a tag with {writer.unmatched[0]}")
    cells = {**values.cells, **{name: CellType(value) for name, value in writer.variables.items()}}
    return _function([*writer.statements, f"return {source}"], cells)


@cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, start="condition", parser="lalr", maybe_placeholders=False)


_GRAMMAR = GRAMMAR.replace("       | NUMBER  ", "       | NUMBER UNIT -> quantity\n       | NUMBER  ", 1) + (
    r"""
UNIT: /[^\W\d][^\s()<>=!+*-]*|[%°]\S*/
"""
)


def _function(statements: Sequence[str], cells: Mapping[str, CellType]) -> Read:
    """Compile statements to a function with cells as free variables."""
    body = "".join(f"  {statement}\n" for statement in statements)
    text = f"def outer({', '.join(cells)}):\n def take():\n{body}"
    outer = next(
        constant
        for constant in compile(text, "<expression>", "exec").co_consts
        if isinstance(constant, CodeType)
    )
    code = next(constant for constant in outer.co_consts if isinstance(constant, CodeType))
    return FunctionType(code, {"abs": abs}, "take", None, tuple(cells[name] for name in code.co_freevars))


@v_args(inline=True)
class _Writer(Transformer[Token, str]):
    """A generator of Python source, which works from the bottom up.

    Attributes:
        variables: variables added by the expression.
        statements: statements before the expression.
        unmatched: numbers with units that are not compared with a tag.
    """

    def __init__(self, values: Values, around: ScanContext) -> None:
        super().__init__()
        self._values, self._around = values, around
        self.statements: list[str] = []
        self.unmatched: list[str] = []
        self.variables: dict[str, Any] = {
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
        raise ExpressionError("'for' needs several scans: use scanrack query")

    def edge(self, name: Token, part: str) -> str:
        """Return a variable for an edge; the edge test becomes a statement before the expression."""
        edge_name = f"edge{len(self.variables)}"
        self.variables[f"__{edge_name}"] = _Edge(name)
        # evaluated in every scan, even if it can't affect the result
        self.statements.append(f"{edge_name} = __{edge_name}({part})")
        return edge_name

    def compare(self, left: str, sign: Token, right: str) -> str:
        """Return a comparison; a number with a unit is converted to the tag's unit."""
        for side in (left, right):
            number = side.written.lstrip("+-") if isinstance(side, _Term) else ""
            if number in self.unmatched:
                self.unmatched.remove(number)
        return f"({_in_unit(left, right)} {sign} {_in_unit(right, left)})"

    def arithmetic(self, left: str, sign: Token, right: str) -> str:
        return f"({left} {sign} {right})"

    def signed(self, sign: Token, part: str) -> str:
        text = f"({sign}{part})"
        if isinstance(part, _Term) and part.written:
            return _Term(text, f"{sign}{part.written}", part.unit)
        return text

    def absolute(self, part: str) -> str:
        return f"abs({part})"

    def duration(self, token: Token) -> str:
        return _Term(str(parse_time(token)), str(token), "ns")

    def quantity(self, token: Token, unit: Token) -> str:
        self.unmatched.append(f"{token} {unit}")
        return _Term(repr(number_of(token)), f"{token} {unit}", str(unit))

    def number(self, token: Token) -> str:
        return repr(number_of(token))

    def text(self, token: Token) -> str:
        return repr(str(token)[1:-1])

    def name(self, token: Token) -> str:
        """Return source for the time, the scan number, true, false, a tag, or a word or bit of an image."""
        name = str(token)
        if name in ("time", "scan"):
            return "__now()" if name == "time" else "__scan()"
        if name.lower() in ("true", "false"):
            return name.capitalize()
        unit = self._around.units.get(name.upper(), "")
        if name not in self._values.tags:
            return _Term(self._image(name), "", unit)
        return _Term(self._values.source(name), "", unit or self._values.unit(name))

    def _image(self, name: str) -> str:
        """Return source that reads a word or bit of an image; raise ExpressionError for other names."""
        try:
            address = parse_address(name, self._around.words)
        except ValueError as error:
            raise ExpressionError(f"no tag, word or bit {name}") from error
        word = f"__image({address.slot}, {address.image!r}, {address.word})"
        return word if address.bit is None else f"({word} >> {address.bit} & 1)"


def _in_unit(part: str, other: str) -> str:
    """Convert a number to the unit of the tag it is compared with; return other terms unchanged.

    Raises:
        ExpressionError: the tag has a different unit, or none.
    """
    if not isinstance(part, _Term) or not part.written:
        return part
    unit = other.unit if isinstance(other, _Term) and not other.written else ""
    if unit == part.unit:
        return part
    if part.unit == "ns" and unit in ("", *UNITS_NS):
        return f"({part} / {UNITS_NS[unit]})" if unit else part
    rule = f"must be in {unit}" if unit else "must have no unit, since the page shows no unit for the tag"
    raise ExpressionError(f"{part.written}: {rule}")
