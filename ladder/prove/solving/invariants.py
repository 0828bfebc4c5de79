"""Finds invariants: conditions on the state after a scan that random scans suggest and the solver proves.

| suggested | for |
|---|---|
| a bit is never on, or never off | bits that never changed in the random scans |
| never both, never neither, never one without the other | two bits |
| at least 0, at most a bound | numbers |
| at most another timer or counter | timers and counters |
| DN only at or above PRE, TT only below it | timers |
| an enabled timer is done, or its time has been counted | timers |

Candidates that the first scan breaks are dropped. Then the solver repeatedly searches for a scan that breaks
a candidate although all candidates were true before it, and broken candidates are dropped. Once no scan
breaks a candidate, the remaining candidates are inductive together. The solver checks candidates in groups.
If a group blows its fuse, only that group is dropped.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, permutations
from typing import Any, NamedTuple

import numpy as np

from ..algebra.batch import Array
from ..algebra.evaluation import Evaluator
from ..algebra.meaning import BOOL, INT
from ..algebra.numbers import lt
from ..algebra.terms import TRUE, T, and_, const, not_, or_
from ..system import CLOCK, System, shown
from .frames import Frame
from .runs import Runs
from .solver import SAT, UNSAT, Solver

SCANS, RESTART = 24, 12
"""Total number of random scans, and the number of scans after which runs restart."""

MOST_STATES = 120
"""Maximum number of states with the full set of suggestions."""

MOST_BITS, FEW_BITS = 160, 40
"""Maximum number of bits that are paired, in cones of up to `MOST_STATES` states and in larger ones."""

MOST_TIMERS = 12
"""Maximum number of timers and counters that are paired."""

MOST_SUGGESTED = 4000

MOST_ROUNDS = 6_400
"""Maximum number of questions in one search; the actual number depends on the solver's models."""

GROUP = 60
"""Number of candidates in one question; hundreds would be too hard, and a blown fuse drops all of them."""

BOUNDS = (1, 2, 5, 10, 100, 1000)


class Invariant(NamedTuple):
    """A condition on the state after a scan, as a term of the values before it and as text."""

    term: T
    text: str


class Invariants(NamedTuple):
    """The invariants of a system, and the cost of the search."""

    found: list[Invariant]
    work: int  # see `Solver`
    steps: int  # the solver's steps
    blown: bool  # whether a fuse blew


