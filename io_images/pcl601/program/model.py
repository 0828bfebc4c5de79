"""A stored program in memory: its steps, its directives and what is wrong with it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from .instructions import BY_NAME, Instruction

Value = int | str


class ProgramError(ValueError):
    """A program that can't be stored.

    Attributes:
        line: the line of the text, from 1; None where there is no text.
        column: the column, from 1; None where the line as a whole is meant.
        reason: what is wrong and what is allowed.
    """

    def __init__(self, reason: str, line: int | None = None, column: int | None = None) -> None:
        place = ", ".join(f"{name} {n}" for name, n in (("line", line), ("column", column)) if n is not None)
        super().__init__(f"{place}: {reason}" if place else reason)
        self.line, self.column, self.reason = line, column, reason


@dataclass(frozen=True, slots=True)
class Step:
    """One instruction with its values.

    Attributes:
        name: of the row of the instruction table.
        values: one for each operand: numbers, 1 or 0 for a word, digits with input or output 1 in
            bit 0, a label's name, the characters of a text.
    """

    name: str
    values: tuple[Value, ...] = ()

    @property
    def instruction(self) -> Instruction:
        """The row of the instruction table."""
        return BY_NAME[self.name]

    @property
    def size(self) -> int:
        """Bytes of program memory."""
        text = len(str(self.values[0])) if self.name == "TEXT" else 0
        return self.instruction.size + text

    @property
    def target(self) -> str | None:
        """The label that it may jump to."""
        jumps = self.name == "GOTO" or self.name.startswith("LOOP")
        return str(self.values[-1]) if jumps else None


@dataclass(frozen=True)
class Program:
    """A stored program.

    Attributes:
        steps: the instructions, in order.
        title: what it is about; directive `.title`.
        axis: the address of the unit it is for; directive `.axis`.
        autostart: whether loading it turns autorun on or off; directive `.autostart`.
    """

    steps: tuple[Step, ...]
    title: str | None = None
    axis: int | None = None
    autostart: bool | None = None

    @property
    def size(self) -> int:
        """Bytes of program memory, of `CAPACITY_BYTES`."""
        return sum(step.size for step in self.steps)

    @cached_property
    def labels(self) -> Mapping[str, int]:
        """The index of the LABEL step by the label's name."""
        return {str(s.values[0]): index for index, s in enumerate(self.steps) if s.name == "LABEL"}
