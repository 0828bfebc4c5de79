"""TOD and FRD: convert integers to binary-coded decimal and back, four bits per digit [1756-RM003N]."""

from __future__ import annotations

from ..interpreter import Interpreter
from ..model.arithmetic import from_digits, to_digits
from ..model.operands import Place, Resolved
from ..model.spec import Use, action


def _tod(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Store an integer as BCD.

    If the integer is out of range, report an overflow, and store 0 (if negative) or the low digits.
    """
    value = machine.integer(source)
    digits = target.type.bits // 4
    if value < 0 or value >= 10**digits:
        machine.fault_log.overflow(machine.site)
        value = 0 if value < 0 else value % 10**digits
    machine.store_bits(target, to_digits(value))


TOD = action("TOD/TO_BCD", Use.INTEGER, Use.INTEGER_TARGET, run=_tod, faults=False)
FRD = action(
    "FRD/BCD_TO",
    Use.INTEGER,
    Use.INTEGER_TARGET,
    run=lambda machine, source, target: machine.store(target, from_digits(machine.filled(source))),
)
