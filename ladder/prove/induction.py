"""Decides properties: it proves a property for every run, finds a run that breaks it, or reaches a limit.

Two questions alternate. Base: can scan k + 1 after power-up break the property? Step: from any state, does
the property follow from k scans that satisfy it? Invariants strengthen the step.

The compiled program replays each run that the solver finds, and the values in its memory decide. An
instruction without a model can compute a different value than the solver chose, or not fault when the solver
chose a fault. The solver then learns the actual value and tries again. A run ends with the scan of a major
fault; claims are about the state after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from itertools import pairwise
from typing import Any

from scanrack.io_images.site import Site

from .algebra.meaning import BOOL, INT
from .algebra.terms import FALSE, TRUE, T
from .certificate import Certificate
from .replaying import ReplayedRun, ScanOf, breaks, first_broken, replay, scenario
from .solving.frames import Frame
from .solving.invariants import Invariant, invariants
from .solving.solver import FUSE, SAT, UNKNOWN, UNSAT, Solver, fuse_text
from .solving.translation import sort_of
from .stretching import STRETCHED_MS, in_short_scans, stretched
from .system import CLOCK, RETAINED, THEN, TURNED, HeldNumber, Key, ProgramSystem, System, shown

MOST_TRIES = 10
"""Maximum number of replays for one property."""

HELPED_FROM = 3
"""Number of scans after which the search for invariants begins; early counterexamples need none."""

WORK = 10_000_000
"""Default work limit for a property."""

SCANS, FURTHER = 20, 1_000_000
"""Number of scans that the search always tries, and the work limit for longer runs."""

FUSES = 10
"""The fuse for a property, as a multiple of the fuse for one question."""

STRETCHED_FROM = 5
"""Number of scans after which the search tries a run with longer scans."""


class VerdictKind(StrEnum):
    """Kind of verdict on a property."""

    PROVED = "proved"
    REFUTED = "refuted"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of a proof. Unless a fuse blows, the verdict is the same on every machine and solver version.

    Attributes:
        scans: length of the longest run that the search tries.
        k: maximum number of scans in an induction.
        work: number of terms in the questions for one property; see `Solver`.
        fuse: the solver's steps for one question; the limit for a property is ten times as high.
        helped: whether the proof can use invariants.
        replays: whether the compiled program replays the runs that the solver finds.
    """

    scans: int = 1_000
    k: int = 6
    work: int = WORK
    fuse: int = FUSE
    helped: bool = True
    replays: bool = True

    def times(self, factor: int) -> Limits:
        """Return the limits with work and fuse multiplied by a factor."""
        return replace(self, work=self.work * factor, fuse=self.fuse * factor)


@dataclass(slots=True)
class Verdict:
    """The verdict on a property.

    Attributes:
        kind: proved, refuted or unknown.
        k: number of scans in the induction, or the number, from 1, of the scan that breaks the property.
        scans: the run that breaks the property, confirmed on the compiled program.
        invariants: the invariants that the proof used.
        held: numbers and bits that nothing writes; the proof assumes that they keep their values.
        blame: the instructions or limits that prevented an answer, if unknown.
        work: number of terms in the questions.
        steps: number of the solver's steps.
        certificates: certificate of the property, and of "the relation follows the program" if this needs a
            proof.
    """

    kind: VerdictKind = VerdictKind.UNKNOWN
    k: int = 0
    scans: tuple[ScanOf, ...] = ()
    invariants: tuple[str, ...] = ()
    held: tuple[HeldNumber, ...] = ()
    blame: tuple[str, ...] = ()
    work: int = 0
    steps: int = 0
    certificates: tuple[Certificate, ...] = ()

    def __bool__(self) -> bool:
        return self.kind is VerdictKind.PROVED


def prove(problem: System, bad: T | Key, limits: Limits = Limits(), *, fault: Site | None = None) -> Verdict:
    """Decide whether a condition is false after every scan.

    Args:
        problem: a program, or a system without a program, whose runs are not replayed.
        bad: a term of the values before a scan, or the place of a bit after it.
        limits: limits of the search.
        fault: the site of the major fault that `bad` describes; None if `bad` does not describe a fault.
    """
    return _Proof(problem, bad, limits, fault).verdict()


