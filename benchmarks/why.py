"""What a chain of causes costs, and what the scans pay for it.

    python benchmarks/why.py [COMMIT] [--scans 300000] [--rounds 9] [--smoke]

The feeder runs on the bench; then the chain of its tag Feeding is made. The tag has not changed since the
eleventh second. Checked: the chain, and that the search scan by scan finds the same scan. Compared within the
run:

    command         `scanrack why` of the recording with its snapshots, a process of its own: processor time
    chain           the whole chain on the bench, which has run the scans already
    reading         the same scans read from a recording and unpacked, the floor
    scan by scan    the search as it was: every scan once more

Then the processor time of a scan on the bench, in turns: before a question, and after some. At last the
command beside that of COMMIT (8b1b7671, before questions were made cheaper), each of a recording of its own,
in turns; exit status 1 if the median of the ratios is above 0.4.
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
from statistics import median

from against import ROOT, archived, has, laid_out
from bars import Bars, children_s
from scanrack import open_bench
from scanrack.jobs.bench import Bench
from scanrack.ladder.debug import replay
from scanrack.ladder.debug.debugger import Debugger
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
    """Make the chain, and check it."""
    link = bench.chain("Feeding")
    names = [each.name for each in link.walk()]
    assert (link.scan, link.value) == (CHANGED, True), (link.scan, link.value)
    assert names[1:3] == ["Home.Busy", "Axis.Finished"], names
    assert link.first.name == "slot1.status.IN_HOME", names


def chain_scan_by_scan(bench: Bench) -> None:
    """Make the chain without the search in all stretches at once."""
    debugger: Debugger = bench.program
    debugger._past._last_changes.clear()  # the first chain cached its results
    side_by_side, replay.ONE_BY_ONE = replay.ONE_BY_ONE, 1 << 30
    try:
        chain(bench)
    finally:
        replay.ONE_BY_ONE = side_by_side


def command_of(trace: Path, site: Path | None = None) -> float:
    """Run the command in a process of its own, and check the last line; return its processor time, s.

    Args:
        site: folder with the package of a commit; None for the installed one.
    """
    words = [sys.executable, "-m", "scanrack", "why", str(trace), "Feeding"]
    before = children_s()
    answer = subprocess.run(
        words, cwd=trace.parent, env=of(site), capture_output=True, text=True, check=True, encoding="utf-8"
    ).stdout
    took = children_s() - before
    assert answer.splitlines()[-1].startswith("Cause: slot1.status.IN_HOME is on since 10.492 s"), answer
    return took


COMMIT, MOST = "8b1b7671", 0.4
RECORD = """
import sys
from scanrack import open_bench
with open_bench(sys.argv[1], record=sys.argv[2]) as bench:
    bench.scan(int(sys.argv[3]))
"""


def of(site: Path | None) -> dict[str, str]:
    """Return the environment of a commit, whose files are compiled, as those of an installation."""
    chosen = {} if site is None else {"PYTHONPATH": str(site)}
    return {key: each for key, each in (os.environ | chosen).items() if key != "PYTHONDONTWRITEBYTECODE"}


def report_turns(commit: str, scans: int, rounds: int, folder: Path, bars: Bars) -> None:
    """Measure the command beside that of a commit."""
    if not has(commit):
        print(f"not compared: this clone does not have the commit {commit} (a shallow clone?)")
        return
    sites = (
        laid_out(archived(commit, folder / "commit"), folder / "other").site,
        laid_out(ROOT, folder / "this").site,
    )
    traces = [folder / f"{site.name}.mcap" for site in sites]
    for site, trace in zip(sites, traces, strict=True):
        words = [sys.executable, "-c", RECORD, str(FEEDER), str(trace), str(scans)]
        subprocess.run(words, cwd=folder, env=of(site), check=True)
        command_of(trace, site)  # compiled files are written
    pairs = [
        [command_of(trace, site) for trace, site in zip(traces, sites, strict=True)] for _ in range(rounds)
    ]
    there, here = (median(each) for each in zip(*pairs, strict=True))
    ratios = sorted(this / other for other, this in pairs)
    spread = f"{ratios[len(ratios) // 4]:.2f} to {ratios[-1 - len(ratios) // 4]:.2f}"
    grade = bars.most("why", median(ratios), MOST)
    print(
        f"the command at {commit}: {there:.2f} s, here {here:.2f} s; {median(ratios):.2f}, {spread}, {grade}"
    )


def report_chain(scans: int, folder: Path) -> None:
    """Measure the chain."""
    with open_bench(FEEDER, record=folder / "run.mcap") as bench:
        bench.scan(scans)
        first, again = spent(lambda: chain(bench)), spent(lambda: chain(bench))
        print(f"chain through {scans:,} scans: {first:.2f} s of a processor, repeated {again:.2f} s")
        print(f"  scan by scan: {spent(lambda: chain_scan_by_scan(bench)):.2f} s")
    print(f"  the command, of the recording: {command_of(folder / 'run.mcap'):.2f} s of a processor")
    counted: list[int] = []
    floor = spent(lambda: counted.append(read(folder / "run.mcap")))
    assert counted == [scans], counted
    print(f"  reading the recording: {floor:.2f} s")


def report_scans(rounds: int) -> None:
    """Measure scans before and after questions, in turns."""
    plain, questioned = open_bench(FEEDER), open_bench(FEEDER)
    for bench in (plain, questioned):
        bench.scan(CHANGED + 1)
    chain(questioned)
    before, after = [], []
    for _ in range(rounds):
        before.append(spent(lambda: plain.scan(ROUND)))
        after.append(spent(lambda: questioned.scan(ROUND)))
    one, other = (1e6 * min(each) / ROUND for each in (before, after))
    print(f"a scan on the bench: {one:.1f} us before a question, {other:.1f} us after one")


def main() -> int:
    """Measure."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("commit", nargs="?", default=COMMIT, help="default: %(default)s")
    parser.add_argument("--scans", type=int, default=300_000)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args()
    scans, rounds = (12_000, 1) if given.smoke else (given.scans, given.rounds)
    bars = Bars(count=not given.smoke)
    with tempfile.TemporaryDirectory() as folder:
        report_chain(scans, Path(folder))
        report_scans(rounds)
        report_turns("HEAD" if given.smoke else given.commit, scans, rounds, Path(folder), bars)
    return bars.status()


if __name__ == "__main__":
    sys.exit(main())
