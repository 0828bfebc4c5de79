"""How fast are the searches, and what do they spend their time on?

    python benchmarks/fuzz.py             both searches, per core, and the suite of planted mistakes
    python benchmarks/fuzz.py --smoke     a few examples of each, quickly
    python benchmarks/fuzz.py --seeds 4 staircase bounce      these programs of the suite alone

Module: scripts of all themes, module and oracle in lockstep (tests/properties/test_against_oracle.py). A
command sequence is a story of a script: the module is made ready, commands are written, their bits fall,
inputs change, and the axis comes to rest. Program: `scanrack fuzz` on the feeder, 2 s of machine time a run.
Seconds are those of the processor.

Suite: the programs of benchmarks/fuzz_programs, each with its mistake, searched with several seeds until the
mistake is found. It counts if the same scenario leaves the correct version whole. Beside it stands a search
that draws blindly, on the same budget. Costs: what noting changes takes beside a plain run. Six programs were
written before the search was tuned, six after it: bounce, forgotten_zero, last_steps, night_start, one_slip,
torn_position.

Exit status: 0; 1 if module and oracle have differed, or a correct program has broken what must hold.
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
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from hunt3601 import scripts_of
from lockstep3601 import GivenUp, Lockstep
from oracle_bits import CONFIGURE
from planted_programs import NAMES, Version, invariant_of, version_of
from scanrack.jobs.fuzz import Counterexample, Scenario, SearchReport, TrialBench, search
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.aim.edges import Edges
from scanrack.jobs.fuzz.aim.probe import Probe
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.fuzz.run import BUILDING
from scanrack.jobs.fuzz.scenarios.kinds import kinds_for
from scanrack.jobs.fuzz.search import DRAWING
from steps3601 import Recover
from stories3601 import THEMES

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
    print("module and oracle in lockstep")
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


def report_program(runs: int) -> None:
    setup = Setup(str(FEEDER), (), ("no-command-error",), SCANS, frozenset())
    bench = bench_of(setup)
    start = process_time()
    report = search(bench, kinds_for(bench.spec), examples=runs)
    seconds = process_time() - start
    print(f"scanrack fuzz, examples/feeder: {report.runs:,} runs in {seconds:.1f} s")
    print(f"  runs               {report.runs / seconds:>10,.1f} per second")
    print(f"  scans              {report.scans / seconds:>10,.0f} per second")


BUDGET, SEEDS = 600, 30
"""Runs of a search, and number of searches: those of the bar, 700 found of 720."""


class _FoundError(Exception):
    """Ends a search at the planted mistake."""


@dataclass(frozen=True)
class Took:
    """What a search took to find a planted mistake: runs None if it has not found it."""

    runs: int | None
    scans: int
    seconds: float


def aimed(planted: Version, is_it: Callable[[Scenario, str], bool], seed: int, runs: int) -> Took:
    """Search as `scanrack fuzz` does."""
    report = SearchReport()
    start = process_time()
    looked = [0]

    def confirm(found: Counterexample, _without: object) -> bool:
        if is_it(found.scenario, found.broken.invariant):
            raise _FoundError
        return True

    def count(number: int) -> None:
        looked[0] = number

    found = False
    try:
        report = search(
            planted.bench, planted.kinds, examples=runs, start=seed, confirm=confirm, progress=count
        )
    except _FoundError:
        found = True
    seconds = process_time() - start
    return Took(looked[0] if found else None, report.scans or looked[0] * planted.bench.scans, seconds)


def blind(planted: Version, is_it: Callable[[Scenario, str], bool], seed: int, runs: int) -> Took:
    """Draw scenarios anywhere: no edges, nothing kept, nothing known of the program."""
    start = process_time()
    draws = Draws(planted.bench.spec, planted.bench.scans, planted.kinds, Random(seed))
    scans = 0
    for number in range(1, runs + 1):
        scenario = draws.scenario()
        verdict = planted.bench.run(scenario)
        scans += verdict.scans
        if verdict.broken is not None and is_it(scenario, verdict.broken.invariant):
            return Took(number, scans, process_time() - start)
    return Took(None, scans, process_time() - start)


def report_suite(names: list[str], seeds: int, runs: int) -> bool:
    """Search the suite, aimed and blindly; return whether every correct program held."""
    print(f"planted mistakes: {seeds} searches of {runs} runs each")
    print(f"  {'program':<16} {'aimed':>6} {'runs':>6} {'s':>6}   {'blind':>6} {'runs':>6} {'s':>6}")
    held, totals = True, [0, 0]
    for name in names:
        with TemporaryDirectory() as folder:
            planted = version_of(name, Path(folder) / "planted", with_mistake=True)
            correct = version_of(name, Path(folder) / "correct", with_mistake=False)
            wanted = invariant_of(name, planted)

            def is_it(scenario: Scenario, broken: str) -> bool:
                return broken == wanted and correct.bench.run(scenario).broken is None  # noqa: B023

            took = [[way(planted, is_it, seed, runs) for seed in range(seeds)] for way in (aimed, blind)]
            print(f"  {name:<16} {_told(took[0])}   {_told(took[1])}", flush=True)
            for place, each in enumerate(took):
                totals[place] += sum(one.runs is not None for one in each)
            alarms = search(correct.bench, correct.kinds, examples=runs).found
        for alarm in alarms:
            held = False
            print(f"  {name}: the correct version: {alarm.broken}")
    of = seeds * len(names)
    print(f"  found: {totals[0]} of {of} aimed, {totals[1]} of {of} blindly (bar: 700 of 720)")
    return held


def _told(took: list[Took]) -> str:
    """Return how many searches have found it, after how many runs in the median, and their mean time."""
    found = [each.runs for each in took if each.runs is not None]
    seconds = sum(each.seconds for each in took) / len(took)
    return f"{len(found):>6} {median(found) if found else '-':>6} {seconds:>6.1f}"


LADDER, PYTHON = "lost_request", "half_command"


def report_costs(runs: int) -> None:
    """Print the cost of a probe, runs of 2 s a second, and the share of drawing and building."""
    print("costs")
    for what, name, bars in (("ladder", LADDER, (1.3, 150)), ("Python", PYTHON, (1.25, 120))):
        with TemporaryDirectory() as folder:
            version = version_of(name, Path(folder) / "it", with_mistake=False)
            bench = replace(version.bench, scans=2_000_000_000 // version.bench.spec.scan_ns)
            plain, noted = _seconds(bench, runs, probed=False), _seconds(bench, runs, probed=True)
            start = process_time()
            report = search(bench, version.kinds, examples=runs)
            speed = report.runs / (process_time() - start)
        shares = (report.spent[DRAWING] + report.spent[BUILDING]) / report.spent.total()
        print(f"  probe, {what:<10} {noted / plain:>8.2f} times a run (bar: {bars[0]})")
        print(f"  runs of 2 s, {what:<6} {speed:>6.0f} per second (bar: {bars[1]})")
        print(f"  drawing, building  {shares:>8.0%} of the time (bar: 15%)")


def _seconds(bench: TrialBench, runs: int, *, probed: bool) -> float:
    """Return the processor time of undisturbed runs, the least of three rounds."""

    def once() -> float:
        start = process_time()
        for _ in range(max(1, runs // 10)):
            bench.run(Scenario(), probe=Probe(Edges()) if probed else None)
        return process_time() - start

    once()
    return min(once() for _ in range(3))


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="How fast are the searches?")
    parser.add_argument("--smoke", action="store_true", help="a few examples of each")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="searches of each program")
    parser.add_argument("--runs", type=int, default=BUDGET, help="runs of a search")
    parser.add_argument("names", nargs="*", help="programs of the suite; all of them if left out")
    given = parser.parse_args(arguments)
    if given.names:
        return 0 if report_suite(given.names, given.seeds, given.runs) else 1
    try:
        report_module(1 if given.smoke else 60)
    except AssertionError as difference:
        print(difference)
        return 1
    report_program(3 if given.smoke else 100)
    report_costs(2 if given.smoke else 100)
    held = report_suite(NAMES[:1], 1, 3) if given.smoke else report_suite(NAMES, given.seeds, given.runs)
    return 0 if held else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
