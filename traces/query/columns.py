"""The operators of the query language. Each works on columns, block by block, with one value per scan."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
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


Memory = dict[object, Any]
"""State that operators keep from block to block, each under its own key."""


@dataclass(frozen=True, slots=True)
class Scans:
    """A block of the columns that a query reads."""

    scan: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    values: Mapping[str, Array]  # columns by signal name, of the signals' own types
    memory: Memory = field(default_factory=dict)

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

    def edges(self, key: object, values: Column, edge: Callable[[Any], Condition]) -> Condition:
        """Return where an edge occurs; the first scan is compared with the previous block's last scan.

        Args:
            key: key of the operator in `memory`.
            edge: `rose`, `fell` or `changed`.
        """
        last_value, self.memory[key] = self.memory.get(key), values[-1:]
        return edge(values) if last_value is None else edge(joined((last_value, values)))[1:]

    def held(self, key: object, condition: Condition, least_ns: int) -> Condition:
        """Return where a condition has been true for a time, even if it became true in an earlier block.

        Args:
            key: key of the operator in `memory`.
        """
        if not len(condition):
            return condition
        since_ns = since(condition, self.time_ns)
        begun_ns = self.memory.get(key)
        if condition[0] and begun_ns is not None:
            since_ns[: len(condition) if condition.all() else int(np.argmin(condition))] = begun_ns
        self.memory[key] = int(since_ns[-1]) if condition[-1] else None
        is_held: Condition = condition & (self.time_ns - since_ns >= least_ns)
        return is_held


def joined(parts: Sequence[Any]) -> Any:
    """Join columns of the same kind."""
    if isinstance(parts[0], Numbers):
        return Numbers(
            np.concatenate([column.values for column in parts]),
            np.concatenate([column.none for column in parts]),
        )
    return np.concatenate(parts)


def rose(condition: Condition) -> Condition:
    """Return where a condition is true and was false in the previous scan; never in the first scan.

    >>> rose(np.array([True, False, True, True])).tolist()
    [False, False, True, False]
    """
    has_risen = np.zeros(len(condition), bool)
    np.greater(condition[1:], condition[:-1], out=has_risen[1:])
    return has_risen


def fell(condition: Condition) -> Condition:
    """Return where a condition is false and was true in the previous scan; never in the first scan."""
    return rose(~condition)


def changed(values: Column) -> Condition:
    """Return where a value differs from its value in the previous scan; never in the first scan."""
    if isinstance(values, Numbers):
        return numbers.changed(values)
    has_changed = np.zeros(len(values), bool)
    np.not_equal(values[1:], values[:-1], out=has_changed[1:])
    return has_changed


def compared(operator: Callable[[Any, Any], Any], left: Column, right: Column) -> Condition:
    """Compare two conditions or two columns of numbers; the result is false if either has no value."""
    if isinstance(left, Numbers) and isinstance(right, Numbers):
        return numbers.compared(operator, left, right)
    is_true: Condition = operator(left, right)
    return is_true


def since(condition: Condition, time_ns: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return, for each scan in which a condition is true, the time when it became true.

    The result for other scans has no meaning.

    >>> since(np.array([True, True, False, True]), np.array([0, 2, 4, 6])).tolist()
    [0, 0, 0, 6]
    """
    is_begin = condition.copy()
    is_begin[1:] &= ~condition[:-1]
    return time_ns[np.maximum.accumulate(np.where(is_begin, np.arange(len(condition)), 0))]
