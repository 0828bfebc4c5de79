"""Differences between a 3601 and a networked drive: a row for each bit or word with another meaning.

A row has the bits on the 3601 (image, word, mask), their meaning there, what the drive does with them, and
what to write instead. Sources are pages of the drive's manuals, or readings (R-nn) where these are silent.
Bits that are in no row mean the same on both.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..amci3601.bits import CommandLsw, CommandMsw, StatusLsw, StatusMsw
from .models import Layout, Model

_SMD = frozenset({Layout.SMD})
_ANF2 = frozenset({Layout.ANF2})
_ALL = _SMD | _ANF2


@dataclass(frozen=True, slots=True)
class Difference:
    """A bit or word of a 3601 that means something else on a drive.

    Attributes:
        id: such as "D-02".
        image: "O" output, "I" input.
        word: 0 to 7.
        mask: the bits of it.
        on_3601: what they mean on a 3601.
        on_drive: what they mean on the drive.
        write: what to write instead.
        source: page or reading.
        layouts: layouts of the words of the models to which the row applies.
    """

    id: str
    image: str
    word: int
    mask: int
    on_3601: str
    on_drive: str
    write: str
    source: str
    layouts: frozenset[Layout] = _SMD

    def names(self, bits_used: int) -> str:
        """Return the names on a 3601, such as "RESET_ERRORS", of those of its bits that are in use."""
        bits = {
            ("O", 0): CommandMsw,
            ("O", 1): CommandLsw,
            ("I", 0): StatusMsw,
            ("I", 1): StatusLsw,
        }[self.image, self.word]
        return ", ".join(str(bit.name) for bit in bits if bit.value & self.mask & bits_used)


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
_CURVE = CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL

DIFFERENCES: tuple[Difference, ...] = (
    # command word 0
    Difference(
        "D-01",
        "O",
        0,
        MOVES.value,
        "starts a motion",
        "is refused unless ENABLE_DRIVER is in word 1",
        "set bit 15 of word 1 (8000h) in every command",
        "SMD p. 59; R-29",
    ),
    Difference(
        "D-02",
        "O",
        0,
        CommandMsw.RESET_ERRORS.value,
        "Reset Errors",
        "Program Assembled: a blend is programmed",
        "bit 10 of word 0 (0400h)",
        "17 p. 80, p. 82",
    ),
    Difference(
        "D-03",
        "O",
        0,
        CommandMsw.PRESET_ENCODER.value,
        "Preset Encoder Position",
        "Reset Errors",
        "bit 14 of word 0 (4000h)",
        "17 p. 82; EDS",
    ),
    Difference(
        "D-04",
        "O",
        0,
        CommandMsw.RUN_BLEND_CW.value,
        "runs the blend clockwise",
        "Read Assembled Data",
        "bit 13 of word 0 (2000h), bit 4 of word 1 off",
        "17 p. 80; SMD p. 72",
    ),
    Difference(
        "D-05",
        "O",
        0,
        CommandMsw.RUN_BLEND_CCW.value,
        "runs the blend counterclockwise",
        "Run Assembled Move, clockwise unless bit 4 of word 1 is on",
        "bit 13 of word 0 (2000h), bit 4 of word 1 on",
        "17 p. 80; SMD p. 72",
    ),
    Difference(
        "D-06",
        "O",
        0,
        _HOME.value,
        "homes with a switch, a marker or proximity",
        "homes with two inputs, without a marker",
        "give an input the function home",
        "SMD p. 13; R-19",
    ),
    Difference(
        "D-07",
        "O",
        0,
        _HOME.value,
        "homes without a time limit",
        "ends with an error after the homing time-out",
        "the time-out of the configuration, 0 to 300 s",
        "ANF2md",
        _ANF2,
    ),
    Difference(
        "D-08",
        "O",
        0,
        (CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW).value,
        "runs a blend",
        "is not known of this drive",
        "single moves",
        "ANF2src",
        _ANF2,
    ),
    # command word 1
    Difference(
        "D-10",
        "O",
        1,
        CommandLsw.S_CURVE.value,
        "an S-curve",
        "a reserved bit: COMMAND_ERROR",
        "a jerk of 1 to 5000 in word 9",
        "SMD p. 46, p. 72; R-08",
    ),
    Difference(
        "D-11",
        "O",
        1,
        CommandLsw.TRAPEZOIDAL.value,
        "a trapezoidal S-curve",
        "takes the motor current from word 8",
        "a jerk of 1 to 5000 in word 9",
        "SMD p. 46, p. 72",
    ),
    Difference(
        "D-12",
        "O",
        1,
        CommandLsw.ENC_FOLLOWER.value,
        "follows the encoder",
        "makes a registration move of a jog",
        "nothing: a drive has no input for another encoder",
        "SMD p. 67; SMD p. 13",
    ),
    Difference(
        "D-13",
        "O",
        1,
        CommandLsw.BLEND_PROGRAM.value,
        "programs a blend",
        "waits for an input before the move starts",
        "0800h and 1800h in word 0, a segment at a time",
        "17 p. 80; SMD p. 13",
    ),
    Difference(
        "D-14",
        "O",
        1,
        CommandLsw.BLEND_TRANSMIT.value,
        "transmits a segment",
        "runs the profile as a dwell move",
        "0800h and 1800h in word 0, a segment at a time",
        "17 p. 80; SMD p. 38",
    ),
    Difference(
        "D-15",
        "O",
        1,
        CommandLsw.STORE_MIN_REG.value,
        "stores the minimum registration distance",
        "a reserved bit: COMMAND_ERROR",
        "bit 7 of word 1 with the distance in words 8 and 9",
        "SMD p. 67; R-08",
    ),
    Difference(
        "D-16",
        "O",
        1,
        CommandLsw.HOME_PROXIMITY.value,
        "the backplane proximity",
        "starts a virtual position follower",
        "bit 11 of word 1 (0800h)",
        "SMD p. 40; EDS",
    ),
    Difference(
        "D-17",
        "O",
        1,
        _CURVE.value,
        "an S-curve",
        "is not known of this drive",
        "constant acceleration",
        "ANF2src",
        _ANF2,
    ),
    # status word 0
    Difference(
        "D-20",
        "I",
        0,
        StatusMsw.STOPPED.value,
        "a jog, hold or cut has ended the motion; no other completion bit is on",
        "no motion, for any reason, beside MOVE_COMPLETE, HOLD_STATE and AT_HOME",
        "MOVE_COMPLETE for the end of a move",
        "SMD p. 83; R-34",
        _ALL,
    ),
    Difference(
        "D-21",
        "I",
        0,
        StatusMsw.HOME_INVALID.value,
        "the home search failed",
        "ASSEMBLED_MODE: a blend is programmed",
        "INPUT_ERROR after a home search",
        "EDS; 17 p. 80",
    ),
    Difference(
        "D-22",
        "I",
        0,
        StatusMsw.INVALID_PROFILE.value,
        "parameters of a move were refused",
        "WAITING_FOR_SEGMENT",
        "COMMAND_ERROR",
        "EDS; R-28",
    ),
    Difference(
        "D-23",
        "I",
        0,
        StatusMsw.INPUT_ERROR.value,
        "the next move or Reset Errors clears it",
        "only Reset Errors clears it",
        "Reset Errors before the next move",
        "17 p. 82",
    ),
    Difference(
        "D-24",
        "I",
        0,
        StatusMsw.COMMAND_ERROR.value,
        "Immediate Stop is refused until Reset Errors",
        "Immediate Stop works, moves are refused until Reset Errors",
        "Reset Errors before the next move",
        "17 p. 82; R-24",
    ),
    # status word 1
    Difference(
        "D-30",
        "I",
        1,
        StatusLsw.IN_CAPTURE.value,
        "the capture input",
        "INPUT_1, whatever its function is",
        "wire the sensor to input 1",
        "SMD p. 83",
    ),
    Difference(
        "D-31",
        "I",
        1,
        StatusLsw.IN_EXTERNAL.value,
        "the external input",
        "INPUT_2, whatever its function is",
        "wire the sensor to input 2",
        "SMD p. 83",
    ),
    Difference(
        "D-32",
        "I",
        1,
        (StatusLsw.IN_HOME | StatusLsw.IN_ESTOP).value,
        "the home and emergency stop inputs",
        "always 0",
        "INPUT_1 or INPUT_2, by their functions",
        "SMD p. 83",
    ),
    Difference(
        "D-33",
        "I",
        1,
        StatusLsw.IN_CW_LIMIT.value,
        "the clockwise limit input",
        "TEMPERATURE_90C",
        "LIMIT_CONDITION (bit 10), or an input with that function",
        "17 p. 84",
    ),
    Difference(
        "D-34",
        "I",
        1,
        StatusLsw.IN_CCW_LIMIT.value,
        "the counterclockwise limit input",
        "PLC_IN_PROGRAM_MODE",
        "LIMIT_CONDITION (bit 10), or an input with that function",
        "17 p. 84; EDS",
    ),
    Difference(
        "D-35",
        "I",
        1,
        StatusLsw.ENC_FOLLOWER.value,
        "the axis follows the encoder",
        "DRIVER_FAULT: over-temperature",
        "nothing: a drive has no encoder follower",
        "17 p. 84",
    ),
    Difference(
        "D-36",
        "I",
        1,
        StatusLsw.BLEND_RUNNING.value,
        "a blend runs",
        "always 0",
        "MOVING_CW or MOVING_CCW",
        "17 p. 84",
    ),
    Difference(
        "D-37",
        "I",
        1,
        StatusLsw.BLEND_ACK.value,
        "the blend handshake",
        "INVALID_JOG_CHANGE",
        "WAITING_FOR_SEGMENT, bit 9 of status word 0",
        "17 p. 80, p. 84",
    ),
    Difference(
        "D-38",
        "I",
        1,
        StatusLsw.MIN_REG_NONZERO.value,
        "a minimum registration distance is stored",
        "LIMIT_CONDITION",
        "nothing: the distance is in each command",
        "17 p. 84",
    ),
    Difference(
        "D-39",
        "I",
        1,
        StatusLsw.HOME_PROX_ECHO.value,
        "the echo of the backplane proximity",
        "ENCODER_ERROR",
        "nothing: a drive has no echo",
        "17 p. 84",
    ),
    Difference(
        "D-40",
        "I",
        1,
        StatusLsw.IN_ESTOP.value,
        "the emergency stop input",
        "the clockwise limit",
        "another input: the drive has no emergency stop",
        "ANF2src",
        _ANF2,
    ),
    Difference(
        "D-41",
        "I",
        1,
        StatusLsw.IN_CW_LIMIT.value,
        "the clockwise limit input",
        "the counterclockwise limit",
        "bit 3 of status word 1",
        "ANF2src",
        _ANF2,
    ),
    Difference(
        "D-42",
        "I",
        1,
        (StatusLsw.IN_CCW_LIMIT | StatusLsw.IN_CAPTURE | StatusLsw.IN_EXTERNAL | StatusLsw.IN_HOME).value,
        "an input",
        "is not known of this drive",
        "the limits in bits 3 and 4",
        "ANF2src",
        _ANF2,
    ),
)
"""The rows, in order of the words."""

CONFIGURATION = (
    "the configuration words of a 3601",
    "words of another layout: functions of two inputs, steps and counts per turn, currents",
    "the drive's own configuration, ten words",
    "EDS; SMD p. 59",
)
"""Differences of every drive's configuration: meaning on a 3601, on the drive, what to write, source."""


def differences(model: Model) -> Iterator[Difference]:
    """Yield the rows that apply to a model."""
    return (row for row in DIFFERENCES if model.layout in row.layouts)
