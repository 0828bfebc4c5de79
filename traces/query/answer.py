"""The result of a query."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Occurrence:
    """An occurrence of a query's condition, or of its cause and effect."""

    first: int  # number of its first scan
    last: int  # number of its last scan; for `then`, of the scan with the effect
    start_ns: int  # virtual time of its first scan
    end_ns: int  # virtual time of the scan after its last scan; for `then`, of the scan with the effect
    open: bool  # whether it continued beyond the last scan of the trace; its duration is then a minimum
    shown: Mapping[str, int | float | bool | None]  # requested signals in its first scan; None = no value

    @property
    def duration_ns(self) -> int:
        """Duration of the occurrence, ns."""
        return self.end_ns - self.start_ns


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of a query."""

    aggregate: str | None  # "count", "first", "last", "longest" or "shortest"; None for all occurrences
    count: int  # number of all occurrences; an aggregate returns one or none of them
    occurrences: tuple[Occurrence, ...]  # the returned occurrences, in the order of their beginnings
