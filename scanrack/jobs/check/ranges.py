"""Ranges of numbers: the possible values of an expression of constants and numbers in known ranges."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple


class Range(NamedTuple):
    """The lowest and highest value of a number; infinite if unknown."""

    least: float
    most: float
    whole: bool = True  # whether it is an integer

    @property
    def is_known(self) -> bool:
        """Whether both bounds are known."""
        return math.isfinite(self.least) and math.isfinite(self.most)

    @property
    def is_constant(self) -> bool:
        """Whether the range is a single number."""
        return self.least == self.most

    def within(self, least: float, most: float) -> bool:
        """Whether all values are within the given bounds."""
        return least <= self.least and self.most <= most

    def outside(self, least: float, most: float) -> bool:
        """Whether all values are outside the given bounds."""
        return self.most < least or self.least > most

    def __str__(self) -> str:
        if self.is_constant:
            return _text(self.least)
        return f"{_text(self.least)} to {_text(self.most)}"


ANY = Range(-math.inf, math.inf, False)
"""A number about which nothing is known."""


def exactly(number: float) -> Range:
    """Return the range of a constant."""
    return Range(number, number, isinstance(number, int) or float(number).is_integer())


def joined(*ranges: Range) -> Range:
    """Return the range of a number that is in any of several ranges."""
    if not ranges:
        return ANY
    return Range(
        min(number.least for number in ranges),
        max(number_range.most for number_range in ranges),
        all(number_range.whole for number_range in ranges),
    )


def _corners(one: Range, other: Range, of: Callable[[float, float], float]) -> Range:
    if not (one.is_known and other.is_known):
        return ANY
    corners = [of(left, right) for left in (one.least, one.most) for right in (other.least, other.most)]
    return Range(min(corners), max(corners), one.whole and other.whole)


def _divided(one: Range, other: Range) -> Range:
    """Return the range of a quotient that has not been truncated."""
    if not (one.is_known and other.is_known) or other.least <= 0 <= other.most:
        return ANY
    return _corners(one, other, lambda a, b: a / b)._replace(whole=False)


def _rest(one: Range, other: Range) -> Range:
    """Return the range of a remainder, which has the sign of the dividend."""
    if not other.is_known:
        return ANY
    most = max(abs(other.least), abs(other.most)) - 1
    if one.is_known and max(abs(one.least), abs(one.most)) <= most:
        return one
    return Range(0 if one.least >= 0 else -most, 0 if one.most <= 0 else most, one.whole and other.whole)


OPERATIONS: Mapping[str, Callable[..., Range]] = {
    "+": lambda a, b: _corners(a, b, lambda x, y: x + y),
    "-": lambda a, b: _corners(a, b, lambda x, y: x - y),
    "*": lambda a, b: _corners(a, b, lambda x, y: x * y),
    "/": _divided,
    "MOD": _rest,
    "NEG": lambda a: Range(-a.most, -a.least, a.whole),
    "ABS": lambda a: Range(
        0 if a.least <= 0 <= a.most else min(abs(a.least), abs(a.most)), max(-a.least, a.most), a.whole
    ),
    "TRN": lambda a: Range(math.trunc(a.least), math.trunc(a.most)) if a.is_known else ANY,
}
"""Operators and functions, by their names in ladder programs."""


def _text(number: float) -> str:
    if not math.isfinite(number):
        return "any number"
    return f"{number:,.0f}".replace(",", "") if float(number).is_integer() else f"{number:g}"
