"""What do the tests cost, beside another commit's? Both run a sample of them in turns, file by file.

    python benchmarks/suite.py [COMMIT] [--rounds N]     ratio of the processor times, with its spread
    python benchmarks/suite.py --smoke                   two files beside HEAD, one round

COMMIT is the one that benchmarks/against.commit names, if none is given. The sample is every sixth file of
its tests, without those of the browser; a file that this checkout does not have is named and left out. Each
side leaves out what README's command leaves out there, and plays as many random examples.

Each side is a copy of a commit or of the working tree, with its package beside it, and one process of pytest
per round, which has collected the sample and runs the file that is named to it. A test's time is
processor time of its process and of the processes that it started, with its fixtures. Three figures come out:

    the same tests    tests that both sides run
    all tests         all that each side runs of these files: new ones count, those that are slow do not
    collecting        from the start of the process to the first test

Exit status: 0; 1 if a test fails or a side does not run; 0 and a line if this clone does not have the commit.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from socket import socketpair
from statistics import median

from against import HERE, ROOT, Side, UnmeasuredError, archived, compared, has, laid_out

EVERY = 6
SMOKE_FILES = ("tests/unit/io_images/test_times.py", "tests/unit/io_images/test_csv_cells.py")

Times = dict[str, float]


class Suite:
    """A process of pytest that has collected files of tests and runs them one after the other.

    Args:
        side: where the package is.
        root: the checkout with the tests.
        files: what it collects in place of the whole suite, from `root`.

    Attributes:
        collecting: processor seconds until it was ready.

    Raises:
        UnmeasuredError: it does not start.
    """

    def __init__(self, side: Side, root: Path, files: Sequence[str]) -> None:
        path = os.pathsep.join(map(str, (side.site, HERE)))
        environment = os.environ | {"PYTHONPATH": path, "PYTHONHASHSEED": "0"}
        environment.pop("PYTHONDONTWRITEBYTECODE", None)
        ours, theirs = socketpair()
        words = [sys.executable, "-m", "pytest", "-q", "-p", "suite_turns", "--turns", str(theirs.fileno())]
        words += ["-p", "no:cacheprovider", "--processes", "1", "-o", f"testpaths={' '.join(files)}"]
        self._said = tempfile.TemporaryFile()  # noqa: SIM115 - `end` closes it
        self._process = subprocess.Popen(
            words,
            cwd=root,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=self._said,
            stderr=subprocess.STDOUT,
            pass_fds=[theirs.fileno()],
        )
        theirs.close()
        with ours:
            self._lines = ours.makefile("rw", encoding="utf-8", buffering=1)
        self.collecting = float(self._answer())

    def _answer(self):
        line = self._lines.readline()
        if not line:
            raise UnmeasuredError(f"its process ended: {self.said()}")
        return json.loads(line)

    def times(self, file: str) -> Times:
        """Run a file; return the processor seconds of its tests by their ids."""
        self._lines.write(file + "\n")
        self._lines.flush()
        return self._answer()

    def said(self) -> str:
        """Return the end of what pytest has printed."""
        self._said.seek(0)
        return self._said.read()[-2_000:].decode("utf-8", "replace")

    def end(self) -> str:
        """End it; return what pytest has printed if a test has failed."""
        self._lines.close()
        status = self._process.wait()
        said = self.said()
        self._said.close()
        return f"pytest ends with {status}: {said}" if status else ""


@contextmanager
def suites(checkouts: Sequence[tuple[Side, Path]], files: Sequence[str]) -> Iterator[list[Suite]]:
    """Start a process on each side.

    Raises:
        UnmeasuredError: a test has failed.
    """
    started: list[Suite] = []
    try:
        for side, root in checkouts:
            started.append(Suite(side, root, files))
        yield started
    finally:
        ends = [suite.end() for suite in started]
    for (_, root), said in zip(checkouts, ends, strict=True):
        if said:
            raise UnmeasuredError(f"{root.name}: {said}")


def sample(root: Path) -> list[str]:
    """Return every sixth file of the tests, from the root of a checkout."""
    files = sorted(file.relative_to(root).as_posix() for file in root.glob("tests/**/test_*.py"))
    return [file for file in files if not file.startswith("tests/browser/")][::EVERY]


def working_tree(folder: Path) -> Path:
    """Copy the files that git has, or would have, and return the folder."""
    words = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(words, cwd=ROOT, check=True, stdout=subprocess.PIPE, encoding="utf-8").stdout
    for name in filter(None, names.split("\0")):
        if (ROOT / name).is_file():  # a link to a folder is none; one may have been deleted since
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


def measured(checkouts: Sequence[tuple[Side, Path]], files: Sequence[str]) -> tuple[list[Times], list[float]]:
    """Run all files on both sides in turns; return the times of their tests, and those of collecting."""
    found: list[Times] = [{} for _ in checkouts]
    with suites(checkouts, files) as running:
        for number, file in enumerate(files):
            sides = list(zip(found, running, strict=True))
            for times, suite in sides if number % 2 else reversed(sides):
                times |= suite.times(file)
        return found, [suite.collecting for suite in running]


def rows(other: Times, this: Times, collecting: Sequence[float]) -> dict[str, tuple[float, float]]:
    """Return the processor seconds of a round: the other commit's and this one's.

    >>> rows({"a": 1.0, "b": 2.0}, {"a": 0.5, "c": 4.0}, [8.0, 6.0])
    {'the same tests': (1.0, 0.5), 'all tests': (3.0, 4.5), 'collecting': (8.0, 6.0)}
    """
    both = other.keys() & this.keys()
    return {
        "the same tests": (sum(other[name] for name in both), sum(this[name] for name in both)),
        "all tests": (sum(other.values()), sum(this.values())),
        "collecting": (collecting[0], collecting[1]),
    }


def report(rounds: Sequence[dict[str, tuple[float, float]]]) -> None:
    """Print the medians of the rounds, and the ratios with their quartiles."""
    print(
        "processor seconds: the other commit, this one; this one in units of the other's, half of the rounds"
    )
    for row in rounds[0]:
        pairs = [each[row] for each in rounds]
        ratio, low, high = compared(pairs)
        other, this = (median(side) for side in zip(*pairs, strict=True))
        print(f"{row:16} {other:8.2f} {this:8.2f} {ratio:6.2f}   {low:5.2f} to {high:5.2f}")


def compare(commit: str, rounds: int, files: Sequence[str]) -> None:
    """Measure and print.

    Raises:
        UnmeasuredError: a side does not run.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        other = archived(commit, folder / "commit")
        this = working_tree(folder / "this")
        checkouts = [(laid_out(root, folder / f"{root.name}-site"), root) for root in (other, this)]
        chosen = list(files) or sample(other)
        missing = [file for file in chosen if not (this / file).exists() or not (other / file).exists()]
        chosen = [file for file in chosen if file not in missing]
        for file in missing:
            print(f"{file}: not on both sides, left out")
        done = []
        for number in range(1, rounds + 1):
            (others, ours), collecting = measured(checkouts, chosen)
            done.append(rows(others, ours, collecting))
            if number == 1:
                both = len(others.keys() & ours.keys())
                print(f"{len(chosen)} files; tests: {len(others):,} and {len(ours):,}, {both:,} the same")
            print(f"round {number}: {done[-1]['the same tests']}", flush=True)
        report(done)


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    named = (HERE / "against.commit").read_text(encoding="utf-8").split()[0]
    parser.add_argument("commit", nargs="?", default=named, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--smoke", action="store_true", help="a quick run that checks, and measures little")
    given = parser.parse_args(arguments)
    commit, rounds, files = ("HEAD", 1, SMOKE_FILES) if given.smoke else (given.commit, given.rounds, ())
    if not has(commit):
        print(f"not compared: this clone does not have the commit {commit} (a shallow clone?)")
        return 0
    try:
        compare(commit, rounds, files)
    except UnmeasuredError as why:
        print(f"not measured: {why}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
