"""Limits for a document's content; limits for its XML are in `parsing`.

All logic of a document is compiled for the trial, so time and memory depend on these counts. The largest
controllers have about 15,000 rungs. A document that exceeds a limit is refused before it is built.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from .parsing import L5xError
from .records import L5xDocument, RoutineRecord

MOST_IN_RUNG = 5_000
"""Maximum number of instructions in a rung; only the rung is refused if it has more."""


class Limit(NamedTuple):
    """A limit for a document's content."""

    most: int
    noun: str  # for messages
    count: Callable[[L5xDocument], int]


def check_limits(document: L5xDocument) -> None:
    """Raise an L5xError if a document exceeds a limit."""
    for limit in LIMITS:
        count = limit.count(document)
        if count > limit.most:
            text = f"it has {count:,} {limit.noun}; {limit.most:,} are allowed"
            raise L5xError(document.file, 0, text)


def instructions_in(text: str) -> int:
    """Return the number of instructions in a rung's text, including functions in expressions."""
    return text.count("(")


def _over_routines(count: Callable[[RoutineRecord], int]) -> Callable[[L5xDocument], int]:
    return lambda document: sum(count(routine) for _, routine in document.routines())


def _characters(routine: RoutineRecord) -> int:
    return sum(len(rung.text) for rung in routine.rungs) + sum(len(text) for text, _ in routine.lines)


LIMITS = (
    Limit(1_000, "programs", lambda document: len(document.programs)),
    Limit(2_000, "add-on instructions", lambda document: len(document.add_ons)),
    Limit(5_000, "routines", _over_routines(lambda _routine: 1)),
    Limit(30_000, "rungs", _over_routines(lambda routine: len(routine.rungs))),
    Limit(30_000, "lines of structured text", _over_routines(lambda routine: len(routine.lines))),
    Limit(8 << 20, "characters of logic", _over_routines(_characters)),
    Limit(
        250_000,
        "instructions in rungs",
        _over_routines(lambda routine: sum(instructions_in(rung.text) for rung in routine.rungs)),
    ),
)
