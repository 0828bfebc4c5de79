"""Exact arithmetic on columns, as in Python: integers of any width and sign remain integers.

    int64      integers that fit, which almost all do
    object     Python's integers, for a value or result that does not fit int64
    float64    numbers with fractions

Integers and floats combine as in Python, so a comparison is exact and a sum is a float.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from operator import ne, sub
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

Array = NDArray[Any]
Condition = NDArray[np.bool_]
Operator = Callable[[Any, Any], Any]

EXACT_MAX = 2**53
"""Every integer up to this value is exact as a float64."""

_LEAST, _MOST = -(2**63), 2**63 - 1


@dataclass(frozen=True, slots=True)
class Numbers:
    """A column with a number, or no number, for each scan."""

    values: Array  # int64, Python's integers (object) or float64
    none: Condition  # whether a scan has no number

    def __len__(self) -> int:
        return len(self.values)

    def __getitem__(self, rows: Any) -> Numbers:
        return Numbers(self.values[rows], self.none[rows])

    def __iter__(self) -> Iterator[int | float | None]:
        for value, none in zip(self.values.tolist(), self.none.tolist(), strict=True):
            yield None if none else value

    @property
    def are_whole(self) -> bool:
        """Whether the numbers are integers."""
        return self.values.dtype.kind != "f"


def numbers(values: Array) -> Numbers:
    """Return an array of numbers of any type; NaN means no number.

    >>> list(numbers(np.array([2**64 - 1, 1], np.uint64))), list(numbers(np.array([1.5, np.nan])))
    ([18446744073709551615, 1], [1.5, None])
    """
    if values.dtype.kind == "f":
        floats = values.astype(np.float64)
        return Numbers(floats, np.isnan(floats))
    return Numbers(_narrow(values), np.zeros(len(values), bool))


def constant(value: int | float, count: int) -> Numbers:
    """Return a column with the same number in each of `count` scans."""
    if isinstance(value, float):
        return numbers(np.full(count, value))
    return numbers(np.full(count, value, np.int64 if _LEAST <= value <= _MOST else object))


def calculated(operator: Operator, left: Numbers, right: Numbers) -> Numbers:
    """Add, subtract or multiply, without overflow of integers.

    >>> from operator import add
    >>> most = numbers(np.array([2**63 - 1]))
    >>> list(calculated(add, most, most))
    [18446744073709551614]

    Raises:
        OverflowError: an integer is too large to be combined with a float.
    """
    none = left.none | right.none
    if not (left.are_whole and right.are_whole):
        with np.errstate(all="ignore"):
            values = operator(_floats(left), _floats(right))
        return Numbers(values, none | np.isnan(values))
    if _fits(operator, left.values, right.values):
        return Numbers(operator(left.values, right.values), none)
    return Numbers(_narrow(operator(left.values.astype(object), right.values.astype(object))), none)


def compared(operator: Operator, left: Numbers, right: Numbers) -> Condition:
    """Compare exactly; the result is false if either side has no value.

    >>> from operator import eq
    >>> wide = numbers(np.array([2**53 + 1]))
    >>> compared(eq, wide, numbers(np.array([2.0**53]))).tolist()
    [False]
    """
    values = left.values, right.values
    kinds = {operand.dtype.kind for operand in values}
    if len(kinds) > 1 and ("O" in kinds or not all(map(_exact_as_float, values))):
        values = values[0].astype(object), values[1].astype(object)
    is_true: Condition = operator(*values).astype(bool)
    return is_true & ~(left.none | right.none)


def negated(numbers: Numbers) -> Numbers:
    """Return the negated numbers."""
    return calculated(sub, constant(0, len(numbers)), numbers)


def absolute(numbers: Numbers) -> Numbers:
    """Return the absolute values.

    >>> list(absolute(numbers(np.array([-(2**63), 3]))))
    [9223372036854775808, 3]
    """
    values = np.where(numbers.values < 0, negated(numbers).values, numbers.values)
    return Numbers(values if values.dtype.kind == "f" else _narrow(values), numbers.none)


def changed(numbers: Numbers) -> Condition:
    """Return where a number differs from the number in the previous scan; never in the first scan.

    A number that appears or disappears is a change. Two successive scans without a number are not a change.

    >>> changed(numbers(np.array([1.0, 1.0, np.nan, np.nan, 2.0]))).tolist()
    [False, False, True, False, True]
    """
    has_changed = np.zeros(len(numbers), bool)
    current, previous = numbers[1:], numbers[:-1]
    has_changed[1:] = compared(ne, current, previous) | (current.none != previous.none)
    return has_changed


def _narrow(values: Array) -> Array:
    """Return integers as int64 if all of them fit, otherwise as Python integers."""
    if values.dtype.kind == "O" or values.dtype == np.uint64:
        fits_int64 = not len(values) or (values.min() >= _LEAST and values.max() <= _MOST)
        return values.astype(np.int64) if fits_int64 else values.astype(object)
    return values.astype(np.int64)


def _fits(operator: Operator, left: Array, right: Array) -> bool:
    """Return whether all integer results fit int64.

    The least and greatest results of +, - and * follow from the least and greatest operands.
    """
    if "O" in (left.dtype.kind, right.dtype.kind):
        return False
    if not len(left):
        return True
    corners = product(*((int(operand.min()), int(operand.max())) for operand in (left, right)))
    return all(_LEAST <= operator(*corner) <= _MOST for corner in corners)


def _exact_as_float(values: Array) -> bool:
    """Return whether these values can be converted to floats exactly."""
    if values.dtype.kind == "f" or not len(values):
        return True
    return bool(values.min() >= -EXACT_MAX and values.max() <= EXACT_MAX)


def _floats(numbers: Numbers) -> Array:
    if numbers.values.dtype.kind == "O":
        return np.array([float(value) for value in numbers.values])
    return numbers.values.astype(np.float64)
