"""The 3601's bits of input word 0 for each error bit of a PCL601 [register 4x36]."""

from __future__ import annotations

from scanrack.io_images.amci3601 import StatusMsw
from scanrack.io_images.pcl601 import Error

COMMAND_ERROR = StatusMsw.COMMAND_ERROR.value
PROFILE = (StatusMsw.INVALID_PROFILE | StatusMsw.COMMAND_ERROR).value
LOST_STEPS = (StatusMsw.INPUT_ERROR | StatusMsw.POSITION_INVALID).value

ERRORS: dict[Error, int] = {
    Error.RECEIVE_OVERFLOW: COMMAND_ERROR,
    Error.ENCODER_CORRECTED: 0,
    Error.ENCODER_FAILED: LOST_STEPS,
    Error.COMMAND: COMMAND_ERROR,
    Error.MOTOR: PROFILE,
    Error.RANGE_OVERFLOW: PROFILE,
    Error.RANGE: PROFILE,
    Error.TRANSMIT: COMMAND_ERROR,
    Error.MODE: COMMAND_ERROR,
    Error.ZERO_PARAMETERS: COMMAND_ERROR,
    Error.BUSY: COMMAND_ERROR,
    Error.MEMORY_RANGE: 0,
    Error.MEMORY_COMMAND: 0,
    Error.THUMBWHEEL: 0,
}
"""The 3601's bits for each error; an error without bits is reported only by an event."""
