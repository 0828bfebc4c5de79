"""Runs scenarios until one breaks an invariant, then shrinks that scenario.

run without events             shows the scans with changes, see `aim.probe`
random scenarios (`aim`)       one of them breaks an invariant in a new way
delta debugging (`shrink`)     finds the smallest scenario with the same failure
confirmation                   repeats the failure in another process

Then the search continues and ignores the known failures.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from hashlib import sha256
from random import Random
from typing import Any

from scanrack.runtime.loop.pace import wall_ns

from .aim.chooser import Chooser
from .aim.corpus import Corpus
from .aim.draws import Draws
from .aim.edges import Edges
from .aim.explored_states import ExploredStates
from .aim.probe import Probe
from .aim.sweep import Sweep
from .aim.times import times_of
from .nondeterminism import NondeterminismSources
from .run import BUILDING, HANGS, JUDGING, PROGRAM, RUNNING, BrokenInvariant, TrialBench, Verdict
from .scenarios.kinds import Kind, buttons, possible_kinds, sensors
from .scenarios.scenario import Scenario
from .scenarios.words import described
from .shrink import smallest

DRAWING, CONFIRMING = "drawing scenarios", "confirming"

LEAST_SHRINKING = 30
"""Minimum number of runs to shrink a failure, even if the time is up."""

SPENT = (PROGRAM, RUNNING, JUDGING, BUILDING, DRAWING, CONFIRMING)
"""Names of the parts of a search's time."""


@dataclass(frozen=True, slots=True)
class Counterexample:
    """A scenario that breaks an invariant."""

    scenario: Scenario
    broken: BrokenInvariant
    after: int  # number of runs until the failure was found


@dataclass(slots=True, kw_only=True)
class RunTotals:
    """The totals of many runs.

    Attributes:
        runs: number of runs, including shrinking runs.
        rules: number of times each rule of the manual fired, by id.
        applied: names of the invariants that had something to check.
        shrinking: number of shrinking runs.
        unshrunk: number of failures that are not completely shrunk.
        spent: time of each part in `SPENT`, ns.
        processor_ns: processor time, ns.
        printed: number of lines that the program printed.
        greatest: greatest value of each maximized number, by name.
        unshrunk_found: the failures as found, before shrinking.
    """

    runs: int = 0
    scans: int = 0
    rules: Counter[str] = field(default_factory=Counter)
    applied: set[str] = field(default_factory=set)
    shrinking: int = field(default=0, compare=False)
    unshrunk: int = field(default=0, compare=False)
    spent: Counter[str] = field(default_factory=Counter, compare=False)
    processor_ns: int = field(default=0, compare=False)
    printed: int = field(default=0, compare=False)
    greatest: dict[str, float] = field(default_factory=dict, compare=False)
    unshrunk_found: list[Counterexample] = field(default_factory=list, compare=False)

    def add_totals(self, other: RunTotals) -> None:
        """Add the totals of other runs."""
        self.runs += other.runs
        self.shrinking += other.shrinking
        self.unshrunk += other.unshrunk
        self.processor_ns += other.processor_ns
        self.unshrunk_found += other.unshrunk_found
        self._add_results(other)

    def _add_results(self, other: RunTotals | Verdict) -> None:
        """Add the results that totals and the verdict of a single run have in common."""
        self.scans += other.scans
        self.rules.update(other.rules)
        self.applied |= other.applied
        self.spent.update(other.spent)
        self.printed += other.printed
        for name, value in other.greatest.items():
            self.greatest[name] = max(value, self.greatest.get(name, value))


@dataclass(slots=True, kw_only=True)
class SearchReport(RunTotals):
    """The result of a search."""

    found: list[Counterexample] = field(default_factory=list)  # the shrunk failures, each once
    steps: bytes = b""  # digest of its runs in order; equal for equal runs
    corpus: Corpus = field(default_factory=Corpus)  # scenarios with new features, including earlier ones

    def add(self, scenario: Scenario, verdict: Verdict) -> None:
        """Count a run."""
        self.runs += 1
        self._add_results(verdict)
        key = verdict.broken.key if verdict.broken else ""
        self.steps = sha256(self.steps + repr((scenario, key)).encode()).digest()


class NondeterministicError(ValueError):
    """The program behaves differently in two runs of the same scenario."""


Confirm = Callable[[Counterexample, Collection[str]], bool]
"""Repeats a failure in another process, which ignores known failures; returns whether it occurs again.

Returns False only if the computer could be the cause. Raises `NondeterministicError` if the cause is the
program.
"""


