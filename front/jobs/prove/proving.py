"""All claims of a subject, one after the other; each scenario is done on the rack, and written."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Self

from ...ladder.prove.answers import LIMITS, Answer, ScenarioStep, answer, steps_of
from ...ladder.prove.induction import Limits, VerdictKind
from ...ladder.prove.questions import Finding, ask
from ...ladder.prove.replaying import ScanOf
from ...runtime.loop.faults import CpuFault
from ...runtime.loop.pace import wall_ns
from ...traces.files.guard import Used
from ..check.rungs.structure import own_routines
from ..fuzz.folder_lock import locked, write_text
from ..fuzz.scenarios.scenario import Scenario
from ..load.loading import SCENARIO, SCENARIO_TRACE, Job
from ..trust.owned import in_use
from .on_rack import OnRack, claim_broken, coils_disagree, faults_on_rack, record, replay_on_rack
from .scenario import RackScenario, on_scans_of
from .subject import ProofSubject

FAULTS = ("fault", "endless")
"""Rules of faults, which a rack shows."""

Progress = Callable[[str, int, int], object]
"""Called before each claim: its name, its number from 1, how many there are."""


def no_progress(_name: str, _number: int, _of: int) -> None:
    """Show nothing."""


@dataclass(slots=True)
class ScenarioFolder:
    """The folder of a command's scenarios, made and locked with the first one; a context releases it."""

    path: Path
    _held: ExitStack = field(default_factory=ExitStack)
    _is_locked: bool = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self._held.close()

    def save(self, name: str, scenario: Scenario, used: Used) -> Path:
        """Write the scenario of a claim in a folder of its name; return its path.

        Raises:
            ValueError: the folder has other files, or another process uses it.
            OSError: the scenario can't be written.
        """
        if not self._is_locked:
            self._held.enter_context(locked(self.path))
            self._is_locked = True
        own = self.path / slug(name)
        own.mkdir(exist_ok=True)
        return write_text(own / SCENARIO, json.dumps(scenario.to_json(), indent=1) + "\n", used)


@dataclass(frozen=True, slots=True)
class Result:
    """An answer with the time that it took, what the rack did, and its scenario's file."""

    answer: Answer
    spent_ns: int
    rack: OnRack | None = None
    scenario: Path | None = None

    @property
    def name(self) -> str:
        """Name of the claim."""
        return self.answer.claim.name


def prove_all(
    subject: ProofSubject, folder: ScenarioFolder, progress: Progress = no_progress, limits: Limits = LIMITS
) -> Iterator[Result]:
    """Decide the claims of a subject.

    Args:
        folder: gets the scenarios.

    Raises:
        ValueError: the folder has other files, or another process uses it.
        OSError: a file can't be written.
    """
    claims = subject.program.properties
    for number, each in enumerate(claims, start=1):
        progress(each.claim.name, number, len(claims))
        start_ns = wall_ns()
        found = answer(subject.problem, subject.program, each, limits)
        if not found.steps:
            yield Result(found, wall_ns() - start_ns)
            continue
        rack = replay_on_rack(subject, claim_broken(subject, each), found.scans)
        file = _written(subject, found.claim.name, found.scans, rack, folder)
        yield Result(found, wall_ns() - start_ns, rack, file)


@dataclass(frozen=True, slots=True)
class FoundAnswer:
    """What a built-in question found; with the run and its file, if a run found it."""

    finding: Finding
    steps: tuple[ScenarioStep, ...] = ()
    scenario: Path | None = None
    rack: str = ""  # what it did on the rack

    @property
    def refuted(self) -> bool:
        """Whether a run shows it, such as a fault; else it is proved, such as a dead rung."""
        return self.finding.verdict.kind is VerdictKind.REFUTED


@dataclass(frozen=True, slots=True)
class Questions:
    """The answers to the built-in questions."""

    found: tuple[FoundAnswer, ...]
    asked: Mapping[str, int]  # by rule
    open: Mapping[str, int]


def ask_questions(subject: ProofSubject, folder: ScenarioFolder) -> Questions:
    """Answer the built-in questions about the user's own text; see `prove_all` for the folder.

    Raises:
        ValueError, OSError: see `prove_all`.
    """
    own = {each.name.upper() for each in own_routines(subject.program.program, subject.problem.lowered)}
    answers = ask(subject.problem, routines=own)
    layout = subject.problem.lowered.layout
    found = []
    for each in answers.findings:
        scans = each.verdict.scans
        if not scans:
            found.append(FoundAnswer(each))
            continue
        name = f"{each.rule} {each.site.routine} {each.site.rung} {each.site.instruction}"
        rack = replay_on_rack(subject, coils_disagree(subject, each.coils), scans) if each.coils else None
        file = _written(subject, name, scans, rack, folder)
        said = faults_on_rack(subject, scans) if each.rule in FAULTS else str(rack or "")
        found.append(FoundAnswer(each, tuple(steps_of(layout, scans)), file, said))
    return Questions(tuple(found), answers.asked, answers.open)


def _scan_ns(subject: ProofSubject) -> int:
    """Return the rack's time between scans; without a rack 1 ms, the grid of the prover."""
    return subject.job.spec.scan_ns if subject.job.spec.slot else 1_000_000


def slug(name: str) -> str:
    """Return the name of a claim's folder.

    >>> slug("lost position"), slug("never Fwd AND Rev (2)"), slug("??")
    ('lost_position', 'never_Fwd_AND_Rev_2', 'claim')
    """
    return re.sub(r"\W+", "_", name).strip("_")[:60] or "claim"


def _written(
    subject: ProofSubject, name: str, scans: Sequence[ScanOf], rack: OnRack | None, folder: ScenarioFolder
) -> Path:
    """Write a scenario, see `write_scenario`."""
    scan_ns, layout = _scan_ns(subject), subject.problem.lowered.layout
    orders = on_scans_of(layout, scans, scan_ns) if rack is None else rack.scenario
    return write_scenario(subject.job, name, orders, scan_ns, rack, folder)


def write_scenario(
    job: Job, name: str, orders: RackScenario, scan_ns: int, rack: OnRack | None, folder: ScenarioFolder
) -> Path:
    """Write a scenario, and its recording if the rack confirms it; return the scenario's path."""
    file = folder.save(name, orders.scenario(scan_ns), in_use(job))
    if rack is not None and rack.confirmed:
        with suppress(CpuFault):  # the recording ends with the fault
            record(job, rack, file.with_name(SCENARIO_TRACE))
    return file
