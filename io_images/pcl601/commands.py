"""The command codes of register 4x1 [Command Register]."""

from __future__ import annotations

from enum import IntEnum


class Code(IntEnum):
    """A command code, 1 to 15."""

    GO = 1
    HOME_TYPE_0 = 2
    HOME_TYPE_1 = 3
    GO_SLEW = 4
    STOP_MOTION = 5
    STOP_SOFT = 6
    MAX_SPEED_FROM_ANALOG = 7
    POSITION_FROM_ANALOG = 8
    STEPS_FROM_THUMBWHEEL = 9
    CLEAR_ERRORS = 10
    SWITCH_TO_ASCII = 11
    RUN_PROGRAM = 12
    AUTORUN_OFF = 13
    AUTORUN_ON = 14
    ENCODER_RESET = 15


NEEDS_IDLE = frozenset(
    {
        Code.GO,
        Code.HOME_TYPE_0,
        Code.HOME_TYPE_1,
        Code.GO_SLEW,
        Code.MAX_SPEED_FROM_ANALOG,
        Code.POSITION_FROM_ANALOG,
        Code.STEPS_FROM_THUMBWHEEL,
        Code.RUN_PROGRAM,
    }
)
"""Codes that are refused with the busy error during motion."""
