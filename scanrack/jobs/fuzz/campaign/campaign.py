"""A campaign: many searches on all cores or on a cluster. It can be interrupted and continued.

    round     starts with one corpus for all of its tasks
    task      is one search with a seed, a number of examples, and a share of that corpus
    report    is added to the state in the order of the tasks, not in the order of arrival

A round depends on the earlier tasks and not on the workers, so a campaign takes the same steps with any
number of workers. The first rounds have four tasks each. Later rounds have a quarter of the number of earlier
tasks. A task therefore lacks the results of at most a fifth of all tasks, and n workers are busy after 4 n
tasks.
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
"""Number of corpus entries that the tasks of a round share: the least varied entries."""

LEAST_WIDTH, EARLIER, MOST_WIDTH = 4, 4, 1024
"""Minimum number of tasks in a round, earlier tasks per task in a round, and maximum number of tasks."""

TRIES = 3
"""Maximum number of attempts at a task if its worker dies."""


@dataclass(frozen=True, slots=True)
class Allowance:
    """The time limits of a task, ns; None = no limit."""

    wall_ns: int | None = None
    processor_ns: int | None = None

    def covers(self, wall_ns: int, processor_ns: int) -> bool:
        """Return whether the used time is below every limit."""
        is_wall_time_left = self.wall_ns is None or wall_ns < self.wall_ns
        return is_wall_time_left and (self.processor_ns is None or processor_ns < self.processor_ns)


@dataclass(frozen=True, slots=True)
class Task:
    """One search."""

    number: int  # from 0; determines the seed
    examples: int
    known: frozenset[str] = frozenset()  # keys of failures to ignore
    base: Scenario | None = None  # scenario to vary, or None
    corpus: Corpus | None = None  # corpus of earlier rounds
    again: tuple[Scenario, ...] = ()  # scenarios to run first, such as a corpus on disk
    allowance: Allowance = Allowance()  # time left at the beginning of the task


Work = Callable[[Task], SearchReport]
"""Runs a task in this or another process; picklable."""

Suggest = Callable[[State], tuple[Scenario, ...]]
"""Returns scenarios to run next, such as a solver's results."""


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
    """Run rounds of tasks until all tasks are done or the time is up. Add the results to the state.

    Args:
        executor: creates the executor. Called again if the workers die.
        tasks: number of tasks; None = run until `has_time` returns False.
        jobs: number of concurrent tasks; None = one per cluster thread.
        again: scenarios of a corpus on disk. The first round runs them.
        suggest: called between two rounds. The next round runs the returned scenarios.
        has_time: called before every task.
        allowance: called before every task; returns its time limits.
        news: called after every task with its new failures.

    Raises:
        CampaignError: the worker of a task has died several times.
        InvariantError: an invariant raised an exception.
    """
    runner = _TaskRunner(work, executor, jobs, has_time, allowance)
    rounds = _rounds(state, examples, None if tasks is None else state.tasks + tasks, again, suggest)
    try:
        for round_tasks in rounds:
            for report in runner.reports(round_tasks, state.tasks):
                news(state.add(report))
            if not has_time():
                return
    finally:
        runner.close()


@dataclass(slots=True)
class _TaskRunner:
    """Submits the tasks of a round and collects their reports; see `campaign`.

    Attributes:
        submitted: the submitted tasks by future.
        early_reports: reports that arrived before the reports of earlier tasks, by task number.
        attempts: number of attempts at each task, by task number.
    """

    work: Work
    executor: Callable[[], Executor]
    jobs: int | None
    has_time: Callable[[], bool]
    allowance: Callable[[], Allowance]
    pool: Executor = field(init=False)
    submitted: dict[Future[SearchReport], Task] = field(default_factory=dict)
    early_reports: dict[int, SearchReport] = field(default_factory=dict)
    attempts: Counter[int] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.pool = self.executor()

    def reports(self, tasks: Iterator[Task], first_number: int) -> Iterator[SearchReport]:
        """Run the tasks of a round, which are numbered from `first_number`; yield their reports in order."""
        next_number = first_number
        self._submit_all(tasks)
        while self.submitted:
            finished, _ = wait(self.submitted, return_when=FIRST_COMPLETED)
            self._collect(finished)
            while next_number in self.early_reports:
                yield self.early_reports.pop(next_number)
                next_number += 1
            self._submit_all(tasks)

    def _submit_all(self, tasks: Iterator[Task]) -> None:
        """Submit a task to every idle worker as long as tasks remain."""
        while len(self.submitted) < self._max_concurrent and self.has_time():
            task = next(tasks, None)
            if task is None:
                return
            self._submit(task)

    @property
    def _max_concurrent(self) -> int:
        """Maximum number of concurrent tasks."""
        if self.jobs is not None:
            return self.jobs
        return self.pool.threads if isinstance(self.pool, OnCluster) else 1

    def _submit(self, task: Task) -> None:
        """Submit a task with its time limits; raise CampaignError if its worker has died too many times."""
        self.attempts[task.number] += 1
        if self.attempts[task.number] > TRIES:
            raise CampaignError(f"task {task.number}: its worker has died {TRIES} times")
        limited = replace(task, allowance=self.allowance())
        self.submitted[self.pool.submit(self.work, limited)] = task

    def _collect(self, finished: set[Future[SearchReport]]) -> None:
        """Store the reports of finished tasks. Submit the tasks of dead workers again."""
        lost_tasks = []
        is_pool_broken = False
        for future in finished:
            task = self.submitted.pop(future)
            error = future.exception()
            if error is None:
                self.early_reports[task.number] = future.result()
            elif isinstance(error, BrokenExecutor):
                is_pool_broken = True
                lost_tasks.append(task)
            elif type(error).__name__ == "KilledWorker":  # of Dask, which replaces the worker
                lost_tasks.append(task)
            else:
                raise error
        if is_pool_broken:
            lost_tasks += self.submitted.values()
            self.submitted.clear()
            self.pool.shutdown(wait=False)
            self.pool = self.executor()
        for task in sorted(lost_tasks, key=lambda lost: lost.number):
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
    """Yield the rounds, each from the current state. The caller stops after an interrupted round.

    Args:
        end: number of tasks at which the campaign ends; None = no limit. Tasks for `again` are extra.
    """
    while again or end is None or state.tasks < end:
        if again:
            tasks = _rerun_tasks(state, again, examples)
            end = None if end is None else end + len(tasks)
            yield iter(tasks)
        else:
            count = width(state.tasks) if end is None else min(width(state.tasks), end - state.tasks)
            yield _search_tasks(state, count, examples)
        again = suggest(state) if end is None or state.tasks < end else ()


def _rerun_tasks(state: State, again: tuple[Scenario, ...], examples: int) -> list[Task]:
    """Return the tasks that run the given scenarios."""
    known = frozenset(state.found)
    count = -(-len(again) // examples)
    shares = [again[index::count] for index in range(count)]
    return [Task(number, len(share), known, again=share) for number, share in enumerate(shares, state.tasks)]


def _search_tasks(state: State, count: int, examples: int) -> Iterator[Task]:
    """Return the search tasks of a round."""
    bases = list(state.corpus.values())
    corpus = state.kept.share(SHARED)
    known, first_number = frozenset(state.found), state.tasks

    def task(index: int) -> Task:
        number = first_number + index
        base = bases[number // 2 % len(bases)] if bases and number % 2 == 0 else None
        return Task(number, examples, known, base, corpus.for_task(index, count))

    return map(task, range(count))
