"""A stored program in memory: steps and directives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from .instructions import BY_NAME, Instruction

Value = int | str


class ProgramError(ValueError):
    """The program can't be stored.

    Attributes:
        line: line number, from 1; None for a program without text.
        column: column number, from 1; None for a whole line.
        reason: the error, with the allowed values.
    """

    def __init__(self, reason: str, line: int | None = None, column: int | None = None) -> None:
        numbers = {"line": line, "column": column}
        location = ", ".join(f"{name} {number}" for name, number in numbers.items() if number is not None)
        super().__init__(f"{location}: {reason}" if location else reason)
        self.line, self.column, self.reason = line, column, reason


@dataclass(frozen=True, slots=True)
class Step:
    """One instruction with its values.

    Attributes:
        name: name in the instruction table.
        values: one per operand: a number; 1 or 0 for a word; digits as a number, with input or output 1 in
            bit 0; the name of a label; the characters of a text.
    """

    name: str
    values: tuple[Value, ...] = ()

    @property
    def instruction(self) -> Instruction:
        """Its row in the instruction table."""
        return BY_NAME[self.name]

    @property
    def size(self) -> int:
        """Bytes of program memory."""
        text = len(str(self.values[0])) if self.name == "TEXT" else 0
        return self.instruction.size + text

    @property
    def target(self) -> str | None:
        """The label that it jumps to; None for other instructions."""
        jumps = self.name == "GOTO" or self.name.startswith("LOOP")
        return str(self.values[-1]) if jumps else None


@dataclass(frozen=True)
class Program:
    """A stored program."""

    steps: tuple[Step, ...]
    title: str | None = None  # directive `.title`
    axis: int | None = None  # address of its unit; directive `.axis`
    autostart: bool | None = None  # whether loading turns autorun on; directive `.autostart`

    @property
    def size(self) -> int:
        """Bytes of program memory, up to `CAPACITY_BYTES`."""
        return sum(step.size for step in self.steps)

    @cached_property
    def labels(self) -> Mapping[str, int]:
        """Index of each LABEL step by its name."""
        return {str(step.values[0]): index for index, step in enumerate(self.steps) if step.name == "LABEL"}
