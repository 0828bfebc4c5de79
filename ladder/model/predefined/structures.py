"""All predefined data types, by name. Types in `_PLAIN` can only be copied and read."""

from __future__ import annotations

import re
from collections.abc import Mapping

from ..types import DINT, TYPES, DataType, Member, Structure, members_of, packed_in, status_bits
from .block_types import BLOCK_TYPES, DIAGRAM_TYPES
from .motion_types import MOTION_TYPES
from .safety_types import SAFETY
from .slc_types import SLC_TYPES

SERIAL_PORT_CONTROL = Structure(
    "SERIAL_PORT_CONTROL", status_bits("EN EU DN RN EM ER FD") + members_of("DINT LEN POS ERROR")
)
"""Control of serial port instructions [1756-RM003N, ASCII serial port instructions]."""

HMIBC = Structure("HMIBC", members_of("BOOL EnableIn EnableOut ProgFB ButtonState HMIButtonSet"))
"""Structure of HMIBC. A page or a test sets its ButtonState."""

_PLAIN = tuple(
    Structure(name, members_of(text))
    for name, text in (
        ("CONNECTION_STATUS", "BOOL RunMode ConnectionFaulted"),
        ("PHASE_INSTRUCTION", "DINT Status BOOL EN ER PC IP WA ABORT"),
        ("DATALOG_INSTRUCTION", "BOOL EN DN ER IP DINT ERR"),
        ("EXT_ROUTINE_CONTROL", "SINT ErrorCode NumParams BOOL EN ReturnsValue DN ER"),
        ("ALARM_SET_CONTROL", "BOOL LastState DINT InstanceID"),
        (
            "PHASE",
            "DINT State Substate StepIndex Failure UnitID Owner PendingRequest BOOL Running Holding "
            "Restarting Stopping Aborting Resetting Idle Held Complete Stopped Aborted Pausing Paused "
            "AutoPause Step NewInputParameters Producing Standby",
        ),
    )
)


def _of_chart(name: str, bits: str, numbers: str, hidden: str = "") -> Structure:
    """Return the type of a chart's tag; `bits` has the bits of Status, such as `X31`."""
    places = dict(re.findall(r"(\w+?)(\d+)\b", bits))
    status = packed_in(Member("Status", DINT), {name: int(bit) for name, bit in places.items()})
    return Structure(name, status + members_of(f"DINT {numbers}"), hidden=members_of(hidden))


CHARTS = (
    _of_chart(
        "SFC_STEP",
        "X31 FS30 SA29 LS28 DN27 OV26 AlarmEn25 AlarmLow24 AlarmHigh23 Reset22 PauseTimer21",
        "PRE T TMax Count LimitLow LimitHigh",
        "LINT ns BOOL new",
    ),
    _of_chart("SFC_ACTION", "A31 Q30 PauseTimer29", "PRE T Count", "LINT ns owner latch"),
    _of_chart("SFC_STOP", "X31 Reset22", "Count"),
)
"""Types of chart tags, with the bits of Status [1756-PM006, step and action tags]. `ns` is the time counted
by T, `new` is whether the step has not been executed yet, `owner` is the action that is on, and `latch` is
the stored action.
"""

PREDEFINED_TYPES: Mapping[str, DataType] = {
    **TYPES,
    **MOTION_TYPES,
    **BLOCK_TYPES,
    **DIAGRAM_TYPES,
    **{kind.name: kind for kind in SAFETY.values()},
    SERIAL_PORT_CONTROL.name: SERIAL_PORT_CONTROL,
    HMIBC.name: HMIBC,
    **{kind.name: kind for kind in (*_PLAIN, *CHARTS)},
    **SLC_TYPES,
}
"""Types that every program can use, by name in capitals."""
