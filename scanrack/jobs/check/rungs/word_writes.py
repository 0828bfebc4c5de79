"""Writes of a ladder program to output words of 3601s, in the form that the rules of all languages read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..written import WordWrite
from .output_writes import Write
from .steps import Steps
from .walk import Point


def word_writes(points: Iterable[Point], writes: Iterable[Write], steps: Steps) -> Iterator[WordWrite]:
    """Yield the writes, each with its condition and the steps in which it may act."""
    by_site = {point.step.site: point for point in points if not point.argument}
    for each in writes:
        point = by_site.get(each.site)
        if point is not None:
            yield WordWrite(
                *(each.place, each.slot, each.word, each.value),
                sets=each.sets if each.known else 0,
                clears=each.clears,
                when=steps.acts_when(point),
                steps=steps.where(point),
                text=point.text,
            )
