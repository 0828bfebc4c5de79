"""Parses the text of a query into functions of columns.

Every expression has a column in the text and one of four types. Errors are therefore reported, with their
column, before the first scan is read:

    condition   true or false in every scan    slot1.in.COMMAND_ERROR, time > 2 s
    number      a number in every scan         slot1.in.position, scan, 4000
    duration    an amount of virtual time      time, 20 ms
    text        a name of a step, or a text    Step == "wait for oil"
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from lark import Lark, Token, Transformer, v_args
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken, VisitError
from scanrack.io_images.dataclass import dataclass

from ..signals import Catalog, Signal, SignalKind
from ..signals.catalog import UnknownSignalError
from . import columns, numbers
from .columns import Condition, Scans
from .expression import (
    Expression,
    MeaningError,
    Type,
    column_of,
    combined,
    derived,
    duration_ns,
    joined,
    leaf,
    number_of,
    refuse_condition,
    require_same_type,
    require_type,
)
from .grammar import GRAMMAR, TERMS
from .patterns import Pattern, response, runs, silence


class QueryError(ValueError):
    """The query can't be parsed; the message names the column."""


@dataclass(frozen=True, slots=True)
class Query:
    """A parsed query."""

    aggregate: str | None  # "count", "first", "last", "longest" or "shortest"; None for all occurrences
    conditions: tuple[Callable[[Scans], Condition], ...]
    pattern: Pattern  # finds the occurrences from the stretches of the conditions
    signals: tuple[Signal, ...]


def parse(text: str, catalog: Catalog) -> Query:
    """Parse a query.

    Raises:
        QueryError: the text is not a query, mixes types, or names an unknown signal.
    """
    try:
        tree = _parser().parse(text)
        query: Query = _Builder(catalog).transform(tree)
    except UnexpectedInput as error:
        raise QueryError(f"{_problem(text, error)}; allowed here: {_allowed(error)}") from error
    except RecursionError as error:
        raise QueryError(TOO_DEEP) from error
    except VisitError as error:
        if isinstance(error.orig_exc, RecursionError):
            raise QueryError(TOO_DEEP) from error
        if isinstance(error.orig_exc, MeaningError):
            raise QueryError(f"column {error.orig_exc.column}: {error.orig_exc}") from error
        raise
    return query


TOO_DEEP = "the query is nested too deeply"


