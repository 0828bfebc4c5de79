"""Subscripts that a FOR loop takes out of their array."""

from __future__ import annotations

from collections.abc import Iterator

from ....ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from ..facts import Facts, FileLine
from ..logic import AllOf, Compare, leaves, never
from .conditions import key_of
from .values import Values, type_range
from .walk import Point


def note_subscripts(
    point: Point, place: FileLine, values: Values, facts: Facts, seen: set[tuple[str, str]]
) -> None:
    """Note the subscripts of an instruction that leave their array: a major fault of type 4, code 20.

    Args:
        seen: routines and subscripts that are noted already.
    """
    for operand in point.step.operands:
        for each, index, size in _subscripts(operand):
            key = point.routine.name, each.text.partition("]")[0].upper()
            if key in seen:
                continue
            reached = values.of(index)
            count = _counted(index, values)
            if count is not None and reached.is_known and not 0 <= reached.least <= reached.most < size:
                offset = reached.most - values.of(count).most
                if not _is_guarded(point, count, size - 1 - offset):
                    text = f"{each.text}: the subscript is {reached}, and allowed are 0 to {size - 1}"
                    facts.remark("subscript", place, text)
                    seen.add(key)


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


def _counted(index: Resolved, values: Values) -> Place | None:
    """Return the number that FOR counts, of a subscript `I`, `I + 1` or `I - 1`; None for another one."""
    place = index.operands[0] if isinstance(index, Calculation) and index.name in "+-" else index
    others = index.operands[1:] if isinstance(index, Calculation) else ()
    if not isinstance(place, Place) or not all(isinstance(each, Constant) for each in others):
        return None
    is_counted = place.type.is_integer and not place.indices and place.bit is None
    return (
        place if is_counted and values.of(place) != type_range(place.type) and values.counts(place) else None
    )


def _is_guarded(point: Point, count: Place, most: float) -> bool:
    """Whether a condition keeps a number from being above this."""
    key = key_of(count)
    names = {
        each.name
        for each in leaves(point.condition)
        if isinstance(each, Compare) and each.name.partition("#")[0] == key
    }
    return any(never(AllOf((Compare(name, ">", most), point.condition))) for name in sorted(names))
