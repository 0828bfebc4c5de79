"""Questions for a search: which states of contacts and coils can't be reached, and how to reach one.

| state | of a contact | of a coil or another output |
|---|---|---|
| `reached` | power reaches it | its rung is scanned |
| `on` | power reaches it and passes | it has power |
| `off` | power reaches it and does not pass | it is scanned without power |
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from enum import StrEnum

from ...model.errors import LadderError
from ...model.spec import InstructionKind
from ...run.engine import Engine
from ..algebra.terms import T, and_, any_of, not_, variables
from ..induction import Limits, prove
from ..relation.noting import Passage
from ..replaying import ScanOf
from ..system import CLOCK, FIRST_SCAN, ProgramSystem
from .asking import find_impossible
from .deciding import QuestionLimits


class PointState(StrEnum):
    """A state that an instruction can reach."""

    REACHED = "reached"
    ON = "on"
    OFF = "off"


@dataclass(frozen=True, slots=True)
class RungPoint:
    """A state of an instruction.

    Attributes:
        number: number of the instruction in `LoweredProgram.sites`.
        state: its state.
    """

    number: int
    state: PointState


LIMITS = Limits(scans=3, k=2, work=200_000, fuse=8_000, helped=False, replays=False)
"""Limits for proving that one point is dead."""

BUDGET = 30_000_000
"""Work limit for all points of a program; see `Solver`."""

SEARCH = Limits(scans=60, k=0, work=4_000_000, fuse=64_000, helped=False, replays=False)
"""Limits for the search for a run."""


def points_of(problem: ProgramSystem) -> dict[RungPoint, T]:
    """Return each point of a program with its condition, in program order."""
    points: dict[RungPoint, T] = {}
    for step in problem.lowered.all_steps:
        passages = problem.machine.passages.get(step.site, ())
        for state, truth in _states(passages, is_contact=step.kind is InstructionKind.INPUT):
            points.setdefault(RungPoint(step.site, state), truth)
    return points


def _states(passages: Iterable[Passage], *, is_contact: bool) -> Iterator[tuple[PointState, T]]:
    """Yield each state of an instruction with its condition, as in the table of this module."""
    all_passages = list(passages)
    if is_contact:
        yield PointState.REACHED, any_of(passage.before for passage in all_passages)
        yield PointState.ON, any_of(and_(passage.before, passage.after) for passage in all_passages)
        yield PointState.OFF, any_of(and_(passage.before, not_(passage.after)) for passage in all_passages)
    else:
        yield PointState.REACHED, any_of(passage.active for passage in all_passages)
        yield PointState.ON, any_of(passage.before for passage in all_passages)
        yield PointState.OFF, any_of(and_(passage.active, not_(passage.power)) for passage in all_passages)


def dead_points(problem: ProgramSystem, budget: int = BUDGET) -> tuple[RungPoint, ...]:
    """Return the points that are proved unreachable, for any values of numbers that nothing writes.

    Args:
        budget: work limit for all points; points that are still undecided at this limit are not returned.
    """
    points = points_of(problem)
    dead = find_impossible(problem, list(points.values()), QuestionLimits(LIMITS, budget, states=0))
    return tuple(point for point, truth in points.items() if truth in dead)


def run_to(
    problem: ProgramSystem, point: RungPoint, start: Engine | None = None, limits: Limits = SEARCH
) -> tuple[ScanOf, ...]:
    """Return a run whose last scan reaches a point; () if no run is found.

    Args:
        start: an engine of the same program, in the state in which the run begins; None to begin at power-up.

    Raises:
        LadderError: the point is not in the program.
    """
    truth = points_of(problem).get(point)
    if truth is None:
        raise LadderError(f"{problem.lowered.name} has no instruction {point.number}")
    if start is None:
        return prove(problem, truth, replace(limits, replays=True)).scans
    saved = problem.initial, problem.late
    problem.initial, problem.late = _state_of(problem, start, [truth]), set()
    try:
        return prove(problem, truth, limits).scans
    finally:
        problem.initial, problem.late = saved


def _state_of(problem: ProgramSystem, start: Engine, roots: Iterable[T]) -> dict[str, object]:
    """Return the values of a problem's variables in an engine, by name."""
    state = dict(problem.initial)
    layout = start.lowered.layout
    for variable in variables([*problem.next.values(), *roots, problem.contract]):
        key = problem.key_of.get(variable.val)
        leaf = None if key is None else layout.find(key[0])
        if key is None or leaf is None:
            continue
        value = start.memory.read(leaf, key[1])
        if key[0].endswith(CLOCK):
            value = min(variable.hi, max(0, start.now_ns - int(value)) // problem.tick_ns)
        state[variable.val] = False if key == FIRST_SCAN else value
    return state
