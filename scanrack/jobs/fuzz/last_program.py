"""A cache with one entry: a search has one program and needs the same facts about it in every run."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from scanrack.ladder.state.lowered import LoweredProgram

Answer = TypeVar("Answer")


def remember_last(compute: Callable[[LoweredProgram], Answer]) -> Callable[[LoweredProgram], Answer]:
    """Return a function that computes its answer again only when the program differs from the last one."""
    last: list[tuple[LoweredProgram, Answer]] = []

    @wraps(compute)
    def remembered(lowered: LoweredProgram) -> Answer:
        if not last or last[0][0] is not lowered:
            last[:] = [(lowered, compute(lowered))]
        return last[0][1]

    return remembered
