"""Bits of the words at their places in the SMD family; a model's row lists the places that differ."""

from __future__ import annotations

from enum import IntEnum, IntFlag


class CommandBit(IntFlag):
    """Command word 0 [EDS; 17 p. 80, p. 82]."""

    ABSOLUTE_MOVE = 1 << 0
    RELATIVE_MOVE = 1 << 1
    HOLD_MOVE = 1 << 2
    RESUME_MOVE = 1 << 3
    IMMEDIATE_STOP = 1 << 4
    FIND_HOME_CW = 1 << 5
    FIND_HOME_CCW = 1 << 6
    JOG_CW = 1 << 7
    JOG_CCW = 1 << 8
    PRESET_POSITION = 1 << 9
    RESET_ERRORS = 1 << 10
    PROGRAM_ASSEMBLED = 1 << 11
    READ_ASSEMBLED_DATA = 1 << 12
    RUN_ASSEMBLED_MOVE = 1 << 13
    PRESET_ENCODER = 1 << 14
    MODE_CONFIG = 1 << 15


class Modifier(IntFlag):
    """Command word 1 [EDS; SMD p. 72; K p. 69]: levels, not edges."""

    MOTOR_CURRENT = 1 << 1
    ENCODER_MOVE = 1 << 2
    REVERSE_BLEND = 1 << 4
    SAVE_TO_FLASH = 1 << 5
    REGISTRATION_MOVE = 1 << 7
    INDEXED_COMMAND = 1 << 8
    DWELL_MOVE = 1 << 9
    BACKPLANE_PROXIMITY = 1 << 11
    VIRTUAL_POSITION_FOLLOWER = 1 << 12
    ENCODER_TO_POSITION = 1 << 13
    VIRTUAL_ENCODER_FOLLOWER = 1 << 14
    ENABLE_DRIVER = 1 << 15


class StatusBit(IntFlag):
    """Status word 0 in bits 0 to 15 [EDS; SMD p. 81-83], status word 1 from bit 16 [17 p. 84; SMD p. 83]."""

    MOVING_CW = 1 << 0
    MOVING_CCW = 1 << 1
    HOLD_STATE = 1 << 2
    STOPPED = 1 << 3
    AT_HOME = 1 << 4
    ACCELERATING = 1 << 5
    DECELERATING = 1 << 6
    MOVE_COMPLETE = 1 << 7
    ASSEMBLED_MODE = 1 << 8
    WAITING_FOR_SEGMENT = 1 << 9
    POSITION_INVALID = 1 << 10
    INPUT_ERROR = 1 << 11
    COMMAND_ERROR = 1 << 12
    CONFIG_ERROR = 1 << 13
    MODULE_OK = 1 << 14
    MODE_CONFIG = 1 << 15
    INPUT_1 = 1 << 16
    INPUT_2 = 1 << 17
    TEMPERATURE_90C = 1 << 20
    PLC_IN_PROGRAM_MODE = 1 << 21
    CONNECTION_LOST = 1 << 22
    DRIVER_FAULT = 1 << 23
    INVALID_JOG_CHANGE = 1 << 25
    LIMIT_CONDITION = 1 << 26
    HEARTBEAT = 1 << 27
    ENCODER_ERROR = 1 << 28
    ACKNOWLEDGE = 1 << 29
    STALL_DETECTED = 1 << 30
    DRIVE_ENABLED = 1 << 31


class Settings(IntFlag):
    """Configuration word 0 in bits 0 to 15, word 1 from bit 16 [EDS; SMD p. 59, p. 67; reading R-02]."""

    USE_ENCODER = 1 << 10
    BACKPLANE_PROXIMITY = 1 << 11
    STALL_DETECTION = 1 << 13
    NO_ANTI_RESONANCE = 1 << 14
    MODE_CONFIG = 1 << 15
    INPUT_1_ACTIVE_HIGH = 1 << 16
    INPUT_2_ACTIVE_HIGH = 1 << 17
    BINARY_OUTPUT_FORMAT = 1 << 24
    BINARY_INPUT_FORMAT = 1 << 25
    BINARY_ENDIAN = 1 << 26


class InputFunction(IntEnum):
    """Functions of an input, three bits of configuration word 0 [SMD p. 13; codes: reading R-01]."""

    GENERAL_PURPOSE = 0
    CW_LIMIT = 1
    CCW_LIMIT = 2
    START_INDEXED_MOVE = 3
    STOP_JOG = 4
    CAPTURE_ENCODER = 5
    EMERGENCY_STOP = 6
    HOME = 7
