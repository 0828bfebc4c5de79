"""Finds instructions in routines, and the names in their first operands."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.tree import Address, Instruction


def named_first(routines: Iterable[Routine], *instructions: str) -> Iterator[str]:
    """Yield the first operand of each of these instructions, if it is a name."""
    for instruction in all_instructions(routines):
        if instruction.name in instructions and instruction.operands:
            target = instruction.operands[0]
            if isinstance(target, Address) and not target.steps:
                yield target.name


def all_instructions(routines: Iterable[Routine]) -> Iterator[Instruction]:
    """Yield the instructions of rungs and of structured text."""
    for routine in routines:
        yield from (instruction for _, instruction in routine.instructions())
