"""Local tags and outputs of add-on instructions that are read but that none of their routines writes."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.lowering.addon import AddOn, Parameter, ParameterMode
from scanrack.ladder.model.operands import first_leaf
from scanrack.ladder.model.tags import OWN
from scanrack.ladder.model.types import Elementary

from ..facts import Access, Facts, Role, Variable
from ..groups import grouped
from .accesses import gives_zero, touch_of
from .counting import RUN, is_run
from .operands import part_of
from .view import LadderView

OWNED = (ParameterMode.LOCAL, ParameterMode.OUTPUT)
"""Parameters that only the routines of an add-on instruction write."""


def note_add_ons(view: LadderView, facts: Facts) -> None:
    """Note local tags and outputs of add-on instructions that are read but never written."""
    owned = {
        (add_on.name.upper(), tag.name.upper()): tag
        for add_on in view.add_ons
        for tag in _owned(add_on, view.written_members)
    }
    accesses = grouped(_accesses(owned, view), lambda each: each[0])
    for key, member in owned.items():
        own = [access for _, access in accesses.get(key, ())]
        if member.type.name in RUN:
            is_run(
                Variable(member.name, view.declaration(member.name), Role.PLAIN, member.type.name), own, facts
            )
        elif not any(access.writes for access in own):
            kind = "local tag" if member.mode is ParameterMode.LOCAL else "output"
            text = f"{kind} {member.name} is read, and no routine of the add-on writes it: it is always 0"
            for first in own[:1]:
                facts.remark("never-written", first.place, text)


def _owned(add_on: AddOn, written_outside: Collection[str]) -> Iterator[Parameter]:
    """Yield the numbers, timers and counters that start at 0 and that only its own routines can write."""
    others = hosts_in(add_on).union(written_outside)
    for parameter in add_on.parameters:
        is_simple = isinstance(parameter.type, Elementary) and not _is_set(parameter.initial)
        is_own = parameter.mode in OWNED and not parameter.at and parameter.name.upper() not in others
        if is_own and (is_simple or parameter.type.name in RUN):
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
    """Yield the accesses to given parameters in the routines of their add-on instructions."""
    frames = {frame for frame, _ in owned}
    for point in view.points:
        frame = point.routine.frame
        for mention in (
            mentions_of(view.lowered.sites[point.step.site], point.step) if frame in frames else ()
        ):
            leaf = first_leaf(mention.where)
            name = leaf.path.upper().partition(".")[0]
            if leaf.root == OWN and (frame, name) in owned:
                zero = mention.writes and gives_zero(point.step)
                part = part_of(mention.where, name)
                yield (
                    (frame, name),
                    Access(name, part, touch_of(mention), point.place, zero=zero, text=mention.text),
                )
