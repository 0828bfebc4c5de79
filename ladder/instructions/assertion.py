"""ASSERT, for test routines; controllers do not have this instruction.

    XIC(Done)ASSERT(Strokes.ACC = 1);     rungs: reached with power
    IF Done THEN ASSERT(Strokes.ACC = 1); END_IF;

A false assertion is a major fault of type 4, code 990, the first code that 1756-PM014 leaves to users. The
program therefore stops at the failed line wherever it runs.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..interpreter import Interpreter
from ..model.operands import Calculation, Group, Place, Resolved
from ..model.spec import Use, action


def _assert(machine: Interpreter, condition: Resolved) -> None:
    machine.fault_log.check(
        machine.site, machine.condition(condition), lambda: dict(_values(machine, condition))
    )


def _values(machine: Interpreter, operand: Resolved) -> Iterator[tuple[str, str]]:
    """Yield the tags of an operand with their values."""
    if isinstance(operand, Calculation):
        for inner in operand.operands:
            yield from _values(machine, inner)
    elif isinstance(operand, Place):
        value = machine.get(operand)
        yield operand.text, str(int(value) if isinstance(value, bool) else value)
    elif isinstance(operand, Group):
        yield operand.text, repr(machine.text(operand).decode("latin-1"))


ASSERT = action("ASSERT", Use.TRUTH, run=_assert, captions=("Condition",))
