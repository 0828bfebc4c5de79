"""Mistakes in calls of blocks: their order, instances that are called twice, parameters out of range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.amci3601 import Limits
from scanrack.io_images.thousands import PARAMETER_MAX, PARAMETER_MIN
from scanrack.ladder.model.operands import Constant, Group, Place
from scanrack.ladder.model.spec import Use
from scanrack.ladder.model.tags import Tag, tag_in
from scanrack.ladder.state.lowered import AddOnCall

from ..facts import Facts, FileLine, LocalFinding
from ..logic import AllOf, never
from .blocks import OWNER, BlockCall
from .number_ranges import Values
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]
"""Points with their lines."""


def misordered(
    calls: Sequence[BlockCall], axes: Mapping[str, int], facts: Facts, *, has_other_axes: bool
) -> None:
    """Note the calls of motion blocks behind the block that owns their axis, and axes without one.

    Args:
        axes: slots of axes.
        has_other_axes: whether something else than Amci3601 may own an axis.
    """
    owned: dict[str, BlockCall] = {}
    by_slot: dict[int, str] = {}
    for each in calls:
        before = owned.get(each.axis)
        if each.call.name == OWNER:
            owned.setdefault(each.axis, each)
            slot = axes.get(each.axis)
            if slot is not None and by_slot.setdefault(slot, each.axis) != each.axis:
                text = f"axis {each.axis} gets slot {slot}, which axis {by_slot[slot]} has already"
                facts.remark("no-place", each.place, text)
        elif before is not None and before.point.routine is each.point.routine:
            text = (
                f"{each.call.name} asks axis {each.axis} behind Amci3601 of line {before.place.line}: "
                "what it asks is sent in the next scan"
            )
            facts.remark("block-order", before.place, text)
    for each in calls:
        if each.call.name != OWNER and each.axis and each.axis not in owned and not has_other_axes:
            text = f"no Amci3601 joins axis {each.axis} with a module: {each.call.name} moves nothing"
            facts.remark("block-order", each.place, text)


def called_twice(points: Placed, facts: Facts) -> None:
    """Note the instances of blocks that are called twice in a scan."""
    first: dict[str, tuple[Point, FileLine]] = {}
    for point, place in points:
        name = _instance(point)
        before, at = first.setdefault(name, (point, place)) if name else (point, place)
        both = AllOf((before.condition, point.condition))
        if before is not point and (point.is_rung or before.is_rung or not never(both)):
            text = f"{name.capitalize()} is called in line {at.line} already: it runs twice in a scan"
            facts.remark("block-twice", place, text)


def parameters_out_of_range(
    points: Placed, values: Values, tags: Mapping[str, Tag], limits: Limits
) -> Iterator[LocalFinding]:
    """Yield the numbers that the program itself writes to parameters of motion blocks."""
    target_range = (PARAMETER_MIN, PARAMETER_MAX)
    ranges = {
        "POSITION": target_range,
        "DISTANCE": target_range,
        "VELOCITY": (-limits.speed, limits.speed),
        "ACCELERATION": (0, limits.rate),
        "DECELERATION": (0, limits.rate),
    }
    for point, place in points:
        step = point.step
        if step.name not in ("MOV", ":=") or point.argument:
            continue
        source, target = step.operands[:2] if step.name == "MOV" else reversed(step.operands[:2])
        if not isinstance(target, Place) or not _is_block(tags.get(tag_in(target.leaf.path).upper())):
            continue
        least, most = ranges.get(target.leaf.path.upper().rpartition(".")[2], (None, None))
        found = values.of(source)
        if least is not None and most is not None and found.outside(least, most):
            yield LocalFinding(place, f"{target.text} is {found}: must be {least} to {most}")


def _is_block(tag: Tag | None) -> bool:
    return tag is not None and getattr(tag.type, "name", "").upper().startswith(("MC_", "MOVEREG"))


def _instance(point: Point) -> str:
    """Return the instance that an instruction runs, in capitals; "" if it runs none."""
    first = point.step.operands[0] if point.step.operands else None
    group = first.instance if isinstance(first, AddOnCall) else first
    if not isinstance(group, Group) or not (isinstance(first, AddOnCall) or Use.BLOCK in point.step.uses):
        return ""
    return "" if any(not isinstance(each, Constant) for each in group.indices) else group.text.upper()
