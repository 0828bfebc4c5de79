"""Decides all claims of a subject, one at a time. Runs each scenario on the rack and writes its files."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Self

from scanrack.ladder.model.tags import Layout
from scanrack.ladder.prove.answers import LIMITS, Answer, ScenarioStep, answer, steps_of
from scanrack.ladder.prove.certificate import Certificate, written
from scanrack.ladder.prove.induction import Limits, VerdictKind
from scanrack.ladder.prove.questions import LIMITS as QUESTION_LIMITS
from scanrack.ladder.prove.questions import Finding, Listener, Question, ask
from scanrack.ladder.prove.replaying import ScanOf
from scanrack.ladder.prove.system import ScanBounds
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.pace import wall_ns
from scanrack.traces.files.guard import Used
from scanrack.traces.files.portable import no_device

from ..check.rungs.view import own_routines
from ..fuzz.folder_lock import locked, write_text
from ..fuzz.scenarios.scenario import Scenario
from ..load.loading import SCENARIO, SCENARIO_TRACE, LoadedRack
from ..trust.owned import in_use
from .checking import Opinion, Solver, check
from .on_rack import OnRack, claim_broken, coils_disagree, faults_on_rack, record, replay_on_rack
from .own_run import seen_in_own_run
from .scenario import on_scans_of
from .subject import ProofSubject, subject_of_job

RELATION, ROLES = "proof.smt2", "proof.json"
"""Files of a proof's certificate."""

FAULTS = ("fault", "endless")
"""Rules for faults, which a rack can show."""

Progress = Callable[[str, int, int], object]
"""Called before each claim with the claim's name, its number from 1, and the number of claims."""


def no_progress(_name: str, _number: int, _of: int) -> None:
    """Ignore the progress."""


@dataclass(slots=True)
class ScenarioFolder:
    """The folder of a command's scenarios. Saving creates and locks it; the context unlocks it."""

    path: Path
    _lock: ExitStack = field(default_factory=ExitStack)
    _is_locked: bool = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        self._lock.close()

    def save(self, name: str, scenario: Scenario, used: Used) -> Path:
        """Write the scenario of a claim to a folder with the claim's name; return the path of the scenario.

        Raises:
            ValueError: the folder has other files, or another process uses it.
            OSError: the scenario can't be written.
        """
        text = json.dumps(scenario.to_json(), indent=1) + "\n"
        return write_text(self._claim_folder(name) / SCENARIO, text, used)

    def save_proof(self, name: str, certificates: Sequence[Certificate], used: Used) -> Path:
        """Write a claim's certificate to a folder with its name; return the folder. Errors: see `save`."""
        folder, (relation, roles) = self._claim_folder(name), written(certificates)
        write_text(folder / RELATION, relation, used)
        write_text(folder / ROLES, json.dumps({"claim": name, **roles}, indent=1) + "\n", used)
        return folder

    def _claim_folder(self, name: str) -> Path:
        """Create the folder of a claim; return it."""
        if not self._is_locked:
            self._lock.enter_context(locked(self.path))
            self._is_locked = True
        folder = self.path / slug(name)
        folder.mkdir(exist_ok=True)
        return folder


@dataclass(frozen=True, slots=True)
class Result:
    """An answer with its duration, its run on the rack, and its files."""

    answer: Answer
    spent_ns: int
    rack: OnRack | None = None
    scenario: Path | None = None
    proof: Path | None = None  # the folder with the certificate of the proof
    opinions: tuple[Opinion, ...] = ()  # verdicts of other solvers
    own_ns: int = 0  # the rack's time between two scans
    at_own_time: Answer | None = (
        None  # the answer for scans of that time, if only longer scans break the claim
    )

    @property
    def refused_by(self) -> tuple[Opinion, ...]:
        """Verdicts of solvers that found a run the proof rules out; a single one makes the claim unknown."""
        return tuple(opinion for opinion in self.opinions if opinion.refused)

    @property
    def word(self) -> str:
        """The verdict, see `Answer.word`."""
        return VerdictKind.UNKNOWN if self.refused_by else self.answer.word

    @property
    def name(self) -> str:
        """Name of the claim."""
        return self.answer.claim.name


