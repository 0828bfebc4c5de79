"""The language's operators on whole columns: one value per scan in, one per scan out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass

from ..signals import Signal, SignalKind
from ..signals.signal import whole_numbers
from . import numbers
from .numbers import Numbers

Array = NDArray[Any]
Condition = NDArray[np.bool_]
Column = Condition | Numbers
"""The value of an expression in every scan."""


@dataclass(frozen=True, slots=True)
class Scans:
    """The columns that a query reads."""

    scan: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    values: Mapping[str, Array]  # columns by signal name, of the signals' own types

    def __len__(self) -> int:
        return len(self.scan)

    def column(self, signal: Signal) -> Column:
        """Return the values of a signal."""
        values = self.values[signal.name]
        if signal.kind is SignalKind.BIT:
            return values
        if signal.kind is SignalKind.VALUE:
            return Numbers(*whole_numbers(values))
        return numbers.numbers(values)


def rose(condition: Condition) -> Condition:
    """True where a condition holds and did not in the scan before; never in the first scan.

    >>> rose(np.array([True, False, True, True])).tolist()
    [False, False, True, False]
    """
    result = np.zeros(len(condition), bool)
    np.greater(condition[1:], condition[:-1], out=result[1:])
    return result


def fell(condition: Condition) -> Condition:
    """True where a condition does not hold and did in the scan before."""
    return rose(~condition)


def changed(values: Column) -> Condition:
    """True where a value differs from the scan before; never in the first scan."""
    if isinstance(values, Numbers):
        return numbers.changed(values)
    result = np.zeros(len(values), bool)
    np.not_equal(values[1:], values[:-1], out=result[1:])
    return result


def compared(operator: Callable[[Any, Any], Any], left: Column, right: Column) -> Condition:
    """Compare two conditions, or two columns of numbers: false wherever either side has no value."""
    if isinstance(left, Numbers) and isinstance(right, Numbers):
        return numbers.compared(operator, left, right)
    result: Condition = operator(left, right)
    return result


def held(condition: Condition, time_ns: NDArray[np.int64], least_ns: int) -> Condition:
    """True where a condition has held without interruption for `least_ns` or longer.

    >>> held(np.array([True, True, True, False, True]), np.array([0, 2, 4, 6, 8]), 4).tolist()
    [False, False, True, False, False]
    """
    begins = condition.copy()
    begins[1:] &= ~condition[:-1]
    since = np.maximum.accumulate(np.where(begins, np.arange(len(condition)), 0))
    result: Condition = condition & (time_ns - time_ns[since] >= least_ns)
    return result
