"""The first difference between the waits of sequences in two traces.

Lines do not count: a comment above them moves them all. Without a tolerance a wait counts with its scan. Both
traces are read side by side, so memory stays flat however often their sequences go on.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from itertools import zip_longest

from ..format.topics import SEQUENCES
from ..read.reader import Trace
from ..read.sequence_steps import OVER, Step, step_of

Difference = tuple[str, str, str]
"""A sequence, and its first step that differs in either trace."""


def differing_sequences(one: Trace, other: Trace, *, exact: bool) -> tuple[Difference, ...]:
    """Return the first difference of each sequence whose waits differ in the two traces.

    Args:
        one: the first trace.
        other: the second.
        exact: whether waits are compared with their scans.
    """
    pairs: dict[str, _Pair] = {}
    for both in zip_longest(_steps(one), _steps(other)):
        for side, step in enumerate(both):
            if step is not None:
                pairs.setdefault(step.sequence, _Pair(exact)).add(side, step)
    found = ((name, pair.difference()) for name, pair in pairs.items())
    return tuple((name, *told) for name, told in found if told is not None)


def _steps(trace: Trace) -> Iterator[Step]:
    if SEQUENCES.name in trace.head.channels:
        yield from (step_of(event) for event in trace.events() if event.topic == SEQUENCES.name)


class _Pair:
    """The steps of one sequence in both traces, as far as they are not compared yet."""

    def __init__(self, exact: bool) -> None:
        self._exact = exact
        self._waiting: tuple[deque[Step], deque[Step]] = (deque(), deque())
        self._differ: tuple[Step, Step] | None = None

    def add(self, side: int, step: Step) -> None:
        """Take the next step of a side, and compare it with that of the other one."""
        if self._differ is not None:
            return
        self._waiting[side].append(step)
        if all(self._waiting):
            a, b = (queue.popleft() for queue in self._waiting)
            if self._key(a) != self._key(b):
                self._differ = a, b

    def difference(self) -> tuple[str, str] | None:
        """Return the first steps that differ; None if all are alike."""
        if self._differ is not None:
            return _told(self._differ[0]), _told(self._differ[1])
        rest = [queue[0] if queue else None for queue in self._waiting]
        return None if rest == [None, None] else (_told(rest[0]), _told(rest[1]))

    def _key(self, step: Step) -> tuple[int, str]:
        return (step.scan if self._exact else 0), step.wait


def _told(step: Step | None) -> str:
    return "nothing more" if step is None else f"{step.wait or OVER} from scan {step.scan} on"
