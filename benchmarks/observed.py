"""Cost of looking on: a scan of the feeder with a forced tag, a breakpoint, all power noted, and alone.

    python benchmarks/observed.py            table
    python benchmarks/observed.py --smoke    a short run that only checks

All variants run in turns in one process, from the middle of a stroke on, the images of that moment. What
each computed is checked: memory, truth and breakpoints are those of the interpreter in the same scans.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

from bars import Bars
from scanrack.jobs.bench.opening import open_bench
from scanrack.ladder.debug import Debugger
from scanrack.ladder.state.memory import same

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
STROKE = "6 s"
PERIOD_MS = 2.0
ROUTINE = "Main"
FORCED = ("Trouble", False)
NOT_TRUE = 2

Prepare = Callable[[Debugger], object]


def note_all(debugger: Debugger) -> None:
    """Ask for the power of all rungs, so that the next scans note it."""
    debugger.truth(ROUTINE)


VARIANTS: dict[str, tuple[Prepare, float]] = {
    "alone": (lambda _debugger: None, 1.0),
    "a forced tag": (lambda debugger: debugger.force(*FORCED), 1.1),
    "a breakpoint": (lambda debugger: debugger.break_at(ROUTINE, NOT_TRUE), 1.2),
    "all power": (note_all, 1.5),
}
"""What is done before the scans, and how many times the scan alone they may cost."""

TRUTH_LIMIT_MS = 1.0


def feeder() -> Debugger:
    """Return the feeder's program under the debugger, in the middle of a stroke."""
    bench = open_bench(FEEDER)
    bench.run_for(STROKE)
    assert isinstance(bench.logic, Debugger)
    return bench.logic


def check(prepare: Prepare, scans: int) -> None:
    """Compare a variant with the interpreter, scan by scan."""
    ours, oracle = feeder(), feeder()
    oracle.interpreted = True
    for each in (ours, oracle):
        prepare(each)
    for _ in range(scans):
        assert ours.scan(1, PERIOD_MS) == oracle.scan(1, PERIOD_MS) == ()
        values = [each._engine.memory.snapshot() for each in (ours, oracle)]
        assert all(same(values[0][path], values[1][path]) for path in values[0])
    assert ours.truth(ROUTINE) == oracle.truth(ROUTINE)


def spent(debugger: Debugger, scans: int) -> float:
    """Return seconds per scan."""
    begin = time.perf_counter()
    debugger.scan(scans, PERIOD_MS)
    return (time.perf_counter() - begin) / scans


def measured(rounds: int, scans: int) -> dict[str, float]:
    """Return seconds per scan by variant, the best of the rounds, in which all take their turns."""
    debuggers = {name: feeder() for name in VARIANTS}
    best = dict.fromkeys(VARIANTS, float("inf"))
    for _ in range(rounds):
        for name, (prepare, _limit) in VARIANTS.items():
            prepare(debuggers[name])
            debuggers[name].scan(1, PERIOD_MS)
            best[name] = min(best[name], spent(debuggers[name], scans))
    return best


def truth_s(questions: int, apart: int) -> float:
    """Return the mean seconds of a question about all rungs, so many scans apart."""
    debugger, total = feeder(), 0.0
    debugger.truth(ROUTINE)
    for _ in range(questions):
        debugger.scan(apart, PERIOD_MS)
        begin = time.perf_counter()
        debugger.truth(ROUTINE)
        total += time.perf_counter() - begin
    return total / questions


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    smoke = parser.parse_args().smoke
    for prepare, _limit in VARIANTS.values():
        check(prepare, 5 if smoke else 50)
    bars = Bars(count=not smoke)
    best = measured(2 if smoke else 60, 10 if smoke else 90)
    for name, (_prepare, limit) in VARIANTS.items():
        ratio = best[name] / best["alone"]
        bar = bars.most(name, ratio, limit)
        print(f"{name:<14} {best[name] * 1e6:>8.2f} us a scan, {ratio:>5.2f} times ({bar})")
    for what, apart in (("while it is looked at", 10), ("for the first time", 333)):
        mean_ms = 1e3 * truth_s(3 if smoke else 30, apart)
        print(f"truth {what:<22} {mean_ms:>7.3f} ms ({bars.most(what, mean_ms, TRUTH_LIMIT_MS)})")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
