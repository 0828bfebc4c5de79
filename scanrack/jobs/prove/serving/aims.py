"""Answers questions of a search: which rungs and contacts are dead, and which scenario turns one on.

"Dead" is proved for all inputs of all modules, including faults, so no scenario can turn on a dead contact.
A scenario sets only values that an operator or a machine can set: tags, inputs of cards, and the six inputs
of a 3601. It does not set other values that the prover chooses, such as the end of a move. A run confirms it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scanrack.io_images.amci3601.bits import InputBit
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.site import Site
from scanrack.ladder import LadderLogic
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.prove.induction import Limits
from scanrack.ladder.prove.questions.points import BUDGET, SEARCH, RungPoint, dead_points, run_to
from scanrack.ladder.prove.replaying import ScanOf
from scanrack.ladder.prove.solving.solver import is_installed
from scanrack.ladder.prove.system import RUN_ONLY, ProgramSystem, ScanBounds
from scanrack.ladder.run.engine import Engine
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.live.actions import Force, Write

from ...check.check import facts_of
from ...fuzz.scenarios.scenario import ContactPress, OperatorAction, Press, Scenario
from ...load.loading import LoadedRack
from ..scenario import on_scans_of
from ..subject import subject_of_job
from .judging import set_outside

LONGEST_NS = 20_000_000
"""Longest scan that the solver can choose. On the rack, it becomes several scans."""


def dead(job: LoadedRack, budget: int = BUDGET) -> dict[RungPoint, Site]:
    """Return the points of a program that are proved unreachable, in program order, with their places.

    Without a solver, nothing is proved.

    Args:
        budget: amount of work, see `Solver`; points beyond it remain undecided. The result is the same on
            every machine.
    """
    problem = _problem(job)
    if problem is None:
        return {}
    return {point: problem.lowered.sites[point.number] for point in dead_points(problem, budget)}


def _problem(job: LoadedRack) -> ProgramSystem | None:
    """Return a job's program with all inputs free; None if nothing can be proved about it."""
    if not isinstance(job.logic, LadderLogic) or not is_installed():
        return None
    settings = job.spec.prove
    written_outside = (*settings.written_outside, *set_outside(facts_of(job)))
    try:
        return ProgramSystem(
            job.logic,
            _bounds(job.spec),
            free=settings.free,
            written_outside=written_outside,
            happens=RUN_ONLY,
        )
    except LadderError:
        return None


def _bounds(spec: RackSpec, longest_ns: int = LONGEST_NS) -> ScanBounds:
    return ScanBounds.of(spec.scan_ns / 1e6, max(spec.scan_ns, longest_ns) / 1e6)


def scenario_to(
    job: LoadedRack,
    point: RungPoint,
    start: Engine | None = None,
    at_ns: int = 0,
    limits: Limits = SEARCH,
    longest_ns: int = LONGEST_NS,
) -> Scenario | None:
    """Return a scenario that reaches a point if the modules respond as the prover assumes.

    Its times count from power-up, or from `at_ns`. Returns None if the solver finds no scenario.

    Args:
        start: engine of a run of the same rack, in the initial state of the scenario; None = power-up.
        at_ns: time of this run's next scan, ns.
        longest_ns: longest scan that the solver can choose, ns. Long scans cover more time, but miss events
            that need a precise time on the rack.

    Raises:
        LadderError: the program has no such point.
    """
    if not isinstance(job.logic, LadderLogic) or not is_installed():
        return None
    try:
        problem = subject_of_job(job, bounds=_bounds(job.spec, longest_ns)).problem
    except LadderError:
        return None
    scans = run_to(problem, point, start, limits)
    return _scenario(job.spec, problem, scans, at_ns) if scans else None


def _scenario(spec: RackSpec, problem: ProgramSystem, scans: Sequence[ScanOf], at_ns: int) -> Scenario:
    """Return a run of the prover as a scenario; words that nothing on the rack can set are left out."""
    run = on_scans_of(problem.lowered.layout, scans, spec.scan_ns)
    begin_ns = {scan: at_ns + scan * spec.scan_ns for scan in range(run.scans + 1)}
    orders = [OperatorAction(begin_ns[scan], order) for scan, order in run.orders if isinstance(order, Write)]
    levels_by_word: dict[str, list[tuple[int, Level]]] = {}
    for scan, order in run.orders:
        if isinstance(order, Force):
            levels_by_word.setdefault(order.tag, []).append((begin_ns[scan], order.value))
    presses: list[Press] = []
    pushes: list[ContactPress] = []
    for slot in spec.slot:
        for word in range(len(slot.words.inputs)):
            levels = levels_by_word.get(f"Local:{slot.number}:I.Data[{word}]")
            if levels is not None:
                levels.append((begin_ns[run.scans], 0))
                presses += _presses(slot, word, levels)
                pushes += _pushes(slot, word, levels)
    return Scenario(orders=tuple(orders), presses=tuple(presses), pushes=tuple(pushes))


Level = bool | int | float | str
Levels = Sequence[tuple[int, Level]]
"""Times, ns, at which a word changes to each value; the last time is the end of the run."""


def _presses(slot: SlotSpec, word: int, levels: Levels) -> Iterator[Press]:
    """Yield presses of the inputs that are active in a 3601's input word 1 (default polarity)."""
    if is_stepper(slot.words) and word == 1:
        for input_bit in InputBit:
            for begin, end in _on(levels, input_bit.value):
                yield Press(slot.number, input_bit, True, begin, end - begin)


def _pushes(slot: SlotSpec, word: int, levels: Levels) -> Iterator[ContactPress]:
    """Yield the presses that operate the contacts of a card."""
    named = slot.words.groups.get("input", {})
    buttons = slot.record.buttons(slot.options)
    for name, place in named.items():
        if name in buttons and (place.image, place.word) == ("I", word):
            for begin, end in _on(levels, 1 << place.bit):
                yield ContactPress(slot.number, name, begin, end - begin)


def _on(levels: Levels, mask: int) -> Iterator[tuple[int, int]]:
    """Yield the beginning and end of each time span in which a bit is set, ns."""
    end_ns, _ = levels[-1]
    begin: int | None = None
    for at_ns, value in levels:
        is_on = bool(int(value) & mask) and at_ns != end_ns
        if is_on and begin is None:
            begin = at_ns
        elif not is_on and begin is not None:
            yield begin, at_ns
            begin = None
