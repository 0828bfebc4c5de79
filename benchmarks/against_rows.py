"""The rows of against.py: slices of hot paths, made of what a commit's own benchmarks have.

    python benchmarks/against_rows.py BENCHMARKS NAME

is one side of a comparison: it says its rows as JSON, then measures the row that a line of its input names.
A row is a function that does the same work each time and returns its seconds of processor time.
"""

from __future__ import annotations

import atexit
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from importlib import import_module
from itertools import count
from pathlib import Path
from time import process_time
from typing import Any

Row = tuple[str, Callable[[], float]]


def timed(action: Callable[..., object], *arguments: object) -> float:
    start = process_time()
    action(*arguments)
    return process_time() - start


def scan(its: Any, folder: Path) -> Iterator[Row]:
    def run(modules: int, recorded: bool) -> float:
        rack = its.rack_of(modules)
        slots = [its.SlotInfo(number, "amci3601", "4.1") for number in rack.slots]
        path = folder / "scan.mcap"
        listeners = (
            [its.ScanRecorder(path, rack.memory, slots, scan_period_ns=its.PERIOD_NS)] if recorded else []
        )
        cpu = its.Cpu(rack, its.logic, its.PERIOD_NS, listeners=listeners)
        took = timed(cpu.run, 60_000 // modules)
        return took + timed(cpu.close)

    yield "1 module", lambda: run(1, False)
    yield "4 modules", lambda: run(4, False)
    yield "1 module, recorded", lambda: run(1, True)
    yield "4 modules, recorded", lambda: run(4, True)


def recorder(its: Any, folder: Path) -> Iterator[Row]:
    path, scans = folder / "recorder.mcap", 50_000
    for slots in its.SLOTS[:2]:
        rack = its.Rack(slots)

        def cost(rack=rack) -> float:
            return timed(its.record, rack, scans, path) - timed(rack.run, scans, its.say_nothing)

        yield f"slots: {slots}", cost


def ladder(its: Any, folder: Path) -> Iterator[Row]:
    def repeated(action: Callable[..., object], times: int) -> None:
        for _ in range(times):
            action(its.PERIOD_MS)

    built = its.parse_program(its.program(1))
    hundred = its.parse_program(its.program(10))
    for name, logic, copies, compiled, steps in (
        ("10 rungs", built, 1, True, 4_000),
        ("100 rungs", hundred, 10, True, 600),
        ("10 rungs, interpreted", built, 1, False, 150),
    ):
        step = its.played(logic, copies, compiled=compiled).step
        yield name, lambda step=step, steps=steps: timed(repeated, step, steps)  # type: ignore[misc]
    yield "building 100 rungs", lambda: timed(lambda: its.parse_program(its.program(10)).compile())


def observed(its: Any, folder: Path) -> Iterator[Row]:
    for name, (prepare, _limit) in its.VARIANTS.items():
        debugger = its.feeder()

        def cost(debugger=debugger, prepare=prepare) -> float:
            total = 0.0
            for _ in range(15):
                prepare(debugger)
                debugger.scan(1, its.PERIOD_MS)
                total += timed(debugger.scan, 90, its.PERIOD_MS)
            return total

        yield name, cost


def sequences(its: Any, folder: Path) -> Iterator[Row]:
    idle = its.Side(its.loop)
    idle.run_to(its.WAITING)
    for name, logic in (("waiting", its.Line), ("waiting, with a lamp", its.Lit)):
        side = its.Side(logic())
        side.run_to(its.WAITING)
        yield name, lambda side=side: side.time(20_000) - idle.time(20_000)  # type: ignore[misc]
    moving = its.Side(its.Line())
    moving.run_to(its.MOVING)
    yield "moving", lambda: moving.time(20_000) - idle.time(20_000)


def tags(its: Any, folder: Path) -> Iterator[Row]:
    yield "with ten tags", lambda: its.measure(folder, 3 * its.CHUNK_SCANS)[1]


def reading(its: Any, folder: Path) -> Iterator[Row]:
    path, scans = folder / "reading.mcap", 50_000
    its.record(its.Rack(1), scans, path)
    yield "arrays", lambda: sum(timed(its.arrays, path, 1, scans) for _ in range(3))
    yield "slice", lambda: sum(timed(its.a_slice, path, 1, scans) for _ in range(5))
    yield "scans", lambda: timed(its.one_by_one, path, 1, scans)


def structures(its: Any, folder: Path) -> Iterator[Row]:
    kinds: dict[str, list[str]] = {"copies and fills": [], "strings": [], "add-ons and members": []}
    for name, line in its.ROWS:
        copied, members = name.startswith(("COP", "CPS", "FLL")), "add-on" in name or "members" in name
        kinds[list(kinds)[0 if copied else 2 if members else 1]].append(line)
    for kind, lines in kinds.items():
        step = its.parse_program(its.program(lines * 10)).compile().step

        def cost(step=step) -> float:
            return timed(lambda: [step(its.PERIOD_MS) for _ in range(100)])

        yield kind, cost


def undebugged(_its: Any, folder: Path) -> Iterator[Row]:
    """Yield racks with a program and a machine that no debugger is connected to."""
    open_bench = import_module("scanrack.jobs.bench.opening").open_bench
    for name, rack in (("rungs", "feeder/feeder.toml"), ("Python", "sequences/labeller.toml")):
        bench = open_bench(Path(__file__).parents[1] / "examples" / rack)

        def cost(bench=bench) -> float:
            return timed(lambda: [bench.scan() for _ in range(400)])

        yield name, cost


BENCHMARKS: dict[str, tuple[str, Callable[[Any, Path], Iterator[Row]]]] = {
    "scan": ("scan_rate", scan),
    "recorder": ("recorder", recorder),
    "ladder": ("ladder", ladder),
    "observed": ("observed", observed),
    "sequences": ("sequences", sequences),
    "tags": ("tags", tags),
    "reading": ("reading", reading),
    "structures": ("structures", structures),
    "undebugged": ("observed", undebugged),
}
"""The file of benchmarks/, and what makes its rows."""

BARS_OF = "8b1b76710e06d6f9ad98995c64ea965c346231c8"
BARS = {
    "scan": {"1 module, recorded": 0.6, "4 modules, recorded": 0.6},
    "sequences": {"waiting": 0.55, "waiting, with a lamp": 0.55, "moving": 0.55},
}
"""Bars of rows: the most that they take, in units of what they took at a commit."""


def searches(its: Any, folder: Path) -> Iterator[tuple[str, Callable[[], list[Any]]]]:
    """Yield the planted programs: each call searches with the next seed."""

    def search_of(name: str) -> Callable[[], list[Any]]:
        seeds = count()
        targets = ExitStack()
        atexit.register(targets.close)
        known: list[Any] = []

        def search() -> list[Any]:
            known[:] = known or [targets.enter_context(its.target_of(name))]
            took = its.aimed(known[0], next(seeds), its.BUDGET)
            return [took.seconds, took.runs, took.scans]

        return search

    for name in its.NAMES:
        yield name, search_of(name)


def questions(_its: Any, folder: Path) -> Iterator[tuple[str, Callable[[], list[Any]]]]:
    """Yield programs: each call asks the built-in questions of `scanrack prove`.

    It returns the seconds, those of the first answers (None where they come together), what is found, and
    how many questions are open.
    """
    proving = import_module("scanrack.jobs.prove.proving")
    subject_of = import_module("scanrack.jobs.prove.subject").subject_of
    listens = hasattr(proving, "AnswerListener")

    def ask_about(rack: Path) -> list[Any]:
        subject = subject_of(str(rack))
        first: list[float] = []
        listener = proving.AnswerListener() if listens else None
        if listener is not None:
            listener.found = lambda _answer: first.append(process_time())
            listener.left = lambda *_: first.append(process_time())
        start = process_time()
        with proving.ScenarioFolder(folder / rack.stem) as scenarios:
            found = proving.ask_questions(subject, scenarios, (), *([listener] if listens else []))
        took = process_time() - start
        texts = sorted(f"{each.finding.rule} {each.finding.site} {each.finding.text}" for each in found.found)
        return [took, first[0] - start if first else None, texts, sum(found.open.values())]

    examples = Path(__file__).parents[1] / "examples"
    for rack in (examples / "feeder/feeder.toml", examples / "hmi/feeder.toml"):
        yield rack.parent.name, lambda rack=rack: ask_about(rack)  # type: ignore[misc]


LONG: dict[str, tuple[str, Callable[[Any, Path], Iterator[tuple[str, Callable[[], Any]]]]]] = {
    "fuzz": ("fuzz", searches),
    "prove": ("prove", questions),
}
"""The same for rows that are no slices: fuzz.py and prove.py compare them."""


def on_one_core() -> None:
    """Run where the other side runs, where a system allows that: both meet the same neighbors."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def main(folder: str, name: str) -> None:
    """Answer the start and each requested row with a line of JSON; an error is {"error": why}."""
    sys.path[0] = folder
    on_one_core()
    answer = sys.stdout
    sys.stdout = sys.stderr  # what a benchmark prints is no answer
    with tempfile.TemporaryDirectory() as work:
        try:
            file, make = (BENCHMARKS | LONG)[name]
            rows = dict(make(import_module(file), Path(work)))
            print(json.dumps(list(rows)), file=answer, flush=True)
            for line in sys.stdin:
                print(json.dumps(rows[line.rstrip("\n")]()), file=answer, flush=True)
        except Exception as error:  # the process that compares reports every mistake of a commit
            print(json.dumps({"error": f"{type(error).__name__}: {error}"}), file=answer, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
