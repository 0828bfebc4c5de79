"""Decide which conditions of a program can be true in a scan; the cheapest method comes first.

1. A few random scans make most of the possible conditions true. 2. The solver finds the conditions that no
state, reachable or not, and no input makes true. 3. More random scans, and a run that the caller provides. 4.
Inductions of all remaining conditions at once; see `joint`. 5. For each condition separately, a run that the
compiled program confirms, or an induction with invariants.

Proofs are valid for any values of numbers that nothing writes, so no proof depends on a recipe. They
assume the contracts of modules, as proofs of properties do.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import compress

from scanrack.io_images.site import Site

from ..algebra.batch import LANES
from ..algebra.terms import FALSE, TRUE, T
from ..certificate import Certificate
from ..induction import Limits, Verdict, VerdictKind, prove
from ..joint import decide_jointly, satisfiable
from ..solving.frames import Frame
from ..solving.invariants import invariants
from ..solving.runs import Runs
from ..solving.solver import SAT, Solver
from ..system import ProgramSystem, System

FIRST_SCANS, FEWEST_SCANS, SCANS, RESTART = 4, 30, 75, 15
"""Numbers of random scans: before the first use of the solver, maximum for large programs, maximum for small
programs, and per run."""

QUIET = 20
"""Number of random scans without a new result after which the solver decides the remaining conditions."""

MANY_LANES = 4 * LANES
"""Number of parallel runs of a program that is not large; fewer would save little time."""

MOST_TERMS = 10_000
"""Maximum number of terms in a scan with `MANY_LANES` parallel runs."""

MOST_COMPUTED = 1_000_000
"""Maximum number of terms that all random scans compute; a large program still gets `FEWEST_SCANS`."""


@dataclass(frozen=True, slots=True)
class QuestionLimits:
    """Limits for questions.

    Attributes:
        each: limits for one question.
        rule: work limit for all questions of a rule (see `Solver`); later questions stay open.
        states: maximum number of states in a question for which invariants are searched. With twice as many
            states, the search takes ten times as long.
    """

    each: Limits
    rule: int
    states: int

    def times(self, factor: int) -> QuestionLimits:
        """Return the limits multiplied by a factor."""
        return QuestionLimits(self.each.times(factor), self.rule * factor, self.states * factor)


KnownRun = Callable[[Sequence[T]], set[T]]
"""Returns which of the given conditions a known run makes true."""


class TruthDecider:
    """Decides conditions on the values before a scan.

    Args:
        problem: a program.
        limits: work limits; conditions that need more stay open.
        rules: the rule of each condition; the work on a condition counts against its rule's limit.

    Attributes:
        system: the problem, in which all numbers that nothing writes are free.
        possible: conditions that some scan makes true.
        impossible: the verdict on each condition that no scan makes true, with certificates added by `never`.
        impossible_held: conditions that no scan makes true while unwritten numbers keep their values.
        spent: the work so far, by rule.
    """

    def __init__(self, problem: ProgramSystem, limits: QuestionLimits, rules: Mapping[T, str]) -> None:
        self.problem, self.limits, self.rules = problem, limits, rules
        self.system = any_numbers(problem, list(rules))
        self.possible: set[T] = {TRUE} & rules.keys()
        self.impossible: dict[T, Verdict] = {}
        self.impossible_held: set[T] = set()
        self.spent: Counter[str] = Counter()
        self._random = _RandomScans(self.system, [truth for truth in rules if truth.op != "const"])
        self._with_invariants = False
        self._undecided: set[tuple[bool, T]] = set()  # without invariants: whether in `system`, condition
        self._without_invariants: set[bool] = set()  # systems that have no invariants

    @property
    def open(self) -> list[T]:
        """The conditions that are undecided so far."""
        return [truth for truth in self.rules if truth not in self.possible and truth not in self.impossible]

    # --- all conditions at once

    def scan_at_random(self, most: int = SCANS) -> None:
        """Run random scans from power-up until their total number reaches a limit."""
        self.possible |= self._random.scan(most)

    def find_impossible(self) -> None:
        """Find the conditions that no state, reachable or not, and no input makes true."""
        if FALSE in self.rules:
            self._note_impossible([FALSE], 0)
        if not self._follows(self.system):
            return
        solver = Solver(self.limits.each.fuse)
        affordable = [truth for truth in self.open if self.spent[self.rules[truth]] < self.limits.rule]
        with self.system.narrowing(affordable):
            scan = Frame(self.system, solver)
        if solver.check() != SAT:
            return  # perhaps no scan satisfies the contracts
        possible, gave_up = satisfiable(solver, {truth: scan.term(truth) for truth in affordable})
        self._note_impossible(
            [truth for truth in affordable if truth not in possible and truth not in gave_up], 0
        )
        self._charge(affordable, solver.work)

    def prove_jointly(self, truths: Iterable[T], *, held: bool = False) -> None:
        """Try an induction of many conditions at once.

        Args:
            held: whether numbers that nothing writes keep their values.
        """
        system = self.problem if held else self.system
        affordable = [
            candidate
            for candidate in truths
            if candidate is not system.deep and self.spent[self.rules[candidate]] < self.limits.rule
        ]
        if not affordable or not self._follows(system):
            return
        answers = decide_jointly(system, affordable, self._limits(held=held))
        self._charge(affordable, answers.work)
        if held:
            self.impossible_held |= answers.proved.keys()
        else:
            for truth, k in answers.proved.items():
                self._note_impossible([truth], k)
            self.possible |= answers.broken
        decided = answers.proved.keys() | answers.broken | answers.gave_up
        self._undecided |= {(not held, candidate) for candidate in affordable if candidate not in decided}

    def _note_impossible(self, truths: Iterable[T], k: int) -> None:
        """Record that induction over `k` scans, without invariants, has proved conditions impossible."""
        for truth in truths:
            self.impossible[truth] = Verdict(VerdictKind.PROVED, k)

    def _charge(self, truths: Sequence[T], work: int) -> None:
        """Add work to the totals of the conditions' rules, in equal shares for all conditions."""
        for truth in truths:
            self.spent[self.rules[truth]] += 1 + work // len(truths)

    def _limits(self, *, held: bool) -> Limits:
        """Return one condition's limits; with free numbers, runs don't count, so the search is short."""
        limits = replace(self.limits.each, helped=False)
        return limits if held else replace(limits, scans=min(limits.scans, limits.k + 1), replays=False)

    def _follows(self, system: System) -> bool:
        """Return whether the relation agrees with the program, as each proof requires."""
        return bool(prove(system, FALSE, replace(self.limits.each, replays=False)))

    # --- one condition

    def known(self, t: T) -> VerdictKind:
        """Return the known verdict on a condition, for any values of numbers that nothing writes."""
        if t in self.impossible:
            return VerdictKind.PROVED
        return VerdictKind.REFUTED if t in self.possible else VerdictKind.UNKNOWN

    def never(self, t: T) -> Verdict:
        """Return the verdict on whether a condition is never true, with certificates; cache the verdict."""
        if t in self.possible:
            return Verdict(VerdictKind.REFUTED)
        verdict = self.impossible.get(t)
        if verdict is None:
            verdict = self._decide(self.system, t, self._limits(held=False))
            if verdict.kind is VerdictKind.PROVED:
                self.impossible[t] = verdict
            elif verdict.kind is VerdictKind.REFUTED:
                self.possible.add(t)
        elif not verdict.certificates:
            verdict.certificates = self._certificates(t, verdict.k)
        return verdict

    def _certificates(self, t: T, k: int) -> tuple[Certificate, ...]:
        """Return the certificates for a condition that an induction without invariants has proved."""
        with self.system.narrowing([t]):
            certificate = Certificate.of(self.system, "what is asked", t, k)
        follows = self.system.follows
        return certificate, *(follows.certificates if follows and t is not self.system.deep else ())

    def find_run(self, t: T, fault: Site | None = None) -> Verdict:
        """Decide whether a run of the program makes a condition true; see `prove` for `fault`."""
        if t in self.impossible or t in self.impossible_held:
            return Verdict(VerdictKind.PROVED)
        return self._decide(self.problem, t, self._limits(held=True), fault)

    def _decide(self, system: System, t: T, limits: Limits, fault: Site | None = None) -> Verdict:
        """Prove or refute a condition within its rule's limit; skip it if only invariants could help."""
        rule, is_free = self.rules.get(t, ""), system is self.system
        if self.spent[rule] >= self.limits.rule:
            return Verdict(blame=(f"the limit of work for all questions of {rule or 'a program'}",))
        helped = (
            self._with_invariants
            and is_free not in self._without_invariants
            and self._gets_invariants(system, t)
        )
        if not helped and (is_free, t) in self._undecided:
            return Verdict(blame=("no invariants are in use",))
        verdict = prove(system, t, replace(limits, helped=helped), fault=fault)
        if verdict.kind is VerdictKind.UNKNOWN:
            self._undecided.add((is_free, t))
        self.spent[rule] += 1 + min(verdict.work, limits.work)
        return verdict

    # --- invariants

    @contextmanager
    def with_invariants(self, free: Iterable[T], held: Iterable[T]) -> Iterator[None]:
        """Find invariants for conditions of both systems, and let proofs use them.

        Args:
            free: conditions to be proved for any numbers.
            held: conditions for which a run is searched.
        """
        saved = [(relation, relation.contract, relation.kept) for relation in (self.system, self.problem)]
        self._with_invariants = True
        try:
            for system, truths in ((self.system, free), (self.problem, held)):
                few = [truth for truth in truths if self._gets_invariants(system, truth)]
                if not few or not self._find_invariants(system, few):
                    self._without_invariants.add(system is self.system)
            yield
        finally:
            for system, contract, contracts in saved:
                system.contract, system.kept = contract, contracts

    def _find_invariants(self, system: System, truths: Sequence[T]) -> bool:
        """Find invariants for conditions, under the part of the contract that affects them."""
        system.contract, system.kept = system.narrowed(truths), []
        cone = system.cone(truths)
        found = invariants(system, cone, self.limits.each.fuse)
        system.invariants[system.contract, frozenset(cone)] = found
        return bool(found.found)

    def _gets_invariants(self, system: System, t: T) -> bool:
        """Return whether a condition depends on states, but not on too many. Contracts do not count."""
        contract, system.contract = system.contract, TRUE
        try:
            return 0 < sum(name in system.next for name in system.cone([t])) <= self.limits.states
        finally:
            system.contract = contract


