"""`within`: a time limit, for waits of a sequence and for invariants of a fuzzed run."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar, overload

from ....ladder.python.sequences.branches import Work
from ....ladder.python.sequences.branches import within as limited
from ....ladder.python.sequences.waits import Wait

if TYPE_CHECKING:
    from .invariants import Condition, Invariant

T = TypeVar("T")


@overload
def within(limit: str, work: Work[T]) -> Wait[T]: ...
@overload
def within(
    limit: str, *, after: Condition, while_resting: bool = False
) -> Callable[[Condition], Invariant]: ...
def within(limit: str, work: Any = None, *, after: Any = None, while_resting: bool = False) -> Any:
    """Limit the time of a wait, or make an invariant of a condition that must become true in time.

    In logic, `await within("5 s", wait)`: see `ladder.python.sequences.within`. In a file of invariants,
    `@within("5 s", after=...)`: see `jobs.fuzz.within`.

    Args:
        limit: machine time with its unit, such as "5 s".
        after: what starts the clock of an invariant.
        while_resting: whether that clock runs in program mode, too.

    Raises:
        TypeError: neither `work` nor `after` is given, or both.
        ValueError: `limit` is not a time.
    """
    if (work is None) is (after is None):
        raise TypeError('write `await within("5 s", wait)`, or `@within("5 s", after=condition)`')
    if after is None:
        return limited(limit, work)
    from .. import within as invariant  # Hypothesis takes time to import

    return invariant(limit, after=after, while_resting=while_resting)