@dataclass(slots=True)
class _Proof:
    system: System
    target: T | Key
    limits: Limits
    fault: Site | None = None
    result: Verdict = field(default_factory=Verdict)
    key: Key | None = None
    bad: T = FALSE

    def verdict(self) -> Verdict:
        """Decide the property."""
        system, result = self.system, self.result
        if isinstance(self.target, tuple):
            assert isinstance(system, ProgramSystem)
            self.key, self.bad = self.target, system.after(self.target)
        else:
            self.bad = self.target
        with system.narrowing([self.bad]):
            self._decide(system.cone([self.bad]))
        return result

    def _decide(self, cone: dict[str, T]) -> None:
        """Prove or refute the property; if it stays open, note everything that can prevent an answer."""
        system, result = self.system, self.result
        result.held = system.held_numbers(cone, [self.bad])
        if self.bad is FALSE:
            self._proved(0)
        else:
            self._search(cone)
        if result.kind is VerdictKind.UNKNOWN:
            result.blame = tuple(dict.fromkeys((*result.blame, *system.blame(cone))))

    # --- the two questions

    def _search(self, cone: dict[str, T]) -> None:
        """Search scan by scan for a run that breaks the property, and for an induction that proves it."""
        system, limits = self.system, self.limits
        base, steps = Solver(limits.fuse), _Steps(system, self.bad, limits)
        run: Frame | None = None
        for k in range(limits.scans):
            run = Frame(system, base, run, first=run is None)
            broken = run.term(self.bad)
            answer = base.check(broken)
            self._count(base, steps)
            if answer == SAT:
                self._refute(base, run, broken)
                return
            if reason := self._reason_to_stop(base, answer, k + 1):
                self._unknown(reason)
                return
            base.state(base.apply("not", [broken]))
            if limits.helped and k == min(HELPED_FROM, limits.k, limits.scans - 1):
                steps.help(cone)
            if steps.proves(k):
                self._proved(steps.k, steps.found)
                return
            if k == STRETCHED_FROM and self._refute_stretched(cone):
                return
        self._unknown(f"the limit of {limits.scans} scans", *([fuse_text()] if steps.blown else []))

    def _reason_to_stop(self, base: Solver, base_answer: str, scan: int) -> str:
        """Return the limit reached, or that no run satisfies the assumptions; "" to continue."""
        limits = self.limits
        assumptions = UNKNOWN
        if base_answer != UNKNOWN and self.result.steps <= FUSES * limits.fuse:
            if self.result.work > (limits.work if scan <= SCANS else min(limits.work, FURTHER)):
                return f"the limit of work, in scan {scan}"
            assumptions = SAT if self.system.contract is TRUE else base.check()
        if assumptions == UNSAT:
            return f"no run of {scan} scans keeps the assumptions"
        return f"{fuse_text()}, in scan {scan}" if assumptions == UNKNOWN else ""

    def _count(self, base: Solver, steps: _Steps) -> None:
        """Update the work and the solver's steps in the result."""
        self.result.work = base.work + steps.work
        self.result.steps = base.steps + steps.steps

    # --- answers

    def _proved(self, k: int, found: Sequence[Invariant] = ()) -> None:
        """Note a proof by `k`-induction with the invariants `found`, if the relation can be trusted."""
        if not self._follows():
            return
        system, result = self.system, self.result
        result.kind, result.k = VerdictKind.PROVED, k
        result.invariants = tuple(invariant.text for invariant in found)
        certificate = Certificate.of(system, "what is asked", self.bad, k, found)
        result.certificates = (certificate, *(system.follows.certificates if system.follows else ()))

    def _follows(self) -> bool:
        """Return whether the relation follows the program in every run."""
        system = self.system
        if system.deep is FALSE or self.bad is system.deep:
            return True
        if system.follows is None:
            verdict = prove(system, system.deep, replace(self.limits, replays=False))
            text = "the relation follows the program"
            verdict.certificates = tuple(
                replace(certificate, says=text) for certificate in verdict.certificates
            )
            system.follows = verdict
        if not system.follows:
            self._unknown(*system.limits_met())
        return bool(system.follows)

    def _unknown(self, *blame: str) -> None:
        """Note the reasons for an open property."""
        self.result.blame = (*self.result.blame, *blame)

    def _refute(self, base: Solver, run: Frame, broken: Any) -> None:
        """Replay the run that the solver found; if it does not break the property, learn from it."""
        frames, system = list(run), self.system
        self._prefer_plain_run(base, frames, broken)
        scans = _values_of(frames)
        if not isinstance(system, ProgramSystem) or not self.limits.replays:
            self._refuted(scans)
            return
        for tries_left in reversed(range(MOST_TRIES)):
            replayed = replay(system, scans, breaks(system, self.bad, self.key))
            if replayed.confirmed or self._is_the_fault(replayed, len(scans)):
                self._refuted(scans)
                return
            learned = self._learn(base, frames, replayed)
            if not learned or not tries_left or base.check(broken, *learned) != SAT:
                self._blame_processor(replayed)
                return
            scans = _values_of(frames)

    @staticmethod
    def _prefer_plain_run(base: Solver, frames: Sequence[Frame], broken: Any) -> None:
        """Prefer a model without prescans, then a model whose prescans read the next scan's inputs."""
        prescans = [
            frame.chosen[name][1] for frame in frames for name in (TURNED, RETAINED) if name in frame.chosen
        ]
        preferences = [[base.apply("not", [prescan]) for prescan in prescans], _read_by_prescan(base, frames)]
        preferences = [preference for preference in preferences if preference]
        if preferences and not any(base.check(broken, *preference) == SAT for preference in preferences):
            base.check(broken)  # repeat the first question, for its model

    def _is_the_fault(self, replayed: ReplayedRun, scans: int) -> bool:
        """Return whether a replay ends with the given fault in its last scan."""
        fault = replayed.fault
        return fault is not None and fault.site == self.fault and replayed.scans_done == scans - 1

    def _learn(self, base: Solver, frames: list[Frame], replayed: ReplayedRun) -> list[Any]:
        """Return formulas that replace the solver's choices with the values that a replay computed."""
        if replayed.fault is not None and not replayed.computed:
            self._unknown(f"a fault ends the run: {replayed.fault}")
        if replayed.differs and not replayed.computed:
            path, index = replayed.differs[0]
            self._unknown(f"the relation and the program differ at {path}[{index}]: a defect of scanrack")
        pins = []
        for (number, name), value in replayed.computed.items():
            choice = frames[number].chosen.get(name)
            if choice is not None:
                variable, formula = choice
                literal = base.value(sort_of(variable), value if variable.kind != INT else int(value))
                pins.append(base.apply("=" if variable.kind in (BOOL, INT) else "fp.eq", [formula, literal]))
        return pins

    def _blame_processor(self, replayed: ReplayedRun) -> None:
        """Blame the values that the processor itself writes, if the property depends on any."""
        system = self.system
        assert isinstance(system, ProgramSystem)
        cone = system.cone([self.bad])
        computed = [name for _, name in replayed.computed if name in cone and name in system.key_of]
        names = dict.fromkeys(
            shown(name) for name in computed if system.is_written_beside(system.key_of[name][0])
        )
        if names:
            self._unknown(f"the processor writes {', '.join(names)} itself")

    def _refuted(self, scans: list[dict[str, Any]]) -> None:
        """Note the run that breaks the property in its last scan, as a scenario."""
        self.result.kind, self.result.k = VerdictKind.REFUTED, len(scans)
        self.result.scans = scenario(self.system, scans)

    # --- scans that are longer than the rack's

    def _refute_stretched(self, cone: dict[str, T]) -> bool:
        """Search for a run with longer scans; replay it with normal scans and unchanged inputs."""
        system, key = self.system, self.key
        if not isinstance(system, ProgramSystem) or key is None or system.bounds.high_ms >= STRETCHED_MS:
            return False
        if not any(name.endswith(CLOCK + "[0]") for name in cone):
            return False
        longer = stretched(system)
        longer.contract = longer.narrowed([longer.after(key)])
        solver, run = Solver(self.limits.fuse), None
        for _ in range(self.limits.scans):
            run = Frame(longer, solver, run, first=run is None)
            broken = run.term(longer.after(key))
            answer = solver.check(broken)
            if answer == SAT:
                return self._done_in_short_scans(longer, [frame.values() for frame in run])
            if answer == UNKNOWN:
                self._unknown(fuse_text())
                return False
            solver.state(solver.apply("not", [broken]))
        return False

    def _done_in_short_scans(self, longer: ProgramSystem, scans: list[dict[str, Any]]) -> bool:
        """Return whether scans of the rack's length also break the property; if so, note the refutation."""
        system, key = self.system, self.key
        assert isinstance(system, ProgramSystem)
        assert key is not None
        for inputs_first in (False, True):
            short = in_short_scans(system.bounds, longer, scans, inputs_first=inputs_first)
            number = first_broken(system, short, key)
            if number is not None:
                self._refuted(short[: number + 1])
                return True
        return False


