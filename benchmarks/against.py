"""Is a hot path slower than at another commit? Both are measured in turns, in one run.

    python benchmarks/against.py [COMMIT] [--only NAME...] [--rounds N]    ratios with their spread
    python benchmarks/against.py --at-most 1.08                            status 1 if a row is above
    python benchmarks/against.py --bars                                    rows with a bar, beside its commit
    python benchmarks/against.py --smoke                                   beside HEAD, one round

COMMIT is the one that benchmarks/against.commit names, if none is given. Its package and its benchmarks are
laid beside those of the working tree; both use the libraries of this environment. The rows, in
against_rows.py, call functions of either commit's own benchmarks, since modules move.

Each benchmark runs in two processes, one of each commit, which take turns of some ten milliseconds. Times are
processor time, on one core, since who else runs there differs. A ratio is the median of the pairs. A row
above the limit is measured again in new processes, twice at most, with more rounds; the least of its ratios
counts, since places in memory alone make one process some percent slower than another.

Exit status: 0; 1 if a row is above `--at-most` or its bar, or a benchmark does not run on both sides; 0 and
a line that says so if this clone does not have the commit.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import quantiles
from types import MappingProxyType

from against_rows import BARS, BARS_OF, BENCHMARKS

HERE = Path(__file__).parent
ROOT = HERE.parent
REPEATS = 2


@dataclass(frozen=True)
class Side:
    """A commit beside others: the folder on the path of its processes, and that of its benchmarks."""

    site: Path
    benchmarks: Path


class UnmeasuredError(Exception):
    """A benchmark or a row does not run on a side; says why."""


class Worker:
    """A process that measures the rows of a benchmark on a side.

    Raises:
        UnmeasuredError: the benchmark does not start there.
    """

    def __init__(self, side: Side, benchmark: str) -> None:
        environment = os.environ | {"PYTHONPATH": str(side.site), "PYTHONHASHSEED": "0"}
        words = [sys.executable, str(HERE / "against_rows.py"), str(side.benchmarks), benchmark]
        self._process = subprocess.Popen(
            words, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8"
        )
        self.rows: list[str] = self._answer()

    def _answer(self):
        assert self._process.stdout is not None
        answer = json.loads(self._process.stdout.readline() or '{"error": "its process ended"}')
        if isinstance(answer, dict):
            raise UnmeasuredError(answer["error"])
        return answer

    def measure(self, row: str):
        """Return the answer of a turn: seconds of processor time, or a list that begins with them."""
        assert self._process.stdin is not None
        self._process.stdin.write(row + "\n")
        self._process.stdin.flush()
        return self._answer()

    def seconds(self, row: str) -> float:
        """Return the processor time of a turn."""
        return float(self.measure(row))

    def end(self) -> None:
        self._process.communicate()


def laid_out(source: Path, site: Path) -> Side:
    """Copy the packages of a checkout to where an installation has them."""
    front = "scanrack" if (source / "scanrack").is_dir() else "front"
    rooms = (
        "examples",
        "io_images",
        "ladder",
        "rockwell",
        "runtime",
        "traces",
    )  # `scanrack` has links to them

    def left_out(folder: str, names: list[str]) -> set[str]:
        return {"__pycache__", *(rooms if Path(folder) == source / front else ())}

    shutil.copytree(source / front, site / "scanrack", ignore=left_out)
    for name in rooms:
        shutil.copytree(source / name, site / "scanrack" / name, ignore=left_out)
    return Side(site, source / "benchmarks")


def archived(commit: str, folder: Path) -> Path:
    """Return a checkout of a commit."""
    packed = subprocess.run(["git", "archive", commit], cwd=ROOT, check=True, stdout=subprocess.PIPE)
    with tarfile.open(fileobj=io.BytesIO(packed.stdout)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def has(commit: str) -> bool:
    """Return whether this clone has a commit."""
    try:
        found = subprocess.run(
            ["git", "cat-file", "-e", f"{commit}^{{commit}}"], cwd=ROOT, stderr=subprocess.DEVNULL
        )
    except FileNotFoundError:  # no git
        return False
    return found.returncode == 0


def named_commit() -> str:
    """Return the commit that `against.commit` names."""
    return (HERE / "against.commit").read_text(encoding="utf-8").split()[0]


@contextmanager
def sides_of(commit: str) -> Iterator[tuple[Side, Side]]:
    """Lay out a commit and the working tree, in this order."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        other = laid_out(archived(commit, folder / "commit"), folder / "other")
        yield other, laid_out(ROOT, folder / "this")


