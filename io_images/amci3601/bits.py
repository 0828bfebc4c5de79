"""Bits of the 3601's command and status words, with this project's names.

The names of the status bits are public: traces, `scanrack drive` and tag addresses use them unchanged.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntFlag


class CommandMsw(IntFlag):
    """Output word 0 in command mode [chapter 5, Command Word MSW]."""

    ABSOLUTE_MOVE = 1 << 0
    RELATIVE_MOVE = 1 << 1
    HOLD_MOVE = 1 << 2
    RESUME_MOVE = 1 << 3
    IMMEDIATE_STOP = 1 << 4
    FIND_HOME_CW = 1 << 5
    FIND_HOME_CCW = 1 << 6
    MANUAL_CW = 1 << 7
    MANUAL_CCW = 1 << 8
    PRESET_POSITION = 1 << 9
    PRESET_ENCODER = 1 << 10
    RESET_ERRORS = 1 << 11
    RUN_BLEND_CW = 1 << 12
    RUN_BLEND_CCW = 1 << 13
    RESERVED_14 = 1 << 14
    MODE_CONFIG = 1 << 15


class CommandLsw(IntFlag):
    """Output word 1 in command mode [chapter 5, Command Word LSW]; the other bits are reserved."""

    S_CURVE = 1 << 0
    TRAPEZOIDAL = 1 << 1
    ENCODER_MOVE = 1 << 2
    ENC_FOLLOWER = 1 << 7
    BLEND_PROGRAM = 1 << 8
    BLEND_TRANSMIT = 1 << 9
    STORE_MIN_REG = 1 << 10
    HOME_PROXIMITY = 1 << 12


class ConfigMsw(IntFlag):
    """Output word 0 in configuration mode [chapter 3, Configuration Bits MSW]; bits 7, 11, 13, 14 unused."""

    USE_CAPTURE = 1 << 0
    USE_EXTERNAL = 1 << 1
    USE_HOME = 1 << 2
    USE_ESTOP = 1 << 3
    USE_CW_LIMIT = 1 << 4
    USE_CCW_LIMIT = 1 << 5
    BACKPLANE_PROXIMITY = 1 << 6
    QUADRATURE_ENCODER = 1 << 8
    DIAGNOSTIC_FEEDBACK = 1 << 9
    STEP_AND_DIRECTION = 1 << 10
    MARKER_HOME = 1 << 12
    MODE_CONFIG = 1 << 15


class InputBit(IntFlag):
    """The six discrete inputs, in the order of configuration bits, level bits and status bits."""

    CAPTURE = 1 << 0
    EXTERNAL = 1 << 1
    HOME = 1 << 2
    ESTOP = 1 << 3
    CW_LIMIT = 1 << 4
    CCW_LIMIT = 1 << 5


ALL_INPUTS = 0x3F


class StatusMsw(IntFlag):
    """Input word 0 [chapter 6, Status Word MSW]."""

    MOVING_CW = 1 << 0
    MOVING_CCW = 1 << 1
    HOLD_STATE = 1 << 2
    STOPPED = 1 << 3
    AT_HOME = 1 << 4
    ACCELERATING = 1 << 5
    DECELERATING = 1 << 6
    MOVE_COMPLETE = 1 << 7
    HOME_INVALID = 1 << 8
    INVALID_PROFILE = 1 << 9
    POSITION_INVALID = 1 << 10
    INPUT_ERROR = 1 << 11
    COMMAND_ERROR = 1 << 12
    CONFIG_ERROR = 1 << 13
    MODULE_OK = 1 << 14
    MODE_CONFIG = 1 << 15


class StatusLsw(IntFlag):
    """Input word 1 [chapter 6, Status Word LSW]; bits 6, 11 and 13 to 15 are reserved and read 0."""

    IN_CAPTURE = 1 << 0
    IN_EXTERNAL = 1 << 1
    IN_HOME = 1 << 2
    IN_ESTOP = 1 << 3
    IN_CW_LIMIT = 1 << 4
    IN_CCW_LIMIT = 1 << 5
    ENC_FOLLOWER = 1 << 7
    BLEND_RUNNING = 1 << 8
    BLEND_ACK = 1 << 9
    MIN_REG_NONZERO = 1 << 10
    HOME_PROX_ECHO = 1 << 12


MOTIONS = (
    CommandMsw.ABSOLUTE_MOVE
    | CommandMsw.RELATIVE_MOVE
    | CommandMsw.RESUME_MOVE
    | CommandMsw.FIND_HOME_CW
    | CommandMsw.FIND_HOME_CCW
    | CommandMsw.MANUAL_CW
    | CommandMsw.MANUAL_CCW
    | CommandMsw.RUN_BLEND_CW
    | CommandMsw.RUN_BLEND_CCW
)
"""Command bits that start a motion."""

ERROR_BITS = (
    StatusMsw.HOME_INVALID
    | StatusMsw.INVALID_PROFILE
    | StatusMsw.POSITION_INVALID
    | StatusMsw.INPUT_ERROR
    | StatusMsw.COMMAND_ERROR
    | StatusMsw.CONFIG_ERROR
)
"""Error bits of input word 0."""

COMPLETION_BITS = StatusMsw.MOVE_COMPLETE | StatusMsw.STOPPED | StatusMsw.HOLD_STATE | StatusMsw.AT_HOME
"""Bits that report the result of a motion; at most one is set [chapter 6, The Stopped Bit]."""


def status_names(word0: int, word1: int) -> list[str]:
    """Return the names of the set status bits, in word-and-bit order.

    In configuration mode all but three bits mirror the configuration, so only these three names are returned
    [chapter 3, note after the input data table].

    >>> status_names(0x6400, 0)
    ['POSITION_INVALID', 'CONFIG_ERROR', 'MODULE_OK']
    >>> status_names(0xC43E, 0x003F)
    ['MODULE_OK', 'MODE_CONFIG']
    """
    if word0 & StatusMsw.MODE_CONFIG.value:
        word0, word1 = word0 & LIVE_BITS, 0
    return [name for name, mask in _MSW_MASKS if word0 & mask] + [
        name for name, mask in _LSW_MASKS if word1 & mask
    ]


LIVE_BITS = (StatusMsw.MODE_CONFIG | StatusMsw.MODULE_OK | StatusMsw.CONFIG_ERROR).value
"""Bits 13 to 15 of input word 0, which are status bits in both modes [chapter 3]."""

_MSW_MASKS = tuple((str(bit.name), bit.value) for bit in StatusMsw)
_LSW_MASKS = tuple((str(bit.name), bit.value) for bit in StatusLsw)


PROFILE_BITS: Mapping[str, int] = {"ConfigError": 13, "ModuleOK": 14, "ConfigMode": 15}
"""Bits of input word 0 that the RSLogix 5000 V20 profile names [chapters 3 and 4].

Only these three bits have the same meaning in configuration mode and command mode.
"""
