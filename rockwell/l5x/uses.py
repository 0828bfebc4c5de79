"""Calls in routines, and their instructions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from scanrack.ladder.model.routine import Routine
from scanrack.ladder.model.statements import Invocation, statements_in
from scanrack.ladder.model.tree import Address, Instruction, instructions_of


def named_first(routines: Iterable[Routine], *instructions: str) -> Iterator[str]:
    """Yield the first operand of each such instruction, if it is a name."""
    for each in all_instructions(routines):
        if each.name in instructions and each.operands:
            target = each.operands[0]
            if isinstance(target, Address) and not target.steps:
                yield target.name


def all_instructions(routines: Iterable[Routine]) -> Iterator[Instruction]:
    """Yield the instructions of rungs and of structured text."""
    for routine in routines:
        yield from (instruction for _, instruction in numbered_instructions(routine))


def numbered_instructions(routine: Routine) -> Iterator[tuple[int, Instruction]]:
    """Yield the instructions of a routine with their rung or line numbers."""
    for number, rung in enumerate(routine.rungs):
        yield from ((number, each) for each in instructions_of(rung.series))
    for statement in statements_in(routine.block):
        if isinstance(statement, Invocation):
            yield statement.line, statement.instruction