@contextmanager
def workers(sides: tuple[Side, Side], benchmark: str) -> Iterator[tuple[Worker, Worker]]:
    """Start a process on each side: the other commit's, this one's."""
    started: list[Worker] = []
    try:
        for side in sides:
            started.append(Worker(side, benchmark))
        yield started[0], started[1]
    finally:
        for worker in started:
            worker.end()


def measured(sides: tuple[Side, Side], benchmark: str, only: set[str], rounds: int) -> dict[str, list[float]]:
    """Return by row the ratio of this side to the other, with its lower and its upper quartile."""
    found: dict[str, list[float]] = {}
    with workers(sides, benchmark) as (other, this):
        for row in this.rows:
            if row not in other.rows:
                print(f"{benchmark}, {row}: the other commit does not have it", flush=True)
            elif not only or row in only:
                for worker in (other, this):  # caches warm up
                    worker.seconds(row)
                found[row] = compared([(other.seconds(row), this.seconds(row)) for _ in range(rounds)])
    return found


def compared(pairs: list[tuple[float, float]]) -> list[float]:
    """Return the median of this / other with its quartiles; a difference of times can be 0 or less.

    >>> compared([(2.0, 2.0), (1.0, 1.5), (2.0, 2.2), (2.0, 2.2)])
    [1.1, 1.025, 1.4]
    """
    ratios = [this / max(other, 1e-9) for other, this in pairs]
    low, middle, high = quantiles(ratios, n=4) if len(ratios) > 1 else ratios * 3
    return [middle, low, high]


def rows_above(
    sides: tuple[Side, Side],
    benchmark: str,
    rounds: int,
    at_most: float,
    bars: Mapping[str, float] = MappingProxyType({}),
) -> list[str]:
    """Measure a benchmark, print its rows, and return those that stay above `at_most` or their bar."""
    only: set[str] = set()
    best: dict[str, list[float]] = {}
    for attempt in range(1 + REPEATS):
        for row, figures in measured(sides, benchmark, only, rounds * (1 + attempt)).items():
            best[row] = min(best.get(row, figures), figures)
        only = {row for row, figures in best.items() if figures[0] > bars.get(row, at_most)}
        if not only:
            break
    for row, (ratio, low, high) in best.items():
        words = f"  bar: {bars[row]:g}" if row in bars else ""
        words += "  above" if row in only else ""
        print(f"{benchmark:11} {row:24} {ratio:6.2f}   {low:5.2f} to {high:5.2f}{words}", flush=True)
    return [f"{benchmark}, {row}" for row in sorted(only)]


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commit", nargs="?", default=named_commit(), help="default: %(default)s")
    parser.add_argument("--only", nargs="+", choices=list(BENCHMARKS), default=list(BENCHMARKS))
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--at-most", type=float, default=float("inf"), help="the highest ratio without a 1")
    parser.add_argument("--bars", action="store_true", help="hold rows against their bars, at their commit")
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    commit, rounds = ("HEAD", 1) if given.smoke else (given.commit, given.rounds)
    bars: Mapping[str, Mapping[str, float]] = BARS if given.bars else {}
    if bars:
        commit, given.only = BARS_OF, [each for each in given.only if each in bars]
    if not has(commit):
        print(f"not compared: this clone does not have the commit {commit} (a shallow clone?)")
        return 0
    above = []
    with sides_of(commit) as sides:
        print(
            f"the working tree's processor time, in units of {commit[:12]}'s; half of the pairs lie between"
        )
        for benchmark in given.only:
            try:
                above += rows_above(sides, benchmark, rounds, given.at_most, bars.get(benchmark, {}))
            except UnmeasuredError as why:
                print(f"{benchmark}: not measured: {why}", flush=True)
                above.append(benchmark)
    if above:
        limit = "their bars" if bars else f"{given.at_most:g}"
        print(f"above {limit}, or not measured: {'; '.join(above)}")
    return int(bool(above))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
