"""The search: scenario after scenario, until an invariant is broken, and then the smallest that breaks it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from hypothesis import HealthCheck, Phase, Verbosity, given, seed, settings, target
from hypothesis import strategies as st
from hypothesis.errors import Flaky

from ..pace import wall_ns
from .scenario import Scenario
from .trial import ASKING, BUILDING, HANGS, PROGRAM, RUNNING, Bench, Broken, Verdict
from .words import told

DRAWING = "drawing scenarios"
SPENT = (PROGRAM, RUNNING, ASKING, BUILDING, DRAWING)
"""What the time of a search goes to."""


@dataclass(frozen=True, slots=True)
class Found:
    """A scenario in which an invariant is broken.

    Attributes:
        scenario: the smallest that was found.
        broken: what is broken.
        after: number of runs until it was first broken.
    """

    scenario: Scenario
    broken: Broken
    after: int


@dataclass(slots=True)
class Report:
    """What a search came to.

    Attributes:
        runs: number of runs, those of shrinking included.
        scans: scans in all of them.
        rules: how often each rule of the manual fired.
        found: what was found, each invariant once.
        firsts: the scenario in which a rule fired first, by the rule's id.
        shrinking: how many of the runs were to shrink what was found.
        spent: what the time went to, ns, by the names of `SPENT`.
        applied: names of the invariants that have had something to look at.
    """

    runs: int = 0
    scans: int = 0
    rules: Counter[str] = field(default_factory=Counter)
    found: list[Found] = field(default_factory=list)
    firsts: dict[str, Scenario] = field(default_factory=dict)
    shrinking: int = 0
    spent: Counter[str] = field(default_factory=Counter)
    applied: set[str] = field(default_factory=set)

    def add(self, scenario: Scenario, verdict: Verdict) -> None:
        """Count a run."""
        self.runs += 1
        self.scans += verdict.scans
        for rule in verdict.rules:
            self.firsts.setdefault(rule, scenario)
        self.rules.update(verdict.rules)
        self.spent.update(verdict.spent)
        self.applied |= verdict.applied


class UnsteadyError(ValueError):
    """A program that does not do the same twice in the same scenario."""


class _BrokenError(Exception):
    """What tells Hypothesis that an example is one."""


def search(
    bench: Bench,
    strategy: st.SearchStrategy[Scenario],
    *,
    examples: int,
    start: int = 0,
    known: Iterable[str] = (),
    progress: Callable[[int], None] = lambda _runs: None,
) -> Report:
    """Look for scenarios in which invariants are broken.

    When one is found it is shrunk, and the search goes on for the others until the examples are
    used up. Faults of the program are told apart by their place; of any other invariant one failure is found.

    Args:
        bench: the program and what must hold.
        strategy: the scenarios.
        examples: how many are tried in all, less those of shrinking.
        start: seed of the search; the same seed finds the same.
        known: names of invariants, and keys of faults, that are not looked for.
        progress: called with the number of runs so far.

    Raises:
        InvariantError: an invariant raised.
        UnsteadyError: the program does not do the same twice.
    """
    report = Report()
    start_ns = wall_ns()
    given_up = set(known)
    left, attempt = examples, 0
    while left > 0 and bench.names - given_up:
        used, found = _hunt(bench, strategy, left, start + attempt, frozenset(given_up), report, progress)
        left -= used
        attempt += 1
        if found is None:
            break
        report.found.append(found)
        given_up.add(found.broken.key)
    report.spent[DRAWING] = wall_ns() - start_ns - report.spent.total()
    return report


def undisturbed(bench: Bench, scenario: Scenario, known: Iterable[str] = ()) -> list[Found]:
    """Run one scenario, before anything is random; return what is broken in it, each invariant once.

    Args:
        bench: the program and what must hold.
        scenario: an empty one, or what a recording shows.
        known: names of invariants that are not asked.

    Raises:
        InvariantError: an invariant raised.
    """
    found: list[Found] = []
    without = set(known)
    while (broken := bench.run(scenario, without=without).broken) is not None:
        found.append(Found(scenario, broken, 1))
        without.add(broken.key)
    return found


def _hunt(
    bench: Bench,
    strategy: st.SearchStrategy[Scenario],
    examples: int,
    start: int,
    without: frozenset[str],
    report: Report,
    progress: Callable[[int], None],
) -> tuple[int, Found | None]:
    """Search until something is broken; return the number of examples used, and what was found."""
    first = 0
    used = 0
    wanted: str | None = None
    smallest: tuple[Scenario, Broken] | None = None

    @seed(start)
    @settings(
        max_examples=examples,
        database=None,
        deadline=None,
        phases=[Phase.generate, Phase.target, Phase.shrink],
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
        verbosity=Verbosity.quiet,
        print_blob=False,
    )
    @given(strategy)
    def trial(scenario: Scenario) -> None:
        nonlocal first, used, wanted, smallest
        verdict = bench.run(scenario, without=without)
        report.add(scenario, verdict)
        progress(report.runs)
        if wanted is not None:
            report.shrinking += 1
        else:
            used += 1
            target(float(len(verdict.rules)), label="rules of the manual that fire")
        broken = verdict.broken
        if wanted is None and broken is not None and broken.cause == HANGS:
            broken = bench.run(scenario, without=without).broken  # the machine may have been busy
        if broken is None or (wanted is not None and broken.key != wanted):
            return
        if wanted is None:
            wanted, first = broken.key, report.runs
        smallest = scenario, broken
        raise _BrokenError

    try:
        trial()
    except _BrokenError:
        assert smallest is not None
        return used, Found(*smallest, first)
    except Flaky:
        assert smallest is not None
        raise UnsteadyError(_unsteady(*smallest)) from None
    return used, None


def _unsteady(scenario: Scenario, broken: Broken) -> str:
    return (
        f"the program does not do the same twice in the same surroundings ({'; '.join(told(scenario))}): "
        f"it broke {broken.invariant} in one run and not in another. Does it ask the clock, use chance, "
        "or keep something from run to run?"
    )
