"""A campaign: many searches on all cores or on a cluster. It can be interrupted and continued.

    a round     begins with one corpus for all of its tasks
    a task      is one search: a seed, a number of examples, a share of that corpus
    a report    is added to the state in the order of the tasks, not in the order of arrival

A round depends on the earlier tasks and not on the workers, so a campaign takes the same steps with any
number of workers. The first rounds have four tasks each, later ones a quarter of the number of earlier tasks.
A task lacks the results of at most a fifth of all tasks, and a cluster of n workers is busy once 4 n tasks
are done.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from dataclasses import dataclass, field, replace

from ..aim.corpus import Corpus
from ..scenarios.scenario import Scenario
from ..search import Counterexample, SearchReport
from .executors import OnCluster
from .state import CampaignError, State

SHARED = 24
"""Number of corpus entries that the tasks of a round get: the least varied ones."""

LEAST_WIDTH, EARLIER, MOST_WIDTH = 4, 4, 1024
"""Number of tasks in a round: the minimum, the divisor of the number of earlier tasks, and the maximum."""

TRIES = 3
"""Number of attempts for a task whose worker dies."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """The time that a task may take, ns; None = no limit."""

    wall_ns: int | None = None
    processor_ns: int | None = None

    def covers(self, wall_ns: int, processor_ns: int) -> bool:
        """Return whether the used time is below every limit."""
        limits_and_use = (self.wall_ns, wall_ns), (self.processor_ns, processor_ns)
        return all(limit is None or spent < limit for limit, spent in limits_and_use)


@dataclass(frozen=True, slots=True)
class Task:
    """One search."""

    number: int  # from 0; its seed follows from it
    examples: int
    known: frozenset[str] = frozenset()
    base: Scenario | None = None  # a scenario to vary, or None
    corpus: Corpus | None = None  # the corpus of earlier rounds
    again: tuple[Scenario, ...] = ()  # scenarios to run first, such as those of a corpus on disk
    allowance: Allowance = Allowance()  # time left when the task begins


Work = Callable[[Task], SearchReport]
"""Runs a task in this or another process; picklable."""

Suggest = Callable[[State], tuple[Scenario, ...]]
"""Returns scenarios to run next, such as a solver's answers."""


def campaign(
    work: Work,
    state: State,
    executor: Callable[[], Executor],
    *,
    examples: int,
    tasks: int | None,
    jobs: int | None,
    again: tuple[Scenario, ...] = (),
    suggest: Suggest = lambda _state: (),
    has_time: Callable[[], bool] = lambda: True,
    allowance: Callable[[], Allowance] = Allowance,
    news: Callable[[list[Counterexample]], None] = lambda _found: None,
) -> None:
    """Run rounds of tasks until all are done or the time is up; add the results to the state.

    Args:
        executor: creates the executor; called again if its workers die.
        tasks: number of tasks; None = run until `has_time` returns False.
        jobs: number of concurrent tasks; None = one per thread of the cluster.
        again: scenarios that the first round runs, from a corpus on disk.
        suggest: called between two rounds; the next round runs its scenarios.
        has_time: called before every task.
        allowance: called before every task; returns the time it may take.
        news: called after every task with its new failures.

    Raises:
        CampaignError: the worker of one task has died several times.
        InvariantError: an invariant raised.
    """
    running = _Tasks(work, executor, jobs, has_time, allowance)
    rounds = _rounds(state, examples, None if tasks is None else state.tasks + tasks, again, suggest)
    try:
        for round_tasks in rounds:
            for report in running.reports(round_tasks, state.tasks):
                news(state.add(report))
            if not has_time():
                return
    finally:
        running.close()


