"""The cause of each status bit of a 3601: one row per bit.

The rules of a row state when its bit is set and cleared. The origin is the next cause to check: a terminal,
the command that started a motion, the configuration, or the recorded rule for a chapter 6 error.
"""

from __future__ import annotations

from enum import Enum

from ...dataclass import dataclass
from ..bits import MOTIONS, CommandMsw, StatusLsw, StatusMsw


class Origin(Enum):
    """The next cause to check for a bit."""

    TERMINAL = "terminal"  # the corresponding input
    COMMAND = "command"  # the command that started the motion
    CONFIGURATION = "configuration"  # the configuration words
    MODULE = "module"  # power and health of the module
    RULE = "rule"  # the rule that fired


_NONE = CommandMsw(0)


@dataclass(frozen=True, slots=True)
class BitCause:
    """The cause of a status bit.

    Attributes:
        rules: ids of the rules that state the cause.
        on: the meaning of the bit when it is on.
        off: the meaning of the bit when it is off.
        commands: bits of output word 0 that start the motion that the bit describes; 0 for a bit that does
            not describe a motion.
    """

    bit: StatusMsw | StatusLsw
    origin: Origin
    rules: tuple[str, ...]
    on: str
    off: str
    commands: CommandMsw = _NONE


_HOME = CommandMsw.FIND_HOME_CW | CommandMsw.FIND_HOME_CCW
_BLENDS = CommandMsw.RUN_BLEND_CW | CommandMsw.RUN_BLEND_CCW
_MOVES = CommandMsw.ABSOLUTE_MOVE | CommandMsw.RELATIVE_MOVE | _BLENDS

# fmt: off
ROWS: tuple[BitCause, ...] = (
    BitCause(StatusMsw.MOVING_CW, Origin.COMMAND, ("STS-M00",),
             "the axis moves clockwise", "no motion clockwise is under way", MOTIONS),
    BitCause(StatusMsw.MOVING_CCW, Origin.COMMAND, ("STS-M01",),
             "the axis moves counterclockwise", "no motion counterclockwise is under way", MOTIONS),
    BitCause(StatusMsw.HOLD_STATE, Origin.COMMAND, ("STS-M02",),
             "a move is held", "no move is held", CommandMsw.HOLD_MOVE),
    BitCause(StatusMsw.STOPPED, Origin.COMMAND, ("STS-M03",),
             "a motion was stopped before its end", "no motion was stopped", MOTIONS),
    BitCause(StatusMsw.AT_HOME, Origin.COMMAND, ("STS-M04",),
             "a search has found home", "no search has found home", _HOME),
    BitCause(StatusMsw.ACCELERATING, Origin.COMMAND, ("STS-M05",),
             "the axis speeds up", "the axis does not speed up", MOTIONS),
    BitCause(StatusMsw.DECELERATING, Origin.COMMAND, ("STS-M06",),
             "the axis slows down", "the axis does not slow down", MOTIONS),
    BitCause(StatusMsw.MOVE_COMPLETE, Origin.COMMAND, ("STS-M07",),
             "a move has come to its end", "no move has come to its end", _MOVES),
    BitCause(StatusMsw.HOME_INVALID, Origin.RULE, ("STS-M08",),
             "a search for home failed", "no search for home failed", _HOME),
    BitCause(StatusMsw.INVALID_PROFILE, Origin.RULE, ("STS-M09",),
             "parameters of a move can't be used", "all parameters can be used", MOTIONS),
    BitCause(StatusMsw.POSITION_INVALID, Origin.RULE, ("STS-M10",),
             "the position is not known", "the position is known", _HOME),
    BitCause(StatusMsw.INPUT_ERROR, Origin.RULE, ("STS-M11",),
             "an input ended a motion", "no input ended a motion", MOTIONS),
    BitCause(StatusMsw.COMMAND_ERROR, Origin.RULE, ("STS-M12",),
             "a command broke a rule", "no command broke a rule", MOTIONS),
    BitCause(StatusMsw.CONFIG_ERROR, Origin.CONFIGURATION, ("STS-M13",),
             "no configuration was accepted", "a configuration was accepted"),
    BitCause(StatusMsw.MODULE_OK, Origin.MODULE, ("STS-M14",),
             "the module works", "the module does not work"),
    BitCause(StatusMsw.MODE_CONFIG, Origin.CONFIGURATION, ("STS-M15",),
             "it is in configuration mode", "it takes commands"),
    BitCause(StatusLsw.IN_CAPTURE, Origin.TERMINAL, ("STS-L00",),
             "the capture input is on", "the capture input is off"),
    BitCause(StatusLsw.IN_EXTERNAL, Origin.TERMINAL, ("STS-L01",),
             "the external input is on", "the external input is off"),
    BitCause(StatusLsw.IN_HOME, Origin.TERMINAL, ("STS-L02",),
             "the home input is on", "the home input is off"),
    BitCause(StatusLsw.IN_ESTOP, Origin.TERMINAL, ("STS-L03",),
             "the emergency stop input is on", "the emergency stop input is off"),
    BitCause(StatusLsw.IN_CW_LIMIT, Origin.TERMINAL, ("STS-L04",),
             "the clockwise limit is on", "the clockwise limit is off"),
    BitCause(StatusLsw.IN_CCW_LIMIT, Origin.TERMINAL, ("STS-L05",),
             "the counterclockwise limit is on", "the counterclockwise limit is off"),
    BitCause(StatusLsw.ENC_FOLLOWER, Origin.COMMAND, ("STS-L07",),
             "the axis follows the encoder", "the axis does not follow the encoder"),
    BitCause(StatusLsw.BLEND_RUNNING, Origin.COMMAND, ("STS-L08",),
             "a blend runs", "no blend runs", _BLENDS),
    BitCause(StatusLsw.BLEND_ACK, Origin.COMMAND, ("STS-L09",),
             "a block of a blend was taken", "no block of a blend was taken"),
    BitCause(StatusLsw.MIN_REG_NONZERO, Origin.COMMAND, ("STS-L10",),
             "a registration distance is set", "no registration distance is set"),
    BitCause(StatusLsw.HOME_PROX_ECHO, Origin.COMMAND, ("STS-L12",),
             "the proximity bit has arrived", "the proximity bit is off"),
)
# fmt: on


def cause_of(word: int, bit: int) -> BitCause | None:
    """Return the row for a bit of an input word, both given by number; None if it is not a status bit.

    >>> cause_of(0, 4).on
    'a search has found home'
    """
    for row in ROWS:
        row_word = 0 if isinstance(row.bit, StatusMsw) else 1
        if word == row_word and row.bit.value == 1 << bit:
            return row
    return None
