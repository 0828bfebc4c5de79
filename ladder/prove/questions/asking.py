"""Answer the built-in questions about a program, cheapest first.

Three rounds report findings: random scans and a single scan from any state, then inductions, then inductions
with invariants. Invariants take most of the time, so they are found once for all open questions.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

from scanrack.io_images.site import Site

from ..algebra.terms import TRUE, T
from ..induction import Limits, Verdict, VerdictKind
from ..system import ProgramSystem
from .deciding import FIRST_SCANS, KnownRun, QuestionLimits, TruthDecider

PROVED_RULES = ("dead-rung", "dead-leg", "never-on", "stuck", "never-done")
"""Rules whose findings are proofs; findings of other rules are runs."""

RULES = (*PROVED_RULES, "conflict", "fault", "endless")

LIMITS = QuestionLimits(Limits(scans=5, k=2, work=1_000_000, fuse=32_000), rule=30_000_000, states=40)


QuestionKey = tuple[str, Site, str]
"""The rule, site and text of a question."""

Rung = tuple[str, int | None]
"""A routine, and the number of a rung in it."""


@dataclass(frozen=True, slots=True)
class Question:
    """A question: can a condition on the values before a scan ever be true?

    Attributes:
        rule: the rule. It reports a finding either if the condition can be true, or if it can't be true.
        site: the instruction or rung.
        text: the finding, in words.
        bad: the condition.
        lives: a condition that must be possible; if it is impossible, another finding covers this question.
        fault: the site of the major fault that `bad` describes, or None.
        coils: numbers of the instructions that disagree.
    """

    rule: str
    site: Site
    text: str
    bad: T
    lives: T = TRUE
    fault: Site | None = None
    coils: tuple[int, ...] = ()

    @property
    def key(self) -> QuestionKey:
        """The identity of a question. It is the same in every pass of a loop."""
        return self.rule, self.site, self.text

    @property
    def is_proof(self) -> bool:
        """Whether the finding is a proof; otherwise it is a run."""
        return self.rule in PROVED_RULES


@dataclass(frozen=True, slots=True)
class Finding:
    """An answer to report; see `Question`."""

    rule: str
    site: Site
    text: str
    verdict: Verdict
    coils: tuple[int, ...] = ()


@dataclass(slots=True)
class Answers:
    """The findings, and the numbers of questions and open questions by rule."""

    findings: list[Finding] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    open: Counter[str] = field(default_factory=Counter)


Found = TypeVar("Found")
"""Type of a finding that a listener receives."""


class Listener(Generic[Found]):
    """Receives answers as they are found, cheap answers first."""

    def begun(self, count: int) -> None:
        """Receive the number of questions."""

    def found(self, answer: Found) -> None:
        """Receive a finding."""

    def left(self, count: int) -> None:
        """Receive the number of open questions after the first round, and again after the inductions."""

    def next(self, question: Question, count: int) -> None:
        """Receive the next open question, and the number of questions after it."""


def find_impossible(problem: ProgramSystem, truths: Sequence[T], limits: QuestionLimits = LIMITS) -> set[T]:
    """Return the conditions that are proved never to be true in a scan."""
    decider = TruthDecider(problem, limits, dict.fromkeys(truths, ""))
    decider.scan_at_random()
    decider.find_impossible()
    decider.prove_jointly(decider.open)
    return {truth for truth in dict.fromkeys(truths) if decider.never(truth)}


class Questioning:
    """Asks questions in rounds."""

    def __init__(
        self,
        problem: ProgramSystem,
        questions: Sequence[Question],
        limits: QuestionLimits,
        listener: Listener[Finding],
    ) -> None:
        self._questions, self._limits, self._listener = questions, limits, listener
        # reversed, so that of questions about one condition, the first one gives the rule
        rules = {question.bad: question.rule for question in reversed(questions)}
        self._decider = TruthDecider(problem, limits, rules)
        self._open = dict(enumerate(questions))  # by index of the question
        self._findings: dict[int, Finding] = {}  # by index of the question
        self._reported: set[QuestionKey] = set()  # questions with a finding
        self._dead_rungs: set[Rung] = set()
        self._remaining = 0  # number of questions after the current one

    def answers(self, known_run: KnownRun | None) -> Answers:
        """Answer all questions; return the findings in question order."""
        answers, decider = Answers(), self._decider
        unique_keys = dict.fromkeys(question.key for question in self._questions)
        answers.counts.update(rule for rule, _, _ in unique_keys)
        self._listener.begun(sum(answers.counts.values()))
        decider.scan_at_random(FIRST_SCANS)
        decider.find_impossible()
        self._ask(self._without_solver)
        if self._open:
            self._listener.left(self._count_left())
            self._decide_by_induction(known_run)
        if self._open and self._limits.each.helped:
            self._listener.left(self._count_left())
            self._decide_with_invariants()
        open_keys = {question.key for question in self._open.values()} - self._reported
        answers.open.update(rule for rule, _, _ in open_keys)
        answers.findings = [self._findings[index] for index in sorted(self._findings)]
        return answers

    def _decide_by_induction(self, known_run: KnownRun | None) -> None:
        """Decide questions using more scans, a known run and inductions."""
        decider = self._decider
        decider.scan_at_random()
        proofs = set(self._truths(is_proof=True))
        if known_run is not None:
            decider.possible |= known_run([truth for truth in decider.open if truth in proofs])
        decider.prove_jointly([truth for truth in decider.open if truth in proofs])
        self._ask(self._without_solver)
        runs = dict.fromkeys(self._truths(is_proof=False))
        decider.prove_jointly([truth for truth in runs if truth not in decider.impossible], held=True)
        self._ask(self._with_solver, is_last=not self._limits.each.helped)

    def _decide_with_invariants(self) -> None:
        free, held = self._truths(is_proof=True), self._truths(is_proof=False)
        with self._decider.with_invariants(free, held):
            self._ask(self._with_solver, is_last=True)

    def _truths(self, *, is_proof: bool) -> list[T]:
        """Return the conditions of the open questions that a proof answers, or otherwise a run."""
        return [question.bad for question in self._open.values() if question.is_proof is is_proof]

    def _count_left(self) -> int:
        return len({question.key for question in self._open.values()} - self._reported)

    def _ask(self, verdict_on: Callable[[Question], Verdict], *, is_last: bool = False) -> None:
        """Ask the open questions. Questions about legs of a possibly dead rung wait for the next round."""
        waiting: set[Rung] = set()
        self._remaining = len(self._open)
        for index, question in [*self._open.items()]:
            self._remaining -= 1
            rung, is_leg = (question.site.routine, question.site.rung), question.rule == "dead-leg"
            if question.key in self._reported or (is_leg and rung in self._dead_rungs):
                del self._open[index]
                continue
            verdict = Verdict() if is_leg and rung in waiting else verdict_on(question)
            if verdict.kind is not VerdictKind.UNKNOWN:
                del self._open[index]
                if (verdict.kind is VerdictKind.PROVED) is question.is_proof:
                    self._report(index, question, verdict)
            elif question.rule == "dead-rung" and not is_last:
                waiting.add(rung)

    def _report(self, index: int, question: Question, verdict: Verdict) -> None:
        """Report an answer, unless another finding covers it."""
        if question.rule == "dead-rung":
            self._dead_rungs.add((question.site.routine, question.site.rung))
        if question.lives is TRUE or not self._decider.never(question.lives):
            finding = Finding(question.rule, question.site, question.text, verdict, question.coils)
            self._findings[index] = finding
            self._reported.add(question.key)
            self._listener.found(finding)

    def _without_solver(self, question: Question) -> Verdict:
        """Return the verdict on a question without using the solver; unknown if it is needed."""
        verdict_kind = self._decider.known(question.bad)
        if not question.is_proof:
            return Verdict(verdict_kind if verdict_kind is VerdictKind.PROVED else VerdictKind.UNKNOWN)
        if verdict_kind is VerdictKind.UNKNOWN or (
            verdict_kind is VerdictKind.PROVED
            and question.lives is not TRUE
            and self._decider.known(question.lives) is VerdictKind.UNKNOWN
        ):
            return Verdict()
        return self._decider.never(question.bad)

    def _with_solver(self, question: Question) -> Verdict:
        """Decide a single question."""
        verdict = self._without_solver(question)
        if verdict.kind is not VerdictKind.UNKNOWN:
            return verdict
        self._listener.next(question, self._remaining)
        if question.is_proof:
            return self._decider.never(question.bad)
        return self._decider.find_run(question.bad, question.fault)
