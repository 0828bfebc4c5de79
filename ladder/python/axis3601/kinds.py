"""The kinds of commands; each row has its allowed states, its end condition, and how it yields to another.

The rows and their behavior match the function blocks in `ladder/blocks/axis3601.rung`.
"""

from __future__ import annotations

from enum import Enum, IntEnum

from scanrack.io_images.amci3601.bits import CommandMsw, StatusMsw
from scanrack.io_images.dataclass import dataclass


class State(IntEnum):
    """The PLCopen state of an axis, with the numbers of the rung library."""

    DISABLED = 0  # not configured, or the module is lost
    STANDSTILL = 1
    DISCRETE_MOTION = 2
    CONTINUOUS_MOTION = 3
    HOMING = 4
    STOPPING = 5  # `stop` holds the axis
    ERROR_STOP = 6  # a command has failed; `reset` clears it
    SYNCHRONIZED_MOTION = 7


class Yielding(Enum):
    """How a command yields to a newer one, with the words to write."""

    WAIT = "wait"
    """The newer command waits, because this one ends soon."""
    HOLD = (CommandMsw.HOLD_MOVE.value, 0, 0, 0, 0, 0, 0, 0)
    STOP = (CommandMsw.IMMEDIATE_STOP.value, 0, 0, 0, 0, 0, 0, 0)
    """Stop without a ramp, because the motion can't be held; the position becomes invalid."""
    NOTHING = (0, 0, 0, 0, 0, 0, 0, 0)
    RELEASE = "release"
    """Turn its command bits off; the deceleration does not change."""


@dataclass(frozen=True, slots=True, eq=False)
class CommandKind:
    """A kind of command."""

    name: str  # the method of the axis
    block: str  # its function block
    allowed: tuple[State, ...]  # states that allow a request
    state: State = State.STANDSTILL  # state of the axis during the command
    done_bits: int | None = 0  # at rest, one of these status bits is success; 0: none needed, None: endless
    yielding: Yielding = Yielding.WAIT
    runs_on: bool = False  # whether the module continues with a command word of 0
    refused_by_stop: bool = True  # whether a `stop` that holds the axis refuses it
    ends_at_rest: bool = False  # whether it is a motion that ends at rest without a completion bit


_REST = (State.STANDSTILL,)
_FREE = (
    State.STANDSTILL,
    State.DISCRETE_MOTION,
    State.CONTINUOUS_MOTION,
    State.HOMING,
    State.SYNCHRONIZED_MOTION,
)
_GEARED = (State.SYNCHRONIZED_MOTION,)
_NOT_MOVING = (State.DISABLED, State.STANDSTILL, State.ERROR_STOP)
_ALIVE = (*_FREE, State.STOPPING)
_CONFIGURED = (*_ALIVE, State.ERROR_STOP)

_COMPLETE = StatusMsw.MOVE_COMPLETE.value
_AT_HOME = StatusMsw.AT_HOME.value

_MOVING = State.DISCRETE_MOTION

# fmt: off
ABSOLUTE = CommandKind("move_to", "MC_MoveAbsolute", _FREE, _MOVING, _COMPLETE, Yielding.HOLD, runs_on=True)
RELATIVE = CommandKind("move_by", "MC_MoveRelative", _FREE, _MOVING, _COMPLETE, Yielding.HOLD, runs_on=True)
VELOCITY = CommandKind("run", "MC_MoveVelocity", _FREE, State.CONTINUOUS_MOTION, None, Yielding.RELEASE)
HOME = CommandKind("home", "MC_Home", _REST, State.HOMING, _AT_HOME, Yielding.STOP, runs_on=True)
HALT = CommandKind("halt", "MC_Halt", _FREE)
GEAR_OUT = CommandKind("gear_out", "MC_GearOut", _GEARED)
STOP = CommandKind("stop", "MC_Stop", _ALIVE, refused_by_stop=False)
RESET = CommandKind("reset", "MC_Reset", _CONFIGURED, refused_by_stop=False)
PRESET = CommandKind("set_position", "MC_SetPosition", _REST)
GEAR = CommandKind("gear", "MC_GearIn", _FREE, State.SYNCHRONIZED_MOTION, None, Yielding.RELEASE)
PROGRAM_BLEND = CommandKind("program_blend", "ProgramBlend3601", _REST, yielding=Yielding.NOTHING)
RUN_BLEND = CommandKind("run_blend", "RunBlend3601", _REST, _MOVING, _COMPLETE, Yielding.STOP, runs_on=True)
REGISTRATION = CommandKind("run", "MoveRegistration3601", _FREE, _MOVING, 0, Yielding.STOP, ends_at_rest=True)
CONFIGURE = CommandKind("configure", "Configure3601", _NOT_MOVING, done_bits=None)
MINIMUM = CommandKind("store_minimum", "StoreMinimum3601", _REST)
# fmt: on

NOTHING_TO_SEND = (HALT, GEAR_OUT, STOP)
"""Kinds that are done once the axis is at rest, without a command to the module."""
