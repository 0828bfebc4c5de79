"""Instructions for the serial port [1756-RM003N, ASCII serial port instructions].

The controller has no port in user mode, so each instruction ends with ER and ERROR 4, "the port is in system
mode". A stub can return another result.
"""

from __future__ import annotations

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operands import Group, Resolved
from ...model.predefined.structures import SERIAL_PORT_CONTROL
from ...model.spec import Spec, Use, always

SYSTEM_MODE = 4


def _run(machine: Interpreter, power: bool, *operands: Resolved) -> None:
    """End with ER at once if the rung has risen; clear EN if it is false."""
    for operand in operands:
        if isinstance(operand, Group) and operand.type == SERIAL_PORT_CONTROL:
            control = Members(machine, operand)
            if power and not control["EN"]:
                control.set(EN=True, ER=True, DN=False, EM=False, RN=False, ERROR=SYSTEM_MODE)
            elif not power:
                control.set(EN=False)


def _row(name: str, *operands: Use) -> Spec:
    return always(name, Use.IGNORED, *operands, run=_run)


_STRING = (Use.IGNORED, Use.SERIAL, Use.IGNORED, Use.IGNORED)

ABL = _row("ABL", Use.SERIAL, Use.IGNORED)
ACB = _row("ACB", Use.SERIAL, Use.IGNORED)
ACL = _row("ACL", Use.KEYWORD, Use.KEYWORD)
AHL = _row("AHL", Use.IGNORED, Use.IGNORED, Use.SERIAL, Use.IGNORED)
ARD = _row("ARD", *_STRING)
ARL = _row("ARL", *_STRING)
AWA = _row("AWA", *_STRING)
AWT = _row("AWT", *_STRING)
