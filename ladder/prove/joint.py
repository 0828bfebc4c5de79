"""Inductions of many conditions at once; each scan is translated only once for all of them.

Base and step are the same as in `induction`. Each question asks about the disjunction of many conditions. If
it is unsatisfiable, so is every condition. Otherwise the conditions that are true in the model are dropped.
Runs that the solver finds are not replayed here.

The longest step comes first: a condition that does not follow from k scans does not follow from fewer. For
each condition that follows, the smallest k is found.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from .algebra.terms import TRUE, T
from .induction import FUSES, Limits
from .solving.frames import Frame
from .solving.solver import SAT, UNKNOWN, Solver
from .system import System

GROUP = 60
"""Maximum number of conditions in one question; a disjunction of hundreds is hard for the solver."""


@dataclass(slots=True)
class JointAnswers:
    """The results of inductions of many conditions.

    Attributes:
        proved: each condition that is never true, with the k of its induction.
        broken: conditions that some run of the relation makes true.
        gave_up: conditions whose fuse blew; a separate induction of such a condition can still succeed.
        work: number of terms in the questions; see `Solver`.
    """

    proved: dict[T, int] = field(default_factory=dict)
    broken: set[T] = field(default_factory=set)
    gave_up: set[T] = field(default_factory=set)
    work: int = 0


def satisfiable(solver: Solver, formulas: Mapping[T, Any]) -> tuple[set[T], set[T]]:
    """Return the conditions that can each be true under the solver's assertions.

    Args:
        formulas: the solver's term of each condition.

    Returns:
        The conditions that can be true, and the conditions whose fuse blew.
    """
    possible, gave_up = set[T](), set[T]()
    todo = [*_groups(list(formulas), GROUP)]
    while todo:
        part = todo.pop()
        answer = solver.check(solver.joined("or", [formulas[truth] for truth in part]))
        if answer == SAT:
            holding = {truth for truth in part if solver.found(formulas[truth], truth)} or {part[0]}
            possible |= holding
            todo += _groups([truth for truth in part if truth not in holding], GROUP)
        elif answer == UNKNOWN and len(part) > 1:
            todo += _groups(part, -(-len(part) // 2))
        elif answer == UNKNOWN:
            gave_up |= {*part}
    return possible, gave_up


def _groups(truths: Sequence[T], size: int) -> Iterator[list[T]]:
    for begin in range(0, len(truths), size):
        yield [*truths[begin : begin + size]]


def decide_jointly(system: System, truths: Iterable[T], limits: Limits) -> JointAnswers:
    """Decide which conditions are never true; a condition in no set of the result is undecided.

    The caller ensures that the relation follows the program; see `induction`.

    Args:
        limits: limits for each condition; a group of n conditions shares n times this work limit.
    """
    answers, groups = JointAnswers(), dict[T, list[T]]()
    for truth in dict.fromkeys(truths):
        groups.setdefault(system.narrowed([truth]), []).append(truth)
    for group in groups.values():
        with system.narrowing(group[:1]):
            for part in _groups(group, GROUP):
                _JointInduction(system, part, limits, answers).decide()
    return answers


class _JointInduction:
    """An induction of conditions that have the same contract."""

    def __init__(self, system: System, truths: Sequence[T], limits: Limits, answers: JointAnswers) -> None:
        self._system, self._limits, self._count, self._answers = system, limits, len(truths), answers
        self._undecided = list(truths)  # conditions that are neither broken nor proved so far
        self._work = self._steps = 0

    def decide(self) -> None:
        """Check the base up to the longest induction, then the step, then the base for more scans."""
        base, run = Solver(self._limits.fuse), None
        last = self._limits.scans - 1
        for number in range(self._limits.scans):
            run = Frame(self._system, base, run, first=run is None)
            broken, gave_up = satisfiable(base, {truth: run.term(truth) for truth in self._undecided})
            self._answers.broken |= broken
            self._answers.gave_up |= gave_up
            self._leave(broken | gave_up)
            if self._has_met_a_limit(base) or not self._keeps_contract(base):
                break
            if number == min(self._limits.k, last):
                self._prove(number)
            if not self._undecided:
                break
        self._answers.work += self._work + base.work

    def _has_met_a_limit(self, base: Solver) -> bool:
        limits, many = self._limits, self._count
        is_too_long = self._steps + base.steps > many * FUSES * limits.fuse
        return is_too_long or self._work + base.work > many * limits.work

    def _keeps_contract(self, base: Solver) -> bool:
        """Return whether some run of the scans so far satisfies the assumptions."""
        return self._system.contract is TRUE or base.check() == SAT

    def _prove(self, most: int) -> None:
        """Prove each condition that must be false after at most `most` scans in which it is false."""
        proved, gave_up = self._follow(self._undecided, most, most)
        if most:
            least, _ = self._follow(
                [truth for truth in self._undecided if truth in proved or truth in gave_up], 0, most
            )
            proved |= least
        self._answers.proved |= proved
        self._leave(proved)

    def _follow(self, truths: Iterable[T], first: int, last: int) -> tuple[dict[T, int], set[T]]:
        """Return the smallest k in a range that proves each condition, and the conditions that gave up."""
        solver, scan = Solver(self._limits.fuse), None
        unbroken: dict[T, list[Any]] = {truth: [] for truth in truths}
        proved, gave_up = dict[T, int](), set[T]()
        for k in range(last + 1):
            scan = Frame(self._system, solver, scan)
            literals = {truth: scan.term(truth) for truth in unbroken}
            if k < first:
                solver.check()  # its model is the start of the search in a longer run
            else:
                breaking = {
                    truth: solver.joined("and", [literals[truth], *unbroken[truth]]) for truth in unbroken
                }
                possible, undecided = satisfiable(solver, breaking)
                proved |= {truth: k for truth in breaking if truth not in possible and truth not in undecided}
                gave_up |= undecided
            unbroken = {
                truth: [*earlier, solver.apply("not", [literals[truth]])]
                for truth, earlier in unbroken.items()
                if truth not in proved and truth not in gave_up
            }
        self._work, self._steps = self._work + solver.work, self._steps + solver.steps
        return proved, gave_up

    def _leave(self, truths: Container[T]) -> None:
        self._undecided = [truth for truth in self._undecided if truth not in truths]