@dataclass(slots=True)
class _Tasks:
    """Submits the tasks of a round and collects their reports; see `campaign`.

    Attributes:
        running: the submitted tasks.
        early: reports that arrived before those of earlier tasks, by task number.
        tried: number of attempts for each task, by task number.
    """

    work: Work
    executor: Callable[[], Executor]
    jobs: int | None
    has_time: Callable[[], bool]
    allowance: Callable[[], Allowance]
    pool: Executor = field(init=False)
    running: dict[Future[SearchReport], Task] = field(default_factory=dict)
    early: dict[int, SearchReport] = field(default_factory=dict)
    tried: Counter[int] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.pool = self.executor()

    def reports(self, tasks: Iterator[Task], number: int) -> Iterator[SearchReport]:
        """Run the tasks of a round; yield their reports in task order, beginning with a task number."""
        self._submit_all(tasks)
        while self.running:
            finished, _ = wait(self.running, return_when=FIRST_COMPLETED)
            self._take(finished)
            while number in self.early:
                yield self.early.pop(number)
                number += 1
            self._submit_all(tasks)

    def _submit_all(self, tasks: Iterator[Task]) -> None:
        """Submit a task to every idle worker as long as tasks remain."""
        while len(self.running) < self._at_a_time and self.has_time():
            task = next(tasks, None)
            if task is None:
                return
            self._submit(task)

    @property
    def _at_a_time(self) -> int:
        if self.jobs is not None:
            return self.jobs
        return self.pool.threads if isinstance(self.pool, OnCluster) else 1

    def _submit(self, task: Task) -> None:
        self.tried[task.number] += 1
        if self.tried[task.number] > TRIES:
            raise CampaignError(f"task {task.number}: its worker has died {TRIES} times")
        limited = replace(task, allowance=self.allowance())
        self.running[self.pool.submit(self.work, limited)] = task

    def _take(self, done: set[Future[SearchReport]]) -> None:
        """Store a report; submit a task again if its worker died."""
        lost_tasks = []
        broken = False
        for future in done:
            task = self.running.pop(future)
            error = future.exception()
            if error is None:
                self.early[task.number] = future.result()
            elif isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker":
                broken = broken or isinstance(error, BrokenExecutor)
                lost_tasks.append(task)
            else:
                raise error
        if broken:
            lost_tasks += self.running.values()
            self.running.clear()
            self.pool.shutdown(wait=False)
            self.pool = self.executor()
        for task in sorted(lost_tasks, key=lambda each: each.number):
            self._submit(task)

    def close(self) -> None:
        """Cancel the running tasks."""
        self.pool.shutdown(wait=True, cancel_futures=True)


def width(earlier: int) -> int:
    """Return the number of tasks of a round.

    >>> [width(earlier) for earlier in (0, 16, 100, 10_000)]
    [4, 4, 25, 1024]
    """
    return min(MOST_WIDTH, max(LEAST_WIDTH, earlier // EARLIER))


def _rounds(
    state: State, examples: int, end: int | None, again: tuple[Scenario, ...], suggest: Suggest
) -> Iterator[Iterator[Task]]:
    """Yield the rounds, each made from the current state; the caller stops after an interrupted round."""
    while again or end is None or state.tasks < end:
        names = frozenset(state.found)
        if again:
            tasks = _tasks_again(again, state.tasks, examples, names)
            end = None if end is None else end + len(tasks)
            yield iter(tasks)
        else:
            count = width(state.tasks) if end is None else min(width(state.tasks), end - state.tasks)
            yield _round(state, state.tasks, count, examples, names)
        again = suggest(state) if end is None or state.tasks < end else ()


def _tasks_again(again: tuple[Scenario, ...], first: int, examples: int, known: frozenset[str]) -> list[Task]:
    """Return the tasks that run the given scenarios."""
    count = -(-len(again) // examples)
    parts = [again[place::count] for place in range(count)]
    return [Task(number, len(part), known, again=part) for number, part in enumerate(parts, first)]


def _round(state: State, first: int, count: int, examples: int, known: frozenset[str]) -> Iterator[Task]:
    """Return the tasks of a round."""
    bases = list(state.corpus.values())
    corpus = state.kept.share(SHARED)

    def task(place: int) -> Task:
        number = first + place
        base = bases[number // 2 % len(bases)] if bases and number % 2 == 0 else None
        return Task(number, examples, known, base, corpus.for_task(place, count))

    return map(task, range(count))
