"""Rungs with the current values of PRE and ACC, LEN and POS."""

from __future__ import annotations

from dataclasses import replace

from ..instructions import BY_NAME
from ..model.routine import Routine
from ..model.spec import WITH_PRESETS, Use
from ..model.tree import Address, Branch, Element, Instruction, MemberStep, Operand, Series, number
from ..run.view import Tags


def with_values(routine: Routine, tags: Tags) -> Routine:
    """Return a routine with current PRE, ACC, LEN and POS; computed subscripts keep the rung's values."""
    rungs = tuple(replace(rung, series=_series(rung.series, tags)) for rung in routine.rungs)
    return replace(routine, rungs=rungs)


def _series(series: Series, tags: Tags) -> Series:
    return tuple(_element(each, tags) for each in series)


def _element(element: Element, tags: Tags) -> Element:
    if isinstance(element, Branch):
        return Branch(tuple(_series(leg, tags) for leg in element.legs))
    spec = BY_NAME.get(element.name)
    if spec is None or Use.PRESET not in spec.operands:
        return element
    place = next(number for number, use in enumerate(spec.operands) if use in WITH_PRESETS)
    parts = iter(WITH_PRESETS[spec.operands[place]])
    shown = [
        _value(element.operands[place], next(parts), tags, said) if use is Use.PRESET else said
        for use, said in zip(spec.operands, element.operands, strict=False)
    ]
    return Instruction(element.name, tuple(shown))


def _value(structure: Operand, part: str, tags: Tags, said: Operand) -> Operand:
    assert isinstance(structure, Address)
    try:
        return number(tags[str(Address(structure.name, (*structure.steps, MemberStep(part))))])
    except ValueError:  # see `with_values`
        return said
