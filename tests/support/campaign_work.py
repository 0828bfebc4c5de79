"""Tasks of campaigns that a new process can import: one that works, and two whose worker dies."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from scanrack.jobs.fuzz import SearchReport
from scanrack.jobs.fuzz.campaign.campaign import Task


def counted(task: Task) -> SearchReport:
    return SearchReport(runs=task.examples, rules=Counter({f"R{task.number}": 1}))


class DiesOnce:
    """Task 1 kills its worker, unless the flag says that it has done so before."""

    def __init__(self, flag: Path) -> None:
        self.flag = flag

    def __call__(self, task: Task) -> SearchReport:
        if task.number == 1 and not self.flag.exists():
            self.flag.touch()
            os._exit(1)
        return counted(task)


def dies(task: Task) -> SearchReport:
    os._exit(1)
