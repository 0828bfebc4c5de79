"""How many mistakes would the tests find, in the 3601's command layer or in another room?

    python tests/tools/mutants.py --cache DIR                  all mutants; can be broken off and taken up
    python tests/tools/mutants.py --cache DIR --sample 200     an estimate
    python tests/tools/mutants.py --files refusals homing      of these files only ("rules": the rule table)
    python tests/tools/mutants.py --room pcl601 --sample 30    of another room, with its own tests
    python tests/tools/mutants.py --list                       the mutants, untried
    python tests/tools/mutants.py --smoke                      a handful that must be killed, quickly

A mutant is the project with one small mistake put in: a condition negated, a comparison off by one, a call
left out, a status bit not set, a row of a table of refusals missing, a rule without its partner. The tests
are run against each in a private copy; a mutant that no test fails for has survived, and is listed. A test
that takes more than 20 times as long as usual counts as failed. What the mistakes are is written in
`mutation/operators.py` and `mutation/effects.py`, which of them no test could notice in `mutation/known.py`,
which files and tests belong to a room in `mutation/rooms.py`.

Exit status: 0 done, 1 a mutant of --smoke has survived or the share is below --at-least, 2 bad option.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import tempfile
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from mutation.effects import effects_of, fired
from mutation.known import SMOKE, SMOKE_TESTS, reason_for
from mutation.operators import Mutant, mutants_of
from mutation.rooms import ROOMS, Room
from mutation.trials import (
    STAGE_LIMIT_S,
    Baseline,
    ProjectCopy,
    Trials,
    Verdict,
    baseline,
    digest,
    file_hash,
    source_hash,
    tree_hash,
)
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from scanrack.io_images.amci3601 import RULES

ROOT = Path(__file__).parents[2]
TABLE = "rules"


def names_in(room: Room) -> list[str]:
    """Return the names that --files takes for a room."""
    return [*room.files(ROOT), *([TABLE] if room is ROOMS["amci3601"] else [])]


def all_mutants(room: Room, names: Iterable[str]) -> list[Mutant]:
    """Return the mutants of these files of a room that are not known to be equivalent."""
    found: list[Mutant] = []
    files = room.files(ROOT)
    for name in names:
        if name == TABLE and name not in files:
            found += _table_mutants()
        else:
            found += mutants_of(files[name], (ROOT / files[name]).read_text(encoding="utf-8"))
    return [mutant for mutant in found if reason_for(mutant) is None]


def _table_mutants() -> list[Mutant]:
    layer = sorted((ROOT / "runtime" / "modules" / "amci3601").rglob("*.py"))
    used = fired((path.read_text(encoding="utf-8") for path in layer), RULES)
    found: list[Mutant] = []
    for path in sorted((ROOT / "io_images" / "amci3601" / "rules").glob("chapter*.py")):
        name = path.relative_to(ROOT).as_posix()
        found += effects_of(name, path.read_text(encoding="utf-8"), RULES, used)
    return found


def test_files(given: Sequence[str]) -> list[str]:
    """Return the files of tests, from the project's root; a folder or a pattern means those in it."""
    files: dict[str, None] = {}
    for name in given:
        for path in sorted(ROOT.glob(name)):
            inside = sorted(path.rglob("test_*.py")) if path.is_dir() else [path]
            files |= dict.fromkeys(file.relative_to(ROOT).as_posix() for file in inside)
    return list(files)


def known_tests(
    copies: Sequence[ProjectCopy],
    room: Room,
    files: Sequence[str],
    cache: Path,
    progress: Progress,
) -> Baseline:
    """Return the tests without a mutant: each file's from the cache, or by running it."""
    traced = list(room.files(ROOT).values())
    free = list(copies)
    sources = source_hash(free[0].package, room.sources)
    common = (
        sources,
        tree_hash(free[0].place / "tests", "support/*.py", "tools/*.py", "conftest.py"),
        *room.folders,
    )
    bar = progress.add_task("tests without a mutant", total=len(files))

    def known(file: str) -> Baseline:
        copy = free.pop()
        kept = cache / f"baseline-{digest(*common, file, file_hash(copy.place / file))}.json"
        if not kept.exists():
            kept.write_text(json.dumps(asdict(baseline(copy, file, traced))), encoding="utf-8")
        free.append(copy)
        progress.update(bar, advance=1)
        return Baseline(**json.loads(kept.read_text(encoding="utf-8")))

    with ThreadPoolExecutor(len(copies)) as pool:
        return Baseline.joined(pool.map(known, files))


def measure(
    mutants: Sequence[Mutant], room: Room, files: Sequence[str], cache: Path, processes: int
) -> dict[Mutant, Verdict]:
    """Try mutants; return their verdicts, up to a Ctrl-C."""
    console = Console(stderr=True)
    verdicts: dict[Mutant, Verdict] = {}
    with tempfile.TemporaryDirectory(prefix="scanrack-mutants-") as folder:
        copies = [ProjectCopy(ROOT, Path(folder) / str(number)) for number in range(processes)]
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        with Progress(*columns, console=console) as progress, ThreadPoolExecutor(processes) as pool:
            known = known_tests(copies, room, files, cache, progress)
            console.print(f"{len(known.tests):,} tests; {len(known.failed)} fail anyway and are left out")
            for node in known.failed:
                console.print(f"  {node}", markup=False)
            trials = Trials(copies, known, cache, room.sources)
            bar = progress.add_task("0 survived", total=len(mutants))
            futures = {pool.submit(trials.judge, mutant): mutant for mutant in mutants}
            try:
                for future in as_completed(futures):
                    verdicts[futures[future]] = future.result()
                    survived = sum(not verdict.killed for verdict in verdicts.values())
                    progress.update(bar, advance=1, description=f"{survived} survived")
            except KeyboardInterrupt:
                pool.shutdown(cancel_futures=True)
    return verdicts


