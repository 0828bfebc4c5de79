"""Runs of two compiled programs with equal inputs, random or from a scenario, to compare values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from random import Random
from typing import Any

from ..model.errors import LadderFault
from .algebra.meaning import BOOL, INT, same_float
from .algebra.terms import T
from .replaying import ScanOf
from .system import STOPPED, Key, ProgramSystem, ScanBounds

RUNS, SCANS = 24, 12
"""Number of random runs, and of scans in each run."""

FAULT: Key = (STOPPED, 0)
"""Key of the value that becomes true when a major fault stops a program."""


def random_runs(old: ProgramSystem, new: ProgramSystem, keys: Sequence[Key]) -> dict[Key, tuple[ScanOf, ...]]:
    """Run both compiled programs with equal random inputs; return a run for each value that differs."""
    runs: dict[Key, tuple[ScanOf, ...]] = {}
    free = _free(new) | _free(old)
    inputs = {(new if name in new.key_of else old).key_of[name]: variable for name, variable in free.items()}
    rng = Random(1)
    for _ in range(RUNS if keys else 0):
        pair = StoppingRun(old), StoppingRun(new)
        scans: list[ScanOf] = []
        for scan in _random_scans(rng, inputs, old.bounds):
            scans.append(scan)
            has_stopped = _scan_both(pair, scan)
            for key in keys:
                if key not in runs and _differ(pair, key):
                    runs[key] = tuple(scans)
            if has_stopped:
                break
    return runs


def _scan_both(pair: tuple[StoppingRun, StoppingRun], scan: ScanOf) -> bool:
    """Run a scan in both programs; return whether one of them has stopped."""
    for run in pair:
        run.do(scan)
    return pair[0].stopped or pair[1].stopped


def _random_scans(rng: Random, inputs: Mapping[Key, T], bounds: ScanBounds) -> Iterator[ScanOf]:
    """Yield the scans of a run with random inputs."""
    likely = {key: rng.choice((0.1, 0.5, 0.9)) for key in inputs}
    for number in range(SCANS):
        changed = {
            key: _random_value(rng, variable, likely[key])
            for key, variable in inputs.items()
            if number == 0 or rng.random() < 0.3
        }
        ms = _clipped(rng.choice((1, 10, 100, 1000)), bounds.low_ms, bounds.high_ms)
        yield ScanOf(ms if number else 0, changed)


class StoppingRun:
    """A run of a compiled program; a major fault stops it."""

    def __init__(self, problem: ProgramSystem) -> None:
        self._engine = problem.program.compile()
        self.stopped = False

    def do(self, scan: ScanOf) -> None:
        """Run a scan."""
        try:
            scan.do(self._engine)
        except LadderFault:
            self.stopped = True

    def value(self, key: Key) -> Any:
        """Return the current value of a place."""
        if key == FAULT:
            return self.stopped
        return self._engine.memory.read(self._engine.lowered.layout.leaf(key[0]), key[1])


def _differ(pair: tuple[StoppingRun, StoppingRun], key: Key) -> bool:
    """Return whether a value differs now; 0.0 and -0.0 differ, NaN equals NaN."""
    old_value, new_value = pair[0].value(key), pair[1].value(key)
    if isinstance(old_value, float) and isinstance(new_value, float):
        return not same_float(old_value, new_value)
    return bool(old_value != new_value)


def _free(problem: ProgramSystem) -> dict[str, T]:
    """Return the free variables that can change before the first scan, by name."""
    variables = problem.machine.vars
    names = [name for name in problem.key_of if problem.role(name) == "free" and name not in problem.late]
    return {name: variables[problem.key_of[name]] for name in sorted(names)}


def _random_value(rng: Random, v: T, likely: float) -> Any:
    """Return a random value of a variable; `likely` is the probability that a bit is true."""
    if v.kind == BOOL:
        return rng.random() < likely
    if v.kind == INT:
        return _clipped(rng.choice((0, 1, 2, 3, 5, 10, 100, 1000, rng.randint(v.lo, v.hi))), v.lo, v.hi)
    return rng.choice((0.0, 1.0, 2.5, -1.0, 100.0))


def _clipped(value: Any, low: Any, high: Any) -> Any:
    return max(low, min(high, value))


def differs(old: ProgramSystem, new: ProgramSystem, scans: Sequence[ScanOf], key: Key) -> bool:
    """Run both compiled programs; return whether neither stopped early and a value differs at the end."""
    runs = StoppingRun(old), StoppingRun(new)
    if any(_scan_both(runs, scan) for scan in scans[:-1]):
        return False
    _scan_both(runs, scans[-1])
    return _differ(runs, key)
