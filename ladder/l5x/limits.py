"""How much a document may have. The XML's own limits are in `document`.

All logic of a document is compiled for the trial, so time and memory follow what is counted here. The largest
controllers have some 15,000 rungs; a document beyond the limits is refused before anything of it is built.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from .document import L5xError
from .records import Document, RoutineRecord


class Limit(NamedTuple):
    """A limit.

    Attributes:
        most: how many there may be.
        noun: of what.
        counts: returns how many a document has, or how many each of its parts has, with the part's line.
    """

    most: int
    noun: str
    counts: Callable[[Document], Iterator[tuple[int, int]]]


def check_limits(document: Document) -> None:
    """Check a document against all limits.

    Raises:
        L5xError: it is beyond one.
    """
    for limit in LIMITS:
        for line, count in limit.counts(document):
            if count > limit.most:
                text = f"it has {count:,} {limit.noun}; {limit.most:,} are allowed"
                raise L5xError(document.file, line, text)


def _routines(document: Document) -> Iterator[RoutineRecord]:
    for owner in (*document.programs, *document.add_ons):
        yield from owner.routines


def _instructions(text: str) -> int:
    return text.count("(")


def _programs(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, len(document.programs)


def _add_ons(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, len(document.add_ons)


def _routine_count(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, sum(1 for _ in _routines(document))


def _rungs(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, sum(len(each.rungs) for each in _routines(document))


def _lines(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, sum(len(each.lines) for each in _routines(document))


def _characters(document: Document) -> Iterator[tuple[int, int]]:
    """Count the characters of all rungs and lines."""
    rungs = sum(len(rung.text) for each in _routines(document) for rung in each.rungs)
    yield 0, rungs + sum(len(text) for each in _routines(document) for text, _ in each.lines)


def _all_instructions(document: Document) -> Iterator[tuple[int, int]]:
    yield 0, sum(_instructions(rung.text) for each in _routines(document) for rung in each.rungs)


def _of_each_rung(document: Document) -> Iterator[tuple[int, int]]:
    for routine in _routines(document):
        yield from ((rung.line, _instructions(rung.text)) for rung in routine.rungs)


LIMITS = (
    Limit(1_000, "programs", _programs),
    Limit(2_000, "add-on instructions", _add_ons),
    Limit(5_000, "routines", _routine_count),
    Limit(30_000, "rungs", _rungs),
    Limit(60_000, "lines of structured text", _lines),
    Limit(8 << 20, "characters of logic", _characters),
    Limit(250_000, "instructions in rungs", _all_instructions),
    Limit(2_000, "instructions in one rung", _of_each_rung),
)
