"""Local tags and outputs of add-on instructions that are read but never written by their routines."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.lowering.addon import AddOn, Parameter, ParameterMode
from scanrack.ladder.model.operands import first_leaf
from scanrack.ladder.model.tags import OWN
from scanrack.ladder.model.types import Elementary

from ..facts import Access, Facts, Role, Variable
from .accesses import gives_zero, touch_of
from .counting import RUN, note_never_run
from .operands import part_of
from .view import LadderView

OWNED = (ParameterMode.LOCAL, ParameterMode.OUTPUT)
"""Parameters that only the routines of an add-on instruction write."""


def note_add_ons(view: LadderView, facts: Facts) -> None:
    """Note local tags and outputs of add-on instructions that are read but never written.

    Also note timers and counters whose result is read but that no instruction runs.
    """
    owned = {
        (add_on.name.upper(), tag.name.upper()): tag
        for add_on in view.add_ons
        for tag in _owned(add_on, view.written_members)
    }
    accesses_by_member: dict[tuple[str, str], list[Access]] = {}
    for key, access in _accesses(owned, view):
        accesses_by_member.setdefault(key, []).append(access)
    for key, member in owned.items():
        accesses = accesses_by_member.get(key, [])
        if member.type.name in RUN:
            place = view.declaration(member.name)
            note_never_run(Variable(member.name, place, Role.PLAIN, member.type.name), accesses, facts)
        elif accesses and not any(access.writes for access in accesses):
            kind = "local tag" if member.mode is ParameterMode.LOCAL else "output"
            text = f"{kind} {member.name} is read, but no routine of the add-on writes it: it is always 0"
            facts.remark("never-written", accesses[0].place, text)


def _owned(add_on: AddOn, written_outside: Collection[str]) -> Iterator[Parameter]:
    """Yield numbers, timers and counters that start at 0 and that only the add-on's routines can write."""
    excluded = hosts_in(add_on).union(written_outside)
    for parameter in add_on.parameters:
        is_simple = isinstance(parameter.type, Elementary) and not _is_set(parameter.initial)
        is_owned = parameter.mode in OWNED and not parameter.at and parameter.name.upper() not in excluded
        if is_owned and (is_simple or parameter.type.name in RUN):
            yield parameter


def hosts_in(add_on: AddOn) -> set[str]:
    """Return the parameters that contain other parameters, in capitals."""
    return {
        parameter.at.upper().partition(".")[0].partition("[")[0]
        for parameter in add_on.parameters
        if parameter.at
    }


def _is_set(initial: object) -> bool:
    """Whether an initial value contains a number other than 0."""
    if isinstance(initial, list):
        return any(map(_is_set, initial))
    return bool(initial)


def _accesses(
    owned: Collection[tuple[str, str]], view: LadderView
) -> Iterator[tuple[tuple[str, str], Access]]:
    """Yield the accesses to parameters in the routines of their add-on instructions, each with its key.

    Args:
        owned: keys of the parameters: the add-on instruction and the name, in capitals.
    """
    frames = {frame for frame, _ in owned}
    for point in (point for point in view.points if point.routine.frame in frames):
        for mention in mentions_of(view.lowered.sites[point.step.site], point.step):
            leaf = first_leaf(mention.where)
            name = leaf.path.upper().partition(".")[0]
            key = point.routine.frame, name
            if leaf.root == OWN and key in owned:
                zero = mention.writes and gives_zero(point.step)
                part, use = part_of(mention.where, name), touch_of(mention)
                yield key, Access(name, part, use, point.place, zero=zero, text=mention.text)
