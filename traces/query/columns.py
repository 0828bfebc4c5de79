"""The language's operators on whole columns: one value per scan in, one per scan out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Condition = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Scans:
    """The columns that a query reads.

    Attributes:
        scan: number of each scan.
        time_ns: its virtual time.
        values: columns by signal name: bool for bits, float64 with NaN for "none" otherwise.
    """

    scan: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    values: Mapping[str, Array]

    def __len__(self) -> int:
        return len(self.scan)


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


def changed(values: Array) -> Condition:
    """True where values differ from the scan before; never in the first scan.

    A value that appears or goes has changed; none after none has not.

    >>> changed(np.array([1.0, 1.0, np.nan, np.nan, 2.0])).tolist()
    [False, False, True, False, True]
    """
    result = np.zeros(len(values), bool)
    result[1:] = values[1:] != values[:-1]
    if values.dtype.kind == "f":
        none = np.isnan(values)
        result[1:] &= ~(none[1:] & none[:-1])
    return result


def compared(operator: Callable[[Array, Array], Array], left: Array, right: Array) -> Condition:
    """Compare; false wherever either side has no value.

    >>> compared(np.not_equal, np.array([1.0, np.nan]), np.array([2.0, 2.0])).tolist()
    [True, False]
    """
    result: Condition = operator(left, right)
    for side in (left, right):
        if side.dtype.kind == "f":
            result = result & ~np.isnan(side)
    return result


def held(condition: Condition, time_ns: NDArray[np.int64], least_ns: int) -> Condition:
    """True where a condition has held without a break since `least_ns` ago or longer.

    >>> held(np.array([True, True, True, False, True]), np.array([0, 2, 4, 6, 8]), 4).tolist()
    [False, False, True, False, False]
    """
    begins = condition.copy()
    begins[1:] &= ~condition[:-1]
    since = np.maximum.accumulate(np.where(begins, np.arange(len(condition)), 0))
    result: Condition = condition & (time_ns - time_ns[since] >= least_ns)
    return result
