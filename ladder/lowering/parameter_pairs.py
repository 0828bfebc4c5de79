"""Pairs of parameters that have the same type: JSR with SBR, and RET with JSR."""

from __future__ import annotations

from collections.abc import Iterator

from ..model.tree import Address, Instruction, Number, Operand

Pair = tuple[str, Operand, Operand]
"""A program, and two of its operands that have the same type."""


class ParameterPairs:
    """Collects calls of routines, and pairs their parameters."""

    def __init__(self) -> None:
        self._calls: list[tuple[str, str, Instruction]] = []  # program, routine in capitals, JSR
        self._sides: dict[tuple[str, str], list[Instruction]] = {}  # SBR and RET of a routine

    def note(self, program: str, routine: str, instruction: Instruction) -> None:
        """Note a JSR, SBR or RET in a routine."""
        called = instruction.operands[0] if instruction.operands else None
        if instruction.name == "JSR" and isinstance(called, Address):
            self._calls.append((program, called.name.upper(), instruction))
        elif instruction.name in ("SBR", "RET"):
            self._sides.setdefault((program, routine.upper()), []).append(instruction)

    def __iter__(self) -> Iterator[Pair]:
        """Yield the pairs of operands with the same type."""
        for program, routine, call in self._calls:
            inputs, returns = _inputs_and_returns(call)
            for side in self._sides.get((program, routine), ()):
                passed = inputs if side.name == "SBR" else returns
                for outer, inner in zip(passed, side.operands, strict=False):
                    yield program, outer, inner


def _inputs_and_returns(call: Instruction) -> tuple[tuple[Operand, ...], tuple[Operand, ...]]:
    """Return the inputs and the returned values of a JSR."""
    count = call.operands[1] if len(call.operands) > 1 else None
    number = count.value if isinstance(count, Number) and isinstance(count.value, int) else 0
    return call.operands[2 : 2 + number], call.operands[2 + number :]
