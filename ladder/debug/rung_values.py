"""Shows rungs with the current values of PRE, ACC, LEN and POS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..model.routine import Routine
from ..model.spec import Spec
from ..model.tree import Address, Branch, Element, Instruction, Operand, Series, number
from ..run.view import Tags


def with_values(routine: Routine, tags: Tags, specs: Mapping[str, Spec]) -> Routine:
    """Return a routine with current PRE, ACC, LEN and POS; computed subscripts keep the written values."""
    rungs = tuple(replace(rung, series=_series(rung.series, tags, specs)) for rung in routine.rungs)
    return replace(routine, rungs=rungs)


def _series(series: Series, tags: Tags, specs: Mapping[str, Spec]) -> Series:
    return tuple(_element(element, tags, specs) for element in series)


def _element(element: Element, tags: Tags, specs: Mapping[str, Spec]) -> Element:
    """Return an element with the current values of operands that repeat members of a structure."""
    if isinstance(element, Branch):
        return Branch(tuple(_series(leg, tags, specs) for leg in element.legs))
    spec = specs.get(element.name)
    if spec is None or not spec.members:
        return element
    operands = [*element.operands]
    for index, (structure_index, member) in spec.members.items():
        if index < len(operands):
            operands[index] = _value(operands[structure_index], member, tags, operands[index])
    return Instruction(element.name, tuple(operands))


def _value(structure: Operand, member: str, tags: Tags, written: Operand) -> Operand:
    """Return the current value of a member, or the operand as written if a subscript is computed."""
    assert isinstance(structure, Address)
    try:
        return number(tags[str(structure.member(member))])
    except ValueError:
        return written
