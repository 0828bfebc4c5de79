"""Searches for the planted mistakes of benchmarks/fuzz_programs: aimed, blind, and with the solver's help.

A find counts if the mistake's invariant is broken, and the same scenario leaves the correct version whole.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import process_time

from planted_programs import Version, invariant_of, version_of
from scanrack.jobs import State, load_job
from scanrack.jobs.fuzz import Counterexample, Scenario, search
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.prove.serving.stuck import SolverStep


@dataclass(frozen=True)
class Target:
    """A program with its mistake, and without."""

    name: str
    rack: Path
    planted: Version
    correct: Version
    invariant: str

    def is_it(self, scenario: Scenario, broken: str) -> bool:
        """Return whether a failure comes of the mistake."""
        return broken == self.invariant and self.correct.bench.run(scenario).broken is None


@contextmanager
def target_of(name: str) -> Iterator[Target]:
    """Lay out both versions of a program."""
    with TemporaryDirectory() as folder:
        planted = version_of(name, Path(folder) / "planted", with_mistake=True)
        correct = version_of(name, Path(folder) / "correct", with_mistake=False)
        yield Target(
            name, Path(folder) / "planted" / "rack.toml", planted, correct, invariant_of(name, planted)
        )


@dataclass(frozen=True)
class Took:
    """What a search took to find a planted mistake: runs None if it has not found it."""

    runs: int | None
    scans: int
    seconds: float  # of the processor


Way = Callable[[Target, int, int], Took]
"""Searches a target with a seed, for a number of runs."""


class _FoundError(Exception):
    """Ends a search at the planted mistake."""


class _Stopwatch:
    """Counts the runs of searches until the mistake is found."""

    def __init__(self, target: Target) -> None:
        self._target = target
        self.begin, self.runs = process_time(), 0

    def failed(self, found: Counterexample) -> None:
        """End the search if this failure is the mistake; it is not shrunk before."""
        if self._target.is_it(found.scenario, found.broken.invariant):
            self.runs += found.after
            raise _FoundError

    def took(self, *, found: bool, scans: int) -> Took:
        """Return what it has taken so far."""
        return Took(self.runs if found else None, scans, process_time() - self.begin)


def aimed(target: Target, seed: int, runs: int) -> Took:
    """Search as `scanrack fuzz` does, in one task and without the solver."""
    watch = _Stopwatch(target)
    try:
        report = search(
            target.planted.bench, target.planted.kinds, examples=runs, start=seed, failed=watch.failed
        )
    except _FoundError:
        return watch.took(found=True, scans=watch.runs * target.planted.bench.scans)
    return watch.took(found=False, scans=report.scans)


def blind(target: Target, seed: int, runs: int) -> Took:
    """Draw scenarios anywhere: no edges, nothing kept, nothing known of the program."""
    watch = _Stopwatch(target)
    bench = target.planted.bench
    draws = Draws(bench.spec, bench.scans, target.planted.kinds, Random(seed))
    scans = 0
    for number in range(1, runs + 1):
        scenario = draws.scenario()
        verdict = bench.run(scenario)
        scans += verdict.scans
        if verdict.broken is not None and target.is_it(scenario, verdict.broken.invariant):
            watch.runs = number
            return watch.took(found=True, scans=scans)
    return watch.took(found=False, scans=scans)


BEFORE, EACH = 10, 5
"""Runs before the solver's first answers, and between two of its answers."""


def solved(target: Target, seed: int, runs: int) -> Took:
    """Search a few runs, then ask the solver every few runs, as a search does that finds nothing new."""
    watch, state = _Stopwatch(target), State()
    bench, kinds = target.planted.bench, target.planted.kinds
    step = SolverStep(load_job(str(target.rack)), bench, patience=0)
    again: tuple[Scenario, ...] = ()
    count = BEFORE
    while state.runs < runs:
        watch.runs = state.runs
        try:
            report = search(
                bench,
                kinds,
                examples=count,
                start=seed << 32 | state.tasks,
                corpus=state.kept.share(24).for_task(0, 1),
                known=frozenset(state.found),
                again=again,
                failed=watch.failed,
            )
        except _FoundError:
            return watch.took(found=True, scans=watch.runs * bench.scans)
        state.add(report)
        again = step(state)
        count = len(again) or EACH
    return watch.took(found=False, scans=state.scans)
