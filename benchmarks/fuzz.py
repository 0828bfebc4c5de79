"""Does the search reach its bars? Each row of its acceptance table, with its figure beside its bar.

    python benchmarks/fuzz.py                        the rows that take some minutes
    python benchmarks/fuzz.py --long                 all rows: `planted` and `alarms` take hours
    python benchmarks/fuzz.py --only planted --seeds 4 staircase bounce    one row, these programs
    python benchmarks/fuzz.py --only turns           seconds until found, there and here in turns (minutes)
    python benchmarks/fuzz.py --smoke                a few runs of some rows

Planted: the programs of benchmarks/fuzz_programs, each with its mistake, searched with several seeds until
it is found. It counts if the same scenario leaves the correct version whole. Beside it stands a search that
draws blindly, in the same run and on the same budget. Six programs were written before the search was tuned,
six after it: bounce, forgotten_zero, last_steps, night_start, one_slip, torn_position.

Seconds are those of the processor. What the other benchmarks of the search measure is a row here, too.

Exit status: 0; 1 if module and oracle have differed, a correct program has broken what must hold, or a digest
or an instant is not what it has to be.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from random import Random
from statistics import median, quantiles
from time import process_time
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

import against
import fuzz_kills
import fuzz_workers
import inevitable
from lockstep3601 import GivenUp, Lockstep
from oracle_bits import CONFIGURE
from planted_programs import NAMES
from planted_searches import Took, Way, aimed, blind, solved, target_of
from scanrack.jobs.fuzz import Scenario, TrialBench, search
from scanrack.jobs.fuzz.aim.edges import Edges
from scanrack.jobs.fuzz.aim.probe import Probe
from scanrack.jobs.fuzz.run import BUILDING
from scanrack.jobs.fuzz.search import DRAWING
from steps3601 import Recover
from stories3601 import THEMES, scripts_of

BUDGET, SEEDS, FEW = 600, 30, 3
"""Runs of a search, number of searches of a program in the row `planted`, and in a row of one program."""


@dataclass(frozen=True)
class Choice:
    """What the command line chooses; None = the default of a row."""

    seeds: int | None = None
    runs: int = BUDGET
    names: tuple[str, ...] = ()
    smoke: bool = False


SHARES = {
    "the oracle's ticks": ("oracle3601.py", "tick"),
    "the oracle's images": ("oracle3601.py", "image"),
    "the module": ("module.py", "update"),
    "comparing": ("lockstep3601.py", "compare"),
}
"""What the time of the lockstep is divided into: functions, in which the time of those below them counts."""

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
SCANS = 1000


def play(scripts) -> tuple[int, int, int]:
    """Play scripts in lockstep; return commands, command sequences and ticks."""
    commands = stories = ticks = 0
    for setting, steps in scripts:
        bench = Lockstep(setting)
        try:
            for step in steps:
                step.play(bench)
                stories += isinstance(step, Recover)
        except GivenUp:
            pass
        ticks += bench.now_ns // 250_000
        commands += sum(is_command(what) for _, what in bench.log)
    return commands, stories, ticks


def is_command(noted) -> bool:
    """Whether what was noted are words, some command bit in them."""
    return isinstance(noted, list) and any(noted[:2]) and not noted[0] & CONFIGURE


def report_module(examples: int) -> None:
    start = process_time()
    scripts = [script for theme in THEMES for script in scripts_of(theme, examples)]
    drawn = process_time() - start
    start = process_time()
    commands, stories, ticks = play(scripts)
    played = process_time() - start
    total = drawn + played
    print(
        f"  scripts            {len(scripts) / total:>10,.0f} per second ({len(scripts):,} in {total:.1f} s)"
    )
    print(f"  command sequences  {stories / total:>10,.0f} per second")
    print(f"  commands           {commands / total:>10,.0f} per second")
    print(f"  ticks of 250 µs    {ticks / total:>10,.0f} per second")
    print(f"  drawing scripts    {drawn / total:>10.0%} of the time")
    for what, share in shares(scripts[:: max(1, len(scripts) // 40)]).items():
        print(f"  {what:<18} {share * played / total:>10.0%}")


def shares(scripts) -> dict[str, float]:
    """Return what playing scripts spends its time on, as a profiler sees it."""
    profile = cProfile.Profile()
    profile.runcall(play, scripts)
    stats: Any = pstats.Stats(profile)  # its counts are in no stub
    spent = {
        (Path(file).name, name): cumulative
        for (file, _, name), (_, _, _, cumulative, _) in stats.stats.items()
    }
    return {what: spent.get(place, 0.0) / stats.total_tt for what, place in SHARES.items()}


def module(choice: Choice) -> bool:
    """Play scripts of all themes, module and oracle in lockstep (tests/properties/test_against_oracle.py).

    A command sequence is a story of a script: the module is made ready, commands are written, their bits
    fall, inputs change, and the axis comes to rest.
    """
    try:
        report_module(1 if choice.smoke else 60)
    except AssertionError as difference:
        print(difference)
        return False
    return True


def planted(choice: Choice) -> bool:
    """Search the suite, aimed and blindly."""
    names, seeds = choice.names or tuple(NAMES), choice.seeds or SEEDS
    print(f"  {seeds} searches of {choice.runs} runs each")
    print(f"  {'program':<16} {'aimed':>6} {'runs':>6} {'s':>6}   {'blind':>6} {'runs':>6} {'s':>6}")
    totals, fewer, slower = [0, 0], [], []
    for name in names:
        with target_of(name) as target:
            both = [[way(target, seed, choice.runs) for seed in range(seeds)] for way in (aimed, blind)]
        print(f"  {name:<16} {_figures(both[0])}   {_figures(both[1])}", flush=True)
        for place, each in enumerate(both):
            totals[place] += sum(took.runs is not None for took in each)
        if not _is_easy(both[1]):
            fewer.append(f"{name} {_scans(both[1]) / _scans(both[0]):.1f}")
        ours, theirs = (median(took.seconds for took in each) for each in both)
        if ours > max(1.3 * theirs, theirs + 0.2):
            slower.append(f"{name} {ours:.1f} s, not {theirs:.1f} s")
    of = seeds * len(names)
    print(f"  found              {totals[0]} of {of} aimed, {totals[1]} of {of} blindly (bar: 700 of 720)")
    print(
        f"  times fewer scans  {', '.join(fewer) or '-'} (bar: 5, where blind misses half or takes 500 runs)"
    )
    print(f"  slower             {', '.join(slower) or 'none'} (bar: none by 1.3 times and 0.2 s)")
    return True


def _figures(took: list[Took]) -> str:
    """Return how many searches have found it, after how many runs in the median, and their mean time."""
    found = [each.runs for each in took if each.runs is not None]
    seconds = sum(each.seconds for each in took) / len(took)
    return f"{len(found):>6} {median(found) if found else '-':>6} {seconds:>6.1f}"


def _is_easy(took: list[Took]) -> bool:
    """Return whether most searches find it in less than 500 runs."""
    return sum(each.runs is not None and each.runs < 500 for each in took) * 2 > len(took)


def _scans(took: list[Took]) -> float:
    return median(each.scans for each in took)


def alarms(choice: Choice) -> bool:
    """Search the correct versions; print what is broken there."""
    names, found = choice.names or tuple(NAMES), 0
    for name in names:
        with target_of(name) as target:
            for seed in range(choice.seeds or 10):
                correct = target.correct
                report = search(correct.bench, correct.kinds, examples=choice.runs, start=seed)
                for each in report.found:
                    print(f"  {name}, seed {seed}: {each.broken}", flush=True)
                found += len(report.found)
    print(f"  alarms             {found} (bar: none that is no fault of the program)")
    return not found


def one(name: str, bar: str, *ways: tuple[str, Way, int]) -> Callable[[Choice], bool]:
    """Return a row of one program: each way with its name and its number of runs."""

    def row(choice: Choice) -> bool:
        with target_of(name) as target:
            for what, way, runs in (*ways, ("blind", blind, BUDGET)):
                took = [way(target, seed, min(runs, choice.runs)) for seed in range(choice.seeds or FEW)]
                print(f"  {name}, {what:<12} {_figures(took)} s of {len(took)}", flush=True)
        print(f"  found, runs, mean seconds; bar: {bar}")
        return True

    return row


LADDER, PYTHON = "lost_request", "half_command"


def costs(choice: Choice) -> bool:
    """Print the cost of a probe, runs of 2 s a second, and the share of drawing and building."""
    runs = 2 if choice.smoke else 100
    for what, name, bars in (("ladder", LADDER, (1.3, 150)), ("Python", PYTHON, (1.25, 120))):
        with target_of(name) as target:
            version = target.correct
            bench = replace(version.bench, scans=2_000_000_000 // version.bench.spec.scan_ns)
            plain, noted = _seconds(bench, runs, probed=False), _seconds(bench, runs, probed=True)
            start = process_time()
            report = search(bench, version.kinds, examples=runs)
            speed = report.runs / (process_time() - start)
        shares = (report.spent[DRAWING] + report.spent[BUILDING]) / report.spent.total()
        print(f"  probe, {what:<10} {noted / plain:>8.2f} times a run (bar: {bars[0]})")
        print(f"  runs of 2 s, {what:<6} {speed:>6.0f} per second (bar: {bars[1]})")
        print(f"  drawing, building  {shares:>8.0%} of the time (bar: 15%)")
    return True


def _seconds(bench: TrialBench, runs: int, *, probed: bool) -> float:
    """Return the processor time of undisturbed runs, the least of three rounds."""

    def once() -> float:
        start = process_time()
        for _ in range(max(1, runs // 10)):
            bench.run(Scenario(), probe=Probe(Edges()) if probed else None)
        return process_time() - start

    once()
    return min(once() for _ in range(3))


AT_MOST = 0.3
"""The bar of `turns`."""


def turns(choice: Choice) -> bool:
    """Search the suite at another commit and here, in turns: seconds until the planted mistake is found."""
    commit, names, seeds = against.named_commit(), choice.names or tuple(NAMES), choice.seeds or SEEDS
    if not against.has(commit):
        print(f"  not compared: this clone does not have the commit {commit}")
        return True
    pairs: list[Pair] = []
    print(f"  {seeds} searches of {BUDGET} runs each, there and here; half of the ratios lie between")
    with against.sides_of(commit) as sides, against.workers(sides, "fuzz") as (other, this):
        for name in names:
            found = [(other.measure(name), this.measure(name)) for _ in range(seeds)]
            print(f"  {name:<16} {_compared(found)}", flush=True)
            pairs += found
    print(f"  {'all':<16} {_compared(pairs)} (bar: {AT_MOST})")
    there, here = (sum(each[side][1] is not None for each in pairs) for side in (0, 1))
    return here >= there


Pair = tuple[list[Any], list[Any]]
"""Seconds, runs (None without a find) and scans of a search at another commit, and here."""


def _compared(pairs: list[Pair]) -> str:
    """Return finds and seconds on both sides, and the ratio of the seconds with that of random halves."""
    there, here = (sum(each[side][1] is not None for each in pairs) for side in (0, 1))
    random = Random(0)
    ratios = [_ratio(random.choices(pairs, k=len(pairs))) for _ in range(400)]
    low, _, high = quantiles(ratios, n=4)
    seconds = [sum(each[side][0] for each in pairs) / len(pairs) for side in (0, 1)]
    return (
        f"found {there:>3} {here:>3}   mean s {seconds[0]:6.2f} {seconds[1]:6.2f}   "
        f"ratio {_ratio(pairs):.2f}, {low:.2f} to {high:.2f}"
    )


def _ratio(pairs: list[Pair]) -> float:
    return sum(here[0] for _, here in pairs) / sum(there[0] for there, _ in pairs)


def kills(choice: Choice) -> bool:
    """Kill searches at random moments."""
    return fuzz_kills.main(["--smoke"] if choice.smoke else []) == 0


def workers(choice: Choice) -> bool:
    """Compare the steps of processes and of Dask, and the time of two processes."""
    return fuzz_workers.main(["--smoke"] if choice.smoke else []) == 0


def instant(_choice: Choice) -> bool:
    """Look for instants that are known."""
    return inevitable.main() == 0


ROWS: dict[str, Callable[[Choice], bool]] = {
    "module": module,
    "costs": costs,
    "presses": one(
        "service_menu",
        "400 runs; with the solver 20 runs, 2 s",
        ("aimed", aimed, BUDGET),
        ("solver", solved, 100),
    ),
    "rare": one(
        "night_start", "with the solver 20 runs, 2 s", ("aimed", aimed, BUDGET), ("solver", solved, 100)
    ),
    "number": one("torn_position", "300 runs", ("aimed", aimed, BUDGET)),
    "race": one("one_zone", "600 runs", ("aimed", aimed, BUDGET)),
    "link": one("second_fault", "600 runs", ("aimed", aimed, BUDGET)),
    "instant": instant,
    "workers": workers,
    "kills": kills,
    "turns": turns,
    "planted": planted,
    "alarms": alarms,
}
"""The rows by name: dear ones at the end."""

DEAR, SMOKED = ("workers", "kills", "turns", "planted", "alarms"), ("module", "costs", "number")
"""Rows that are measured only on request, and those of a smoke run."""


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Does the search reach its bars?")
    parser.add_argument("--smoke", action="store_true", help="a few runs of some rows")
    parser.add_argument("--long", action="store_true", help="the dear rows, too")
    parser.add_argument("--only", choices=list(ROWS), help="one row")
    parser.add_argument("--seeds", type=int, help="searches of each program")
    parser.add_argument("--runs", type=int, default=BUDGET, help="runs of a search at most")
    parser.add_argument("names", nargs="*", help="programs of `planted` and `alarms`; all if left out")
    given = parser.parse_args(arguments)
    choice = Choice(given.seeds, given.runs, tuple(given.names), given.smoke)
    rows = [name for name in ROWS if given.long or name not in DEAR]
    if given.smoke:
        rows, choice = list(SMOKED), replace(choice, seeds=1, runs=3)
    if given.only or given.names:
        rows = [given.only or "planted"]
    held = True
    for name in rows:
        print(name, flush=True)
        held = ROWS[name](choice) and held
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
