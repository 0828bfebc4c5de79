"""What a chain of causes costs, and what the scans pay for it.

    python benchmarks/why.py [--scans 300000] [--rounds 3] [--smoke]

The feeder runs on the bench; then its tag Feeding is asked about, which has not changed since the eleventh
second. Checked: the chain, and that the search scan by scan finds the same scan. Compared within the run:

    command         `scanrack why` of the recording with its snapshots, a process of its own: processor time
    chain           the whole chain on the bench, which has run the scans already
    reading         the same scans read from a recording and unpacked, the floor
    scan by scan    the search as it was: every scan once more

Then the processor time of a scan on the bench, in turns: before a question, and after some.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from scanrack import open_bench
from scanrack.jobs.bench import Bench
from scanrack.ladder.debug import replay
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

FEEDER = Path(__file__).parents[1] / "examples" / "feeder" / "feeder.toml"
CHANGED = 5_247
"""The scan in which the search for home, after the emergency stop at 8 s, ends."""

ROUND = 5_000
"""Scans of a round of the second part."""


def spent(action: Callable[[], object]) -> float:
    """Return the processor time of an action, s."""
    begun = time.process_time()
    action()
    return time.process_time() - begun


def read(path: Path) -> int:
    """Read a recording, unpack it, and return the number of its scans."""
    with open_trace(path) as trace:
        recording = PackedTrace.of(trace)
    return len(recording.columns.scan)


def chain(bench: Bench) -> None:
    """Ask, and check the answer."""
    link = bench.chain("Feeding")
    names = [each.name for each in link.walk()]
    assert (link.scan, link.value) == (CHANGED, True), (link.scan, link.value)
    assert names[1:3] == ["Home.Busy", "Axis.Finished"], names
    assert link.first.name == "slot1.status.IN_HOME", names


def chain_scan_by_scan(bench: Bench) -> None:
    """Ask without the search in all stretches at once."""
    bench.program._past._found.clear()  # what has been found is kept
    side_by_side, replay.ONE_BY_ONE = replay.ONE_BY_ONE, 1 << 30
    try:
        chain(bench)
    finally:
        replay.ONE_BY_ONE = side_by_side


def asked(trace: Path) -> float:
    """Ask the command in a process of its own, and check the last line; return its processor time, s."""
    words = [sys.executable, "-m", "scanrack", "why", str(trace), "Feeding"]
    before = os.times()
    said = subprocess.run(
        words, cwd=trace.parent, capture_output=True, text=True, check=True, encoding="utf-8"
    ).stdout
    after = os.times()
    assert said.splitlines()[-1].startswith("Cause: slot1.status.IN_HOME is on since 10.492 s"), said
    return after.children_user + after.children_system - before.children_user - before.children_system


def report_chain(scans: int, folder: Path) -> None:
    """Measure the chain."""
    with open_bench(FEEDER, record=folder / "run.mcap") as bench:
        bench.scan(scans)
        first, again = spent(lambda: chain(bench)), spent(lambda: chain(bench))
        print(f"chain through {scans:,} scans: {first:.2f} s of a processor, asked again {again:.2f} s")
        print(f"  scan by scan: {spent(lambda: chain_scan_by_scan(bench)):.2f} s")
    print(f"  the command, of the recording: {asked(folder / 'run.mcap'):.2f} s of a processor")
    counted: list[int] = []
    floor = spent(lambda: counted.append(read(folder / "run.mcap")))
    assert counted == [scans], counted
    print(f"  reading the recording: {floor:.2f} s")


def report_scans(rounds: int) -> None:
    """Measure scans before and after questions, in turns."""
    plain, asked = open_bench(FEEDER), open_bench(FEEDER)
    for bench in (plain, asked):
        bench.scan(CHANGED + 1)
    chain(asked)
    before, after = [], []
    for _ in range(rounds):
        before.append(spent(lambda: plain.scan(ROUND)))
        after.append(spent(lambda: asked.scan(ROUND)))
    one, other = (1e6 * min(each) / ROUND for each in (before, after))
    print(f"a scan on the bench: {one:.1f} us before a question, {other:.1f} us after one")


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scans", type=int, default=300_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        report_chain(12_000 if given.smoke else given.scans, Path(folder))
    report_scans(1 if given.smoke else given.rounds)


if __name__ == "__main__":
    main()
