"""The result of a query."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Occurrence:
    """One occurrence.

    Attributes:
        first: number of its first scan.
        last: number of the last scan in which it held; of an answer, the scan of the answer.
        start_ns: virtual time of its first scan.
        end_ns: virtual time of the first scan in which it no longer held; of an answer, of the answer.
        open: it was not over in the last scan of the trace: it lasted at least this long.
        shown: values of the requested signals in its first scan, or None.
    """

    first: int
    last: int
    start_ns: int
    end_ns: int
    open: bool
    shown: Mapping[str, int | float | bool | None]

    @property
    def duration_ns(self) -> int:
        """Its duration, ns."""
        return self.end_ns - self.start_ns


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of a query."""

    aggregate: str | None  # "count", "first", "last", "longest" or "shortest"; None for all occurrences
    count: int  # number of occurrences, of which an aggregate returns one or none
    occurrences: tuple[Occurrence, ...]  # those returned, in the order of their begins
