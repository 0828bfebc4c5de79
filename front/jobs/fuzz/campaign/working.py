"""A worker of a campaign: runs one task, in this process or in one of its own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from warnings import catch_warnings, simplefilter

from hypothesis.configuration import set_hypothesis_home_dir
from hypothesis.errors import HypothesisDeprecationWarning

from .. import SearchReport, search
from ..drawing import scenarios
from ..job import Setup, bench_of
from .campaign import Task
from .confirming import Confirmation
from .fresh import in_fresh_process


@dataclass(frozen=True, slots=True)
class Work:
    """Runs a task of a campaign, see `jobs.fuzz.campaign.campaign.Work`."""

    setup: Setup

    def __call__(self, task: Task) -> SearchReport:
        """Run a task's search."""
        bench = bench_of(self.setup)
        strategy = scenarios(bench.spec, bench.scans, self.setup.kinds, base=task.base)
        with _kept_in(self.setup.notes), catch_warnings():
            # threads of a cluster's worker use `random`; Hypothesis would blame the strategies
            simplefilter("ignore", HypothesisDeprecationWarning)
            return search(
                bench,
                strategy,
                examples=task.examples,
                start=task.number,
                known=task.known,
                confirm=Confirmation(self.setup),
            )


@dataclass(frozen=True, slots=True)
class OwnProcess:
    """Runs a task in a process of its own.

    The worker of a cluster may run several tasks in threads of one process, which the modules of a program
    and its redirected output do not tolerate.
    """

    work: Work

    def __call__(self, task: Task) -> SearchReport:
        """Run a task's search in a process."""
        return in_fresh_process(self.work, task)


@contextmanager
def _kept_in(folder: Path) -> Iterator[None]:
    """Make Hypothesis write its files to a folder, not to the current one."""
    set_hypothesis_home_dir(folder / ".hypothesis")
    try:
        yield
    finally:
        set_hypothesis_home_dir(None)
