"""The budget of a `scanrack fuzz` session, and the share for explanations."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import NamedTuple

from scanrack.jobs.fuzz.campaign.campaign import Allowance
from scanrack.jobs.fuzz.campaign.state import State
from scanrack.runtime.loop.pace import wall_ns

EXPLAINING = 2
"""Divisor of a time budget that yields the share for explanations: 2 = one half."""


@dataclass(frozen=True, slots=True)
class Budget:
    """The limits of a session, which ends at the first limit; `runs` applies only without other limits."""

    runs: int  # number of scenarios
    wall_ns: int | None = None
    scans: int | None = None
    processor_ns: int | None = None  # of all workers

    @property
    def is_by_runs(self) -> bool:
        """Whether only the number of runs is limited."""
        return self.wall_ns is None and self.scans is None and self.processor_ns is None


class Times(NamedTuple):
    """A duration in wall-clock time and in processor time, ns."""

    wall_ns: int
    processor_ns: int


NO_TIME = Times(0, 0)


@dataclass(slots=True)
class Spending:
    """The used part of a session's budget.

    Explanations have a share of the time. When the share or the budget is used up, additional failures are
    not explained.
    """

    budget: Budget
    state: State
    scans_before: int
    explaining: Allowance = field(default_factory=Allowance)  # the time for explanations
    not_explained: int = 0  # number of failures without an explanation
    begin_ns: int = field(default_factory=wall_ns)
    _explained: Times = NO_TIME  # the time of finished explanations
    _since: Times | None = None  # the beginning of the running explanation; None without one

    def __post_init__(self) -> None:
        wall, processor = self.budget.wall_ns, self.budget.processor_ns
        self.explaining = Allowance(_share(wall), _share(processor))

    @property
    def searches(self) -> bool:
        """Whether the search may continue."""
        scans = self.budget.scans
        may_continue = scans is None or self.state.scans - self.scans_before < scans
        return may_continue and Allowance(self.budget.wall_ns, self.budget.processor_ns).covers(*self.used)

    @property
    def explains(self) -> bool:
        """Whether time is left for explanations."""
        return self.explaining.covers(*self._explained_so_far)

    @property
    def used(self) -> Times:
        """The time used."""
        processor_ns = self.state.processor_ns + self._explained_so_far.processor_ns
        return Times(wall_ns() - self.begin_ns, processor_ns)

    def allowance(self, jobs: int) -> Allowance:
        """Return the time for one of several tasks that run at the same time."""
        used, limits = self.used, self.budget
        return Allowance(
            None if limits.wall_ns is None else limits.wall_ns - used.wall_ns,
            None if limits.processor_ns is None else (limits.processor_ns - used.processor_ns) // jobs,
        )

    @property
    def share(self) -> float | None:
        """The fraction of the time that is used, 0 to 1; None without a time limit."""
        limits = self.budget.wall_ns, self.budget.processor_ns
        shares = [spent / limit for spent, limit in zip(self.used, limits, strict=True) if limit is not None]
        return min(1.0, max(shares)) if shares else None

    @contextmanager
    def on_explaining(self) -> Iterator[None]:
        """Count the time of the block as explanation."""
        self._since = _current_times()
        try:
            yield
        finally:
            self._explained, self._since = self._explained_so_far, None

    @property
    def _explained_so_far(self) -> Times:
        if self._since is None:
            return self._explained
        times = zip(self._explained, _current_times(), self._since, strict=True)
        return Times(*(explained + current - begin for explained, current, begin in times))


def _share(limit: int | None) -> int | None:
    return None if limit is None else limit // EXPLAINING


def _current_times() -> Times:
    """Return the wall-clock time and the processor time of this process."""
    return Times(wall_ns(), round(sum(os.times()[:2]) * 1e9))
