"""A cache with one entry. A search has one program and needs the same facts about it in every run."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from scanrack.ladder.state.lowered import LoweredProgram

Facts = TypeVar("Facts")


def remember_last(compute: Callable[[LoweredProgram], Facts]) -> Callable[[LoweredProgram], Facts]:
    """Return a function that recomputes its result only if the program differs from the last one."""
    last_programs: list[LoweredProgram] = []  # at most one, with its facts in `last_facts`
    last_facts: list[Facts] = []

    @wraps(compute)
    def remembered(lowered: LoweredProgram) -> Facts:
        if not last_programs or last_programs[0] is not lowered:
            last_facts[:] = [compute(lowered)]
            last_programs[:] = [lowered]
        return last_facts[0]

    return remembered
