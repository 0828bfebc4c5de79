"""What a query found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Occurrence:
    """One occurrence.

    Attributes:
        first: number of the scan in which it began.
        last: number of the last scan in which it held; of an answer, the scan of the answer.
        start_ns: virtual time of its first scan.
        end_ns: virtual time of the first scan in which it no longer held; of an answer, of the answer.
        open: it was not over in the last scan of the trace: it lasted at least this long.
        shown: values in its first scan of the signals that were asked for, None where there is none.
    """

    first: int
    last: int
    start_ns: int
    end_ns: int
    open: bool
    shown: Mapping[str, int | float | bool | None]

    @property
    def duration_ns(self) -> int:
        """How long it lasted, ns."""
        return self.end_ns - self.start_ns


@dataclass(frozen=True, slots=True)
class Answer:
    """What a query found.

    Attributes:
        aggregate: "count", "first", "last", "longest" or "shortest"; None if all were asked for.
        count: how many occurrences there are, of which an aggregate gives one or none.
        occurrences: those asked for, in the order in which they began.
    """

    aggregate: str | None
    count: int
    occurrences: tuple[Occurrence, ...]
