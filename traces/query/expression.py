"""The expressions of a query: functions of columns, each with a type and a position in the text."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from functools import reduce
from typing import Any

from lark import Token
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import parse_time

from ..signals import Signal
from .columns import Scans


class Type(Enum):
    """Type of an expression's values."""

    CONDITION = "a condition"
    NUMBER = "a number"
    DURATION = "a time"
    TEXT = "a text"


@dataclass(frozen=True, slots=True)
class Expression:
    """An expression of a query."""

    type: Type
    column: int  # its column in the query's text, from 1
    text: str  # its first token, for a message
    evaluate: Callable[[Scans], Any]  # returns its values, one per scan: conditions, or `Numbers`
    signals: tuple[Signal, ...] = ()


class MeaningError(Exception):
    """A query has correct grammar, but mixes types or names an unknown signal."""

    def __init__(self, column: int, text: str) -> None:
        super().__init__(text)
        self.column = column


def leaf(kind: Type, token: Token, evaluate: Callable[[Scans], Any], *signals: Signal) -> Expression:
    """Create an expression from a single token."""
    return Expression(kind, column_of(token), str(token), evaluate, signals)


def derived(kind: Type, part: Expression, evaluate: Callable[[Scans], Any]) -> Expression:
    """Create an expression from another expression."""
    return Expression(kind, part.column, part.text, evaluate, part.signals)


def joined(
    kind: Type, left: Expression, right: Expression, operator: Callable[[Any, Any], Any]
) -> Expression:
    """Create an expression from two others."""
    return Expression(
        kind,
        left.column,
        left.text,
        lambda scans: operator(left.evaluate(scans), right.evaluate(scans)),
        left.signals + right.signals,
    )


def combined(operator: Callable[[Any, Any], Any], parts: tuple[Expression, ...]) -> Expression:
    """Create a condition from several conditions."""
    for condition in parts:
        require_type(condition, Type.CONDITION)
    signals = tuple(signal for term in parts for signal in term.signals)
    return Expression(
        Type.CONDITION,
        parts[0].column,
        parts[0].text,
        lambda scans: reduce(operator, (term.evaluate(scans) for term in parts)),
        signals,
    )


def require_type(part: Expression, expected: Type, operator: str = "the query") -> None:
    """Raise a MeaningError if an operand of `operator` does not have the type `expected`."""
    if part.type is expected:
        return
    hint = f"; compare it, as in {part.text} > 0" if part.type is Type.NUMBER else ""
    problem = f"{operator} needs {expected.value} here, but {part.text} is {part.type.value}{hint}"
    raise MeaningError(part.column, problem)


def refuse_condition(part: Expression, operator: str) -> None:
    """Raise a MeaningError if an operand is a condition where `operator` needs a number or a time."""
    if part.type is Type.CONDITION:
        require_type(part, Type.NUMBER, operator)


def require_same_type(left: Expression, right: Expression, sign: Token) -> None:
    """Raise a MeaningError if two expressions have different types."""
    if left.type is right.type:
        return
    hint = "; a time has a unit, as in 20 ms" if Type.DURATION in (left.type, right.type) else ""
    problem = f"{sign} has {left.type.value} on its left and {right.type.value} on its right{hint}"
    raise MeaningError(column_of(sign), problem)


def duration_ns(token: Token) -> int:
    """Return the duration in a token, ns.

    >>> duration_ns(Token("DURATION", "1.5 ms")), duration_ns(Token("DURATION", "2min"))
    (1500000, 120000000000)
    """
    try:
        return parse_time(token)
    except ValueError as error:
        raise MeaningError(column_of(token), str(error)) from None


def number_of(token: Token) -> int | float:
    """Return the number in a token, as an integer unless it has a fraction.

    >>> [number_of(Token("NUMBER", text)) for text in ("4_000", "0x4000", "1.5")]
    [4000, 16384, 1.5]
    """
    text = token.replace("_", "")
    if len(text) > DIGITS_MAX:
        raise MeaningError(column_of(token), f"the number {token} is too large")
    if text[:2].lower() == "0x":
        return int(text, 16)
    return float(text) if "." in text else int(text)


DIGITS_MAX = 200
"""Maximum number of digits in a number. The square of a longer number may exceed the range of a float."""


def column_of(token: Token) -> int:
    """Return the column at which a token begins, from 1."""
    return (token.start_pos or 0) + 1
