"""Tasks of campaigns that a new process can import: one that works, and two whose worker dies."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path

from scanrack.jobs.fuzz import Report
from scanrack.jobs.fuzz.campaign.campaign import Task


def counted(task: Task) -> Report:
    return Report(runs=task.examples, rules=Counter({f"R{task.number}": 1}))


class DiesOnce:
    """Task 1 kills its worker, unless the flag says that it has done so before."""

    def __init__(self, flag: Path) -> None:
        self.flag = flag

    def __call__(self, task: Task) -> Report:
        if task.number == 1 and not self.flag.exists():
            self.flag.touch()
            os._exit(1)
        return counted(task)


def dies(task: Task) -> Report:
    os._exit(1)