def prove_all(
    subject: ProofSubject,
    folder: ScenarioFolder,
    progress: Progress = no_progress,
    limits: Limits = LIMITS,
    others: Sequence[Solver] = (),
) -> Iterator[Result]:
    """Decide the claims of a subject.

    Args:
        folder: receives the scenarios, and the certificates of proofs.
        others: solvers that check each certificate.

    Raises:
        ValueError: the folder has other files, or another process uses it.
        OSError: a file can't be written.
    """
    claims = subject.program.properties
    for number, claim in enumerate(claims, start=1):
        progress(claim.claim.name, number, len(claims))
        start_ns = wall_ns()
        claim_answer = answer(subject.problem, subject.program, claim, limits)
        if claim_answer.verdict:
            spent_ns, used = wall_ns() - start_ns, in_use(subject.job)
            proof = folder.save_proof(claim_answer.claim.name, claim_answer.verdict.certificates, used)
            opinions = tuple(check(proof, solver) for solver in others)
            yield Result(claim_answer, spent_ns, proof=proof, opinions=opinions)
            continue
        if not claim_answer.steps:
            yield Result(claim_answer, wall_ns() - start_ns)
            continue
        rack = replay_on_rack(subject, claim_broken(subject, claim), claim_answer.scans)
        layout = subject.problem.lowered.layout
        file = write_scenario(subject.job, layout, claim_answer.claim.name, claim_answer.scans, rack, folder)
        at_own_time = _at_own_time(subject, number - 1, claim_answer, rack, limits)
        yield Result(
            claim_answer,
            wall_ns() - start_ns,
            rack=rack,
            scenario=file,
            own_ns=subject.job.spec.scan_ns,
            at_own_time=at_own_time,
        )


def _at_own_time(
    subject: ProofSubject, index: int, refuted: Answer, rack: OnRack | None, limits: Limits
) -> Answer | None:
    """Decide a refuted claim again with the rack's own scan time, if a run with longer scans breaks it.

    Args:
        index: place of the claim among the subject's claims.

    Returns:
        The answer; None if the rack confirms the run, no scan is longer, or the claim is refuted again.
    """
    own_ns = subject.job.spec.scan_ns
    has_longer_scan = any(scan.ms * 1_000_000 > own_ns and not scan.turned for scan in refuted.scans)
    if rack is None or rack.confirmed or not has_longer_scan:
        return None
    bounds = ScanBounds.of(own_ns / 1e6, own_ns / 1e6)
    own_subject = subject_of_job(subject.job, subject.problem, bounds)
    claim = own_subject.program.properties[index]
    own_answer = answer(own_subject.problem, own_subject.program, claim, limits)
    return None if own_answer.verdict.kind is VerdictKind.REFUTED else own_answer


@dataclass(frozen=True, slots=True)
class FoundAnswer:
    """A finding of a built-in question, with its run and its files if it has any."""

    finding: Finding
    steps: tuple[ScenarioStep, ...] = ()
    scenario: Path | None = None
    rack: str = ""  # the effect of the run on the rack, as text
    proof: Path | None = None  # the folder with the certificate of the proof
    opinions: tuple[Opinion, ...] = ()

    @property
    def refuted(self) -> bool:
        """Whether a run shows the finding (such as a fault); otherwise it is proved (such as a dead rung)."""
        return self.finding.verdict.kind is VerdictKind.REFUTED


@dataclass(frozen=True, slots=True)
class Questions:
    """The answers to the built-in questions."""

    found: tuple[FoundAnswer, ...]
    counts: Mapping[str, int]  # number of questions by rule
    open: Mapping[str, int]  # number of undecided questions by rule


AnswerListener = Listener[FoundAnswer]
"""Receives the findings of built-in questions as soon as they are decided."""


