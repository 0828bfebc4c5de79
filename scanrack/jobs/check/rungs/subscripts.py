"""Subscripts in FOR loops that are out of bounds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain

from scanrack.ladder.model.operands import Calculation, Constant, Place, Resolved

from ..facts import Facts
from ..logic import AllOf, Compare, base_of, leaves, never
from ..ranges import Range
from .operands import key_of, parts_of
from .walk import Point


def note_subscripts(
    point: Point, counts: Mapping[int, Mapping[str, Range]], facts: Facts, noted: set[tuple[str, str]]
) -> None:
    """Note out-of-bounds subscripts of an instruction, which are a major fault, type 4, code 20.

    Args:
        counts: for each instruction in the body of a FOR, the ranges of the counts, by path in capitals.
        noted: routines and subscripts that have already been noted.
    """
    counts_here = counts.get(point.step.site, {})
    for operand, index, size in _subscripts(point) if counts_here else ():
        key = point.routine.name, operand.text.partition("]")[0].upper()
        count, offset = _count_and_offset(index)
        range_ = counts_here.get(count)
        if range_ is None or key in noted:
            continue
        subscript = Range(range_.least + offset, range_.most + offset)
        above = subscript.most >= size and not _is_guarded(point, count, ">", size - 1 - offset)
        below = subscript.least < 0 and not _is_guarded(point, count, "<", -offset)
        if above or below:
            text = f"{operand.text}: the subscript is {subscript}: must be 0 to {size - 1}"
            facts.remark("subscript", point.place, text)
            noted.add(key)


def note_lengths(point: Point, facts: Facts) -> None:
    """Note copies and fills that are longer than their arrays."""
    step = point.step
    if step.name not in ("COP", "CPS", "FLL") or not isinstance(step.operands[2], Constant):
        return
    source, target, length = step.operands[0], step.operands[1], int(step.operands[2].value)
    is_same = isinstance(source, Place) and isinstance(target, Place) and source.leaf.type == target.leaf.type
    for operand in (source, target) if step.name != "FLL" and is_same else (target,):
        elements_left = _elements_from(operand)
        if elements_left is not None and length > elements_left:
            text = f"{step.name} of {length} elements: only {elements_left} are left from {operand.text}"
            facts.remark("subscript", point.place, text)
            return


def _elements_from(operand: object) -> int | None:
    """Return the number of array elements from an operand to the end; None if it is unknown."""
    if not isinstance(operand, Place) or not operand.leaf.dims or operand.frame:
        return None
    return None if operand.fixed_index is None else operand.leaf.size - operand.fixed_index


def _subscripts(point: Point) -> Iterator[tuple[Place, Resolved, int]]:
    """Yield the subscripts and bit numbers in an instruction, each with the number of elements or bits."""
    for part in chain.from_iterable(map(parts_of, point.step.operands)):
        if isinstance(part, Place):
            for index, size in zip(part.indices, part.leaf.dims, strict=True):
                yield part, index, size
            if part.bit is not None:
                yield part, part.bit, part.leaf.type.bits


def _count_and_offset(index: Resolved) -> tuple[str, float]:
    """Return the key and offset of a subscript `I`, `I + 1` or `I - 1`; "" and 0 for any other."""
    number, offset = index, 0.0
    match index:
        case Calculation("+" | "-" as sign, (number, Constant() as added)):
            offset = added.value if sign == "+" else -added.value
    if isinstance(number, Place) and not number.indices and number.bit is None:
        return key_of(number), offset
    return "", 0


def _is_guarded(point: Point, count: str, relation: str, bound: float) -> bool:
    """Whether a condition limits a number to a bound."""
    compared = (leaf for leaf in leaves(point.condition) if isinstance(leaf, Compare))
    names = sorted({comparison.name for comparison in compared if base_of(comparison.name) == count})
    return any(never(AllOf((Compare(name, relation, bound), point.condition))) for name in names)