def _confirm_any(_found: Counterexample, _without: Collection[str]) -> bool:
    return True


def search(
    bench: TrialBench,
    kinds: Collection[Kind],
    *,
    examples: int,
    start: int = 0,
    base: Scenario | None = None,
    corpus: Corpus | None = None,
    known: Iterable[str] = (),
    again: Iterable[Scenario] = (),
    failed: Callable[[Counterexample], None] = lambda _found: None,
    confirm: Confirm = _confirm_any,
    has_time: Callable[[], bool] = lambda: True,
) -> SearchReport:
    """Search for scenarios that break invariants.

    Each failure is shrunk and confirmed, and the search continues until the examples are used up. Failures of
    the same invariant have different causes.

    Args:
        kinds: kinds of random events. Kinds that are impossible in the rack are ignored.
        examples: number of scenarios to run, without shrinking.
        start: seed of the search. The same seed produces the same results.
        base: a scenario to vary; None = none.
        corpus: results of other searches, see `aim.corpus`. This search adds to it.
        known: names of invariants and keys of failures to ignore.
        again: scenarios to run first. Scenarios with new features are added to the corpus.
        failed: called with each failure before it is shrunk.
        confirm: see `Confirm`.
        has_time: returns whether there is time left; called before every run except the runs of `again`.

    Raises:
        InvariantError: an invariant raised.
        NondeterministicError: the program is not deterministic.
    """
    report = SearchReport(corpus=corpus or Corpus())
    start_ns = wall_ns()
    runner = _Runner(bench, report, set(known))
    random = Random(start)
    draws = Draws(bench.spec, bench.scans, kinds, random, bench.rungs, bench.settings)
    swept_kinds = possible_kinds(bench.spec).intersection(kinds)
    sweep = Sweep(bench.spec, swept_kinds, random, report.corpus, bench.rungs)
    chooser = Chooser(draws, sweep, random, report.corpus, base)
    waiting = deque(again)
    while runner.runs < examples and bench.names - runner.known and (waiting or has_time()):
        is_rerun = bool(waiting)
        scenario = waiting.popleft() if is_rerun else chooser.next(runner.edges_of)
        edges = Edges()
        counterexample = runner.find_failure(scenario, edges)
        if runner.runs == 1:  # the first run has created the logic
            draws.times = times_of(runner.logic, draws.scan_ns, draws.scans)
        if counterexample is not None:
            report.unshrunk_found.append(counterexample)
            failed(counterexample)
            runner.shrink_and_confirm(counterexample, confirm, has_time)
        elif not is_rerun:
            chooser.ran(scenario, edges)
        elif (entry := report.corpus.take(scenario, edges, bench.spec.scan_ns)) is not None:
            entry.new_features = ()  # a scenario of an earlier search is already trimmed
    report.spent[DRAWING] = wall_ns() - start_ns - report.spent.total()
    return report


def undisturbed(
    bench: TrialBench,
    scenario: Scenario,
    known: Iterable[str] = (),
    *,
    confirm: Confirm = _confirm_any,
    has_time: Callable[[], bool] = lambda: True,
) -> list[Counterexample]:
    """Run one scenario without random events; return each failure once.

    Args:
        scenario: an empty scenario, or the scenario of a recording.
        known: names of invariants to skip, and keys of failures to ignore.
        confirm: see `Confirm`.
        has_time: returns whether there is time left for shrinking.

    Raises:
        InvariantError: an invariant raised.
        NondeterministicError: the program is not deterministic.
    """
    counterexamples: list[Counterexample] = []
    ignored = set(known)
    while (broken := bench.run(scenario, without=ignored).broken) is not None:
        without = all_but(bench, broken, ignored)
        ignored.add(broken.key)
        smaller = shrunk(bench, Counterexample(scenario, broken, 1), without, SearchReport(), has_time)
        if confirm(smaller, without):
            counterexamples.append(smaller)
    return counterexamples


def all_but(bench: TrialBench, broken: BrokenInvariant, known: Collection[str]) -> frozenset[str]:
    """Return the names of all other invariants and the keys of known failures, to ignore in a run."""
    return frozenset({*known, *bench.names} - {broken.invariant, broken.key})


