"""Searches that are killed at random moments: is anything lost that was found?

    python benchmarks/fuzz_kills.py [--kills N] [--smoke]

A child process searches a program with many mistakes, and notes each failure once it has been told of it;
kill -9 meets it within some seconds, mostly while it shrinks or confirms. Every failure noted so far has to
be in the state of the campaign or among its finds, and every file of the folder has to be whole. Two sessions
share a folder; a third that is not killed shrinks what they have left.

Exit status: 0; an AssertionError if something is lost.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from pathlib import Path

from scanrack.commands import build
from scanrack.jobs.fuzz import Counterexample
from scanrack.jobs.fuzz.campaign.recipes import read_recipe
from scanrack.jobs.fuzz.campaign.state import State, read_state
from scanrack.jobs.fuzz.campaign.working import Work
from typer.testing import CliRunner

MISTAKES, SESSIONS, LATEST_S = 40, 2, 3.0
BODY = "".join(
    f"        if n == {n}:\n            raise RuntimeError('mistake {n}')\n" for n in range(MISTAKES)
)
PROGRAM = f"""
from scanrack.io_images.amci3601 import Configuration, Idle, StatusView

WORDS = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=500).to_image()

def logic(scan):
    status, n = StatusView(scan.slot[1].inputs), scan.number % {MISTAKES}
    scan.slot[1].outputs.load(Idle().to_image() if status.MODE_CONFIG or scan.number > 5 else WORDS)
    if status.IN_ESTOP:
{BODY}"""
RACK = 'program = "line.py"\nrun_for_s = 0.5\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'


def search(folder: Path, notes: Path, runs: int) -> None:
    """Search in this process, and note what is found and how long it takes to be on the disk."""
    save = Work._save

    def noted(self: Work, failure: Counterexample) -> None:
        since = time.perf_counter()
        save(self, failure)
        with notes.open("a", encoding="utf-8") as file:
            file.write(f"{failure.broken.key}\t{time.perf_counter() - since:.6f}\n")

    Work._save = noted  # type: ignore[method-assign]
    words = ("--only", "inputs", "--jobs", "1", "--out", folder / "out", "--runs", runs, "--quiet")
    CliRunner().invoke(build(), ["fuzz", str(folder / "line.toml"), *map(str, words)])


def killed(folder: Path, notes: Path, after_s: float) -> None:
    """Let a child search, and kill it once it has begun."""
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        search(folder, notes, 100_000)
        os._exit(0)
    while not (folder / "out" / "state.json").exists():
        time.sleep(0.01)
    time.sleep(after_s)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def noted_in(notes: Path) -> dict[str, float]:
    """Return the keys of the failures that were told, with the seconds until they were on the disk."""
    if not notes.exists():
        return {}
    rows = [line.split("\t") for line in notes.read_text(encoding="utf-8").splitlines()]
    return {key: float(seconds) for key, seconds in rows}


def check(folder: Path, wanted: set[str]) -> tuple[State, int]:
    """Return the state and the number of finds that wait; AssertionError if something is lost or torn."""
    state = read_state(folder / "out" / "state.json", "../line.toml")
    for name in ("corpus", "finds"):
        for file in (folder / "out" / name).glob("[!.]*"):
            read_recipe(file)
    left = len(list((folder / "out" / "finds").glob("[!.]*")))
    lost = len(wanted - set(state.found))
    assert lost <= left, f"{lost} failures are not in the state, and {left} wait to be shrunk"
    return state, left


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description="Searches that are killed at random moments.")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--smoke", action="store_true", help="one kill only")
    given = parser.parse_args(arguments)
    kills, moments = 1 if given.smoke else given.kills, random.Random(1)
    waited, found, slowest = 0, 0, 0.0
    with tempfile.TemporaryDirectory() as place:
        for begin in range(0, kills, SESSIONS):
            folder = Path(place) / str(begin)
            folder.mkdir()
            (folder / "line.py").write_text(PROGRAM, encoding="utf-8")
            (folder / "line.toml").write_text(RACK, encoding="utf-8")
            notes = folder / "notes"
            for _ in range(min(SESSIONS, kills - begin)):
                killed(folder, notes, moments.uniform(0, 1.0 if given.smoke else LATEST_S))
                _, left = check(folder, set(noted_in(notes)))
                waited += left > 0
            wanted = noted_in(notes)
            if not given.smoke:
                search(folder, notes, 1)
                state, left = check(folder, set(wanted))
                assert left == 0, f"{left} finds still wait"
                assert wanted.keys() <= state.found.keys(), f"lost: {wanted.keys() - state.found.keys()}"
            found += len(wanted)
            slowest = max(slowest, *wanted.values(), 0.0)
    print(f"{kills} kills, {found} failures had been found, none is lost, every file is whole")
    print(f"after {waited} of the kills a find waited to be shrunk by the next session")
    print(f"a find was on the disk after {slowest * 1000:.1f} ms at the latest")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
