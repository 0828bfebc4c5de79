"""A campaign: many searches, on all cores or on a cluster, that can be interrupted and continued.

A search is a task: a seed and a number of examples. Tasks go to an executor with the interface of the
standard
library; their reports are added to the state, which is written after every one of them. Every other task
varies the first scenario in which a rule of the manual fired. Each gets a share of what the tasks before have
found to be new.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass

from ..aim.corpus import Corpus
from ..scenarios.scenario import Scenario
from ..search import Counterexample, SearchReport
from .state import CampaignError, State

SHARED = 12
"""Number of entries of the corpus that a task gets, those whose turn it is."""

TRIES = 3
"""Number of attempts for a task whose worker dies."""


@dataclass(frozen=True, slots=True)
class Task:
    """One search."""

    number: int  # from 0; its seed follows from it
    examples: int
    known: frozenset[str] = frozenset()
    base: Scenario | None = None  # a scenario to vary, or None
    corpus: Corpus | None = None  # what earlier tasks have found


Work = Callable[[Task], SearchReport]
"""Does a task, in this process or another one; it can be pickled."""


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
    news: Callable[[list[Counterexample]], None] = lambda _found: None,
) -> None:
    """Run tasks until all are done, or until `go_on` returns False; the state collects the results.

    Args:
        executor: makes the executor, and again if its workers die.
        tasks: their number; None = until `go_on` returns False.
        go_on: called after every task.
        news: called after every task with its findings.

    Raises:
        CampaignError: a task's worker has died several times.
        InvariantError: an invariant raised.
    """
    desk = _Desk(work, executor, _tasks(state, examples, tasks, known))
    try:
        for _ in range(jobs):
            desk.give_out()
        while desk.reports_are_due:
            for report in desk.wait(state.tasks):
                news(state.add(report))
                if go_on():
                    desk.give_out()
    finally:
        desk.close()


class _Desk:
    """Submits tasks and collects their reports.

    Reports are passed on in the order of their tasks, and each is followed by a new task: the knowledge of a
    task
    therefore does not depend on the workers' speed, and the same campaign has the same results.
    """

    def __init__(self, work: Work, executor: Callable[[], Executor], waiting: Iterator[Task]) -> None:
        self._work = work
        self._executor = executor
        self._waiting = waiting
        self._pool = executor()
        self._running: dict[Future[SearchReport], Task] = {}
        self._early: dict[int, SearchReport] = {}
        self._tried: Counter[int] = Counter()

    @property
    def reports_are_due(self) -> bool:
        """Whether a task is under way."""
        return bool(self._running)

    def give_out(self) -> None:
        """Submit the next task, if there is one."""
        task = next(self._waiting, None)
        if task is not None:
            self._submit(task)

    def _submit(self, task: Task) -> None:
        self._tried[task.number] += 1
        if self._tried[task.number] > TRIES:
            raise CampaignError(f"task {task.number}: its worker has died {TRIES} times")
        self._running[self._pool.submit(self._work, task)] = task

    def wait(self, number: int) -> Iterator[SearchReport]:
        """Wait until a task is done; yield the reports that have arrived, from a task's number on."""
        done, _ = wait(self._running, return_when=FIRST_COMPLETED)
        self._take(done)
        while number in self._early:
            yield self._early.pop(number)
            number += 1

    def _take(self, done: set[Future[SearchReport]]) -> None:
        """Store a report; submit a task again if its worker died."""
        lost = []
        broken = False
        for future in done:
            task = self._running.pop(future)
            error = future.exception()
            if error is None:
                self._early[task.number] = future.result()
            elif isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker":
                broken = broken or isinstance(error, BrokenExecutor)
                lost.append(task)
            else:
                raise error
        if broken:
            lost += self._running.values()
            self._running.clear()
            self._pool.shutdown(wait=False)
            self._pool = self._executor()
        for task in sorted(lost, key=lambda each: each.number):
            self._submit(task)

    def close(self) -> None:
        """Cancel the running tasks."""
        self._pool.shutdown(wait=True, cancel_futures=True)


def _tasks(state: State, examples: int, count: int | None, known: frozenset[str]) -> Iterator[Task]:
    """Yield tasks with the knowledge at their submission."""
    number = state.tasks
    end = None if count is None else number + count
    while end is None or number < end:
        bases = list(state.corpus.values())
        base = bases[number // 2 % len(bases)] if bases and number % 2 == 0 else None
        yield Task(number, examples, known | frozenset(state.found), base, state.kept.share(SHARED))
        number += 1
