"""Mistakes in calls of blocks: wrong order, instances called twice, and parameters out of range."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf

from scanrack.io_images.amci3601 import Limits
from scanrack.ladder.model.operands import Group
from scanrack.ladder.model.spec import Use
from scanrack.ladder.model.tags import Tag, tag_in
from scanrack.ladder.state.lowered import AddOnCall

from ..facts import Facts, Violation
from ..logic import AllOf, never
from ..module_kinds import allowed
from .blocks import PROFILE, BlockCall
from .number_ranges import target_of
from .operands import is_fixed, path_of
from .view import LadderView
from .walk import Point

WRITTEN = {"POSITION": "position", "DISTANCE": "distance", **PROFILE}
"""Parameters of motion blocks that the program can write, by their names in `Axis3601`."""


def misordered(view: LadderView, facts: Facts) -> None:
    """Note calls of motion blocks after the block that owns their axis, and axes that no block owns."""
    owned: dict[str, BlockCall] = {}
    for call in view.calls:
        owner = owned.get(call.axis)
        if call.is_owner:
            owned.setdefault(call.axis, call)
        elif owner is not None and owner.point.routine is call.point.routine:
            text = (
                f"{call.call.name} commands axis {call.axis} after Amci3601 of line {owner.place.line}: "
                "the command is sent in the next scan"
            )
            facts.remark("block-order", owner.place, text)
    for block in () if view.lowered.axes else view.calls:  # other axes may have an owner elsewhere
        if block.axis and not block.is_owner and block.axis not in owned:
            text = f"no Amci3601 connects axis {block.axis} to a module: {block.call.name} moves nothing"
            facts.remark("block-order", block.place, text)


def slots_shared(view: LadderView, facts: Facts) -> None:
    """Note slots that two axes own."""
    by_slot: dict[int, str] = {}
    for call in view.calls:
        slot = view.axes.get(call.axis) if call.is_owner else None
        if slot is not None and by_slot.setdefault(slot, call.axis) != call.axis:
            text = f"axis {call.axis} gets slot {slot}, which axis {by_slot[slot]} already has"
            facts.remark("no-place", call.place, text)


def called_twice(points: Iterable[Point], facts: Facts) -> None:
    """Note block instances that are called twice in a scan."""
    first_calls: dict[str, Point] = {}
    for point in points:
        name = _instance(point)
        first = first_calls.setdefault(name, point) if name else point
        both = AllOf((first.condition, point.condition))
        if first is not point and (point.is_rung or first.is_rung or not never(both)):
            text = f"{name.capitalize()} is already called in line {first.place.line}"
            facts.remark("block-twice", point.place, f"{text}: it runs twice in a scan")


def parameters_out_of_range(view: LadderView, limits: Limits) -> Iterator[Violation]:
    """Yield out-of-range numbers that the program writes to parameters of motion blocks."""
    ranges = allowed("run", limits)
    for point in view.main:
        step = point.step
        target = target_of(step) if step.name in ("MOV", ":=") and not point.argument else None
        if target is None or not _is_block(view.tags.get(tag_in(path_of(target)))):
            continue
        parameter = path_of(target).rpartition(".")[2]
        least, most = ranges.get(WRITTEN.get(parameter, ""), (-inf, inf))
        value = view.values.range_of(step.operands[1 if step.name == ":=" else 0])
        if value.outside(least, most):
            text = f"{target.text} is {value}: must be {least} to {most}"
            yield Violation(point.place, text)


def _is_block(tag: Tag | None) -> bool:
    return tag is not None and getattr(tag.type, "name", "").upper().startswith(("MC_", "MOVEREG"))


def _instance(point: Point) -> str:
    """Return the instance that an instruction runs, in capitals; "" if it runs none."""
    instance = point.step.operands[0] if point.step.operands else None
    if isinstance(instance, AddOnCall):
        instance = instance.instance
    elif Use.BLOCK not in point.step.uses:
        return ""
    return instance.text.upper() if isinstance(instance, Group) and is_fixed(instance) else ""
