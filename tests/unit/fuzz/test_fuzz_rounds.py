"""Rounds: the same steps on any number of workers, and what the tasks of a round hand over."""

from __future__ import annotations

import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from scanrack.commands.programs import fuzz_budget
from scanrack.commands.programs.fuzz_budget import Budget, Spending
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import State
from scanrack.jobs.fuzz import Press, Scenario, SearchReport
from scanrack.jobs.fuzz.aim.corpus import Corpus
from scanrack.jobs.fuzz.aim.edges import Edges
from scanrack.jobs.fuzz.campaign.campaign import Task, campaign, width
from scanrack.jobs.fuzz.campaign.executors import InlineExecutor

STEP_NS = 2_000_000


def shown(*names):
    edges = Edges()
    for scan, name in enumerate(names):
        edges.add("state", (0, name, 1), scan)
    return edges


def press(scan):
    return Scenario(presses=(Press(1, InputBit.HOME, True, scan * STEP_NS, STEP_NS),))


def keeps(task: Task) -> SearchReport:
    """Finds one new thing, and tells what it was given."""
    report = SearchReport(
        runs=task.examples, steps=repr(given(task)).encode(), corpus=task.corpus or Corpus()
    )
    report.corpus.take(press(task.number), shown("same", task.number), STEP_NS)
    return report


def given(task):
    corpus = task.corpus or Corpus()
    entries = [(each.scenario, each.chosen) for each in corpus.entries]
    return (
        task.number,
        task.examples,
        sorted(task.known),
        entries,
        len(corpus.seen),
        corpus.waiting,
        task.again,
    )


def late(task: Task) -> SearchReport:
    """The same, in another order."""
    time.sleep(task.number * 7 % 5 / 1000)
    return keeps(task)


def steps_of(work, executor, jobs, tasks=30):
    state = State()
    campaign(work, state, executor, examples=5, tasks=tasks, jobs=jobs)
    return state


def test_a_round_is_as_wide_as_what_is_behind_it_allows():
    assert [width(behind) for behind in (0, 4, 16, 20, 400, 4_096, 10**6)] == [4, 4, 4, 5, 100, 1024, 1024]


@pytest.mark.parametrize("jobs", [2, 3, 8])
def test_the_number_of_workers_and_the_order_of_arrival_change_nothing(jobs):
    one = steps_of(keeps, InlineExecutor, 1)
    many = steps_of(late, lambda: ThreadPoolExecutor(jobs), jobs)
    assert (one.tasks, one.runs) == (30, 150)
    assert one.steps == many.steps
    assert [each.scenario for each in one.kept.entries] == [each.scenario for each in many.kept.entries]
    assert len(one.kept.entries) == 30


def test_the_tasks_of_a_round_begin_with_one_corpus_and_the_next_knows_what_they_found():
    asked: list[Task] = []

    def work(task):
        asked.append(task)
        return keeps(task)

    campaign(work, State(), InlineExecutor, examples=5, tasks=8, jobs=1)
    sizes = [len(task.corpus.entries) - 1 for task in asked if task.corpus]  # less its own
    assert sizes == [0, 0, 0, 0, 4, 4, 4, 4]


def test_the_sweep_goes_on_where_the_round_before_has_left_it():
    corpus = Corpus(swept={"a"}, waiting=[("a", press(scan)) for scan in range(5)])
    shared = corpus.share(12)
    one, two = shared.for_task(0, 2), shared.for_task(1, 2)
    assert [len(each.waiting) for each in (one, two, corpus)] == [3, 2, 0]
    one.waiting.pop()
    for each in (one, two):  # both meet the same thin state
        each.swept.add("b")
        each.waiting.append(("b", press(9)))
        corpus.merge(each)
    assert [kind for kind, _ in corpus.waiting] == [None, None, "b", None, None]
    assert corpus.swept == {"a", "b"}


def test_the_tasks_of_the_first_round_share_the_contacts_and_later_ones_know_the_answers():
    button = Press(1, InputBit.HOME, True, 0, 0)
    corpus = Corpus()
    shared = corpus.share(12)
    one, two = shared.for_task(0, 2), shared.for_task(1, 2)
    assert (one.part, two.part) == ((0, 2), (1, 2))
    for each in (one, two):
        each.answered.append(button)
        corpus.merge(each)
    assert corpus.answered == corpus.share(12).for_task(0, 1).answered == [button]


def test_a_budget_that_is_used_up_ends_a_wide_round_in_its_middle():
    state = State()
    campaign(keeps, state, InlineExecutor, examples=5, tasks=None, jobs=1, has_time=lambda: state.tasks < 6)
    assert state.tasks == 6


def test_entries_of_a_corpus_on_disk_are_run_first_by_tasks_of_their_own():
    asked: list[Task] = []

    def work(task):
        asked.append(task)
        return keeps(task)

    again = tuple(map(press, range(7)))
    campaign(work, State(), InlineExecutor, examples=5, tasks=2, jobs=1, again=again)
    assert [(task.number, task.examples) for task in asked] == [(0, 4), (1, 3), (2, 5), (3, 5)]
    assert {each for task in asked for each in task.again} == set(again)


@pytest.mark.parametrize(
    ("budget", "left"),
    [
        (Budget(1), True),
        (Budget(1, wall_ns=5), True),
        (Budget(1, wall_ns=4), False),
        (Budget(1, scans=31), True),
        (Budget(1, scans=30), False),
        (Budget(1, processor_ns=8), True),
        (Budget(1, wall_ns=9, processor_ns=7), False),
    ],
)
def test_the_limit_that_is_reached_first_ends_a_search(budget, left, monkeypatch):
    """100 scans of earlier sessions do not count."""
    monkeypatch.setattr(fuzz_budget, "wall_ns", lambda: 4)
    assert Spending(budget, State(scans=130, processor_ns=7), 100, begin_ns=0).searches is left


def test_explaining_gets_half_of_a_budget_of_time_and_uses_it_up(monkeypatch):
    now = map(fuzz_budget.Times, (0, 4, 5, 5), (0, 4, 5, 5))  # its beginning, two looks at the clock, its end
    monkeypatch.setattr(fuzz_budget, "_current_times", lambda: next(now))
    spending = Spending(Budget(1, processor_ns=10), State(processor_ns=3), 0)
    with spending.on_explaining():
        assert spending.explains
        assert not spending.explains
    assert not spending.explains
    assert spending.allowance(jobs=2).processor_ns == (10 - 3 - 5) // 2
