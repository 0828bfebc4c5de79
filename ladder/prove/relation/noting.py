"""A scan on terms that records the power at each instruction, for questions about rungs."""

from __future__ import annotations

from typing import Any, NamedTuple

from ...state.lowered import LoweredStep, Parallel
from ..algebra.terms import T, and_, any_of
from .turning import TurningMachine


class Passage(NamedTuple):
    """One execution of an instruction in a scan."""

    active: T  # condition that it is reached
    power: T  # power before it
    after: T  # power after it

    @property
    def before(self) -> T:
        """The condition under which power reaches the instruction."""
        return and_(self.active, self.power)


class NotingMachine(TurningMachine):
    """Records passages by instruction number, and the power after each leg by branch."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.noting = True
        self.passages: dict[int, list[Passage]] = {}
        self.legs: dict[int, list[tuple[T, tuple[T, ...]]]] = {}

    def execute(self, step: LoweredStep, power: Any) -> Any:
        """Run an instruction; return the power after it."""
        active = self.active
        after = super().execute(step, power)
        if self.noting:
            self.log.append_at(self.passages, step.site, Passage(active, power, after))
        return after

    def _branch(self, branch: Parallel, power: Any) -> Any:
        """Run the legs of a branch, and record the power after each leg. Return whether any leg has power."""
        active = self.active
        powers = [self._series(leg, power) for leg in branch.legs]
        if self.noting:
            self.log.append_at(self.legs, id(branch), (active, tuple(powers)))
        return any_of(powers)
