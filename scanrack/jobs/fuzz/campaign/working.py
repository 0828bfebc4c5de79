"""Runs a task of a campaign, in this process or in a new one."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass

from scanrack.runtime.loop.pace import wall_ns

from .. import Counterexample, SearchReport, search
from ..job import Setup, bench_of
from .campaign import Task
from .confirming import Confirmation
from .fresh import run_in_fresh_process
from .recipes import RecipeFolder

SEED_BITS = 32
"""Number of bits that a task's number has in the seed of its search."""


@dataclass(frozen=True, slots=True)
class Work:
    """Runs a task of a campaign, see `jobs.fuzz.campaign.campaign.Work`.

    Attributes:
        finds: folder for failures as found. None are written if it is None or does not exist on this machine.
    """

    setup: Setup
    finds: RecipeFolder | None = None

    def __call__(self, task: Task) -> SearchReport:
        """Run a task's search; return its report with the processor time."""
        begin_ns, begin_wall_ns = _processor_ns(), wall_ns()
        bench = bench_of(self.setup)
        report = search(
            bench,
            self.setup.kinds,
            examples=task.examples,
            start=self.setup.seed << SEED_BITS | task.number,
            base=task.base,
            corpus=task.corpus,
            known=task.known,
            again=task.again,
            failed=self._save,
            confirm=Confirmation(self.setup),
            has_time=lambda: task.allowance.covers(wall_ns() - begin_wall_ns, _processor_ns() - begin_ns),
        )
        report.processor_ns = _processor_ns() - begin_ns
        return report

    def _save(self, failure: Counterexample) -> None:
        """Write a failure before it is shrunk."""
        if self.finds is not None and self.finds.folder.is_dir():
            with suppress(OSError):  # the session reports a full disk
                self.finds.put(failure.scenario, failure.broken.invariant)


def _processor_ns() -> int:
    """Return the processor time of this process and its terminated child processes, ns."""
    return round(sum(os.times()[:4]) * 1e9)


@dataclass(frozen=True, slots=True)
class OwnProcess:
    """Runs a task in its own process.

    A worker of a cluster can run several tasks in threads of one process. However, each task redirects the
    output and reloads the program's modules for the whole process.
    """

    work: Work

    def __call__(self, task: Task) -> SearchReport:
        """Run a task's search in a process."""
        return run_in_fresh_process(self.work, task)