def invariants(system: System, cone: Mapping[str, T], fuse: int) -> Invariants:
    """Return conditions that are true after power-up and inductive together, with the work and steps used.

    Work counts terms, because the number of questions depends on the solver's models, but the terms and the
    result do not.

    Args:
        cone: the relevant variables, nearest first.
        fuse: see `Solver`; a group that blows it has no invariants.
    """
    values = traces(system, cone)
    suggested = {
        invariant.term: invariant
        for invariant in _suggested(system, cone, values)
        if invariant.term.op != "const"
    }
    search = _Search(system, fuse // 4)  # each group of candidates takes many questions
    candidates = search.kept(list(suggested.values())[:MOST_SUGGESTED], first=True)
    return Invariants(search.kept(candidates, first=False), search.work, search.steps, search.blown)


def traces(system: System, cone: Mapping[str, T]) -> dict[str, Array]:
    """Return the values of each state after random scans from power-up."""
    states = [name for name in cone if name in system.next]
    runs = Runs(system, cone, [system.next[name] for name in states])
    blocks: list[list[Array]] = [[] for _ in states]
    for number in range(SCANS):
        if number and number % RESTART == 0:
            runs.restart()
        watched, kept_contract = runs.scan()
        for block, values in zip(blocks, watched, strict=True):
            block.append(values[kept_contract])
    return {name: np.concatenate(block) for name, block in zip(states, blocks, strict=True)}


# --- suggestions


def _suggested(system: System, cone: Mapping[str, T], values: Mapping[str, Array]) -> Iterator[Invariant]:
    """Yield candidates that the values of the random runs satisfy; fewer if there are many states."""
    small = len(values) <= MOST_STATES
    bits = [name for name in values if cone[name].kind == BOOL]
    yield from _of_bits(system, values, bits[: MOST_BITS if small else FEW_BITS])
    yield from _of_two_times(system, values)
    for index, name in enumerate(values):
        if cone[name].kind == INT and (small or index < MOST_STATES // 2):
            yield from _of_number(system, name, values)


def _of_bits(system: System, values: Mapping[str, Array], bits: Sequence[str]) -> Iterator[Invariant]:
    """Suggest that a bit never changes, or that two bits are never both true, or one implies the other."""
    every = _packed(np.ones_like(values[bits[0]])) if bits else 0  # one bit for each scan of a run
    changing = []
    for name in bits:
        term, packed = system.next[name], _packed(values[name])
        if packed in (0, every):
            yield Invariant(term, shown(name)) if packed else Invariant(not_(term), f"NOT {shown(name)}")
        else:
            changing.append((shown(name), term, packed))
    for (left, a, seen_a), (right, b, seen_b) in combinations(changing, 2):
        if not seen_a & seen_b:
            yield Invariant(not_(and_(a, b)), f"NOT ({left} AND {right})")
        if not seen_a & ~seen_b:
            yield Invariant(or_(not_(a), b), f"NOT {left} OR {right}")
        if not ~seen_a & seen_b:
            yield Invariant(or_(a, not_(b)), f"{left} OR NOT {right}")
        if (seen_a | seen_b) == every:
            yield Invariant(or_(a, b), f"{left} OR {right}")


def _packed(truths: Array) -> int:
    """Return Booleans as the bits of a number."""
    return int.from_bytes(np.packbits(truths).tobytes())


def _of_number(system: System, name: str, values_by_name: Mapping[str, Array]) -> Iterator[Invariant]:
    """Suggest bounds for a number; for an ACC with a preset, also conditions with DN and TT."""
    term, values = system.next[name], values_by_name[name]
    if name.endswith(CLOCK + "[0]"):
        yield from _of_clock(system, name)
        return
    if not len(values):
        return
    least, most = int(min(values)), int(max(values))
    if least >= 0:
        yield Invariant(not_(lt(term, const(0))), f"{shown(name)} >= 0")
    for bound in sorted({most, *BOUNDS}):
        if most <= bound:
            yield Invariant(not_(lt(const(bound), term)), f"{shown(name)} <= {bound}")
    stem, _, last = name.rpartition(".")
    preset = system.initial.get(f"{stem}.PRE[0]")
    if last == "ACC[0]" and preset is not None:
        below = lt(term, const(preset))
        for member, truth, sign in (("DN", not_(below), ">="), ("TT", below, "<")):
            flag = system.next.get(f"{stem}.{member}[0]")
            if flag is not None:
                text = f"NOT {stem}.{member} OR {shown(name)} {sign} {preset}"
                yield Invariant(or_(not_(flag), truth), text)


def _of_two_times(system: System, values: Mapping[str, Array]) -> Iterator[Invariant]:
    """Suggest that one timer or counter never exceeds another."""
    timed = [name for name in values if name.endswith(".ACC[0]") and any(values[name])][:MOST_TIMERS]
    for lower, upper in permutations(timed, 2):
        if (values[lower] <= values[upper]).all():
            text = f"{shown(lower)} <= {shown(upper)}"
            yield Invariant(not_(lt(system.next[upper], system.next[lower])), text)


def _of_clock(system: System, name: str) -> Iterator[Invariant]:
    """Suggest that an enabled timer that is not done has counted all time up to the scan."""
    stem = name.rpartition(".")[0]
    enabled, done = (system.next.get(f"{stem}.{member}[0]") for member in ("EN", "DN"))
    if enabled is not None and done is not None:
        counted = not_(lt(const(0), system.next[name]))
        yield Invariant(or_(not_(enabled), or_(done, counted)), f"{stem} has counted its time")


# --- search for the candidates that hold


@dataclass
class _Search:
    """Finds the candidates that are invariants; checks each scan from the solver against all of them."""

    system: System
    fuse: int
    work: int = 0
    steps: int = 0
    rounds: int = 0
    blown: bool = False

    def kept(self, candidates: list[Invariant], *, first: bool) -> list[Invariant]:
        """Return the candidates that are true after the first scan, or those that are inductive together."""
        while candidates:
            remaining = self._round(candidates, first=first)
            if first or len(remaining) == len(candidates):
                return remaining
            candidates = remaining
        return []

    def _round(self, candidates: list[Invariant], *, first: bool) -> list[Invariant]:
        """Return the candidates still true after the first scan, or after a scan that starts with all."""
        solver = Solver(self.fuse)
        frame = Frame(self.system, solver, first=first)
        if not first:
            for candidate in candidates:
                solver.state(frame.term(candidate.term))
            frame = Frame(self.system, solver, frame)
        formulas = [frame.term(invariant.term) for invariant in candidates]
        self.work += solver.made  # counted first: the models decide how many questions follow
        evaluator = Evaluator([invariant.term for invariant in candidates])
        remaining = set(range(len(candidates)))
        for begin in range(0, len(candidates), GROUP):
            group = remaining.intersection(range(begin, begin + GROUP))
            remaining -= self._broken(frame, formulas, evaluator, group)
        self.steps += solver.steps
        return [candidates[number] for number in sorted(remaining)]

    def _broken(self, frame: Frame, formulas: list[Any], evaluator: Evaluator, group: set[int]) -> set[int]:
        """Return the numbers of all broken candidates in a group, and of others that the models show.

        Args:
            formulas: the solver's terms for all candidates in the scan.
            evaluator: evaluates all candidates.
        """
        solver, broken = frame.solver, set[int]()
        while remaining := sorted(group - broken):
            self.rounds += 1
            all_hold = solver.joined("and", [formulas[number] for number in remaining])
            answer = solver.check(solver.apply("not", [all_hold]))
            if answer == UNSAT:
                break
            if answer != SAT or self.rounds > MOST_ROUNDS:
                self.blown = True
                return broken | group
            false_numbers = {
                number for number, truth in enumerate(evaluator(self._values(frame))) if not truth
            }
            if false_numbers.isdisjoint(
                remaining
            ):  # the solver found a difference that evaluation does not show
                false_numbers = {number for number in remaining if not solver.found(formulas[number], TRUE)}
            broken |= false_numbers
        return broken

    def _values(self, frame: Frame) -> dict[str, Any]:
        """Return the values that the solver chose for the variables of the last scan."""
        system, values = self.system, dict[str, Any]()
        for scan in frame:
            values |= {name: system.initial[name] for name in system.held}
            if scan.first:
                values |= system.initial
            values |= scan.values()
            if scan is not frame:
                values |= dict(zip(system.next, self._next(values), strict=True))
        return values

    @cached_property
    def _next(self) -> Evaluator:
        """Return an evaluator of the states after a scan."""
        return Evaluator([*self.system.next.values()])
