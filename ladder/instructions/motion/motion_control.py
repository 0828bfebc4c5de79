"""The bits of a MOTION_INSTRUCTION, and the codes of its ERR [MOTION-RM002, appendix]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operands import Resolved
from ...model.predefined.words import plain
from ...model.types import DINT

SERVO_OFF, SHUT_DOWN, AXIS_NOT_CONFIGURED, OUT_OF_RANGE = 5, 7, 11, 13
AXIS_FAULT, IN_MOTION, ILLEGAL_CHANGE, ILLEGAL = 20, 22, 23, 25
QUEUE_FULL = 43
"""Codes of ERR [MOTION-RM002, appendix "Error codes"]."""

ERRORS = {
    SERVO_OFF: "servo off",
    SHUT_DOWN: "shut down",
    AXIS_NOT_CONFIGURED: "not configured",
    OUT_OF_RANGE: "operand out of range",
    AXIS_FAULT: "axis faulted",
    IN_MOTION: "in motion; a 3601 can't superimpose",
    ILLEGAL_CHANGE: "no motion of this kind to change",
    ILLEGAL: "not available for this axis",
    QUEUE_FULL: "a path is already waiting",
}
"""Meanings of the ERR codes."""


class MotionError(Exception):
    """A refused instruction: `code` is for ERR."""

    def __init__(self, code: int) -> None:
        self.code = code


MotionOperand = Resolved | str
"""An operand: a number, a tag, or a keyword."""


class MotionControl(Members):
    """A MOTION_INSTRUCTION in a scan."""

    @property
    def ticket(self) -> int:
        """Number of the instruction's request to the axis; 0 if none."""
        return self._machine.whole(self["~ticket"])

    @ticket.setter
    def ticket(self, value: int) -> None:
        self.set(**{"~ticket": value})

    @property
    def claim(self) -> int:
        """The instruction's number in the upper 32 bits, and its request's number in the lower 32."""
        return self._machine.whole(self["~number"]) << 32 | self.ticket

    def begin(self, ticket: int = 0) -> None:
        """Set the bits of an instruction that has begun."""
        self.set(EN=True, DN=False, ER=False, IP=False, PC=False, AC=False, ACCEL=False, DECEL=False, ERR=0)
        self.ticket = ticket

    def refuse(self, error: int) -> None:
        """Set the bits of a refused or failed instruction, with its ERR."""
        self.set(ER=True, IP=False, AC=False, ERR=error)


def word_of(machine: Interpreter, operand: MotionOperand, words: tuple[str, ...]) -> str:
    """Return a keyword operand in the form of `plain`; "" for a number beyond its list."""
    if isinstance(operand, str):
        return operand
    number = int(machine.number(operand, DINT.bits))
    return plain(words[number]) if 0 <= number < len(words) else ""


def number_of(machine: Interpreter, operand: MotionOperand) -> float:
    """Return a numeric operand; 0 for a keyword."""
    return 0.0 if isinstance(operand, str) else float(machine.number(operand, -1))


class Starter(NamedTuple):
    """How an instruction begins."""

    begin: Callable[..., None]  # raises a MotionError for a refused instruction
    moves: bool = False  # whether it needs an axis that accepts motion


Starters = Mapping[str, Starter]
"""Starters by names of instructions."""


def start(starters: Starters, name: str, check_ready: Callable[[], None], *arguments: Any) -> None:
    """Begin an instruction by its starter, or raise a MotionError.

    Args:
        starters: the instructions that the axis or coordinate system has.
        name: name of the instruction.
        check_ready: raises a MotionError if the axis accepts no motion at present.
        arguments: arguments of the starter's function.
    """
    if name not in starters:
        raise MotionError(ILLEGAL)
    starter = starters[name]
    if starter.moves:
        check_ready()
    starter.begin(*arguments)
