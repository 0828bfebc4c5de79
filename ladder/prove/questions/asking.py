"""Answers questions about truths: random scans answer most, the solver many others without a history.

Induction decides some of the rest: first alone, then with invariants, which take most of the time. They are
found once for all questions that are left. Proofs hold for any values of numbers that nothing writes, so no
finding depends on a recipe. The contracts of modules hold, as they do for properties.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from scanrack.io_images.site import Site

from ..algebra.terms import FALSE, TRUE, T, variables
from ..certificate import Certificate
from ..induction import Limits, Verdict, VerdictKind, prove
from ..solving.frames import Frame
from ..solving.invariants import invariants
from ..solving.runs import Runs
from ..solving.solver import SAT, UNSAT, Solver
from ..system import ProgramSystem, System

PROVED_RULES = ("dead-rung", "dead-leg", "never-on", "stuck", "never-done")
"""Rules that find something by a proof; the others find it by a run."""

RULES = (*PROVED_RULES, "conflict", "fault", "endless")

SCANS, FEWEST_SCANS, RESTART = 300, 30, 15
"""Random scans of each run of the relation: most, least, until it starts again."""

QUIET = 60
"""Random scans that made no further truth true, after which the solver decides about the others."""

MOST_COMPUTED = 1_000_000
"""Terms that all random scans compute; of a large program at least `FEWEST_SCANS`."""


@dataclass(frozen=True, slots=True)
class QuestionLimits:
    """Limits of questions.

    Attributes:
        each: for one question.
        rule: the work for all questions of a rule, see `Solver`; what is left then is open.
        states: maximum states of a question that gets invariants: twice as many take ten times as long.
    """

    each: Limits
    rule: int
    states: int

    def times(self, factor: int) -> QuestionLimits:
        """Return multiples of the limits."""
        return QuestionLimits(self.each.times(factor), self.rule * factor, self.states * factor)


LIMITS = QuestionLimits(Limits(scans=5, k=2, work=1_000_000, fuse=32_000), rule=30_000_000, states=40)


@dataclass(frozen=True, slots=True)
class Question:
    """Whether a truth, of the values before a scan, can ever hold.

    Attributes:
        rule: the rule that reports it if the truth can't hold, or if it can.
        site: the instruction or rung.
        text: what is found, in words.
        bad: the truth.
        lives: a truth that must be able to hold; otherwise another finding covers this one.
        fault: the site of the major fault that it is, or None.
        coils: numbers of the instructions that disagree.
    """

    rule: str
    site: Site
    text: str
    bad: T
    lives: T = TRUE
    fault: Site | None = None
    coils: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Finding:
    """An answer worth a line; see `Question`."""

    rule: str
    site: Site
    text: str
    verdict: Verdict
    coils: tuple[int, ...] = ()


@dataclass(slots=True)
class Answers:
    """The findings, and the numbers of questions and of open questions by rule."""

    findings: list[Finding] = field(default_factory=list)
    counts: Counter[str] = field(default_factory=Counter)
    open: Counter[str] = field(default_factory=Counter)


class Listener:
    """Receives answers as they come, the cheap ones first."""

    def begun(self, count: int) -> None:
        """Receive the number of questions."""

    def found(self, finding: Finding) -> None:
        """Receive a finding."""

    def left(self, count: int, spent: int, most: int) -> None:
        """Receive how many questions are left for invariants, the work so far, and the most to come."""

    def next(self, question: Question, count: int) -> None:
        """Receive the next question that is left, and the number of questions after it."""


Seen = Callable[[Sequence[T]], set[T]]
"""Returns which of some truths a run that is known makes true."""


def answered(
    problem: ProgramSystem,
    questions: Sequence[Question],
    limits: QuestionLimits = LIMITS,
    seen: Seen | None = None,
    listener: Listener | None = None,
) -> Answers:
    """Answer questions; the findings are in the order of the questions.

    Args:
        limits: questions beyond them stay open.
        seen: returns what a run of the program does, such as a rack's own; called after the random scans.
        listener: receives the findings in the order in which they are made.
    """
    truths = [each.bad for each in questions]
    asking = _prepared(problem, limits, truths)
    asking.listener = listener or Listener()
    asking.listener.begun(len(dict.fromkeys(map(_key, questions))))
    if seen is not None:
        proved = [each.bad for each in questions if each.rule in PROVED_RULES and each.bad.op != "const"]
        asking.possible |= seen([t for t in dict.fromkeys(proved) if t not in asking.possible])
    return asking.answers(questions)


def impossible(problem: ProgramSystem, truths: Sequence[T], limits: QuestionLimits = LIMITS) -> set[T]:
    """Return the truths that are proved to hold in no scan."""
    asking = _prepared(problem, limits, truths)
    asking.find_impossible(dict.fromkeys(truths, ""))
    return {t for t in dict.fromkeys(truths) if asking.proof("", t)}


def _prepared(problem: ProgramSystem, limits: QuestionLimits, truths: Sequence[T]) -> _Questioning:
    system = any_numbers(problem, truths)
    return _Questioning(problem, limits, _possible(system, truths), system)


@dataclass(slots=True)
class _Questioning:
    """Answers questions.

    Attributes:
        possible: truths that are known to hold in some scan.
        system: the problem with all numbers free that nothing writes.
        impossible: truths that are known to hold in none.
        spent: the work so far, by rule.
    """

    problem: ProgramSystem
    limits: QuestionLimits
    possible: set[T]
    system: System
    found: Answers = field(default_factory=Answers)
    impossible: set[T] = field(default_factory=set)
    spent: Counter[str] = field(default_factory=Counter)
    listener: Listener = field(default_factory=Listener)
    helped: bool = False  # whether invariants are in use by now
    reported: set[tuple[str, Site, str]] = field(default_factory=set)  # questions with a finding
    open: set[tuple[str, Site, str]] = field(default_factory=set)
    findings: dict[int, Finding] = field(default_factory=dict)  # by the place of the question
    later: list[tuple[int, Question]] = field(default_factory=list)  # left for invariants
    undecided: set[tuple[bool, T]] = field(default_factory=set)  # without invariants
    hopeless: set[bool] = field(default_factory=set)  # systems without invariants, as in `undecided`
    dead_rungs: set[tuple[str, int | None]] = field(default_factory=set)
    open_rungs: set[tuple[str, int | None]] = field(default_factory=set)

    def answers(self, questions: Sequence[Question]) -> Answers:
        """Answer all, the cheap ones first."""
        self.found.counts.update(rule for rule, _, _ in dict.fromkeys(map(_key, questions)))
        self.find_impossible({each.bad: each.rule for each in reversed(questions)})
        for place, each in enumerate(questions):
            self._ask(place, each)
        if self.later:
            self.helped = True
            most = min(len(self.later) * self.limits.each.work, len(RULES) * self.limits.rule)
            count = len(self.later)
            self.listener.left(count, sum(self.spent.values()) + len(questions), most)
            for number, (place, each) in enumerate(self._with_invariants(), start=1):
                self.listener.next(each, count - number)
                self._ask(place, each)
        self.found.open.update(rule for rule, _, _ in self.open - self.reported)
        self.found.findings = [self.findings[place] for place in sorted(self.findings)]
        return self.found

    def _ask(self, place: int, question: Question) -> None:
        """Answer a question, or leave it for invariants."""
        rule, at = question.rule, (question.site.routine, question.site.rung)
        if (rule == "dead-leg" and at in self.dead_rungs) or _key(question) in self.reported:
            return
        if rule == "dead-leg" and at in self.open_rungs:
            self.later.append((place, question))
            return
        verdict = self.proof(rule, question.bad) if rule in PROVED_RULES else self._run(question)
        if verdict.kind is VerdictKind.UNKNOWN:
            self._leave(place, question)
        elif (verdict.kind is VerdictKind.PROVED) is (rule in PROVED_RULES):
            if self._can_be(question):
                found = Finding(rule, question.site, question.text, verdict, question.coils)
                self.findings[place] = found
                self.reported.add(_key(question))
                self.listener.found(found)
            if rule == "dead-rung":
                self.dead_rungs.add(at)

    def _leave(self, place: int, question: Question) -> None:
        if self.helped or not self.limits.each.helped:
            self.open.add(_key(question))
            return
        self.later.append((place, question))
        if question.rule == "dead-rung":
            self.open_rungs.add((question.site.routine, question.site.rung))

    def _with_invariants(self) -> Iterator[tuple[int, Question]]:
        """Yield the questions that are left, with invariants for each of both systems."""
        self.open_rungs.clear()
        later, self.later = self.later, []
        own = [(each, each.contract, each.kept) for each in (self.system, self.problem)]
        try:
            for system, is_proved in ((self.system, True), (self.problem, False)):
                truths = [each.bad for _, each in later if (each.rule in PROVED_RULES) is is_proved]
                few = [t for t in truths if self._gets_invariants(system, t)]
                if few:
                    system.contract, system.kept = system.narrowed(few), []
                    cone = system.cone(few)
                    known = invariants(system, cone, self.limits.each.fuse)
                    system.invariants[system.contract, frozenset(cone)] = known
                if not few or not known.found:
                    self.hopeless.add(system is self.system)
            yield from later
        finally:
            for system, contract, kept in own:
                system.contract, system.kept = contract, kept

    def _gets_invariants(self, system: System, t: T) -> bool:
        """Whether some states decide a truth, contracts apart, but not too many."""
        own, system.contract = system.contract, TRUE
        try:
            return 0 < sum(name in system.next for name in system.cone([t])) <= self.limits.states
        finally:
            system.contract = own

    def find_impossible(self, rules: Mapping[T, str]) -> None:
        """Find the truths that no state and input makes true, whatever came before.

        Args:
            rules: of each truth the rule that its work counts for.
        """
        if not prove(self.system, FALSE, replace(self.limits.each, replays=False)):
            return  # the relation does not follow the program
        solver, frame = self._any_scan(rules)
        for t, rule in rules.items():
            if t is FALSE:
                self.impossible.add(t)
            elif frame is not None and t not in self.possible and self.spent[rule] < self.limits.rule:
                before = solver.work
                if solver.check(frame.term(t)) == UNSAT:
                    self.impossible.add(t)
                self.spent[rule] += solver.work - before

    def _any_scan(self, truths: Iterable[T]) -> tuple[Solver, Frame | None]:
        """Return a scan from any state that keeps the contracts; None if there may be none."""
        system, solver = self.system, Solver(self.limits.each.fuse)
        own, system.contract = system.contract, system.narrowed(truths)
        try:
            frame = Frame(system, solver)
        finally:
            system.contract = own
        return solver, frame if solver.check() == SAT else None

    def proof(self, rule: str, t: T) -> Verdict:
        """Decide whether a truth never holds."""
        if t in self.impossible:
            return Verdict(VerdictKind.PROVED, certificates=(self._certificate(t),))
        if t in self.possible:
            return Verdict(VerdictKind.REFUTED)
        each = self.limits.each
        scans = min(each.scans, each.k + 1)  # a run that refutes it is no finding
        return self._decided(self.system, rule, t, replace(each, scans=scans, replays=False))

    def _certificate(self, t: T) -> Certificate:
        """Return that of a truth that no state makes true."""
        system = self.system
        own, system.contract = system.contract, system.narrowed([t])
        try:
            return Certificate.of(system, "what is asked", t, 0)
        finally:
            system.contract = own

    def _run(self, question: Question) -> Verdict:
        if question.bad in self.impossible:
            return Verdict(VerdictKind.PROVED)
        return self._decided(self.problem, question.rule, question.bad, self.limits.each, question.fault)

    def _decided(self, system: System, rule: str, t: T, limits: Limits, fault: Site | None = None) -> Verdict:
        if self.spent[rule] >= self.limits.rule:
            return Verdict(blame=(f"the limit of work for all questions of {rule or 'a program'}",))
        place = system is self.system
        helped = self.helped and place not in self.hopeless and self._gets_invariants(system, t)
        if self.helped and not helped and (place, t) in self.undecided:
            return Verdict(blame=("no invariants are in use",))
        verdict = prove(system, t, replace(limits, helped=helped), fault=fault)
        if verdict.kind is VerdictKind.UNKNOWN:
            self.undecided.add((place, t))
        self.spent[rule] += 1 + min(verdict.work, limits.work)
        if verdict.kind is not VerdictKind.UNKNOWN and system is self.system:
            (self.impossible if verdict else self.possible).add(t)
        return verdict

    def _can_be(self, question: Question) -> bool:
        t = question.lives
        return t is TRUE or self.proof(question.rule, t).kind is not VerdictKind.PROVED


def _key(question: Question) -> tuple[str, Site, str]:
    """Return the identity of a question, the same in every pass of a loop."""
    return question.rule, question.site, question.text


def any_numbers(problem: ProgramSystem, roots: Sequence[T] = ()) -> System:
    """Return the problem with all numbers, and bits of numbers, free that terms read and nothing writes."""
    return System(
        next=problem.next_of_any(roots),
        initial=problem.initial,
        held={name for name in problem.held if name.startswith(("~", "S:"))},
        late=problem.late,
        contract=problem.contract,
        kept=problem.kept,
        likely=problem.likely,
        deep=problem.deep,
        havocs=problem.havocs,
        key_of=problem.key_of,
        least=problem.least,
        tick_ns=problem.tick_ns,
    )


def _possible(system: System, truths: Sequence[T]) -> set[T]:
    """Return truths that random scans from power-up made true, with the contracts of modules kept."""
    watched = [t for t in dict.fromkeys(truths) if t.op != "const"]
    own, system.contract = system.contract, system.narrowed(watched)
    try:
        cone = {v.val: v for v in variables([*system.next.values(), *watched, system.contract])}
        seen = _seen(Runs(system, cone, watched, seed=1), len(watched))
    finally:
        system.contract = own
    return {t for t in truths if t is TRUE} | {t for t, truth in zip(watched, seen, strict=True) if truth}


def _seen(runs: Runs, count: int) -> list[bool]:
    """Return which of the watched truths some run has made true."""
    seen, since = [False] * count, 0
    for number in range(max(FEWEST_SCANS, min(SCANS, MOST_COMPUTED // (runs.size + 1)))):
        if all(seen) or since == QUIET:
            break
        if number and number % RESTART == 0:
            runs.restart()
        watched, kept = runs.scan()
        before = sum(seen)
        seen = [truth or bool((now & kept).any()) for truth, now in zip(seen, watched, strict=True)]
        since = since + 1 if sum(seen) == before else 0
    return seen
