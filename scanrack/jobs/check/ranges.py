"""Ranges of numbers, and arithmetic with them."""

from __future__ import annotations

import math
import operator
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
"""The range of an unknown number."""


def exactly(number: float) -> Range:
    """Return the range of a constant."""
    return Range(number, number, isinstance(number, int) or float(number).is_integer())


def joined(*ranges: Range) -> Range:
    """Return the range of a number that is in any of several ranges."""
    if not ranges:
        return ANY
    return Range(
        min(number.least for number in ranges),
        max(number.most for number in ranges),
        all(number.whole for number in ranges),
    )


def _between_corners(a: Range, b: Range, calculate: Callable[[float, float], float]) -> Range:
    """Return the range of a calculation that has its extremes at the bounds of its operands."""
    if not (a.is_known and b.is_known):
        return ANY
    corners = [calculate(left, right) for left in (a.least, a.most) for right in (b.least, b.most)]
    return Range(min(corners), max(corners), a.whole and b.whole)


def _divided(dividend: Range, divisor: Range) -> Range:
    """Return the range of a quotient before truncation."""
    if divisor.least <= 0 <= divisor.most:
        return ANY
    return _between_corners(dividend, divisor, operator.truediv)._replace(whole=False)


def _remainder(dividend: Range, divisor: Range) -> Range:
    """Return the range of a remainder, which has the sign of the dividend."""
    if not divisor.is_known:
        return ANY
    most = max(abs(divisor.least), abs(divisor.most)) - 1
    if dividend.is_known and max(abs(dividend.least), abs(dividend.most)) <= most:
        return dividend
    least = 0 if dividend.least >= 0 else -most
    return Range(least, 0 if dividend.most <= 0 else most, dividend.whole and divisor.whole)


OPERATIONS: Mapping[str, Callable[..., Range]] = {
    "+": lambda a, b: _between_corners(a, b, operator.add),
    "-": lambda a, b: _between_corners(a, b, operator.sub),
    "*": lambda a, b: _between_corners(a, b, operator.mul),
    "/": _divided,
    "MOD": _remainder,
    "NEG": lambda a: Range(-a.most, -a.least, a.whole),
    "ABS": lambda a: Range(
        0 if a.least <= 0 <= a.most else min(abs(a.least), abs(a.most)), max(-a.least, a.most), a.whole
    ),
    "TRN": lambda a: Range(math.trunc(a.least), math.trunc(a.most)) if a.is_known else ANY,
}
"""The range of a result, by the name of its operator or function in ladder programs."""


def _text(number: float) -> str:
    if not math.isfinite(number):
        return "any number"
    return f"{number:,.0f}".replace(",", "") if float(number).is_integer() else f"{number:g}"
