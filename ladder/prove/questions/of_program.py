"""The built-in questions about a program, as conditions on the values before a scan."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

from ...model.operands import Constant, Group, Place
from ...model.spec import InstructionKind
from ...state.lowered import LoweredLine, LoweredRoutine, LoweredStep, Node, Parallel, steps_of
from ..algebra.meaning import BOOL
from ..algebra.numbers import bit
from ..algebra.terms import FALSE, TRUE, T, and_, any_of, iff, not_, or_, replaced
from ..relation.symbols import term_of
from ..system import ProgramSystem
from .asking import Question

PASSIVE = frozenset(("AFI", "NOP", "ONS", "OSR", "OSF"))
"""Instructions that by design never pass power, always pass it, or pass it for one scan."""

COILS = frozenset(("OTE", "OTL", "OTU"))

TIMED = frozenset(("TON", "TOF", "RTO", "CTU", "CTD", "CTUD", "TONR", "TOFR", "RTOR"))


def questions_of(problem: ProgramSystem, routines: Collection[str] | None = None) -> Iterator[Question]:
    """Yield the built-in questions, in program order.

    Args:
        routines: names of the routines to check, as in `LoweredProgram.routines`; None for all. Faults
            and endless loops are questions about all routines, because they stop the controller.
    """
    lines = [
        line
        for name, routine in problem.lowered.routines.items()
        if routines is None or name in routines
        for line in lines_reached(problem, routine)
    ]
    for line in lines:
        yield from _of_line(problem, line)
    steps = [step for line in lines for step in line.steps]
    for step in steps:
        if step.name in TIMED and isinstance(step.operands[0], Group):
            yield from _of_timer(problem, step)
    for coils in _coils_by_bit(steps).values():
        yield from _of_coil(problem, coils)
    yield from _faults(problem)


def _coils_by_bit(steps: Iterable[LoweredStep]) -> dict[str, list[LoweredStep]]:
    """Return the coils of each bit at a fixed place."""
    coils: dict[str, list[LoweredStep]] = {}
    for step in steps:
        if step.name in COILS and _is_fixed(step.operands[0]):
            coils.setdefault(step.operands[0].text.upper(), []).append(step)
    return coils


def lines_reached(problem: ProgramSystem, routine: LoweredRoutine) -> Iterator[LoweredLine]:
    """Yield the rungs and statements of a routine that can run in some scan."""
    for line in routine.lines:
        if any(step.site in problem.machine.passages for step in line.steps):
            yield line


def _of_line(problem: ProgramSystem, line: LoweredLine) -> Iterator[Question]:
    """Yield questions about a rung: does an output ever have power, and do its contacts have an effect?"""
    passages, sites = problem.machine.passages, problem.lowered.sites
    outputs = [step for step in line.steps if step.kind is not InstructionKind.INPUT]
    if not outputs or sites[outputs[0].site].unit != "rung":
        return
    site = sites[outputs[0].site]
    reached = any_of(passage.before for step in outputs for passage in passages.get(step.site, ()))
    yield Question("dead-rung", site, f"no output of {site.place} ever has power", reached)
    yield from _of_contacts(problem, line.nodes)


def _of_contacts(problem: ProgramSystem, nodes: tuple[Node, ...]) -> Iterator[Question]:
    """Yield questions about contacts that always or never pass, and about branches, at any depth."""
    for node in nodes:
        if isinstance(node, Parallel):
            for leg in node.legs:
                yield from _of_contacts(problem, leg)
            yield from _of_legs(problem, node)
        elif node.kind is InstructionKind.INPUT and node.name not in PASSIVE:
            passages = problem.machine.passages.get(node.site, ())
            passed = any_of(and_(passage.before, passage.after) for passage in passages)
            blocked = any_of(and_(passage.before, not_(passage.after)) for passage in passages)
            site = problem.lowered.sites[node.site]
            always = f"{site.instruction} decides nothing: it passes power whenever power reaches it"
            yield Question("dead-leg", site, always, blocked, passed)
            yield Question("dead-leg", site, f"{site.instruction} never passes", passed, blocked)


def _of_legs(problem: ProgramSystem, branch: Parallel) -> Iterator[Question]:
    """Yield questions about redundant legs, which have power only when another leg does."""
    if any(step.kind is not InstructionKind.INPUT for step in steps_of((branch,))):
        return
    for number, leg in enumerate(branch.legs):
        if leg:
            adds_power = has_power = FALSE
            for active, powers in problem.machine.legs.get(id(branch), ()):
                other_power = any_of(power for index, power in enumerate(powers) if index != number)
                has_power = or_(has_power, and_(active, powers[number]))
                adds_power = or_(adds_power, and_(and_(active, powers[number]), not_(other_power)))
            site = problem.lowered.sites[steps_of(leg)[0].site]
            text = f"the leg of {site.instruction} decides nothing: another leg also has power"
            yield Question("dead-leg", site, text, adds_power, has_power)


def _of_timer(problem: ProgramSystem, step: LoweredStep) -> Iterator[Question]:
    """Yield the question whether a timer or counter is ever done."""
    done = step.operands[0].member("DN")
    if _is_fixed(done):
        site, text = problem.lowered.sites[step.site], step.operands[0].text
        yield Question("never-done", site, f"{text} is never done", bit_after(problem, done))


def _of_coil(problem: ProgramSystem, steps: Sequence[LoweredStep]) -> Iterator[Question]:
    """Yield questions about a bit's coils: is it ever on, is it ever off again, do two OTEs disagree?"""
    place: Place = steps[0].operands[0]
    sites, after = problem.lowered.sites, bit_after(problem, place)
    setter = next((step for step in steps if step.name != "OTU"), None)
    if setter is not None:
        site, text = sites[setter.site], f"{place.text} is never off again once it is on"
        yield Question("never-on", site, f"{place.text} is never on", after)
        falls = and_(bit_before(problem, place), not_(_as_first(problem, after)))
        yield Question("stuck", site, text, falls, and_(after, not_(problem.stops)))
    for first, second in _pairs(problem, [step for step in steps if step.name == "OTE"]):
        other_place = sites[first.site].place
        text = f"{place.text}: the coils here and in {other_place} write different values in one scan"
        pair = first.site, second.site
        yield Question("conflict", sites[second.site], text, _disagree(problem, first, second), coils=pair)


