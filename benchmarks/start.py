"""What a command costs before it works, and the README's example, beside another commit.

    python benchmarks/start.py [COMMIT] [--rounds N] [--smoke]

Processes of either commit take turns: `scanrack run` of the README's example, `scanrack --help` and
`scanrack run --help`. Times are processor time; the least and the median of the rounds, and the ratio of the
medians. COMMIT is 8b1b7671, before the start was made shorter, if none is given. Both run from compiled
files, as an installation does.

Exit status 1 if the example takes more than 0.5 of the time there, or the help of run more than 1.5 times
as long as that of the whole; 0 and a line that says so if this clone does not have the commit.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median

from against import ROOT, archived, has, laid_out
from bars import Bars, children_s

COMMIT = "8b1b7671"
LINE = ROOT / "examples/three_stations/line.toml"
MOST_RUN, MOST_HELP = 0.5, 1.5

COMMANDS = {
    "run": ("run", str(LINE), "--record", "a.mcap", "--replace"),
    "--help": ("--help",),
    "run --help": ("run", "--help"),
}


def processor_s(site: Path, words: Sequence[str], folder: str) -> float:
    """Return the processor time of a command of a commit."""
    environment = os.environ | {"PYTHONPATH": str(site)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    command = [sys.executable, "-m", "scanrack", *words]
    before = children_s()
    subprocess.run(command, cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL)
    return children_s() - before


def turns(sites: Sequence[Path], words: Sequence[str], rounds: int, folder: str) -> list[list[float]]:
    """Return the times of each commit."""
    for site in sites:  # compiled files are written
        processor_s(site, words, folder)
    return [
        list(each)
        for each in zip(
            *([processor_s(site, words, folder) for site in sites] for _ in range(rounds)), strict=True
        )
    ]


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("commit", nargs="?", default=COMMIT, help="default: %(default)s")
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--smoke", action="store_true", help="one round beside HEAD, no limit")
    given = parser.parse_args(arguments)
    commit, rounds = ("HEAD", 1) if given.smoke else (given.commit, given.rounds)
    if not has(commit):
        print(f"not compared: this clone does not have the commit {commit} (a shallow clone?)")
        return 0
    bars = Bars(count=not given.smoke)
    medians: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sites = (
            laid_out(archived(commit, folder / "commit"), folder / "other").site,
            laid_out(ROOT, folder / "this").site,
        )
        print(f"processor time, ms: least and median at {commit}, here; ratio of the medians")
        for command, words in COMMANDS.items():
            there, here = turns(sites, words, rounds, name)
            medians[command] = median(here)
            ratio = median(here) / median(there)
            bar = bars.most("run", ratio, MOST_RUN) if command == "run" else ""
            ms = "  ".join(
                f"{each * 1000:5.0f}" for side in (there, here) for each in (min(side), median(side))
            )
            print(f"{command:12} {ms}  {ratio:5.2f}  {bar}", flush=True)
    ratio = medians["run --help"] / medians["--help"]
    print(f"run --help takes {ratio:.2f} of --help, {bars.most('run --help', ratio, MOST_HELP)}")
    return bars.status()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