def any_numbers(problem: ProgramSystem, roots: Sequence[T] = ()) -> System:
    """Return the problem as a system in which all numbers and bits that nothing writes are free."""
    return System(
        next=problem.next_of_any(roots),
        initial=problem.initial,
        held={name for name in problem.held if name.startswith(("~", "S:"))},
        late=problem.late,
        contract=problem.contract,
        kept=problem.kept,
        likely=problem.likely,
        deep=problem.deep,
        unmodeled=problem.unmodeled,
        key_of=problem.key_of,
        least=problem.least,
        tick_ns=problem.tick_ns,
        variables_known=problem.variables_known,
    )


class _RandomScans:
    """Random scans of a system from power-up that satisfy the module contracts.

    Args:
        watched: the conditions to observe.
    """

    def __init__(self, system: System, watched: Sequence[T]) -> None:
        self._watched = watched
        self._was_true = [False] * len(watched)
        self._scan_count = self._scans_without_news = 0
        with system.narrowing(watched):
            cone = system.cone(watched)
            self._runs = Runs(system, cone, watched, seed=1, lanes=MANY_LANES)
            if self._runs.size > MOST_TERMS:
                self._runs = Runs(system, cone, watched, seed=1)
        self._most = max(FEWEST_SCANS, min(SCANS, MOST_COMPUTED // (self._runs.size + 1)))

    def scan(self, most: int) -> set[T]:
        """Run scans until their total reaches a limit; return the conditions that were true in some scan."""
        while (
            self._scan_count < min(most, self._most)
            and self._scans_without_news < QUIET
            and not all(self._was_true)
        ):
            if self._scan_count and self._scan_count % RESTART == 0:
                self._runs.restart()
            truths, keeps_contract = self._runs.scan()
            count_before = sum(self._was_true)
            self._was_true = [
                seen or bool((truth_values & keeps_contract).any())
                for seen, truth_values in zip(self._was_true, truths, strict=True)
            ]
            self._scan_count += 1
            self._scans_without_news = (
                0 if sum(self._was_true) > count_before else self._scans_without_news + 1
            )
        return set(compress(self._watched, self._was_true))
