"""Writes pytest tests whose runs together reach all instructions or branches that a campaign has reached.

The folder has a test file and a scenario for each test. The tests load the user's rack file and invariants,
so they test a changed program. They name the reached instructions and branches without line and rung numbers.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from scanrack.io_images.doors import json_value
from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.text_limits import TextKind
from scanrack.traces.files.guard import OwnedError
from scanrack.traces.files.portable import relative

from ..load.loading import LoadedRack, load_job
from .explain.coverage import places_in
from .folder_lock import write_text
from .job import Setup, bench_of, replay
from .run import TrialBench
from .scenarios.kinds import Kind
from .scenarios.scenario import Scenario

FILE = "test_reached.py"

TEXT = '''\
"""Tests of everything that a search reached in {rack} without a failure; written by scanrack fuzz."""

from pathlib import Path

import pytest
from scanrack.jobs.fuzz.written_tests import play

HERE = Path(__file__).parent
RACK = HERE / {path!r}
INVARIANTS = [HERE / each for each in {invariants!r}]
CHECKS = {checks!r}
SCANS = {scans}
REACHED = {{
{reached}
}}


@pytest.mark.parametrize("scenario", REACHED)
def test_reached(scenario: str) -> None:
    outcome = play(RACK, HERE / scenario, SCANS, INVARIANTS, CHECKS)
    assert outcome.broken == []
    assert sorted(set(REACHED[scenario]) - outcome.reached) == []
'''


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """The outcome of one run.

    Attributes:
        broken: a sentence for each broken invariant.
        reached: instructions that passed power, or branches that were taken, with their routine or file.
    """

    broken: list[str]
    reached: frozenset[str]


def play(
    rack: Path, scenario: Path, scans: int, invariants: Sequence[Path] = (), checks: Sequence[str] = ()
) -> RunOutcome:
    """Run a scenario from a file on a rack.

    Args:
        scans: number of scans to run.
        invariants: files with invariants.
        checks: names of standard invariants, as for `scanrack fuzz --check`.

    Raises:
        ValueError: a file can't be used.
        OSError: a file can't be read.
    """
    setup = Setup(str(rack), tuple(invariants), tuple(checks), scans, frozenset(Kind))
    parsed = Scenario.from_json(json_value(read_input_text(scenario, TextKind.SCENARIO), TextKind.SCENARIO))
    parsed.check(bench_of(setup).spec)
    return _outcome(bench_of(setup), parsed, load_job(setup.rack))


def _outcome(bench: TrialBench, scenario: Scenario, job: LoadedRack) -> RunOutcome:
    broken = [str(failure.broken) for failure in replay(bench, scenario)]
    return RunOutcome(broken, places_in(bench, scenario, job))


def check_new(folder: Path) -> None:
    """Check that a folder for new tests is empty or missing.

    Raises:
        OwnedError: the folder is not empty.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise OwnedError(f"{folder} is not an empty folder: use a new folder with --write-tests")


def write_tests(folder: Path, setup: Setup, job: LoadedRack, scenarios: Iterable[Scenario]) -> int:
    """Write the tests of a campaign; return their number.

    Args:
        job: the rack and program.
        scenarios: scenarios to choose from. Scenarios that break an invariant are left out.

    Raises:
        OwnedError: the folder is not empty.
        OSError: a file can't be written.
    """
    check_new(folder)
    folder.mkdir(parents=True, exist_ok=True)
    chosen = list(_choose(bench_of(setup), job, scenarios))
    rows = []
    for number, (scenario, places) in enumerate(chosen, 1):
        name = f"scenario-{number}.json"
        fields = {key: value for key, value in scenario.to_json().items() if value}
        write_text(folder / name, json.dumps(fields, indent=1) + "\n")
        rows += [f"    {name!r}: [", *(f"        {place!r}," for place in sorted(places)), "    ],"]
    text = TEXT.format(
        rack=Path(setup.rack).name,
        path=relative(setup.rack, folder),
        invariants=[relative(file, folder) for file in setup.invariants],
        checks=list(setup.checks),
        scans=setup.scans,
        reached="\n".join(rows),
    )
    write_text(folder / FILE, text)
    return len(chosen)


def _choose(
    bench: TrialBench, job: LoadedRack, scenarios: Iterable[Scenario]
) -> Iterator[tuple[Scenario, frozenset[str]]]:
    """Yield a few scenarios that together reach all places, each with the places that it adds.

    The next scenario is always the one that adds the most places.
    """
    runs = [(scenario, _outcome(bench, scenario, job)) for scenario in scenarios]
    unreached_places = [(scenario, outcome.reached) for scenario, outcome in runs if not outcome.broken]
    while unreached_places:
        scenario, new_places = max(unreached_places, key=lambda run: len(run[1]))
        if not new_places:
            return
        yield scenario, new_places
        unreached_places = [(other, places - new_places) for other, places in unreached_places]
