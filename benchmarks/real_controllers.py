"""Controllers with the shape of real ones: a compiled scan, XML to the first scan, and the memory that takes.

    python benchmarks/real_controllers.py            1,000 rungs of each variant; 100 to 5,000 rungs imported
    python benchmarks/real_controllers.py --smoke    100 rungs of each: a short run that only checks
    python benchmarks/real_controllers.py --only mix strings        these variants, and no import

The documents come from a seed (tests/support/real_mix.py), with the shares of rungs that exports of real
machines have; a variant has more of one thing, or what one kind of machine has: drives that look up faults
(FSC, FAL), messages made by routines with parameters, alarms and queues (ALMA, ALMD, FFL, FFU). A rung
counts when it is executed: those of a called routine or add-on, and statements of structured text, each time.
Scans differ, since inputs do: the mean of many is given, and beside it how many times what a rung of bits
takes.

Checked: all rungs are imported; compiled and interpreted have equal memory, which has changed. CPU time and
memory of an import are those of a process of its own; the floor is what lxml alone needs for the same bytes.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from bars import Bars
from l5x import measured
from real_mix import real_controller
from real_rungs import VARIANTS
from scanrack.ladder.run.engine import Engine
from scanrack.rockwell.l5x import import_l5x
from scanrack.rockwell.l5x.trial import memory_difference

PERIOD_MS = 10
SCAN_BAR_NS, MACHINE_BAR_NS, RUNG_BAR_MS, MEMORY_BAR_MIB = 100, 150, 0.6, 300
MACHINES = ("drives", "messages", "alarms")
TAGS_PER_RUNG = 5
UNLIMITED = 1 << 40


def executed(engine: Engine, scans: int) -> float:
    """Return the rungs and statements of a scan, as the interpreter counts them."""
    engine.interpreter.lines_left = UNLIMITED
    for _ in range(scans):
        engine.step(PERIOD_MS)
    return (UNLIMITED - engine.interpreter.lines_left) / scans


def seconds_of(engine: Engine, scans: int, rounds: int) -> float:
    """Return CPU seconds per scan, the mean of the quickest round."""
    found = []
    for _ in range(rounds):
        begin = time.process_time()
        for _ in range(scans):
            engine.step(PERIOD_MS)
        found.append((time.process_time() - begin) / scans)
    return min(found)


def variant_ns(path: Path, rungs: int, variant: str, scans: int) -> tuple[float, float, float]:
    """Return seconds per scan, rungs executed in it, and seconds per scan interpreted."""
    path.write_text(real_controller(rungs, rungs * TAGS_PER_RUNG, variant=variant), encoding="utf-8")
    imported = import_l5x(path)
    assert imported.report.complete, imported.report.refused
    assert imported.controller is not None
    compiled, interpreted = imported.controller.compile(), imported.controller.interpret()
    before = compiled.memory.snapshot()
    begin = time.process_time()
    lines = executed(interpreted, scans)
    slow = (time.process_time() - begin) / scans
    for _ in range(scans):
        compiled.step(PERIOD_MS)
    assert not memory_difference(compiled, interpreted), memory_difference(compiled, interpreted)
    after = compiled.memory.snapshot()
    assert sum(before[each] != after[each] for each in before) > rungs / 4
    return seconds_of(compiled, max(scans, 20), 1 if scans < 10 else 5), lines, slow


def scans(path: Path, rungs: int, variants: list[str], count: int, bars: Bars) -> None:
    """Measure and print a scan of each variant."""
    bits = 0.0
    for variant in variants:
        taken, lines, slow = variant_ns(path, rungs, variant, count)
        each = max(taken, 1e-9) / lines * 1e9
        most = MACHINE_BAR_NS if variant in MACHINES else SCAN_BAR_NS
        bits, bar = bits or each, bars.most(variant, each, most)
        print(
            f"{variant:>10}: {taken * 1e6:8.1f} us a scan of {lines:6,.0f} rungs, {each:6.0f} ns each "
            f"({bar}), {each / bits:5.1f} x {variants[0]}, interpreted {slow / max(taken, 1e-9):.0f} x"
        )


def imports(path: Path, sizes: tuple[int, ...], bars: Bars) -> None:
    """Measure and print imports of so many rungs."""
    for rungs in sizes:
        path.write_text(real_controller(rungs, rungs * TAGS_PER_RUNG), encoding="utf-8")
        count, taken, highest = measured(path, "--measure")
        _, least, lowest = measured(path, "--floor")
        rung_ms, alone_ms = (1e3 * each / count for each in (taken, least))
        bar = bars.most("ms a rung", rung_ms, RUNG_BAR_MS)
        print(
            f"{count:6,} rungs, {rungs * TAGS_PER_RUNG:6,} tags, {path.stat().st_size / 1e6:5.1f} MB: "
            f"{rung_ms:.2f} ms a rung from XML to first scan ({bar}), "
            f"lxml alone {alone_ms:.3f}; {highest:.0f} MiB ({bars.most('MiB', highest, MEMORY_BAR_MIB)}), "
            f"lxml alone {lowest:.0f}"
        )


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    parser.add_argument("--only", nargs="+", choices=VARIANTS, help="scans of these variants, no import")
    given = parser.parse_args()
    bars = Bars(count=not given.smoke)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "real.L5X"
        rungs, count = (100, 3) if given.smoke else (1_000, 20)
        scans(path, rungs, given.only or list(VARIANTS), count, bars)
        if not given.only:
            imports(path, (100,) if given.smoke else (100, 500, 1_000, 5_000), bars)
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
