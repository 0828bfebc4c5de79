"""All predefined data types, by name. Those of `_PLAIN` are for copies and reads only."""

from __future__ import annotations

from collections.abc import Mapping

from ..types import BOOL, DINT, SINT, TYPES, DataType, Structure, members, status_bits
from .block_types import BLOCK_TYPES
from .motion_types import MOTION_TYPES
from .safety_types import SAFETY
from .slc_types import SLC_TYPES

SERIAL_PORT_CONTROL = Structure(
    "SERIAL_PORT_CONTROL",
    (*status_bits("EN EU DN RN EM ER FD"), *members(DINT, "LEN POS ERROR")),
)
"""Control of serial port instructions [1756-RM003N, ASCII serial port instructions]."""

HMIBC = Structure("HMIBC", members(BOOL, "EnableIn EnableOut ProgFB ButtonState HMIButtonSet"))
"""Structure of HMIBC: a page or a test sets ButtonState."""

_PLAIN = (
    Structure("CONNECTION_STATUS", members(BOOL, "RunMode ConnectionFaulted")),
    Structure("PHASE_INSTRUCTION", (*members(DINT, "Status"), *members(BOOL, "EN ER PC IP WA ABORT"))),
    Structure("DATALOG_INSTRUCTION", (*members(BOOL, "EN DN ER IP"), *members(DINT, "ERR"))),
    Structure(
        "EXT_ROUTINE_CONTROL",
        (*members(SINT, "ErrorCode NumParams"), *members(BOOL, "EN ReturnsValue DN ER")),
    ),
    Structure("ALARM_SET_CONTROL", (*members(BOOL, "LastState"), *members(DINT, "InstanceID"))),
    Structure(
        "PHASE",
        (
            *members(DINT, "State Substate StepIndex Failure UnitID Owner PendingRequest"),
            *members(
                BOOL,
                "Running Holding Restarting Stopping Aborting Resetting Idle Held Complete Stopped Aborted "
                "Pausing Paused AutoPause Step NewInputParameters Producing Standby",
            ),
        ),
    ),
    Structure(
        "SFC_STEP",
        (
            *members(DINT, "Status"),
            *members(BOOL, "X FS SA LS DN OV AlarmEn AlarmLow AlarmHigh Reset PauseTimer"),
            *members(DINT, "PRE T TMax Count LimitLow LimitHigh"),
        ),
    ),
    Structure("SFC_ACTION", (*members(DINT, "Status"), *members(BOOL, "A Q"), *members(DINT, "PRE T Count"))),
    Structure("SFC_STOP", (*members(DINT, "X Count"), *members(BOOL, "Reset"))),
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
"""Types that every program may use, by name in capitals."""
