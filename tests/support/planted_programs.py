"""The programs of benchmarks/fuzz_programs: each correct, with one mistake to plant, and what must hold.

NAME/rack.toml, program.*    the correct version, which `scanrack fuzz` takes as it is
NAME/must_hold.py            its invariants
NAME/planted.toml            `correct`: lines of the program; `planted`: what replaces them
                             `invariant`: the name of what is then broken, if it is not in must_hold.py
NAME/scenario.json           made by hand: breaks the planted version, not the correct one
"""

from __future__ import annotations

import json
import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path

from scanrack.jobs import Kind, kinds_for, load_job
from scanrack.jobs.fuzz import Scenario, TrialBench
from scanrack.jobs.fuzz.job import Setup, bench_of
from scanrack.jobs.load.loading import scans_to_run

FOLDER = Path(__file__).parents[2] / "benchmarks" / "fuzz_programs"
NAMES = sorted(each.name for each in FOLDER.iterdir() if each.is_dir())


@dataclass(frozen=True)
class Version:
    """A program laid out in a folder, planted or correct."""

    bench: TrialBench
    kinds: frozenset[Kind]


def planted(name: str) -> dict[str, str]:
    """Return what is planted in a program."""
    return tomllib.loads((FOLDER / name / "planted.toml").read_text(encoding="utf-8"))


def invariant_of(name: str, version: Version) -> str:
    """Return the name of the invariant that the planted mistake breaks."""
    given = planted(name).get("invariant")
    return given or version.bench.invariants[0].name


def scenario_of(name: str) -> Scenario:
    """Return the scenario made by hand."""
    text = (FOLDER / name / "scenario.json").read_text(encoding="utf-8")
    return Scenario.from_json(json.loads(text))


def lay_out(name: str, folder: Path, *, with_mistake: bool) -> Path:
    """Copy a program to a folder, with its mistake or without; return its rack file."""
    shutil.copytree(FOLDER / name, folder, ignore=shutil.ignore_patterns("__pycache__"))
    change = planted(name)
    file = next(folder.glob("program.*"))
    text = file.read_text(encoding="utf-8")
    correct = change["correct"].strip("\n")
    assert text.count(correct) == 1, f"{name}: {correct!r} is there {text.count(correct)} times"
    if with_mistake:
        file.write_text(text.replace(correct, change["planted"].strip("\n")), encoding="utf-8")
    return folder / "rack.toml"


def version_of(name: str, folder: Path, *, with_mistake: bool) -> Version:
    """Lay out a program in a folder of its own; return its bench and the events of its rack."""
    rack = lay_out(name, folder, with_mistake=with_mistake)
    job = load_job(str(rack))
    scans = scans_to_run(job.spec, None, None, endless=False)
    assert scans is not None
    kinds = kinds_for(job.spec)
    setup = Setup(str(rack), (rack.parent / "must_hold.py",), (), scans, kinds)
    return Version(bench_of(setup), kinds)
