"""Motion instructions on a 3601, as requests to the block that owns the module's words (`axis3601.rung`).

| instruction | 3601 |
|---|---|
| MSO | configures the module if the rack has a configuration; then the axis takes commands |
| MSF, MASD | brings the axis to rest; it takes no commands |
| MASR, MAFR | Reset Errors |
| MAM | absolute or relative move; MAJ: manual move; MAS: hold, or release |
| MAH | Find Home |
| MRP | Preset Position |
| MCD | changes the speed of a manual move |

A request is a ticket of the axis, see `axis3601.rung`. The instruction's bits follow the request: IP while it
is under way, PC or DN when it has ended, ER if the axis failed. A newer request ends IP without PC. A program
with functions that a 3601 lacks is refused when it is built.

A 3601 executes one command and superimposes nothing. MAM and MAJ replace a motion of their own kind. During
another motion, they are refused without Merge (ERR 22); with Merge, the axis comes to rest in between.
"""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.thousands import split_thousands

from ...model.operands import Resolved
from ...model.predefined.motion_words import (
    CHANGED_MOTION,
    DISABLED_ENABLED,
    MERGE_SPEEDS,
    NO_YES,
    RATE_UNITS,
    REDEFINITIONS,
    SPEED_UNITS,
    STOP_TYPES,
)
from .axis_3601 import (
    ABSOLUTE,
    COMMANDS,
    CONFIGURE,
    HALT,
    HOME,
    RELATIVE,
    RESET,
    SET_POSITION,
    STANDSTILL,
    VELOCITY,
    Axis,
)
from .motion_control import (
    AXIS_FAULT,
    AXIS_NOT_CONFIGURED,
    ILLEGAL_CHANGE,
    IN_MOTION,
    OUT_OF_RANGE,
    SHUT_DOWN,
    MotionControl,
    MotionError,
    MotionOperand,
    Starter,
    Starters,
    number_of,
    start,
    word_of,
)


def _profile(command: int, target: int, speed: int, rates: Sequence[int], shape: int = 0) -> tuple[int, ...]:
    """Return the output words of a motion, in the module's units."""
    return command, shape, *split_thousands(target), *split_thousands(speed), *rates


def _servo_on(axis: Axis, motion: MotionControl) -> None:
    if axis.tag["ShutdownStatus"]:
        raise MotionError(SHUT_DOWN)
    if axis.status != 0:
        axis.tag.set(ServoActionStatus=True, DriveEnableStatus=True)
        motion.set(DN=True)
    elif axis.settings.configuration:
        axis.request(motion, CONFIGURE, *axis.settings.configuration)
    else:
        raise MotionError(AXIS_NOT_CONFIGURED)


def _servo_off(axis: Axis, motion: MotionControl, *, shut_down: bool = False) -> None:
    axis.tag.set(ServoActionStatus=False, DriveEnableStatus=False)
    if shut_down:
        axis.tag.set(ShutdownStatus=True)
    if axis.state["Running"]:
        axis.request(motion, HALT)
        motion.ticket = 0
    motion.set(DN=True)


def _reset(axis: Axis, motion: MotionControl, *, restart: bool = False) -> None:
    if restart:
        axis.tag.set(ShutdownStatus=False)
    if axis.status == 0:
        raise MotionError(AXIS_NOT_CONFIGURED)
    axis.request(motion, RESET, COMMANDS[RESET])


def _move(
    axis: Axis, motion: MotionControl, kind: Resolved, position: Resolved, *dynamics_and_merge: MotionOperand
) -> None:
    request = {0: ABSOLUTE, 1: RELATIVE}.get(int(number_of(axis.machine, kind)))
    target = axis.steps(number_of(axis.machine, position))
    if request is None:
        raise MotionError(OUT_OF_RANGE)
    _begin_motion(axis, motion, request, COMMANDS[request], target, dynamics_and_merge)


def _jog(
    axis: Axis, motion: MotionControl, direction: MotionOperand, *dynamics_and_merge: MotionOperand
) -> None:
    backwards = word_of(axis.machine, direction, ("Forward", "Reverse")) == "REVERSE"
    _begin_motion(axis, motion, VELOCITY, 256 if backwards else 128, 0, dynamics_and_merge)


STOPPED_BY = {"MOVE": (ABSOLUTE, RELATIVE), "JOG": (VELOCITY,), "HOME": (HOME,)}
"""Kinds of requests by the stop type of MAS that ends them; other stop types don't apply to a 3601."""


def _begin_motion(
    axis: Axis,
    motion: MotionControl,
    kind: int,
    command: int,
    target: int,
    operands: tuple[MotionOperand, ...],
) -> None:
    """Request a move or a jog; `operands` begin with the speed, and have the merge at 10 and 11."""
    kind_under_way = axis.kind_under_way
    merge = len(operands) > 10 and word_of(axis.machine, operands[10], DISABLED_ENABLED) == "ENABLED"
    if not merge and any(kind_under_way in kinds and kind not in kinds for kinds in STOPPED_BY.values()):
        raise MotionError(IN_MOTION)
    speed, *rates = _dynamics(axis, *operands[:6])
    if merge and kind_under_way and word_of(axis.machine, operands[11], MERGE_SPEEDS) == "CURRENT":
        speed = axis.requested_speed or speed
    axis.request(motion, kind, *_profile(command, target, speed, rates))
    motion.set(DN=True, IP=True, AC=True)


