"""What may differ between two traces that count as the same."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far two traces may be apart.

    Attributes:
        time_ns: by how much an edge, a word or a position may come earlier or later, ns.
        counts: by how much position, encoder count and captured value of a 3601 may differ.

    Raises:
        ValueError: one of them is negative.
    """

    time_ns: int = 0
    counts: int = 0

    def __post_init__(self) -> None:
        for name, value in (("time_ns", self.time_ns), ("counts", self.counts)):
            if value < 0:
                raise ValueError(f"a tolerance of {name} = {value} is not allowed: 0 or more")

    @property
    def exact(self) -> bool:
        """Whether nothing may differ."""
        return not (self.time_ns or self.counts)


EXACT = Tolerance()
"""Nothing may differ."""
