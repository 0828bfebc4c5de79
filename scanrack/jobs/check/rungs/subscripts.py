"""Subscripts that a FOR loop takes out of their array."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved

from ..facts import Facts, FileLine
from ..logic import AllOf, Compare, leaves, never
from ..ranges import Range
from .conditions import key_of
from .walk import Point


def note_subscripts(
    point: Point,
    place: FileLine,
    counts: Mapping[int, Mapping[str, Range]],
    facts: Facts,
    seen: set[tuple[str, str]],
) -> None:
    """Note the subscripts of an instruction that leave their array: a major fault of type 4, code 20.

    Args:
        counts: what FOR counts, by instruction in its body, and by path in capitals.
        seen: routines and subscripts that are noted already.
    """
    for operand in point.step.operands:
        for each, index, size in _subscripts(operand):
            key = point.routine.name, each.text.partition("]")[0].upper()
            if key in seen:
                continue
            count, offset = _counted(index)
            counted = counts.get(point.step.site, {}).get(key_of(count)) if count is not None else None
            if count is None or counted is None:
                continue
            reached = Range(counted.least + offset, counted.most + offset)
            above = reached.most >= size and not _is_guarded(point, count, ">", size - 1 - offset)
            below = reached.least < 0 and not _is_guarded(point, count, "<", -offset)
            if above or below:
                text = f"{each.text}: the subscript is {reached}; must be 0 to {size - 1}"
                facts.remark("subscript", place, text)
                seen.add(key)


def note_lengths(point: Point, place: FileLine, facts: Facts) -> None:
    """Note copies and fills of more elements than their arrays have."""
    step = point.step
    if step.name not in ("COP", "CPS", "FLL") or not isinstance(step.operands[2], Constant):
        return
    source, target, length = step.operands[0], step.operands[1], int(step.operands[2].value)
    ends = [target]
    is_same = isinstance(source, Place) and isinstance(target, Place) and source.leaf.type == target.leaf.type
    if step.name != "FLL" and is_same:
        ends.insert(0, source)
    for each in ends:
        if isinstance(each, Place) and each.leaf.dims and not each.frame and each.fixed_index is not None:
            there = each.leaf.size - each.fixed_index
            if length > there:
                text = f"{step.name} of {length} elements: {each.text} has {there} from there on"
                facts.remark("subscript", place, text)
                return


def _subscripts(operand: object) -> Iterator[tuple[Place | Group, Resolved, int]]:
    """Yield the computed subscripts and bits in an operand, each with its number of elements."""
    if isinstance(operand, Calculation):
        for part in operand.operands:
            yield from _subscripts(part)
    if isinstance(operand, Place):
        for index, size in zip(operand.indices, operand.leaf.dims, strict=True):
            yield operand, index, size
        if operand.bit is not None:
            yield operand, operand.bit, operand.leaf.type.bits


def _counted(index: Resolved) -> tuple[Place | None, float]:
    """Return the number in a subscript `I`, `I + 1` or `I - 1`, and what is added; None for another one."""
    place, offset = index, 0.0
    if isinstance(index, Calculation) and index.name in ("+", "-") and len(index.operands) == 2:
        place, other = index.operands
        if not isinstance(other, Constant):
            return None, 0
        offset = other.value if index.name == "+" else -other.value
    is_count = isinstance(place, Place) and not place.indices and place.bit is None
    return (place, offset) if is_count and isinstance(place, Place) else (None, 0)


def _is_guarded(point: Point, count: Place, relation: str, bound: float) -> bool:
    """Whether a condition keeps a number from being beyond a bound."""
    key = key_of(count)
    names = {
        each.name
        for each in leaves(point.condition)
        if isinstance(each, Compare) and each.name.partition("#")[0] == key
    }
    beyond = (Compare(name, relation, bound) for name in sorted(names))
    return any(never(AllOf((each, point.condition))) for each in beyond)
