"""All predefined data types, by name: those that instructions need, those of motion, and a few more.

Types of the last kind are here for logic that copies, moves or reads them; no instruction works on them.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, SINT, TYPES, DataType, Member, Structure
from .block_types import BLOCK_TYPES
from .motion_types import MOTION_TYPES
from .safety_types import SAFETY
from .slc_types import SLC_TYPES


def _members(kind: DataType, names: str) -> tuple[Member, ...]:
    return tuple(Member(name, kind) for name in names.split())


def _flags(names: str) -> tuple[Member, ...]:
    return tuple(Member(name, BOOL, bit=31 - number) for number, name in enumerate(names.split()))


SERIAL_PORT_CONTROL = Structure(
    "SERIAL_PORT_CONTROL",
    (*_flags("EN EU DN RN EM ER FD"), *_members(DINT, "LEN POS ERROR")),
)
"""What the instructions of the serial port work on [1756-RM003N, ASCII serial port instructions]."""

HMIBC = Structure("HMIBC", _members(BOOL, "EnableIn EnableOut ProgFB ButtonState HMIButtonSet"))
"""What HMIBC works on: a page or a test sets ButtonState."""

_PLAIN = (
    Structure("CONNECTION_STATUS", _members(BOOL, "RunMode ConnectionFaulted")),
    Structure("PHASE_INSTRUCTION", (*_members(DINT, "Status"), *_members(BOOL, "EN ER PC IP WA ABORT"))),
    Structure("DATALOG_INSTRUCTION", (*_members(BOOL, "EN DN ER IP"), *_members(DINT, "ERR"))),
    Structure(
        "EXT_ROUTINE_CONTROL",
        (*_members(SINT, "ErrorCode NumParams"), *_members(BOOL, "EN ReturnsValue DN ER")),
    ),
    Structure("ALARM_SET_CONTROL", (*_members(BOOL, "LastState"), *_members(DINT, "InstanceID"))),
    Structure(
        "PHASE",
        (
            *_members(DINT, "State Substate StepIndex Failure UnitID Owner PendingRequest"),
            *_members(
                BOOL,
                "Running Holding Restarting Stopping Aborting Resetting Idle Held Complete Stopped Aborted "
                "Pausing Paused AutoPause Step NewInputParameters Producing Standby",
            ),
        ),
    ),
    Structure(
        "SFC_STEP",
        (
            *_members(DINT, "Status"),
            *_members(BOOL, "X FS SA LS DN OV AlarmEn AlarmLow AlarmHigh Reset PauseTimer"),
            *_members(DINT, "PRE T TMax Count LimitLow LimitHigh"),
        ),
    ),
    Structure(
        "SFC_ACTION", (*_members(DINT, "Status"), *_members(BOOL, "A Q"), *_members(DINT, "PRE T Count"))
    ),
    Structure("SFC_STOP", (*_members(DINT, "X Count"), *_members(BOOL, "Reset"))),
)

PREDEFINED_TYPES: Mapping[str, DataType] = {
    **TYPES,
    **MOTION_TYPES,
    **BLOCK_TYPES,
    **{each.name: each for each in SAFETY.values()},
    SERIAL_PORT_CONTROL.name: SERIAL_PORT_CONTROL,
    HMIBC.name: HMIBC,
    **{each.name: each for each in _PLAIN},
    **SLC_TYPES,
}
"""By name in capitals: the types that every program may use."""