def shrunk(
    bench: TrialBench,
    failure: Counterexample,
    without: Collection[str],
    report: SearchReport,
    has_time: Callable[[], bool],
) -> Counterexample:
    """Return a failure with its smallest scenario, see `shrink`.

    Args:
        without: names of invariants to skip, and keys of failures to ignore.
        report: counts the runs.
        has_time: returns whether there is time for more than `LEAST_SHRINKING` runs.
    """
    runs, is_in_time = 0, True

    def same_failure(scenario: Scenario) -> BrokenInvariant | None:
        """Run a scenario; return its failure if it is the same. Return None without a run if time is up."""
        nonlocal runs, is_in_time
        is_in_time = is_in_time and (runs < LEAST_SHRINKING or has_time())
        if not is_in_time:
            return None
        runs += 1
        verdict = bench.run(scenario, without=without, every_scan=False)
        report.add(scenario, verdict)
        report.shrinking += 1
        return verdict.broken if verdict.broken and verdict.broken.key == failure.broken.key else None

    inputs = {slot.number: (*buttons(slot), *sensors(slot)) for slot in bench.spec.slot}
    scenario, broken = smallest(failure.scenario, failure.broken, same_failure, inputs, bench.spec.scan_ns)
    report.unshrunk += not is_in_time
    return Counterexample(scenario, broken, failure.after)


@dataclass(slots=True)
class _Runner:
    """Runs the scenarios of a search, and ignores the known failures."""

    bench: TrialBench
    report: SearchReport
    known: set[str]  # names of invariants and keys of failures
    runs: int = 0  # number of runs without shrinking
    logic: Any = None  # logic of the last run
    explored: ExploredStates = field(default_factory=ExploredStates)

    def find_failure(self, scenario: Scenario, edges: Edges) -> Counterexample | None:
        """Run a scenario and record its changes; return its failure, or None.

        Raises:
            NondeterministicError: the program is not deterministic.
        """
        self.runs += 1
        probe = Probe(edges)
        broken = self._run(scenario, probe, every_scan=False)
        self.logic = probe.logic
        edges.close()
        if broken is None:
            return None
        counterexample = Counterexample(scenario, broken, self.report.runs)
        repeated = self._run(scenario, None, every_scan=True)
        if repeated is not None and repeated.key == broken.key:
            return counterexample
        if broken.cause == HANGS:  # the computer may have been busy
            return None
        sources = NondeterminismSources()
        sources.recording_bench(self.bench).run(scenario)
        raise NondeterministicError(describe_nondeterminism(counterexample, str(sources)))

    def edges_of(self, scenario: Scenario) -> Edges | None:
        """Run a scenario; return its changes, or None if it breaks an invariant."""
        self.runs += 1
        edges = Edges()
        broken = self._run(scenario, Probe(edges), every_scan=False)
        edges.close()
        return None if broken else edges

    def shrink_and_confirm(
        self, failure: Counterexample, confirm: Confirm, has_time: Callable[[], bool]
    ) -> None:
        """Shrink a failure, and report it if it is confirmed. Later runs ignore the failure."""
        report = self.report
        without = all_but(self.bench, failure.broken, self.known)
        self.known.add(failure.broken.key)
        smallest_failure = shrunk(self.bench, failure, without, report, has_time)
        start_ns = wall_ns()
        if confirm(smallest_failure, without):
            report.found.append(smallest_failure)
        report.spent[CONFIRMING] += wall_ns() - start_ns

    def _run(self, scenario: Scenario, probe: Probe | None, *, every_scan: bool) -> BrokenInvariant | None:
        """Run a scenario and count it; return its failure, or None. Known failures are ignored."""
        verdict = self.bench.run(
            scenario, without=self.known, probe=probe, explored=self.explored, every_scan=every_scan
        )
        self.report.add(scenario, verdict)
        return verdict.broken


def describe_nondeterminism(failure: Counterexample, sources: str = "") -> str:
    """Return the message that a program is not deterministic, with the reason.

    Args:
        sources: its sources of nondeterminism, such as "the clock (line.py:12)"; empty if none is known.
    """
    reason = f"It uses {sources}." if sources else UNKNOWN_SOURCE
    return (
        "results differ between identical runs "
        f"({'; '.join(described(failure.scenario))}): it broke {failure.broken.invariant} in one run and not "
        f"in another. {reason}"
    )


UNKNOWN_SOURCE = (
    "It stores something from run to run, or depends on its process: the order of a set of texts, a file, or "
    "an object's address."
)
"""Text for a program whose source of nondeterminism is unknown."""
