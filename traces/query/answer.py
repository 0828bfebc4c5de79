"""The result of a query."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Occurrence:
    """One occurrence."""

    first: int  # number of its first scan
    last: int  # number of the last scan in which it held; of an answer, the scan of the answer
    start_ns: int  # virtual time of its first scan
    end_ns: int  # virtual time of the first scan in which it no longer held; of an answer, of the answer
    open: bool  # it was not over in the last scan of the trace: it lasted at least this long
    shown: Mapping[str, int | float | bool | None]  # requested signals in its first scan, or None

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