def _values_of(frames: Sequence[Frame]) -> list[dict[str, Any]]:
    """Return the model's values in each scan; a value that prescan reads belongs to the next scan."""
    scans = [frame.values() for frame in frames]
    for previous, scan in pairwise(scans):
        for name in [chosen for chosen in previous if chosen.startswith(THEN)]:
            scan.setdefault(name.removeprefix(THEN), previous[name])
    return scans


def _read_by_prescan(base: Solver, frames: Sequence[Frame]) -> list[Any]:
    """Return the conditions under which prescan reads the next scan's inputs, as in a scenario."""
    conditions: list[Any] = []
    for previous, scan in pairwise(frames):
        for name, (variable, formula) in previous.chosen.items():
            input_name = name.removeprefix(THEN)
            if name.startswith(THEN) and variable.kind in (BOOL, INT) and input_name in scan.chosen:
                _, next_formula = scan.chosen[input_name]
                conditions.append(base.apply("=", [formula, next_formula]))
    return conditions


@dataclass(slots=True)
class _Steps:
    """The step of an induction. It checks whether a property follows from k scans that satisfy it."""

    system: System
    bad: T
    limits: Limits
    found: Sequence[Invariant] = ()
    k: int = -1  # the latest step
    _solver: Solver = field(init=False)
    _last: Frame | None = None
    _open: bool = True  # whether more scans may prove the property
    _before: tuple[int, int] = (0, 0)  # work and steps of earlier solvers
    blown: bool = False  # whether a fuse ended the step

    def __post_init__(self) -> None:
        self._solver = Solver(self.limits.fuse)

    @property
    def work(self) -> int:
        """Number of terms in the questions so far."""
        return self._before[0] + self._solver.work

    @property
    def steps(self) -> int:
        """Number of the solver's steps so far."""
        return self._before[1] + self._solver.steps

    def help(self, cone: dict[str, T]) -> None:
        """Find invariants, or reuse the invariants of a larger cone; restart the step with them."""
        cache, contract, names = self.system.invariants, self.system.contract, frozenset(cone)
        cache_key = next((key for key in cache if key[0] is contract and key[1] >= names), (contract, names))
        if cache_key not in cache:
            cache[cache_key] = invariants(self.system, cone, self.limits.fuse)
        self.found, work, steps, blown = cache[cache_key]  # count the same work for reused invariants
        self._before = self.work + work, self.steps + steps
        self._solver, self.blown = Solver(self.limits.fuse), self.blown or blown
        self._last, self._open, self.k = None, True, -1

    def proves(self, most: int) -> bool:
        """Check the steps up to `most`; return whether one of them proves the property."""
        while self._open and self.k < min(most, self.limits.k):
            if self._next_step_proves():
                return True
        return False

    def _next_step_proves(self) -> bool:
        """Add a scan; return whether the property follows in this scan. If undecided, end the steps."""
        solver = self._solver
        self._last = Frame(self.system, solver, self._last)
        for invariant in self.found:
            solver.state(self._last.term(invariant.term))
        broken = self._last.term(self.bad)
        answer = solver.check(broken)
        solver.state(solver.apply("not", [broken]))
        self._open, self.blown = answer == SAT, self.blown or answer == UNKNOWN
        self.k += 1
        return answer == UNSAT


WITHOUT_FAULTS = Limits(scans=3, k=2, work=200_000, helped=False, replays=False)
"""Limits for deciding whether a program can have a major fault at all."""


def _never_holds(problem: ProgramSystem, t: T) -> bool:
    return bool(prove(problem, t, WITHOUT_FAULTS))


ProgramSystem.never_holds = staticmethod(_never_holds)
