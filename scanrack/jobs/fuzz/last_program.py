"""A cache with one entry. A search has one program and needs the same facts about it in every run."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from scanrack.ladder.state.lowered import LoweredProgram

Facts = TypeVar("Facts")


def remember_last(compute: Callable[[LoweredProgram], Facts]) -> Callable[[LoweredProgram], Facts]:
    """Return a function that computes its result again only for another program than the last one."""
    last: list[tuple[LoweredProgram, Facts]] = []

    @wraps(compute)
    def remembered(lowered: LoweredProgram) -> Facts:
        if not last or last[0][0] is not lowered:
            last[:] = [(lowered, compute(lowered))]
        return last[0][1]

    return remembered