@cache
def _parser() -> Lark:
    return Lark(GRAMMAR, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def _problem(text: str, error: UnexpectedInput) -> str:
    """Return the position at which a text stops being a query, and the unexpected text there."""
    if isinstance(error, UnexpectedToken):
        if error.token.type == "$END":
            return f"column {len(text) + 1}: the query ends too early"
        return f"column {column_of(error.token)}: {str(error.token)!r} is unexpected"
    position = int(getattr(error, "pos_in_stream", 0))
    return f"column {position + 1}: {text[position]!r} is unexpected"


def _allowed(error: UnexpectedInput) -> str:
    """Return the names of the terms that are allowed at the position of an error."""
    names: set[str] = set()
    if isinstance(error, UnexpectedCharacters):
        names = set(error.allowed)
    elif isinstance(error, UnexpectedToken):
        names = set(error.accepts or error.expected)
    return ", ".join(text for name, text in TERMS.items() if name in names)


_COMPARE: Mapping[str, Callable[[Any, Any], Any]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
}
_EDGES: Mapping[str, Callable[[Any], Condition]] = {
    "rose": columns.rose,
    "fell": columns.fell,
    "changed": columns.changed,
}


def _query(pattern: Pattern, *conditions: Expression) -> Query:
    """Create a query from its conditions."""
    for condition in conditions:
        require_type(condition, Type.CONDITION)
    signals = tuple(signal for condition in conditions for signal in condition.signals)
    return Query(None, tuple(condition.evaluate for condition in conditions), pattern, signals)


def _text_comparison(coded: Expression, text: Expression, sign: Token) -> Expression:
    """Compare a signal of kind CODE with the name of a step or with a text."""
    signal = coded.signals[0] if coded.type is Type.NUMBER and len(coded.signals) == 1 else None
    if signal is None or signal.kind is not SignalKind.CODE or sign not in ("==", "!="):
        problem = "use == or != to compare a text with a step, or with a tag that contains text"
        raise MeaningError(column_of(sign), problem)
    searched_name = text.text[1:-1]
    codes = [code for code, name in signal.names.items() if name == searched_name]
    return derived(
        Type.CONDITION,
        coded,
        lambda scans: np.isin(coded.evaluate(scans).values, codes, invert=sign == "!="),
    )


@v_args(inline=True)
class _Builder(Transformer[Token, Any]):
    """Builds the query bottom up, with one method per grammar rule."""

    def __init__(self, catalog: Catalog) -> None:
        super().__init__()
        self._catalog = catalog

    # -- queries ------------------------------------------------------------------------------------

    def aggregate(self, name: Token, query: Query) -> Query:
        return replace(query, aggregate=str(name))

    def runs(self, condition: Expression) -> Query:
        return _query(runs, condition)

    def then(self, cause: Expression, effect: Expression, limit: Token | None = None) -> Query:
        within_ns = None if limit is None else duration_ns(limit)
        return _query(partial(response, within_ns), cause, effect)

    def without(self, cause: Expression, effect: Expression, limit: Token) -> Query:
        return _query(partial(silence, duration_ns(limit)), cause, effect)

    # -- conditions ---------------------------------------------------------------------------------

    def any_of(self, *parts: Expression) -> Expression:
        return combined(np.logical_or, parts)

    def all_of(self, *parts: Expression) -> Expression:
        return combined(np.logical_and, parts)

    def negation(self, part: Expression) -> Expression:
        require_type(part, Type.CONDITION)
        return derived(Type.CONDITION, part, lambda scans: ~part.evaluate(scans))

    def held(self, part: Expression, time: Token) -> Expression:
        require_type(part, Type.CONDITION)
        least_ns, key = (
            duration_ns(time),
            object(),
        )  # the key finds what earlier blocks left for this condition
        return derived(Type.CONDITION, part, lambda scans: scans.held(key, part.evaluate(scans), least_ns))

    def edge(self, name: Token, part: Expression) -> Expression:
        """Return the scans in which a condition rose or fell, or in which any value changed."""
        if name != "changed":
            require_type(part, Type.CONDITION, f"{name}()")
        is_edge, key = _EDGES[name], object()
        return derived(Type.CONDITION, part, lambda scans: scans.edges(key, part.evaluate(scans), is_edge))

    def compare(self, left: Expression, sign: Token, right: Expression) -> Expression:
        """Compare two values of the same type, or a text with the names of a signal's codes."""
        if right.type is Type.TEXT:
            return _text_comparison(left, right, sign)
        if left.type is Type.TEXT:
            return _text_comparison(right, left, sign)
        require_same_type(left, right, sign)
        if left.type is Type.CONDITION and sign not in ("==", "!="):
            problem = f"{sign} does not compare conditions; use == or !="
            raise MeaningError(column_of(sign), problem)
        return joined(Type.CONDITION, left, right, partial(columns.compared, _COMPARE[sign]))

    # -- numbers and times --------------------------------------------------------------------------

    def arithmetic(self, left: Expression, sign: Token, right: Expression) -> Expression:
        """Calculate with two numbers or two durations; only numbers can be multiplied."""
        for operand in (left, right):
            refuse_condition(operand, str(sign))
        if sign == "*":
            require_type(right, Type.NUMBER, "*")
            require_type(left, Type.NUMBER, "*")
        require_same_type(left, right, sign)
        return joined(left.type, left, right, partial(numbers.calculated, _ARITHMETIC[sign]))

    def signed(self, sign: Token, part: Expression) -> Expression:
        """Return a number or duration with its sign."""
        refuse_condition(part, str(sign))
        if sign == "+":
            return part
        return derived(part.type, part, lambda scans: numbers.negated(part.evaluate(scans)))

    def absolute(self, part: Expression) -> Expression:
        refuse_condition(part, "abs()")
        return derived(part.type, part, lambda scans: numbers.absolute(part.evaluate(scans)))

    def duration(self, token: Token) -> Expression:
        value = duration_ns(token)
        return leaf(Type.DURATION, token, lambda scans: numbers.constant(value, len(scans)))

    def number(self, token: Token) -> Expression:
        value = number_of(token)
        return leaf(Type.NUMBER, token, lambda scans: numbers.constant(value, len(scans)))

    def text(self, token: Token) -> Expression:
        return leaf(Type.TEXT, token, lambda scans: str(token)[1:-1])

    def name(self, token: Token) -> Expression:
        """Return the time or number of each scan, or a signal."""
        if token == "time":
            return leaf(Type.DURATION, token, lambda scans: numbers.numbers(scans.time_ns))
        if token == "scan":
            return leaf(Type.NUMBER, token, lambda scans: numbers.numbers(scans.scan))
        try:
            signal = self._catalog[str(token)]
        except UnknownSignalError as error:
            raise MeaningError(column_of(token), str(error)) from error
        kind = Type.CONDITION if signal.kind is SignalKind.BIT else Type.NUMBER
        return leaf(kind, token, lambda scans: scans.column(signal), signal)
