"""A campaign: many searches, on all cores or on a cluster, that can be broken off and gone on with.

A search is a task: a seed and a number of examples. Tasks go to an executor of the standard library's
kind; what they report is added to the state, which is written after every one of them. Every other task
varies a scenario of the corpus, which holds the first scenario in which each rule of the manual fired.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .scenario import Scenario
from .search import Found, Report
from .trial import Broken

TRIES = 3
"""How often a task is given out whose worker dies."""


@dataclass(frozen=True, slots=True)
class Task:
    """One search.

    Attributes:
        number: which one, from 0; its seed follows from it.
        examples: how many scenarios it tries.
        known: names of invariants that it does not look for.
        base: a scenario that it varies.
    """

    number: int
    examples: int
    known: frozenset[str] = frozenset()
    base: Scenario | None = None


RECORDING = "recording"
"""What stands for a rule in the corpus where a scenario was learned from a recording."""

Work = Callable[[Task], Report]
"""Does a task, in this process or another one; it can be pickled."""


class CampaignError(ValueError):
    """A campaign that can't go on; the message says why."""


@dataclass(slots=True)
class State:
    """What a campaign knows.

    Attributes:
        tasks: number of tasks done, all of those before included.
        runs: number of runs.
        scans: scans in all of them.
        rules: how often each rule of the manual fired.
        corpus: by a rule's id, the scenario in which it fired first; by `RECORDING`, that of a recording.
        found: the smallest scenario that breaks an invariant, by the invariant's name.
    """

    tasks: int = 0
    runs: int = 0
    scans: int = 0
    rules: Counter[str] = field(default_factory=Counter)
    corpus: dict[str, Scenario] = field(default_factory=dict)
    found: dict[str, Found] = field(default_factory=dict)

    def add(self, report: Report) -> list[Found]:
        """Add what a task reports; return what is found for the first time, or smaller than before."""
        self.tasks += 1
        self.runs += report.runs
        self.scans += report.scans
        self.rules.update(report.rules)
        for rule, scenario in report.firsts.items():
            self.corpus.setdefault(rule, scenario)
        news = []
        for each in report.found:
            known = self.found.get(each.broken.invariant)
            if known is None or each.scenario.size < known.scenario.size:
                self.found[each.broken.invariant] = each
                news.append(each)
        return news

    def to_json(self) -> dict[str, Any]:
        """Return the state as JSON can hold it."""
        return {
            "tasks": self.tasks,
            "runs": self.runs,
            "scans": self.scans,
            "rules": dict(sorted(self.rules.items())),
            "corpus": {rule: each.to_json() for rule, each in sorted(self.corpus.items())},
            "found": [_found_json(each) for _, each in sorted(self.found.items())],
        }

    @classmethod
    def from_json(cls, given: dict[str, Any]) -> State:
        """Return the state that `to_json` wrote.

        Raises:
            ValueError: it is none.
        """
        try:
            found = [_found(each) for each in given["found"]]
            return cls(
                int(given["tasks"]),
                int(given["runs"]),
                int(given["scans"]),
                Counter(given["rules"]),
                {rule: Scenario.from_json(each) for rule, each in given["corpus"].items()},
                {each.broken.invariant: each for each in found},
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"this is no state of a campaign: {error!r}") from None


def _found_json(found: Found) -> dict[str, Any]:
    broken = found.broken
    return {
        "scenario": found.scenario.to_json(),
        "after": found.after,
        "invariant": broken.invariant,
        "sentence": broken.sentence,
        "scan": broken.scan,
        "now_ns": broken.now_ns,
        "why": broken.why,
        "rules": list(broken.rules),
    }


def _found(given: dict[str, Any]) -> Found:
    broken = Broken(
        given["invariant"],
        given["sentence"],
        given["scan"],
        given["now_ns"],
        given["why"],
        tuple(given["rules"]),
    )
    return Found(Scenario.from_json(given["scenario"]), broken, given["after"])


def read_state(file: Path) -> State:
    """Return the state in a file, an empty one if there is no such file.

    Raises:
        CampaignError: the file can't be read, or holds none.
    """
    if not file.exists():
        return State()
    try:
        return State.from_json(json.loads(file.read_text(encoding="utf-8")))
    except (OSError, ValueError) as error:
        raise CampaignError(f"{file}: {error}; move it away to begin anew") from error


def write_state(state: State, file: Path) -> None:
    """Write a state beside what was there, then put it in its place.

    Raises:
        OSError: it can't be written.
    """
    beside = file.with_suffix(".new")
    beside.write_text(json.dumps(state.to_json(), indent=1) + "\n", encoding="utf-8")
    beside.replace(file)


def campaign(
    work: Work,
    state: State,
    executor: Callable[[], Executor],
    *,
    examples: int,
    tasks: int | None,
    jobs: int,
    known: frozenset[str] = frozenset(),
    go_on: Callable[[], bool] = lambda: True,
    news: Callable[[list[Found]], None] = lambda _found: None,
) -> None:
    """Do tasks until they are done, or until `go_on` says no; the state holds what came out of them.

    Args:
        work: does a task.
        state: what is known; it is added to.
        executor: makes the executor, and makes it anew should its workers die.
        examples: scenarios per task.
        tasks: how many tasks; None = until `go_on` says no.
        jobs: how many at a time.
        known: names of invariants that are not looked for.
        go_on: asked after every task.
        news: told after every task, with what it found.

    Raises:
        CampaignError: a task's worker has died several times.
        InvariantError: an invariant raised.
    """
    waiting = _tasks(state, examples, tasks, known)
    tried: Counter[int] = Counter()
    running: dict[Future[Report], Task] = {}
    lost: list[Task] = []
    pool = executor()
    wanted = True
    try:
        while True:
            while wanted and len(running) < jobs:
                task = lost.pop() if lost else next(waiting, None)
                if task is None:
                    break
                tried[task.number] += 1
                if tried[task.number] > TRIES:
                    raise CampaignError(f"task {task.number}: its worker has died {TRIES} times")
                running[pool.submit(work, task)] = task
            if not running:
                break
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            broken = False
            for future in sorted(done, key=lambda each: running[each].number):
                task = running.pop(future)
                error = future.exception()
                if error is not None and _worker_died(error):
                    broken = broken or isinstance(error, BrokenExecutor)
                    lost.append(task)
                elif error is not None:
                    raise error
                else:
                    news(state.add(future.result()))
            if broken:
                lost += running.values()
                running.clear()
                pool.shutdown(wait=False)
                pool = executor()
            wanted = wanted and go_on()
    finally:
        for future in running:
            future.cancel()
        pool.shutdown(wait=True)


def _worker_died(error: BaseException) -> bool:
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"


def _tasks(state: State, examples: int, count: int | None, known: frozenset[str]) -> Iterator[Task]:
    """Return tasks with what is known when each is given out."""
    number = state.tasks
    end = None if count is None else number + count
    while end is None or number < end:
        bases = list(state.corpus.values())
        base = bases[number // 2 % len(bases)] if bases and number % 2 == 0 else None
        yield Task(number, examples, known | frozenset(state.found), base)
        number += 1
