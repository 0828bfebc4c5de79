"""Decides which truths of a program can hold in a scan, the cheapest way first.

1. A few random scans make most truths true that can be.
2. The solver finds those that no state and input makes true, whatever came before.
3. Further random scans, and a run that the caller knows.
4. Inductions of all that are left at once, see `joint`.
5. One truth alone: a run of it that the compiled program confirms, or an induction with invariants.

Proofs hold for any values of numbers that nothing writes, so none depends on a recipe. The contracts of
modules hold, as they do for properties.
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
"""Random scans before the solver is used, of a large and of a small program at most, and those of a run."""

QUIET = 20
"""Random scans that made no further truth true, after which the solver decides about the others."""

MANY_LANES = 4 * LANES
"""Runs side by side of a program that is not large: a scan of them takes little longer."""

MOST_TERMS = 10_000
"""Terms of a scan up to which there are many runs side by side."""

MOST_COMPUTED = 1_000_000
"""Terms that all random scans compute; of a large program those of `FEWEST_SCANS`."""


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


KnownRun = Callable[[Sequence[T]], set[T]]
"""Returns which of some truths a run that is known makes true."""


class TruthDecider:
    """Decides truths of the values before a scan.

    Args:
        problem: a program.
        limits: what is beyond them stays open.
        rules: the rule of each truth for which its work counts.

    Attributes:
        system: the problem with all numbers free that nothing writes.
        possible: truths that some scan of the system makes true.
        impossible: the verdict on each truth that none does; `never` adds its certificates.
        impossible_held: truths that no scan makes true while unwritten numbers keep their values.
        spent: the work so far, by rule.
    """

    def __init__(self, problem: ProgramSystem, limits: QuestionLimits, rules: Mapping[T, str]) -> None:
        self.problem, self.limits, self.rules = problem, limits, rules
        self.system = any_numbers(problem, list(rules))
        self.possible: set[T] = {TRUE} & rules.keys()
        self.impossible: dict[T, Verdict] = {}
        self.impossible_held: set[T] = set()
        self.spent: Counter[str] = Counter()
        self._random = _RandomScans(self.system, [t for t in rules if t.op != "const"])
        self._with_invariants = False
        self._undecided: set[tuple[bool, T]] = set()  # without invariants; whether of `system`
        self._without_invariants: set[bool] = set()  # systems for which there are none

    @property
    def open(self) -> list[T]:
        """Truths that are neither possible nor impossible so far."""
        return [t for t in self.rules if t not in self.possible and t not in self.impossible]

    # --- all truths at once

    def scan_at_random(self, most: int = SCANS) -> None:
        """Do random scans from power-up, up to a number of them in all."""
        self.possible |= self._random.scan(most)

    def find_impossible(self) -> None:
        """Find the truths that no state and input makes true, whatever came before."""
        if FALSE in self.rules:
            self._note_impossible([FALSE], 0)
        if not self._follows(self.system):
            return
        solver = Solver(self.limits.each.fuse)
        left = [t for t in self.open if self.spent[self.rules[t]] < self.limits.rule]
        with self.system.narrowing(left):
            scan = Frame(self.system, solver)
        if solver.check() != SAT:
            return  # no scan may keep the contracts
        can, gave_up = satisfiable(solver, {t: scan.term(t) for t in left})
        self._note_impossible([t for t in left if t not in can and t not in gave_up], 0)
        self._charge(left, solver.work)

    def prove_jointly(self, truths: Iterable[T], *, held: bool = False) -> None:
        """Try an induction of many truths at once.

        Args:
            held: whether numbers that nothing writes keep their values.
        """
        system = self.problem if held else self.system
        left = [t for t in truths if t is not system.deep and self.spent[self.rules[t]] < self.limits.rule]
        if not left or not self._follows(system):
            return
        found = decide_jointly(system, left, self._limits(held=held))
        self._charge(left, found.work)
        if held:
            self.impossible_held |= found.proved.keys()
        else:
            for t, k in found.proved.items():
                self._note_impossible([t], k)
            self.possible |= found.broken
        decided = found.proved.keys() | found.broken | found.gave_up
        self._undecided |= {(not held, t) for t in left if t not in decided}

    def _note_impossible(self, truths: Iterable[T], k: int) -> None:
        for t in truths:
            self.impossible[t] = Verdict(VerdictKind.PROVED, k)

    def _charge(self, truths: Sequence[T], work: int) -> None:
        for t in truths:
            self.spent[self.rules[t]] += 1 + work // len(truths)

    def _limits(self, *, held: bool) -> Limits:
        """Return the limits of one truth; with free numbers no run is a finding, so the search is short."""
        each = replace(self.limits.each, helped=False)
        return each if held else replace(each, scans=min(each.scans, each.k + 1), replays=False)

    def _follows(self, system: System) -> bool:
        """Whether the model of a system matches the program, as every proof checks."""
        return bool(prove(system, FALSE, replace(self.limits.each, replays=False)))

    # --- one truth

    def known(self, t: T) -> VerdictKind:
        """Return what is known about a truth for any numbers."""
        if t in self.impossible:
            return VerdictKind.PROVED
        return VerdictKind.REFUTED if t in self.possible else VerdictKind.UNKNOWN

    def never(self, t: T) -> Verdict:
        """Decide whether a truth never holds."""
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
        """Return those of a truth that an induction without invariants has proved."""
        with self.system.narrowing([t]):
            own = Certificate.of(self.system, "what is asked", t, k)
        follows = self.system.follows
        return own, *(follows.certificates if follows and t is not self.system.deep else ())

    def find_run(self, t: T, fault: Site | None = None) -> Verdict:
        """Decide whether a run of the program makes a truth true; see `prove` for `fault`."""
        if t in self.impossible or t in self.impossible_held:
            return Verdict(VerdictKind.PROVED)
        return self._decide(self.problem, t, self._limits(held=True), fault)

    def _decide(self, system: System, t: T, limits: Limits, fault: Site | None = None) -> Verdict:
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
        """Find invariants for truths of both systems, and let proofs use them.

        Args:
            free: truths to be proved for any numbers.
            held: truths whose run is to be found.
        """
        own = [(each, each.contract, each.kept) for each in (self.system, self.problem)]
        self._with_invariants = True
        try:
            for system, truths in ((self.system, free), (self.problem, held)):
                few = [t for t in truths if self._gets_invariants(system, t)]
                if not few or not self._find_invariants(system, few):
                    self._without_invariants.add(system is self.system)
            yield
        finally:
            for system, contract, kept in own:
                system.contract, system.kept = contract, kept

    def _find_invariants(self, system: System, truths: Sequence[T]) -> bool:
        """Find invariants for truths; the contract becomes the part that counts for them."""
        system.contract, system.kept = system.narrowed(truths), []
        cone = system.cone(truths)
        known = invariants(system, cone, self.limits.each.fuse)
        system.invariants[system.contract, frozenset(cone)] = known
        return bool(known.found)

    def _gets_invariants(self, system: System, t: T) -> bool:
        """Whether some states decide a truth, contracts apart, but not too many."""
        own, system.contract = system.contract, TRUE
        try:
            return 0 < sum(name in system.next for name in system.cone([t])) <= self.limits.states
        finally:
            system.contract = own


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
        variables_known=problem.variables_known,
    )


class _RandomScans:
    """Random scans of a system from power-up, with the contracts of modules kept.

    Args:
        watched: truths.
    """

    def __init__(self, system: System, watched: Sequence[T]) -> None:
        self._watched, self._seen, self._done, self._quiet = watched, [False] * len(watched), 0, 0
        with system.narrowing(watched):
            cone = system.cone(watched)
            self._runs = Runs(system, cone, watched, seed=1, lanes=MANY_LANES)
            if self._runs.size > MOST_TERMS:
                self._runs = Runs(system, cone, watched, seed=1)
        self._most = max(FEWEST_SCANS, min(SCANS, MOST_COMPUTED // (self._runs.size + 1)))

    def scan(self, most: int) -> set[T]:
        """Do scans, up to a number of them in all; return the truths that some scan has made true."""
        while self._done < min(most, self._most) and self._quiet < QUIET and not all(self._seen):
            if self._done and self._done % RESTART == 0:
                self._runs.restart()
            truths, kept = self._runs.scan()
            before = sum(self._seen)
            self._seen = [
                seen or bool((now & kept).any()) for seen, now in zip(self._seen, truths, strict=True)
            ]
            self._done += 1
            self._quiet = 0 if sum(self._seen) > before else self._quiet + 1
        return set(compress(self._watched, self._seen))
