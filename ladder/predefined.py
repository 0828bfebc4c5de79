"""All predefined data types, by name: those that instructions need, those of motion, and a few more.

Types of the last kind are here for logic that copies, moves or reads them; no instruction works on them.
"""

from __future__ import annotations

from collections.abc import Mapping

from .motion_types import MOTION_TYPES
from .types import BOOL, DINT, SINT, TYPES, DataType, Member, Structure


def _members(kind: DataType, names: str) -> tuple[Member, ...]:
    return tuple(Member(name, kind) for name in names.split())


def _flags(names: str) -> tuple[Member, ...]:
    """Status bits in the first DINT, from bit 31 down."""
    return tuple(Member(name, BOOL, bit=31 - number) for number, name in enumerate(names.split()))


SERIAL_PORT_CONTROL = Structure(
    "SERIAL_PORT_CONTROL",
    (*_flags("EN EU DN RN EM ER FD"), *_members(DINT, "LEN POS ERROR")),
)
"""What the instructions of the serial port work on [1756-RM003N, ASCII serial port instructions]."""

PHASE_INSTRUCTION = Structure(
    "PHASE_INSTRUCTION", (Member("Status", DINT), *_members(BOOL, "EN ER PC IP WA ABORT"))
)

PREDEFINED_TYPES: Mapping[str, DataType] = {
    **TYPES,
    **MOTION_TYPES,
    SERIAL_PORT_CONTROL.name: SERIAL_PORT_CONTROL,
    PHASE_INSTRUCTION.name: PHASE_INSTRUCTION,
    "CONNECTION_STATUS": Structure("CONNECTION_STATUS", _members(BOOL, "RunMode ConnectionFaulted")),
    "EXT_ROUTINE_CONTROL": Structure(
        "EXT_ROUTINE_CONTROL",
        (*_members(SINT, "ErrorCode NumParams"), *_members(BOOL, "EN ReturnsValue DN ER")),
    ),
}
"""By name in capitals: the types that every program may use."""
