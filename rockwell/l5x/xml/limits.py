"""Limits of a document's content. The XML's own limits are in `document`.

All logic of a document is compiled for the trial, so time and memory depend on these counts. The largest
controllers have some 15,000 rungs; a document beyond the limits is refused before any of it is built.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .parsing import L5xError
from .records import L5xDocument, RoutineRecord

MOST_IN_RUNG = 5_000
"""Maximum instructions in a rung; a longer rung is refused by itself."""


class Limit(NamedTuple):
    """A maximum, the noun of what it limits, and the function that counts it."""

    most: int
    noun: str
    count: Callable[[L5xDocument], int]


def check_limits(document: L5xDocument) -> None:
    """Raise an L5xError if a document exceeds a limit."""
    for limit in LIMITS:
        count = limit.count(document)
        if count > limit.most:
            text = f"it has {count:,} {limit.noun}; {limit.most:,} are allowed"
            raise L5xError(document.file, 0, text)


def instructions_in(text: str) -> int:
    """Return the number of instructions in a rung's text, functions in expressions included."""
    return text.count("(")


def _sum(count: Callable[[RoutineRecord], int]) -> Callable[[L5xDocument], int]:
    return lambda document: sum(count(routine) for _, routine in document.routines())


def _characters(routine: RoutineRecord) -> int:
    return sum(len(rung.text) for rung in routine.rungs) + sum(len(text) for text, _ in routine.lines)


LIMITS = (
    Limit(1_000, "programs", lambda document: len(document.programs)),
    Limit(2_000, "add-on instructions", lambda document: len(document.add_ons)),
    Limit(5_000, "routines", _sum(lambda _routine: 1)),
    Limit(30_000, "rungs", _sum(lambda routine: len(routine.rungs))),
    Limit(30_000, "lines of structured text", _sum(lambda routine: len(routine.lines))),
    Limit(8 << 20, "characters of logic", _sum(_characters)),
    Limit(
        250_000,
        "instructions in rungs",
        _sum(lambda routine: sum(instructions_in(rung.text) for rung in routine.rungs)),
    ),
)