def ask_questions(
    subject: ProofSubject,
    folder: ScenarioFolder,
    others: Sequence[Solver] = (),
    listener: AnswerListener | None = None,
    work: int = 1,
) -> Questions:
    """Answer the built-in questions about the user's own code. For `folder` and `others` see `prove_all`.

    With other solvers, each proved finding also gets a certificate. If a solver refuses it, the question
    remains open.

    Args:
        work: factor for the limits.

    Raises:
        ValueError, OSError: see `prove_all`.
    """
    routines = own_routines(subject.program.program, subject.problem.lowered)
    writer = _FindingWriter(subject, folder, others, listener or AnswerListener())
    answers = ask(
        subject.problem,
        limits=QUESTION_LIMITS.times(work),
        routines={routine.name.upper() for routine in routines},
        known_run=partial(seen_in_own_run, subject),
        listener=writer,
    )
    answers.open.update(writer.refused)
    in_program_order = [writer.answers.get(id(finding)) for finding in answers.findings]
    found = tuple(answer for answer in in_program_order if answer is not None)
    return Questions(found, answers.counts, answers.open)


class _FindingWriter(Listener[Finding]):
    """Writes the scenario or certificate of each finding, and reports the finding."""

    def __init__(
        self,
        subject: ProofSubject,
        folder: ScenarioFolder,
        others: Sequence[Solver],
        listener: AnswerListener,
    ) -> None:
        self._subject, self._folder, self._others, self._listener = subject, folder, others, listener
        self.answers: dict[int, FoundAnswer] = {}  # by the `id` of the finding
        self.refused: list[str] = []  # rules of the findings that another solver refuses

    def begun(self, count: int) -> None:
        """Report the number of questions."""
        self._listener.begun(count)

    def left(self, count: int) -> None:
        """Report the number of questions left."""
        self._listener.left(count)

    def next(self, question: Question, count: int) -> None:
        """Report the next question."""
        self._listener.next(question, count)

    def found(self, answer: Finding) -> None:
        """Report a finding."""
        result = self._with_files(answer)
        if result is None:
            self.refused.append(answer.rule)
        else:
            self.answers[id(answer)] = result
            self._listener.found(result)

    def _with_files(self, finding: Finding) -> FoundAnswer | None:
        """Write the files of a finding, and return it with them; None if another solver refuses it."""
        subject, scans, site = self._subject, finding.verdict.scans, finding.site
        name = f"{finding.rule} {site.routine} {site.rung} {site.instruction}"
        if not scans and not self._others:
            return FoundAnswer(finding)
        if not scans:
            proof = self._folder.save_proof(name, finding.verdict.certificates, in_use(subject.job))
            opinions = tuple(check(proof, solver) for solver in self._others)
            is_refused = any(opinion.refused for opinion in opinions)
            return None if is_refused else FoundAnswer(finding, proof=proof, opinions=opinions)
        coils = finding.coils
        rack = replay_on_rack(subject, coils_disagree(subject, coils), scans) if coils else None
        layout = subject.problem.lowered.layout
        file = write_scenario(subject.job, layout, name, scans, rack, self._folder)
        on_rack = faults_on_rack(subject, scans) if finding.rule in FAULTS else str(rack or "")
        return FoundAnswer(finding, tuple(steps_of(layout, scans)), scenario=file, rack=on_rack)


def slug(name: str) -> str:
    """Return the folder name for a claim.

    >>> slug("lost position"), slug("never Fwd AND Rev (2)"), slug("??"), slug("Aux")
    ('lost_position', 'never_Fwd_AND_Rev_2', 'claim', 'Aux_')
    """
    return no_device(re.sub(r"\W+", "_", name).strip("_")[:60]) or "claim"


def write_scenario(
    job: LoadedRack,
    layout: Layout,
    name: str,
    scans: Sequence[ScanOf],
    rack: OnRack | None,
    folder: ScenarioFolder,
) -> Path:
    """Write a run as a scenario, and its recording if the rack confirms it; return the scenario's path.

    Args:
        layout: the tags of the program that runs.
        name: name of the claim, or another name for the scenario's folder.
        rack: the effect of the run on the rack; None if it did not run there.
    """
    scan_ns = job.spec.scan_ns if job.spec.slot else 1_000_000  # without a rack, the time unit of the prover
    orders = on_scans_of(layout, scans, scan_ns) if rack is None else rack.scenario
    file = folder.save(name, orders.scenario(scan_ns), in_use(job))
    if rack is not None and rack.confirmed:
        with suppress(CpuFault):  # a fault ends the recording
            record(job, rack, file.with_name(SCENARIO_TRACE))
    return file
