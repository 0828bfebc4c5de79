"""The budget of a session of `scanrack fuzz`, and its share for explaining."""

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
"""Divisor of a budget of time: 1/2 is for explaining, the rest for the search."""


@dataclass(frozen=True, slots=True)
class Budget:
    """The limits of a session, which ends at the first one; `runs` applies only without the others."""

    runs: int  # number of scenarios
    wall_ns: int | None = None
    scans: int | None = None
    processor_ns: int | None = None  # of all workers

    @property
    def is_by_runs(self) -> bool:
        """Whether only the runs count."""
        return self.wall_ns is None and self.scans is None and self.processor_ns is None


class Times(NamedTuple):
    """A duration, ns: of the wall clock, and of processors."""

    wall_ns: int
    processor_ns: int


NO_TIME = Times(0, 0)


@dataclass(slots=True)
class Spending:
    """The used part of a session's budget.

    Explaining takes part of the time. Once that part or the budget is used up, further failures are not
    explained.
    """

    budget: Budget
    state: State
    scans_before: int
    explaining: Allowance = field(default_factory=Allowance)  # the time it may take
    not_explained: int = 0  # number of failures
    begin_ns: int = field(default_factory=wall_ns)
    _explained: Times = NO_TIME
    _since: Times | None = None

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
        """Whether there is time for explaining."""
        return self.explaining.covers(*self._explained_so_far)

    @property
    def used(self) -> Times:
        """The time used."""
        processor_ns = self.state.processor_ns + self._explained_so_far.processor_ns
        return Times(wall_ns() - self.begin_ns, processor_ns)

    def allowance(self, jobs: int) -> Allowance:
        """Return the time for a task, one of several at the same time."""
        used, limits = self.used, self.budget
        return Allowance(
            None if limits.wall_ns is None else limits.wall_ns - used.wall_ns,
            None if limits.processor_ns is None else (limits.processor_ns - used.processor_ns) // jobs,
        )

    @property
    def share(self) -> float | None:
        """The used part of the time, 0 to 1; None without a limit of time."""
        limits = self.budget.wall_ns, self.budget.processor_ns
        shares = [spent / limit for spent, limit in zip(self.used, limits, strict=True) if limit is not None]
        return min(1.0, max(shares)) if shares else None

    @contextmanager
    def on_explaining(self) -> Iterator[None]:
        """Count the time within as explaining."""
        self._since = _now()
        try:
            yield
        finally:
            self._explained, self._since = self._explained_so_far, None

    @property
    def _explained_so_far(self) -> Times:
        before, since = self._explained, self._since
        if since is None:
            return before
        now = _now()
        return Times(
            before.wall_ns + now.wall_ns - since.wall_ns,
            before.processor_ns + now.processor_ns - since.processor_ns,
        )


def _share(limit: int | None) -> int | None:
    return None if limit is None else limit // EXPLAINING


def _now() -> Times:
    """Return the time of the wall clock, and the processor time of this process."""
    return Times(wall_ns(), round(sum(os.times()[:2]) * 1e9))
