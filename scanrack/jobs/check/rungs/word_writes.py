"""Writes of a ladder program to output words of 3601s, as rules of all languages read them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from scanrack.ladder.state.lowered import LoweredProgram

from ..facts import FileLine
from ..written import WordWrite
from .output_writes import Write
from .steps import Steps
from .walk import Point


def word_writes(
    points: Sequence[tuple[Point, FileLine]], writes: Iterable[Write], steps: Steps, lowered: LoweredProgram
) -> Iterator[WordWrite]:
    """Yield the writes with the condition under which each acts, and its steps."""
    by_site = {point.step.site: point for point, _ in points if not point.argument}
    for each in writes:
        point = by_site.get(each.site)
        if point is None:
            continue
        yield WordWrite(
            *(each.place, each.slot, each.word, each.value),
            sets=each.sets if each.known else 0,
            clears=each.clears,
            when=steps.acts_when(point),
            steps=steps.where(point),
            text=lowered.sites[each.site].instruction,
        )
