"""Operands of instructions: their uses, parts and names."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import Any, TypeGuard

from scanrack.ladder.debug.crossref import TARGETS
from scanrack.ladder.model.operands import Calculation, Constant, Group, Place, Resolved
from scanrack.ladder.model.spec import Use
from scanrack.ladder.state.lowered import LoweredRoutine, LoweredStep


def uses_of(step: LoweredStep) -> Iterable[tuple[Use, Any]]:
    """Return the operands of an instruction, each with its use."""
    return zip(step.uses, step.operands, strict=False)


def steps_in(*routines: LoweredRoutine) -> Iterator[LoweredStep]:
    """Yield the instructions of routines, including copies of add-on parameters."""
    return (step for routine in routines for line in routine.lines for step in line.all_steps)


def written_by(step: LoweredStep) -> Iterator[Any]:
    """Yield the operands that an instruction writes."""
    return (operand for use, operand in uses_of(step) if use in TARGETS)


def first_of(step: LoweredStep, names: Collection[str]) -> Any:
    """Return the first operand of an instruction with one of the names; None for other instructions."""
    return step.operands[0] if step.name in names and step.operands else None


def group_of(step: LoweredStep, names: Collection[str]) -> Group | None:
    """Return the structure, such as a timer, that `first_of` finds; None for any other operand."""
    group = first_of(step, names)
    return group if isinstance(group, Group) else None


def own_group_of(step: LoweredStep, names: Collection[str]) -> Group | None:
    """Return the structure that `group_of` finds; None inside add-on instructions."""
    group = group_of(step, names)
    return None if group is None or group.frame else group


def parts_of(operand: object) -> Iterator[object]:
    """Yield an operand and all parts of its expression, outer parts first."""
    yield operand
    if isinstance(operand, Calculation):
        for part in operand.operands:
            yield from parts_of(part)


def calculations_of(step: LoweredStep, names: Collection[str]) -> Iterator[Calculation]:
    """Yield the operators and functions with the given names in an instruction's operands."""
    for operand in step.operands:
        for part in parts_of(operand):
            if isinstance(part, Calculation) and part.name in names:
                yield part


def divisors_of(step: LoweredStep) -> Iterator[Resolved]:
    """Yield the operands by which an instruction divides, including its expressions."""
    if step.name in ("DIV", "MOD"):
        yield from step.operands[1:2]
    for calculation in calculations_of(step, ("/", "MOD")):
        yield calculation.operands[1]


def is_zero(operand: object) -> bool:
    """Whether an operand is the constant 0."""
    return isinstance(operand, Constant) and not operand.value


def is_input(operand: Place | None) -> TypeGuard[Place]:
    """Whether an operand is in the input image of a slot."""
    return operand is not None and operand.leaf.slot is not None and not operand.leaf.output


def is_fixed(operand: Place | Group) -> bool:
    """Whether all subscripts of an operand are constants."""
    return all(isinstance(index, Constant) for index in operand.indices)


def path_of(operand: Place | Group) -> str:
    """Return the path of a tag, in capitals."""
    return operand.path.upper()


def around(path: str) -> Iterator[str]:
    """Yield the paths of the structures that contain a path.

    >>> list(around("LINE.AXIS.GO"))
    ['LINE.AXIS', 'LINE']
    """
    while "." in path:
        path = path.rpartition(".")[0]
        yield path


def key_of(place: Place) -> str:
    """Return the name of a value; equal places have equal names. A computed subscript becomes "?"."""
    return f"{path_of(place)}{_subscripts(place)}"


def part_of(operand: Place | Group, tag: str) -> str:
    """Return the part of a tag in an operand: the rest of its path, its subscripts and its bit."""
    return f"{path_of(operand)[len(tag) :]}{_subscripts(operand)}"


def _subscripts(operand: Place | Group) -> str:
    bit = operand.bit if isinstance(operand, Place) else None
    indices = "".join(f"[{_index(index)}]" for index in operand.indices)
    return indices if bit is None else f"{indices}.{_index(bit)}"


def _index(index: Resolved) -> str:
    return str(index.value) if isinstance(index, Constant) else "?"
