"""Two compiled programs with equal inputs: random runs, and a given one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from random import Random
from typing import Any

from ..model.errors import LadderFault
from ..run.engine import Engine
from .algebra.meaning import BOOL, INT
from .algebra.terms import T
from .replaying import ScanOf
from .system import Key, ProgramSystem

RUNS, SCANS = 24, 12
"""Random runs, and scans of each."""


def random_runs(
    old: ProgramSystem, new: ProgramSystem, keys: Sequence[Key], runs: int = RUNS
) -> dict[Key, tuple[ScanOf, ...]]:
    """Run both compiled programs with equal random inputs; return a run for each value that differs."""
    free = _free(old) | _free(new)
    places = {name: (new if name in new.key_of else old).key_of[name] for name in free}
    found: dict[Key, tuple[ScanOf, ...]] = {}
    rng, left = Random(1), list(keys)
    for _ in range(runs if keys else 0):
        engines = old.program.compile(), new.program.compile()
        likely = {name: rng.choice((0.1, 0.5, 0.9)) for name in free}
        scans: list[ScanOf] = []
        with suppress(LadderFault):
            for number in range(SCANS):
                inputs = {
                    places[name]: _any(rng, v, likely[name])
                    for name, v in free.items()
                    if number == 0 or rng.random() < 0.3
                }
                ms = _clipped(rng.choice((1, 10, 100, 1000)), old.bounds.low_ms, old.bounds.high_ms)
                scans.append(ScanOf(ms if number else 0, inputs))
                for engine in engines:
                    scans[-1].do(engine)
                for key in left:
                    if _value(engines[0], key) != _value(engines[1], key):
                        found[key] = tuple(scans)
                left = [key for key in left if key not in found]
    return found


def _free(problem: ProgramSystem) -> dict[str, T]:
    """Return the inputs, but those that are written outside as well."""
    places = problem.machine.vars
    names = [name for name in problem.key_of if problem.role(name) == "free" and name not in problem.late]
    return {name: places[problem.key_of[name]] for name in sorted(names)}


def _any(rng: Random, v: T, likely: float) -> Any:
    if v.kind == BOOL:
        return rng.random() < likely
    if v.kind == INT:
        return _clipped(rng.choice((0, 1, 2, 3, 5, 10, 100, 1000, rng.randint(v.lo, v.hi))), v.lo, v.hi)
    return rng.choice((0.0, 1.0, 2.5, -1.0, 100.0))


def _clipped(value: int, low: int, high: int) -> int:
    return max(low, min(high, value))


def _value(engine: Engine, key: Key) -> Any:
    return engine.memory.read(engine.lowered.layout.leaf(key[0]), key[1])


def differs(old: ProgramSystem, new: ProgramSystem, scans: Sequence[ScanOf], key: Key) -> bool:
    """Run both compiled programs; return whether a value differs at the end."""
    return bool(_left_by(old, scans, key) != _left_by(new, scans, key))


def _left_by(problem: ProgramSystem, scans: Sequence[ScanOf], key: Key) -> Any:
    """Return a value after a run; a fault's text if it faults."""
    engine = problem.program.compile()
    try:
        for scan in scans:
            scan.do(engine)
    except LadderFault as fault:
        return str(fault)
    return _value(engine, key)