def report(mutants: Sequence[Mutant], verdicts: dict[Mutant, Verdict]) -> float:
    """Print what became of the mutants; return the share of those killed, in per cent."""
    survivors = [mutant for mutant in mutants if mutant in verdicts and not verdicts[mutant].killed]
    for mutant in survivors:
        print(f"\n{mutant} ({verdicts[mutant].why})")
        print(mutant.diff((ROOT / mutant.path).read_text(encoding="utf-8")))
    killed = len(verdicts) - len(survivors)
    slow = sum(verdict.why == "time" for verdict in verdicts.values())
    share = 100 * killed / max(1, len(verdicts))
    print(
        f"\n{killed:,} of {len(verdicts):,} mutants killed, {share:.1f} %; {slow} of them by taking too long"
    )
    if len(verdicts) < len(mutants):
        print(f"{len(mutants) - len(verdicts):,} not tried")
    return share


def smoke() -> int:
    """Try a handful of mutants that are known to be killed, and no mutant at all; return the exit status."""
    with tempfile.TemporaryDirectory(prefix="scanrack-mutants-") as folder:
        copies = [ProjectCopy(ROOT, Path(folder) / str(number)) for number in range(2)]
        tasks = [None, *(_smoke_mutant(*row) for row in SMOKE)]

        def killed(mutant: Mutant | None) -> bool:
            copy = copies.pop()
            source = "" if mutant is None else copy.file(mutant.path).read_text(encoding="utf-8")
            if mutant is not None:
                copy.file(mutant.path).write_text(mutant.apply(source), encoding="utf-8")
            run = copy.run({}, [SMOKE_TESTS], limit_s=STAGE_LIMIT_S, first_only=True)
            if mutant is not None:
                copy.file(mutant.path).write_text(source, encoding="utf-8")
            copies.append(copy)
            return run.status != 0

        with ThreadPoolExecutor(len(copies)) as pool:
            outcomes = list(pool.map(killed, tasks))
    for task, outcome in zip(tasks, outcomes, strict=True):
        print(f"{'killed  ' if outcome else 'survived'}  {task or 'no mutant'}")
    return 0 if not outcomes[0] and all(outcomes[1:]) else 1


def _smoke_mutant(path: str, scope: str, old: str, new: str) -> Mutant:
    wanted = (scope, old, new)
    source = (ROOT / path).read_text(encoding="utf-8")
    for mutant in mutants_of(path, source):
        if (mutant.scope, mutant.old, mutant.new) == wanted:
            return mutant
    raise ValueError(f"mutation/known.py: {path} has no {old!r} in {scope} any more")


def parse(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="How many mistakes would the tests find, in the 3601's command layer or in another room?"
    )
    parser.add_argument("--room", choices=[*ROOMS], default=next(iter(ROOMS)), help="what is measured")
    parser.add_argument("--files", nargs="+", metavar="NAME", help="of these files of the room only")
    parser.add_argument(
        "--tests", nargs="+", metavar="PATH", help="files, folders or patterns of tests, not the room's"
    )
    parser.add_argument("--sample", type=int, metavar="N", help="try so many, chosen at random")
    parser.add_argument("--seed", type=int, default=0, help="of the choice")
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="where verdicts are kept, for taking up again"
    )
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument(
        "--at-least", type=float, metavar="PERCENT", default=0.0, help="exit status 1 below it"
    )
    parser.add_argument("--list", action="store_true", help="print the mutants, try none")
    parser.add_argument("--smoke", action="store_true", help="a handful that must be killed")
    given = parser.parse_args(arguments)
    names = names_in(ROOMS[given.room])
    if unknown := set(given.files or ()) - {*names}:
        parser.error(f"--files {' '.join(sorted(unknown))}: the room {given.room} has {' '.join(names)}")
    return given


def main(arguments: Sequence[str]) -> int:
    given = parse(arguments)
    if given.smoke:
        return smoke()
    room = ROOMS[given.room]
    mutants = all_mutants(room, given.files or names_in(room))
    if given.sample is not None and given.sample < len(mutants):
        chosen = set(random.Random(given.seed).sample(range(len(mutants)), given.sample))
        mutants = [mutant for index, mutant in enumerate(mutants) if index in chosen]
    if given.list:
        for mutant in mutants:
            print(
                f"{mutant}: {' '.join(mutant.old.split())}  ->  {' '.join(mutant.new.split()) or '(nothing)'}"
            )
        print(f"{len(mutants):,} mutants")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        cache = given.cache or Path(folder)
        cache.mkdir(parents=True, exist_ok=True)
        tests = test_files(given.tests or room.tests)
        verdicts = measure(mutants, room, tests, cache, given.processes)
    return 0 if report(mutants, verdicts) >= given.at_least else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
