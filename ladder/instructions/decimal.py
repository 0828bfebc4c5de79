"""TOD and FRD: an integer as binary coded decimal, four bits a digit, and back [1756-RM003N, conversions]."""

from __future__ import annotations

from ..interpreter import Interpreter
from ..operands import Place, Resolved
from ..spec import Use, action

__all__ = ["TOD", "FRD"]  # noqa: RUF022 - the manual's order


def to_digits(value: int) -> int:
    """Return a number from 0 as binary coded decimal.

    >>> hex(to_digits(1254))
    '0x1254'
    """
    return int(str(value), 16)


def from_digits(pattern: int) -> int:
    """Return the number of a pattern of binary coded decimal; a digit above 9 counts as it is.

    >>> from_digits(0x1254), from_digits(0x1A)
    (1254, 20)
    """
    value, weight = 0, 1
    while pattern:
        value += (pattern & 0xF) * weight
        pattern, weight = pattern >> 4, weight * 10
    return value


def _tod(machine: Interpreter, source: Resolved, target: Place) -> None:
    value = machine.integer(source)
    digits = target.type.bits // 4
    if value < 0 or value >= 10**digits:
        machine.fault_log.overflow(machine.site)
        value = 0 if value < 0 else value % 10**digits
    machine.store_bits(target, to_digits(value))


def _frd(machine: Interpreter, source: Resolved, target: Place) -> None:
    machine.store(target, from_digits(machine.filled(source)))


TOD = action("TOD/TO_BCD", Use.INTEGER, Use.INTEGER_TARGET, run=_tod)
FRD = action("FRD/BCD_TO", Use.INTEGER, Use.INTEGER_TARGET, run=_frd)
