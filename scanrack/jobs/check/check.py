"""Checks a rack and its program: facts, rules, and suppressions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

from scanrack.io_images.drives.models import Model
from scanrack.io_images.site import Site, sites_of
from scanrack.ladder import LadderLogic
from scanrack.ladder.files.steps import Steps
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.config.rackfile import load_rack_file

from ..load.loading import LoadedRack, rack_form
from ..load.program import Form
from .facts import Facts, FileLine
from .python.functions import python_facts
from .python.sequences import sequence_facts
from .replacing import RULE, replaced
from .rules import BY_ID, RULES, Rule
from .rules.rack import terminals
from .rungs.program import ladder_facts
from .step_list import step_facts
from .subject import Subject
from .suppressions import Suppressions

_TOO_DEEP = "the program has an expression that is nested too deep: only the rack file is checked"


@dataclass(frozen=True, slots=True)
class Finding:
    """A rule that a rack breaks."""

    rule: str
    place: FileLine
    text: str
    site: Site

    @property
    def row(self) -> Rule:
        """The row of the rule in the table of rules."""
        return BY_ID[self.rule]

    def __str__(self) -> str:
        rung = "" if self.site.rung is None else f" ({self.site.routine}, {self.site.place})"
        return f"{self.place.file}:{self.place.line}: {self.rule}: {self.text}{rung}; {self.row.remedy}"


@dataclass(frozen=True, slots=True)
class CheckReport:
    """The result of a check."""

    findings: tuple[Finding, ...]
    not_seen: tuple[str, ...]  # what the check can't determine, one text each
    ignored: int = 0  # findings that comments suppress


@dataclass(frozen=True, slots=True)
class ProofFinding:
    """A proof's verdict that confirms or refutes a finding of a rule.

    Attributes:
        rule: name of the rule, such as "unreachable".
        holds: whether the proof confirms the finding; otherwise it refutes the finding.
        text: the finding's text, used if the rule reports nothing at this place.
    """

    rule: str
    place: FileLine
    holds: bool
    text: str = ""


Prover = Callable[[LoadedRack, Facts], Iterable[ProofFinding]]
"""Yields the verdicts of proofs about a rack's program and its facts."""


def check_replacement(job: LoadedRack, model: Model, *, alone: bool = False) -> CheckReport:
    """List the changes a 3601 program needs for a networked drive; raise LadderError as in `check_rack`."""
    facts = facts_of(job)
    violations = (
        Finding(RULE, place, text, _site(facts, place))
        for place, text in replaced(Subject(job, facts, None, alone), model)
    )
    return CheckReport(tuple(violations), tuple(facts.not_seen))


def check_rack(job: LoadedRack, *, alone: bool = False, prover: Prover | None = None) -> CheckReport:
    """Check a rack and its program statically; raise LadderError if the program can't be built.

    Args:
        alone: check the program without a rack. Rules about wiring then do not apply.
        prover: yields verdicts on rungs and tags. The report marks proved findings and omits refuted ones.
    """
    facts = facts_of(job)
    is_toml = not alone and rack_form(job.rack_file) is Form.DATA
    lines = load_rack_file(job.rack_file).lines if is_toml else None
    subject = Subject(job, facts, lines, alone)
    findings = list(_findings(subject))
    if prover is not None:
        findings = list(_with_verdicts(findings, prover(job, facts), facts))
    suppressions = Suppressions(job)
    kept = tuple(finding for finding in findings if not suppressions.ignores(finding.rule, finding.place))
    stubs = (f"behind {stub}" for stub in job.stubs)
    not_seen = (*facts.not_seen, *_unseen_configurations(subject), *stubs)
    return CheckReport(kept, not_seen, len(findings) - len(kept))


def refused(error: Exception, file: str) -> CheckReport:
    """Return the report of a file that can't be loaded: one finding, at the last line that the error names.

    Args:
        file: the file to check. The finding is at its first line if the error names no line.
    """
    sites = [Site(file=file, line=1), *(site for site in sites_of(error) if site.file and site.line)]
    last = sites[-1]
    return CheckReport((Finding("refused", FileLine(last.file, last.line or 1), str(error), last),), ())


def _findings(subject: Subject) -> Iterator[Finding]:
    """Yield the findings, one per rule, place and text, in rule order."""
    facts = subject.facts
    for rule in RULES:
        reported: set[tuple[FileLine, str]] = set()
        violations = (violation for check in rule.checks for violation in check(subject))
        for place, text in chain(facts.remarks.get(rule.id, ()), violations):
            key = place, "" if rule.id == "out-of-range" else text  # one range finding per line is enough
            if key not in reported:
                reported.add(key)
                yield Finding(rule.id, place, text, _site(facts, place))


def _with_verdicts(
    findings: list[Finding], verdicts: Iterable[ProofFinding], facts: Facts
) -> Iterator[Finding]:
    """Yield the findings that no proof refutes, then proved findings at lines without a finding."""
    unused = {(verdict.rule, verdict.place): verdict for verdict in verdicts}
    for finding in findings:
        verdict = unused.pop((finding.rule, finding.place), None)
        if verdict is None:
            yield finding
        elif verdict.holds:
            yield replace(finding, text=f"{finding.text} (proved)")
    places_with_finding = {finding.place for finding in findings}
    for verdict in unused.values():
        place = verdict.place
        if verdict.holds and place not in places_with_finding:
            yield Finding(verdict.rule, place, f"{verdict.text} (proved)", _site(facts, place))


def _site(facts: Facts, place: FileLine) -> Site:
    """Return the routine and rung of a line, if it belongs to a routine."""
    return facts.sites.get(place) or Site(file=place.file, line=place.line)


def facts_of(job: LoadedRack) -> Facts:
    """Return the facts of a rack's program."""
    if isinstance(job.logic, LadderLogic):
        return ladder_facts(job.logic, job.program, job.spec)
    if job.program.suffix == ".py":
        try:
            return _python_facts(job)
        except RecursionError:  # Python compiles sums of hundreds of terms that `ast` can't print
            return Facts(not_seen=[_TOO_DEEP])
    logic: object = job.logic
    return step_facts(job.program, logic) if isinstance(logic, Steps) else Facts()


def _python_facts(job: LoadedRack) -> Facts:
    if isinstance(job.logic, Logic):
        return sequence_facts(job.program, job.logic, job.spec)
    names = {name for slot in job.spec.slot for _, _, name, _ in terminals(slot)}
    return python_facts(job.program, _globals_of(job.logic), names, job.spec)


def _globals_of(logic: object) -> Mapping[str, Any]:
    """Return the global names of the module that defines a function, method, partial or callable object."""
    called = getattr(logic, "func", logic)  # for functools.partial
    function = called if hasattr(called, "__globals__") else vars(type(called)).get("__call__")
    names: Mapping[str, Any] = getattr(getattr(called, "__func__", function), "__globals__", {})
    return names


def _unseen_configurations(subject: Subject) -> Iterator[str]:
    for _, slot in subject.steppers:
        if not subject.sent_to(slot.number, subject.facts.configurations):
            yield f"slot {slot.number}: no configuration in constants, so its inputs are not checked"
