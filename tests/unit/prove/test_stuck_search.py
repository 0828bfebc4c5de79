"""What a search has reached, and what it asks of the solver when nothing new comes.

Broken on purpose: a threshold that is off by one, a patience not waited for, an instruction asked twice.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.jobs import ContactPress, Kind, Scenario, State, load_job
from scanrack.jobs.fuzz import search
from scanrack.jobs.fuzz.aim.corpus import STEP_WORTH
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.reached import reached
from scanrack.jobs.prove.serving.stuck import NEAR, PATIENCE, QUESTIONS, SolverStep

CODE = """\
PROGRAM code
TAG One : BOOL
TAG Fill : TIMER
TAG Hold : TIMER
TAG Never : BOOL
TAG Open : BOOL
ROUTINE Main
XIC(Local:2:I.Data.0)XIO(Local:2:I.Data.1)TON(Fill,40,0);
XIC(Fill.DN)XIC(Local:2:I.Data.2)OTL(One);
XIC(One)XIO(Local:2:I.Data.0)XIC(Local:2:I.Data.1)TON(Hold,60,0);
XIC(Hold.DN)XIC(Local:2:I.Data.3)OTE(Open);
XIC(One)XIO(One)OTE(Never);
END
"""
RACK = """\
program = "code.rung"
scan_ms = 10
run_for_s = 2
[[slot]]
number = 2
module = "1769-IQ16"
[slot.options]
inputs = { a = 0, b = 1, c = 2, d = 3 }
"""


@pytest.fixture
def setup(tmp_path: Path) -> Setup:
    """A lock: first a alone for 40 ms, then c; then b alone for 60 ms, and d."""
    (tmp_path / "code.rung").write_text(CODE, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    return Setup(str(tmp_path / "rack.toml"), (), (), 200, frozenset(Kind))


def after_runs(setup: Setup, *scenarios: Scenario) -> State:
    """The state of a campaign that has made these runs, and then nothing new for long."""
    state = State()
    bench = bench_of(setup)
    state.add(search(bench, setup.kinds, examples=len(scenarios) or 1, again=scenarios or (Scenario(),)))
    state.stale = PATIENCE
    return state


def gaps(job, state):
    return [each.text for each in reached(job, state.kept.seen).gaps]


def test_without_a_press_no_instruction_has_power_behind_it(setup):
    """Each rung begins with a contact that is off; a negated one behind it gets no power, either."""
    job = load_job(setup.rack)
    state = after_runs(setup)
    found = reached(job, state.kept.seen)
    assert found.total == 16  # three, three, four, three and three
    assert [each for each in gaps(job, state) if "XIO" in each] == [
        "XIO(Local:2:I.Data.1) in Main, rung 0",
        "XIO(Local:2:I.Data.0) in Main, rung 2",
        "XIO(One) in Main, rung 4",
    ]
    assert len(found.gaps) == found.total


@pytest.mark.extra("prove")
def test_the_answer_opens_the_lock_and_what_is_dead_is_no_gap(setup):
    job = load_job(setup.rack)
    state = after_runs(setup)
    scenarios: list[Scenario] = []
    step = SolverStep(job, bench_of(setup))
    after = state
    while step.questions < 20 and (answers := step(after)):
        scenarios += answers
        after = after_runs(setup, *scenarios)
    assert not [each for each in gaps(job, after) if "Open" in each]
    assert [each.text for each in step.gaps(reached(job, after.kept.seen)) if "Never" in each.text] == []
    assert "OTE(Never) in Main, rung 4" in gaps(job, after)


@pytest.mark.slow
@pytest.mark.extra("prove")
def test_nothing_is_asked_before_its_time_nor_twice(setup):
    job = load_job(setup.rack)
    state = after_runs(setup)
    state.stale = PATIENCE - 1
    step = SolverStep(job, bench_of(setup))
    assert (step(state), step.questions) == ((), 0)
    state.stale = PATIENCE
    for _ in range(30):
        step(state)
    most = step.questions
    step(state)
    assert step.questions == most <= QUESTIONS * 16


@pytest.mark.extra("prove")
def test_an_entry_of_the_corpus_is_where_a_question_begins(setup):
    """The lock's first half is open, its buttons still held: from there on they are let go, then b and d."""
    job = load_job(setup.rack)
    first = Scenario(
        pushes=(ContactPress(2, "a", 0, 5_000_000_000), ContactPress(2, "c", 50_000_000, 5_000_000_000))
    )
    state = after_runs(setup, first)
    state.kept.entries[-1].worth = STEP_WORTH
    (point,) = (
        each.number
        for each in reached(job, state.kept.seen).gaps
        if each.number is not None and each.text.startswith("OTE(Open")
    )
    found = SolverStep(job, bench_of(setup))._solve(point, NEAR + 1, state.kept.entries[-1:])
    assert found is not None
    known = state.kept.entries[-1].points[-1] + 1
    assert {each.at_ns + each.for_ns for each in found.pushes[:2]} == {known * 10_000_000}
    assert {each.input for each in found.pushes[2:]} >= {"b", "d"}
    assert min(each.at_ns for each in found.pushes[2:]) >= known * 10_000_000
    assert not [each for each in gaps(job, after_runs(setup, first, found)) if "Open" in each]
