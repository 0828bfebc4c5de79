"""Numbers a rung's elements, and shows the power after each element as one character.

Elements are numbered from 0: instructions in order of execution, then branches in order of opening, then the
left rail. A wire shows the power after the element before it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

from ..model.tree import Branch, Rung, Series, instructions_of


class Numbering:
    """Numbers a rung's elements from left to right; `rail` is the last number."""

    def __init__(self, series: Series) -> None:
        self.instructions = sum(1 for _ in instructions_of(series))
        self.rail = self.instructions + branches_in(series)
        self._instruction = count()
        self._branch = count(self.instructions)

    def instruction(self) -> int:
        """Return the number of the next instruction."""
        return next(self._instruction)

    def branch(self) -> int:
        """Return the number of the next opening branch."""
        return next(self._branch)


def branches_in(series: Series) -> int:
    """Return the number of branches in a series, including nested branches.

    >>> from ..lowering.text import parse_rung
    >>> branches_in(parse_rung("[[XIC(A),XIC(B)],XIC(C)][,]OTE(D);").series)
    3
    """
    branches = [element for element in series if isinstance(element, Branch)]
    return len(branches) + sum(branches_in(leg) for branch in branches for leg in branch.legs)


def power(rung: Rung, truth: Sequence[bool] | None) -> str:
    """Return the power after each element of a rung, as `1` or `0`.

    >>> from ..lowering.text import parse_rung
    >>> seal_in = parse_rung("[XIC(Start),XIC(Run)]XIO(Stop)OTE(Run);")
    >>> power(seal_in, [False, True, True, True])  # four instructions, the branch, the rail
    '011111'
    >>> power(seal_in, None)
    '000000'

    Args:
        truth: power after each executed instruction, in order; None if the rung was not scanned.
    """
    numbering = Numbering(rung.series)
    if truth is None:
        return "0" * (numbering.rail + 1)
    if len(truth) > numbering.instructions:
        raise ValueError(
            f"{len(truth)} truths; must be at most {numbering.instructions}, one per instruction"
        )
    power_after = [False] * (numbering.rail + 1)
    power_after[: len(truth)] = truth
    power_after[numbering.rail] = True
    _flow(rung.series, numbering.rail, numbering, power_after)
    return "".join("01"[powered] for powered in power_after)


def _flow(series: Series, last: int, numbering: Numbering, power_after: list[bool]) -> int:
    """Append the power after each branch of a series; return the number of the last element."""
    for element in series:
        if isinstance(element, Branch):
            number = numbering.branch()
            ends = [_flow(leg, last, numbering, power_after) for leg in element.legs]
            power_after[number] = any(power_after[end] for end in ends)
            last = number
        else:
            last = numbering.instruction()
    return last
