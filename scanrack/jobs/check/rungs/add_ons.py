"""Local tags and outputs of add-on instructions that are read, and that none of their routines writes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.lowering.addon import AddOn, Parameter, ParameterMode
from scanrack.ladder.model.operands import first_leaf
from scanrack.ladder.model.tags import OWN
from scanrack.ladder.model.types import Elementary
from scanrack.ladder.state.lowered import LoweredProgram

from ..facts import Access, Facts, FileLine, Role, Touch, Variable
from .accesses import gives_zero
from .conditions import part_of
from .counting import RUN, is_run
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

OWNED = (ParameterMode.LOCAL, ParameterMode.OUTPUT)
"""What only the routines of an add-on instruction write."""


def note_add_ons(
    add_ons: Iterable[AddOn],
    points: Placed,
    lowered: LoweredProgram,
    written_outside: Collection[str],
    declared: Callable[[str], FileLine],
    facts: Facts,
) -> None:
    """Note local tags and outputs of add-on instructions that are read, and that nothing writes.

    Args:
        written_outside: members of instances that the program itself writes, in capitals.
        declared: returns the place of a declaration.
    """
    owned = {
        each.name.upper(): {
            one.name.upper(): one for one in _owned(each) if one.name.upper() not in written_outside
        }
        for each in add_ons
    }
    accesses = list(_accesses(owned, points, lowered)) if owned else []
    for name, parameters in owned.items():
        for key, each in parameters.items():
            own = [access for frame, access in accesses if frame == name and access.variable == key]
            variable = Variable(each.name, declared(each.name), Role.PLAIN, each.type.name)
            if each.type.name in RUN:
                is_run(variable, own, facts)
            elif not any(access.writes for access in own):
                first = next((access for access in own if access.reads), None)
                kind = "local tag" if each.way is ParameterMode.LOCAL else "output"
                if first is not None:
                    text = (
                        f"{kind} {each.name} is read, and no routine of the add-on writes it: it is always 0"
                    )
                    facts.remark("never-written", first.place, text)


def _owned(add_on: AddOn) -> Iterator[Parameter]:
    """Yield the numbers, timers and counters that only its routines write, and that begin with 0."""
    hosts = {each.at.upper().partition(".")[0].partition("[")[0] for each in add_on.parameters if each.at}
    for each in add_on.parameters:
        is_simple = isinstance(each.type, Elementary) and not _is_set(each.initial)
        is_own = each.way in OWNED and not each.at and each.name.upper() not in hosts
        if is_own and (is_simple or each.type.name in RUN):
            yield each


def _is_set(initial: object) -> bool:
    """Whether an initial value has a number other than 0 in it."""
    if isinstance(initial, list):
        return any(map(_is_set, initial))
    return bool(initial)


def _accesses(
    owned: dict[str, dict[str, Parameter]], points: Placed, lowered: LoweredProgram
) -> Iterator[tuple[str, Access]]:
    for point, place in points:
        if point.routine.frame not in owned:
            continue
        for each in mentions_of(lowered.sites[point.step.site], point.step):
            leaf = first_leaf(each.where)
            name = leaf.path.upper().partition(".")[0]
            if leaf.root == OWN and name in owned[point.routine.frame]:
                use = Touch.BOTH if each.reads and each.writes else Touch.WRITE if each.writes else Touch.READ
                zero = each.writes and gives_zero(point.step)
                part = part_of(each.where, name)
                yield point.routine.frame, Access(name, part, use, place, zero=zero, text=each.text)
