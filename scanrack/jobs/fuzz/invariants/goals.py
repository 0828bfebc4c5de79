"""Goals of a search: a condition that should become true in some run, or a number to maximize."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import partial
from typing import Any

from ..aim.edges import SIZE, STATE
from .invariants import FOREVER_NS, Condition, Invariant, always, evaluate, same_until_ns
from .scan_view import Snapshot

Note = Callable[[str, Hashable, int], None]
"""Records the group, kind and scan of a change."""


def sometimes(condition: Condition) -> Invariant:
    """Return a goal with a condition that a good search must reach. The condition's docstring describes it.

    The search keeps the first run that reaches it, and varies the run after that scan. The summary names
    goals that were never reached. `scanrack fuzz --strict` then exits with status 3.

    Raises:
        InvariantError: the condition is not a function of one argument, the snapshot.
    """
    return replace(always(condition), start=partial(Sometimes, condition), is_goal=True)


def maximize(measure: Condition) -> Invariant:
    """Return a goal with a number to maximize. The search keeps and varies runs in which it increases a lot.

    The summary shows the greatest value. Use this for computed values, since a search watches integer tags
    and fields anyway. Values below 1 are ignored.

    Args:
        measure: computes the number from the snapshot.

    Raises:
        InvariantError: the measure is not a function of one argument, the snapshot.
    """
    return replace(always(measure), start=partial(MaximumGoal, measure), is_goal=True)


class Sometimes:
    """Watches a run for a condition that should become true.

    Attributes:
        applied: whether the condition has been true.
        note: records the first scan in which it is true.
    """

    def __init__(self, condition: Condition) -> None:
        self._condition = condition
        self.applied = False
        self.note: Note | None = None

    def __call__(self, now: Snapshot) -> None:
        """Record the first scan in which the condition is true."""
        if not self.applied and evaluate(self._condition, now):
            self.applied = True
            if self.note is not None:
                self.note(STATE, ("sometimes", str(self._condition.__name__), "seen"), now.scan)

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        return FOREVER_NS if self.applied else same_until_ns(self._condition, counting)


class MaximumGoal:
    """Watches a run for the greatest value of a number.

    Attributes:
        greatest: greatest value so far.
        note: records each scan with a higher size level, see `level_of`.
    """

    def __init__(self, measure: Condition) -> None:
        self._measure = measure
        self._level = (0, 0)
        self.greatest: float | None = None
        self.note: Note | None = None

    @property
    def applied(self) -> bool:
        """Whether the number has been measured in any scan."""
        return self.greatest is not None

    def __call__(self, now: Snapshot) -> None:
        """Record the scan if the number reaches a higher size level."""
        value: Any = evaluate(self._measure, now)
        if self.greatest is not None and value <= self.greatest:
            return
        self.greatest = value
        level = level_of(int(value))
        if level > self._level:
            self._level = level
            if self.note is not None:
                self.note(SIZE, ("maximize", str(self._measure.__name__), *level), now.scan)

    def same_until_ns(self, counting: bool) -> int:
        """See `Watch`."""
        return same_until_ns(self._measure, counting)


def level_of(value: int) -> tuple[int, int]:
    """Return the size level of a number: its number of bits and its three leading bits.

    There are four levels between successive powers of two.

    >>> level_of(-3), level_of(8), level_of(9), level_of(10), level_of(1000)
    ((0, 0), (4, 4), (4, 4), (4, 5), (10, 7))
    """
    size = max(0, value).bit_length()
    return size, max(0, value) >> max(0, size - 3)
