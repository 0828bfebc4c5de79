"""Cost of a debug adapter: scans with breakpoints that do not hit, stops, steps back in a recording.

    python benchmarks/debugging.py            table
    python benchmarks/debugging.py --smoke    a short run that only checks

Scans are those of the feeder, from the middle of a stroke on; variants run in turns in one process. A stop is
the time from the request to pause until frames, scopes and tags are answered. A step back goes to the scan
before; in a program in Python most steps back find their scan prepared.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from pathlib import Path

from bars import Bars
from scanrack.dap.breakpoints import Breakpoint, LinePoints, Looker, RungValues
from scanrack.dap.conditions import ScanContext
from scanrack.jobs.bench.opening import open_bench
from scanrack.jobs.load.loading import load_job
from scanrack.jobs.load.program import lines_marked
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.ladder.debug import Debugger
from scanrack.ladder.python.line_marks import WATCH

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from debug_client import DebugClient

ROOT = Path(__file__).parents[1]
FEEDER = ROOT / "examples/feeder/feeder.toml"
PERIOD_MS = 2.0
SCANS, STOP_MS, BACK_MS, FIRST_MS, LIMIT = 300_000, 50, 100, 2_000, 1.2
SILENCE_S = 4

VARIANTS = {
    "alone": None,
    "a line, condition false": Breakpoint(1, "line", "", keys=(("MAIN", 6),), condition="Strokes.ACC > 999"),
    "a line, its power": Breakpoint(2, "line", "", keys=(("MAIN", 5),), condition="becomes true"),
    "a condition": Breakpoint(3, "function", "Axis.State == 6 and Strokes.ACC > 999"),
    "a change of a tag": Breakpoint(4, "data", "Trouble"),
    "error bits": Breakpoint(5, "exception", "error"),
}
"""Breakpoints that are not met in the middle of a stroke."""

LABELLER = ROOT / "examples/sequences/labeller.toml"
LINES = {
    "Python alone": None,
    "Python, a line": Breakpoint(6, "line", "", keys=(("labeller.py", 45),), line=45),
}
"""A breakpoint on what follows an error of the axis, which no scan comes to."""


def prepared(given: Breakpoint | None) -> Callable[[int], float]:
    """Return what does scans with a breakpoint, and returns seconds per scan."""
    bench = open_bench(FEEDER)
    bench.run_for("6 s")
    assert isinstance(bench.logic, Debugger)
    debugger = bench.logic
    words = {slot.number: slot.words for slot in load_job(str(FEEDER)).spec.slot}
    around = ScanContext(words, lambda *_: 0, lambda: debugger.now_ns, lambda: debugger.scans)
    looker = None if given is None else Looker([given], RungValues(debugger.engine), around, lambda _scan: ())
    if looker is not None:
        debugger.note_lines(looker.lines)
    debugger.scan(5, PERIOD_MS)

    def spent(scans: int) -> float:
        hits = 0
        begin = time.process_time()
        for number in range(scans):
            debugger.scan(1, PERIOD_MS)
            if looker is not None:
                hits += len(looker.look(number))
        took = time.process_time() - begin
        assert not hits, given
        return took / scans

    return spent


def prepared_lines(given: Breakpoint | None) -> Callable[[int], float]:
    """Return the same of a program in Python, with a breakpoint on a line that does not run."""
    with nullcontext() if given is None else lines_marked():
        bench = open_bench(LABELLER)
    bench.run_for("1 s")
    points = LinePoints({}, in_frames=True)
    around = ScanContext({}, lambda *_: 0, lambda: bench.now_ns, lambda: bench.scans)
    looker = None if given is None else Looker([given], points, around, lambda _scan: ())
    watch = WATCH.get()

    def spent(scans: int) -> float:
        if looker is not None:
            watch.only(points)
        hits = 0
        begin = time.process_time()
        for number in range(scans):
            bench.scan()
            if looker is not None:
                hits += len(looker.look(number))
        took = time.process_time() - begin
        watch.only()
        assert not hits, given
        return took / scans

    return spent


def costs(rounds: int, scans: int) -> dict[str, float]:
    """Return seconds per scan by variant, the best of the rounds."""
    variants = {name: prepared(each) for name, each in VARIANTS.items()}
    variants |= {name: prepared_lines(each) for name, each in LINES.items()}
    best = dict.fromkeys(variants, float("inf"))
    for _ in range(rounds):
        for name, spent in variants.items():
            best[name] = min(best[name], spent(scans))
    return best


@contextmanager
def connected() -> Iterator[DebugClient]:
    """Connect to an adapter in its own process."""
    words = [sys.executable, "-m", "scanrack", "debug"]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        client = DebugClient(process.stdin, process.stdout)
        yield client
        client.tell("disconnect")


def stop_ms(client: DebugClient) -> float:
    """Pause, and ask what an editor asks then; return the time."""
    client.ask("continue", threadId=1)
    time.sleep(0.05)
    begin = time.perf_counter()
    client.ask("pause", threadId=1)
    client.event("stopped")
    frame = client.frames()[0]["id"]
    client.scope("Tags", frame)
    return 1e3 * (time.perf_counter() - begin)


def stops(count: int) -> list[float]:
    """Return the times of stops of a rack at full speed."""
    with connected() as client:
        client.begin(FEEDER, speed="max")
        client.ask("configurationDone")
        client.event("stopped")
        return sorted(stop_ms(client) for _ in range(count))


def steps_back(scans: int, count: int) -> list[float]:
    """Return the times of steps back into the scan before, from five sixths of a recording on."""
    times = []
    with tempfile.TemporaryDirectory() as folder, ExitStack() as ports:
        trace = Path(folder, "long.mcap")
        JobRun(load_job(str(FEEDER)), ports, RunOptions(trace=trace)).run(scans)
        with connected() as client:
            client.begin(trace, scan=scans * 5 // 6)
            client.ask("configurationDone")
            client.stopped()
            for number in range(count):
                begin = time.perf_counter()
                reason, scan = client.go("stepBack")
                times.append(1e3 * (time.perf_counter() - begin))
                assert (reason, scan) == ("step", scans * 5 // 6 - 1 - number)
                while client.at() != "Main, rung 0":
                    client.go("stepBack")
    return sorted(times)


def steps_back_in_python(scans: int, count: int) -> tuple[list[float], list[float]]:
    """Return the time to five sixths of a recording of a program in Python, and of steps back from there.

    An editor that has been silent for a few seconds is the usual case: the adapter prepares steps meanwhile.
    """
    times = []
    with tempfile.TemporaryDirectory() as folder, ExitStack() as ports:
        trace = Path(folder, "long.mcap")
        JobRun(load_job(str(LABELLER)), ports, RunOptions(trace=trace)).run(scans)
        with connected() as client:
            client.begin(trace, scan=scans * 5 // 6, trust=True)
            begin = time.perf_counter()
            client.ask("configurationDone")
            client.stopped()
            first = 1e3 * (time.perf_counter() - begin)
            time.sleep(SILENCE_S)
            for _ in range(count):
                begin = time.perf_counter()
                client.go("stepBack")
                times.append(1e3 * (time.perf_counter() - begin))
    return [first], sorted(times)


def main() -> int:
    """Measure, print, and say whether the bars hold."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    smoke = parser.parse_args().smoke
    bars = Bars(count=not smoke)
    best = costs(2 if smoke else 40, 20 if smoke else 200)
    rows = []
    for name, alone in [*((each, "alone") for each in VARIANTS), *((each, "Python alone") for each in LINES)]:
        ratio = best[name] / best[alone]
        bar = bars.most(name, ratio, LIMIT)
        rows.append(f"{name:<26} {best[name] * 1e6:>7.2f} us a scan, {ratio:>5.2f} times ({bar})")
    first, back = steps_back_in_python(2_000 if smoke else SCANS, 80 if smoke else 1_000)
    for name, times, most_ms in (
        ("a stop", stops(3 if smoke else 30), STOP_MS),
        ("a step back", steps_back(2_000 if smoke else SCANS, 3 if smoke else 30), BACK_MS),
        ("a step back in Python", back, BACK_MS),
        ("to a scan in Python", first, FIRST_MS),
    ):
        middle, most = times[len(times) // 2], times[-1]
        rows.append(f"{name:<26} {middle:>7.1f} ms, {most:.1f} at most ({bars.most(name, middle, most_ms)})")
    print("\n".join(rows))
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
