"""Differences between a 3601 and a networked drive: a row for each bit or word whose meaning differs.

A row has the bits, their meanings on a 3601 and on the drive, and a replacement. Sources are pages of the
drive's manuals, or readings (R-nn) where the manuals are silent. Bits that are not in any row mean the same
on both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..amci3601.bits import CommandLsw, CommandMsw, StatusLsw, StatusMsw
from .models import Layout, Model

_SMD = (Layout.SMD,)
_ANF2 = (Layout.ANF2,)
_ALL = (Layout.SMD, Layout.ANF2)

_WORDS = {CommandMsw: ("O", 0), CommandLsw: ("O", 1), StatusMsw: ("I", 0), StatusLsw: ("I", 1)}
"""Image ("O" output, "I" input) and number of the word of a 3601's bits."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A bit or word of a 3601 that has a different meaning on a drive.

    Attributes:
        id: for example "D-02".
        bits: the bits on a 3601.
        on_3601: their meaning on a 3601.
        on_drive: their meaning on the drive.
        write: the replacement on the drive.
        source: page or reading.
        layouts: the layouts of words to which the row applies.
    """

    id: str
    bits: CommandMsw | CommandLsw | StatusMsw | StatusLsw
    on_3601: str
    on_drive: str
    write: str
    source: str
    layouts: tuple[Layout, ...] = _SMD

    @property
    def place(self) -> tuple[str, int]:
        """The image ("O" output, "I" input) and the number of the word."""
        return _WORDS[type(self.bits)]

    def names(self, bits_used: int) -> str:
        """Return the names on a 3601, such as "RESET_ERRORS", of the bits that a mask contains."""
        return ", ".join(str(bit.name) for bit in type(self.bits) if bit & self.bits & bits_used)


MOVES = (
    CommandMsw.ABSOLUTE_MOVE
    | CommandMsw.RELATIVE_MOVE
    | CommandMsw.RESUME_MOVE
    | CommandMsw.FIND_HOME_CW
    | CommandMsw.FIND_HOME_CCW
    | CommandMsw.MANUAL_CW
    | CommandMsw.MANUAL_CCW
)
_HOME = CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW
_INPUTS = StatusLsw.IN_CCW_LIMIT | StatusLsw.IN_CAPTURE | StatusLsw.IN_EXTERNAL | StatusLsw.IN_HOME

# One row per difference; the formatter would spread each over many lines.
# fmt: off
DIFFERENCES: tuple[Difference, ...] = (
    # command word 0
    Difference("D-01", MOVES,
        "starts a motion", "is refused unless ENABLE_DRIVER is in word 1",
        "set bit 15 of word 1 (8000h) in every command", "SMD p. 59; R-29"),
    Difference("D-02", CommandMsw.RESET_ERRORS,
        "Reset Errors", "Program Assembled: a blend is programmed",
        "bit 10 of word 0 (0400h)", "17 p. 80, p. 82"),
    Difference("D-03", CommandMsw.PRESET_ENCODER,
        "Preset Encoder Position", "Reset Errors", "bit 14 of word 0 (4000h)", "17 p. 82; EDS"),
    Difference("D-04", CommandMsw.RUN_BLEND_CW,
        "runs the blend clockwise", "Read Assembled Data",
        "bit 13 of word 0 (2000h), bit 4 of word 1 off", "17 p. 80; SMD p. 72"),
    Difference("D-05", CommandMsw.RUN_BLEND_CCW,
        "runs the blend counterclockwise", "Run Assembled Move, clockwise unless bit 4 of word 1 is on",
        "bit 13 of word 0 (2000h), bit 4 of word 1 on", "17 p. 80; SMD p. 72"),
    Difference("D-06", _HOME,
        "homes with a switch, a marker or proximity", "homes with two inputs, without a marker",
        "give an input the function home", "SMD p. 13; R-19"),
    Difference("D-07", _HOME,
        "homes without a time limit", "ends with an error after the homing time-out",
        "the time-out of the configuration, 0 to 300 s", "ANF2md", _ANF2),
    Difference("D-08", CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW,
        "runs a blend", "is not known of this drive", "single moves", "ANF2src", _ANF2),
    # command word 1
    Difference("D-10", CommandLsw.S_CURVE,
        "an S-curve", "a reserved bit: COMMAND_ERROR",
        "a jerk of 1 to 5000 in word 9", "SMD p. 46, p. 72; R-08"),
    Difference("D-11", CommandLsw.TRAPEZOIDAL,
        "a trapezoidal S-curve", "takes the motor current from word 8",
        "a jerk of 1 to 5000 in word 9", "SMD p. 46, p. 72"),
    Difference("D-12", CommandLsw.ENC_FOLLOWER,
        "follows the encoder", "makes a registration move of a jog",
        "nothing: a drive has no input for another encoder", "SMD p. 67; SMD p. 13"),
    Difference("D-13", CommandLsw.BLEND_PROGRAM,
        "programs a blend", "waits for an input before the move starts",
        "0800h and 1800h in word 0, a segment at a time", "17 p. 80; SMD p. 13"),
    Difference("D-14", CommandLsw.BLEND_TRANSMIT,
        "transmits a segment", "runs the profile as a dwell move",
        "0800h and 1800h in word 0, a segment at a time", "17 p. 80; SMD p. 38"),
    Difference("D-15", CommandLsw.STORE_MIN_REG,
        "stores the minimum registration distance", "a reserved bit: COMMAND_ERROR",
        "bit 7 of word 1 with the distance in words 8 and 9", "SMD p. 67; R-08"),
    Difference("D-16", CommandLsw.HOME_PROXIMITY,
        "the backplane proximity", "starts a virtual position follower",
        "bit 11 of word 1 (0800h)", "SMD p. 40; EDS"),
    Difference("D-17", CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL,
        "an S-curve", "is not known of this drive", "constant acceleration", "ANF2src", _ANF2),
    # status word 0
    Difference("D-20", StatusMsw.STOPPED,
        "a jog, hold or cut has ended the motion; no other completion bit is on",
        "no motion, for any reason, beside MOVE_COMPLETE, HOLD_STATE and AT_HOME",
        "MOVE_COMPLETE for the end of a move", "SMD p. 83; R-34", _ALL),
    Difference("D-21", StatusMsw.HOME_INVALID,
        "the home search failed", "ASSEMBLED_MODE: a blend is programmed",
        "INPUT_ERROR after a home search", "EDS; 17 p. 80"),
    Difference("D-22", StatusMsw.INVALID_PROFILE,
        "parameters of a move were refused", "WAITING_FOR_SEGMENT", "COMMAND_ERROR", "EDS; R-28"),
    Difference("D-23", StatusMsw.INPUT_ERROR,
        "the next move or Reset Errors clears it", "only Reset Errors clears it",
        "Reset Errors before the next move", "17 p. 82"),
    Difference("D-24", StatusMsw.COMMAND_ERROR,
        "Immediate Stop is refused until Reset Errors",
        "Immediate Stop works, moves are refused until Reset Errors",
        "Reset Errors before the next move", "17 p. 82; R-24"),
    # status word 1
    Difference("D-30", StatusLsw.IN_CAPTURE,
        "the capture input", "INPUT_1, whatever its function is", "wire the sensor to input 1", "SMD p. 83"),
    Difference("D-31", StatusLsw.IN_EXTERNAL,
        "the external input", "INPUT_2, whatever its function is", "wire the sensor to input 2", "SMD p. 83"),
    Difference("D-32", StatusLsw.IN_HOME | StatusLsw.IN_ESTOP,
        "the home and emergency stop inputs", "always 0",
        "INPUT_1 or INPUT_2, by their functions", "SMD p. 83"),
    Difference("D-33", StatusLsw.IN_CW_LIMIT,
        "the clockwise limit input", "TEMPERATURE_90C",
        "LIMIT_CONDITION (bit 10), or an input with that function", "17 p. 84"),
    Difference("D-34", StatusLsw.IN_CCW_LIMIT,
        "the counterclockwise limit input", "PLC_IN_PROGRAM_MODE",
        "LIMIT_CONDITION (bit 10), or an input with that function", "17 p. 84; EDS"),
    Difference("D-35", StatusLsw.ENC_FOLLOWER,
        "the axis follows the encoder", "DRIVER_FAULT: over-temperature",
        "nothing: a drive has no encoder follower", "17 p. 84"),
    Difference("D-36", StatusLsw.BLEND_RUNNING,
        "a blend runs", "always 0", "MOVING_CW or MOVING_CCW", "17 p. 84"),
    Difference("D-37", StatusLsw.BLEND_ACK,
        "the blend handshake", "INVALID_JOG_CHANGE",
        "WAITING_FOR_SEGMENT, bit 9 of status word 0", "17 p. 80, p. 84"),
    Difference("D-38", StatusLsw.MIN_REG_NONZERO,
        "a minimum registration distance is stored", "LIMIT_CONDITION",
        "nothing: the distance is in each command", "17 p. 84"),
    Difference("D-39", StatusLsw.HOME_PROX_ECHO,
        "the echo of the backplane proximity", "ENCODER_ERROR", "nothing: a drive has no echo", "17 p. 84"),
    Difference("D-40", StatusLsw.IN_ESTOP,
        "the emergency stop input", "the clockwise limit",
        "another input: the drive has no emergency stop", "ANF2src", _ANF2),
    Difference("D-41", StatusLsw.IN_CW_LIMIT,
        "the clockwise limit input", "the counterclockwise limit",
        "bit 3 of status word 1", "ANF2src", _ANF2),
    Difference("D-42", _INPUTS,
        "an input", "is not known of this drive", "the limits in bits 3 and 4", "ANF2src", _ANF2),
)
# fmt: on
"""All rows, in order of the words."""

CONFIGURATION = (
    "the configuration words of a 3601",
    "words of another layout: functions of two inputs, steps and counts per turn, currents",
    "the drive's own configuration, ten words",
    "EDS; SMD p. 59",
)
"""The difference in configuration: meaning on a 3601, meaning on every drive, replacement, source."""


def differences(model: Model) -> Iterator[Difference]:
    """Yield the differences of a model."""
    return (row for row in DIFFERENCES if model.layout in row.layouts)
