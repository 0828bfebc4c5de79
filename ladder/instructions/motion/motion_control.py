"""The bits of a MOTION_INSTRUCTION, and the codes of its ERR [MOTION-RM002, appendix]."""

from __future__ import annotations

from ...interpreter.files import Members
from ...model.operands import Resolved

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
    """An instruction was refused; `code` is the value for ERR."""

    def __init__(self, code: int) -> None:
        self.code = code


Argument = Resolved | str
"""An operand: a number, a tag or a keyword."""


class MotionControl(Members):
    """A MOTION_INSTRUCTION in a scan."""

    @property
    def ticket(self) -> int:
        """Number of the instruction's request to the axis; 0 if there is none."""
        return self._machine.whole(self["~ticket"])

    @ticket.setter
    def ticket(self, value: int) -> None:
        self.set(**{"~ticket": value})

    @property
    def claim(self) -> int:
        """The instruction's number in the upper 32 bits, and its request's number in the lower 32 bits."""
        return self._machine.whole(self["~number"]) << 32 | self.ticket

    def begin(self, ticket: int = 0) -> None:
        """Set the bits of an instruction that has begun."""
        self.set(EN=True, DN=False, ER=False, IP=False, PC=False, AC=False, ACCEL=False, DECEL=False, ERR=0)
        self.ticket = ticket

    def refuse(self, error: int) -> None:
        """Set the bits of a refused or failed instruction, with its ERR."""
        self.set(ER=True, IP=False, AC=False, ERR=error)