def _dynamics(axis: Axis, *operands: MotionOperand) -> tuple[int, int, int]:
    """Return speed and both rates in the module's units, from three values with a unit after each."""
    speed, up, down = (number_of(axis.machine, value) for value in operands[::2])
    keywords = zip(operands[1::2], (SPEED_UNITS, RATE_UNITS, RATE_UNITS), strict=True)
    speed_unit, up_unit, down_unit = (word_of(axis.machine, unit, units) for unit, units in keywords)
    rates = axis.rate(up, up_unit), axis.rate(down, down_unit)
    return axis.speed(speed, speed_unit), *rates


def _stop(axis: Axis, motion: MotionControl, operand: MotionOperand, *_others: MotionOperand) -> None:
    stop_type = word_of(axis.machine, operand, STOP_TYPES)
    if stop_type == "ALL" or axis.kind_under_way in (*STOPPED_BY.get(stop_type, ()), HALT):
        motion.set(DN=True, IP=True)
        axis.request(motion, HALT)
    else:
        motion.set(DN=True, PC=True)


def _home(axis: Axis, motion: MotionControl) -> None:
    settings = axis.settings
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    speed = axis.speed(settings.home_speed or float(axis.tag["HomeSpeed"]), "")
    rate = axis.rate(settings.home_acceleration or axis.max_acceleration(), "")
    command = COMMANDS[HOME] if settings.home_direction > 0 else 2 * COMMANDS[HOME]  # the next bit is CCW
    axis.request(motion, HOME, *_profile(command, 0, speed, (rate, rate)))
    motion.set(DN=True, IP=True, AC=True)


def _redefine(
    axis: Axis, motion: MotionControl, kind: MotionOperand, _select: MotionOperand, position: Resolved
) -> None:
    units = number_of(axis.machine, position)
    if word_of(axis.machine, kind, REDEFINITIONS) == "RELATIVE":
        units += float(axis.tag["ActualPosition"])
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    axis.request(motion, SET_POSITION, COMMANDS[SET_POSITION], 0, *split_thousands(axis.steps(units)))


def _change(
    axis: Axis,
    motion: MotionControl,
    kind: MotionOperand,
    change_speed: MotionOperand,
    speed: Resolved,
    change_up: MotionOperand,
    up: Resolved,
    change_down: MotionOperand,
    down: Resolved,
    *others: MotionOperand,
) -> None:
    """Change the speed of a manual move; MCD can't change other moves."""
    words = axis.output_words
    moving = axis.tag["JogStatus"] and word_of(axis.machine, kind, CHANGED_MOTION) == "JOG"
    if not moving:
        raise MotionError(ILLEGAL_CHANGE)
    speed_unit, up_unit, down_unit = (_unit(axis, unit) for unit in others[4:7])
    changes = [
        word_of(axis.machine, word, NO_YES) == "YES" for word in (change_speed, change_up, change_down)
    ]
    new_speed, new_up, new_down = (
        axis.speed(number_of(axis.machine, speed), speed_unit) if changes[0] else axis.requested_speed,
        axis.rate(number_of(axis.machine, up), up_unit) if changes[1] else words[6],
        axis.rate(number_of(axis.machine, down), down_unit) if changes[2] else words[7],
    )
    axis.request(motion, VELOCITY, *_profile(words[0], 0, new_speed, (new_up, new_down)))
    motion.ticket = 0
    motion.set(DN=True)


def _unit(axis: Axis, operand: MotionOperand) -> str:
    return word_of(axis.machine, operand, RATE_UNITS)


STARTERS: Starters = {
    "MSO": Starter(_servo_on),
    "MSF": Starter(_servo_off),
    "MASD": Starter(lambda axis, motion: _servo_off(axis, motion, shut_down=True)),
    "MASR": Starter(lambda axis, motion: _reset(axis, motion, restart=True)),
    "MAFR": Starter(_reset),
    "MAM": Starter(_move, moves=True),
    "MAJ": Starter(_jog, moves=True),
    "MAS": Starter(_stop, moves=True),
    "MAH": Starter(_home, moves=True),
    "MRP": Starter(_redefine, moves=True),
    "MCD": Starter(_change, moves=True),
}


def begin(axis: Axis, motion: MotionControl, name: str, operands: tuple[MotionOperand, ...]) -> None:
    """Begin an instruction with the operands after the axis and the control, or raise a MotionError."""
    start(STARTERS, name, axis.check_ready, axis, motion, *operands)


def follow(axis: Axis, motion: MotionControl, name: str) -> None:
    """Update an instruction's bits from its request."""
    ticket = motion.ticket
    if not ticket:
        return
    if axis.state["Failed"] == ticket:
        motion.refuse(AXIS_FAULT)
    elif axis.state["Finished"] == ticket:
        motion.set(IP=False, AC=False, DN=True, PC=name in ("MAM", "MAS", "MAH"))
        if name == "MSO":
            axis.tag.set(ServoActionStatus=True, DriveEnableStatus=True)
    elif axis.state["Ticket"] != ticket:
        motion.set(IP=False, AC=False)
    else:
        return
    motion.ticket = 0