def _pairs(problem: ProgramSystem, coils: Sequence[LoweredStep]) -> Iterator[tuple[LoweredStep, LoweredStep]]:
    """Yield pairs of coils. Thousands of coils can have the same power, so only neighbors are paired."""
    numbers_by_power: dict[object, list[int]] = {}
    powers: list[object] = []  # of each coil; the coil's number if it has none or several
    for number, coil in enumerate(coils):
        states = {(passage.active, passage.power) for passage in problem.machine.passages.get(coil.site, ())}
        powers.append(next(iter(states)) if len(states) == 1 else number)
        numbers_by_power.setdefault(powers[-1], []).append(number)
    neighbors = {
        first: second for numbers in numbers_by_power.values() for first, second in pairwise(numbers)
    }
    for number, power in enumerate(powers):
        others: list[int] = []
        for other_power, numbers in numbers_by_power.items():
            if other_power != power:
                others += [other for other in numbers if other > number]
        if number in neighbors:
            others.append(neighbors[number])
        for other in sorted(others):
            yield coils[number], coils[other]


def _as_first(problem: ProgramSystem, t: T) -> T:
    """Return the condition that a term is true, and would also be true in a first scan after program mode."""
    names = {"S:FS[0]": TRUE}
    schedule = problem.lowered.schedule
    for program in () if schedule is None else schedule.programs:
        names[f"{program.started.path.upper()}[0]"] = FALSE
    first = replaced(t, names, {})
    return and_(t, first)


def _disagree(problem: ProgramSystem, first: LoweredStep, second: LoweredStep) -> T:
    """Return the condition that both coils are scanned and write different values."""
    passages = problem.machine.passages
    return any_of(
        and_(
            and_(first_passage.active, second_passage.active),
            not_(iff(first_passage.power, second_passage.power)),
        )
        for first_passage in passages.get(first.site, ())
        for second_passage in passages.get(second.site, ())
    )


def _faults(problem: ProgramSystem) -> Iterator[Question]:
    """Yield questions about major faults, minor faults, and endless loops."""
    sites, machine = problem.lowered.sites, problem.machine
    for number, condition in machine.faults:
        site = sites[number]
        yield Question("fault", site, f"{site.instruction}: a major fault", condition, fault=site)
    for (number, kind), condition in machine.fault_log.minor.items():  # type: ignore[attr-defined]
        yield Question("fault", sites[number], f"{sites[number].instruction}: {kind}", condition)
    if problem.deep is not FALSE:
        for site, name, reason in machine.cut:
            yield Question("endless", site, f"{name}: {reason}", problem.deep, fault=site)


# --- bits


def _is_fixed(place: Any) -> bool:
    """Return whether an operand is a single bit of the program at a fixed place."""
    return (
        isinstance(place, Place)
        and not place.leaf.root
        and place.fixed_index is not None
        and (place.bit is None or isinstance(place.bit, Constant))
    )


def bit_after(problem: ProgramSystem, place: Place) -> T:
    """Return the term of a bit after a scan."""
    return term_of(problem.machine.get(place), BOOL)


def bit_before(problem: ProgramSystem, place: Place) -> T:
    """Return the term of a bit before a scan."""
    word = problem.now((place.leaf.path.upper(), place.fixed_index or 0))
    return bit(word, int(place.bit.value)) if isinstance(place.bit, Constant) else word
