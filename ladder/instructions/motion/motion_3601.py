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

A request is a ticket of the axis, see `axis3601.rung`. The instruction's bits follow it: IP while it is under
way, PC or DN when it has ended, ER if the axis failed. A newer request ends IP without PC. Functions that a
3601 lacks are refused when the program is built.

A 3601 executes one command and superimposes nothing. MAM and MAJ replace a motion of their own kind. During
another motion, they are refused without Merge (ERR 22); with Merge, the axis comes to rest in between.
"""

from __future__ import annotations

from collections.abc import Sequence

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
    Answers,
    Given,
    MotionControl,
    MotionError,
    begin_by,
    number_of,
    word_of,
)


def _pair(value: int) -> tuple[int, int]:
    """Split a number into thousands and remainder, both signed."""
    size = (abs(value) // 1000, abs(value) % 1000)
    return size if value >= 0 else (-size[0], -size[1])


def _profile(command: int, target: int, speed: int, rates: Sequence[int], shape: int = 0) -> tuple[int, ...]:
    """Return the output words of a motion, in the module's units."""
    return command, shape, *_pair(target), *_pair(speed), *rates


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


def _move(axis: Axis, motion: MotionControl, kind: Resolved, position: Resolved, *others: Given) -> None:
    request = {0: ABSOLUTE, 1: RELATIVE}.get(int(number_of(axis.machine, kind)))
    target = axis.steps(number_of(axis.machine, position))
    if request is None:
        raise MotionError(OUT_OF_RANGE)
    _go(axis, motion, request, COMMANDS[request], target, others)


def _jog(axis: Axis, motion: MotionControl, direction: Given, *others: Given) -> None:
    backwards = word_of(axis.machine, direction, ("Forward", "Reverse")) == "REVERSE"
    _go(axis, motion, VELOCITY, 256 if backwards else 128, 0, others)


STOPPED_BY = {"MOVE": (ABSOLUTE, RELATIVE), "JOG": (VELOCITY,), "HOME": (HOME,)}
"""Kinds of requests by the stop type of MAS that ends them; other stop types don't apply to a 3601."""


def _go(
    axis: Axis, motion: MotionControl, kind: int, command: int, target: int, operands: tuple[Given, ...]
) -> None:
    """Request a move or a jog; `operands` begin with the speed."""
    present = axis.under_way
    merge = len(operands) > 10 and word_of(axis.machine, operands[10], DISABLED_ENABLED) == "ENABLED"
    if not merge and any(present in kinds and kind not in kinds for kinds in STOPPED_BY.values()):
        raise MotionError(IN_MOTION)
    speed, *rates = _dynamics(axis, *operands[:6])
    if merge and present and word_of(axis.machine, operands[11], MERGE_SPEEDS) == "CURRENT":
        words = axis.words
        speed = words[4] * 1000 + words[5] or speed
    axis.request(motion, kind, *_profile(command, target, speed, rates))
    motion.set(DN=True, IP=True, AC=True)


def _dynamics(axis: Axis, *operands: Given) -> tuple[int, int, int]:
    """Return speed and both rates in the module's units."""
    values, units = operands[::2], operands[1::2]
    lists = (SPEED_UNITS, RATE_UNITS, RATE_UNITS)
    words = [word_of(axis.machine, unit, names) for unit, names in zip(units, lists, strict=True)]
    numbers = [number_of(axis.machine, value) for value in values]
    up, down = axis.rate(numbers[1], words[1]), axis.rate(numbers[2], words[2])
    return axis.speed(numbers[0], words[0]), up, down


def _stop(axis: Axis, motion: MotionControl, operand: Given, *_others: Given) -> None:
    stop_type = word_of(axis.machine, operand, STOP_TYPES)
    if stop_type == "ALL" or axis.under_way in (*STOPPED_BY.get(stop_type, ()), HALT):
        motion.set(DN=True, IP=True)
        axis.request(motion, HALT)
    else:
        motion.set(DN=True, PC=True)


def _home(axis: Axis, motion: MotionControl) -> None:
    settings = axis.settings
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    speed = axis.speed(settings.home_speed or float(axis.tag["HomeSpeed"]), "")
    rate = axis.rate(settings.home_acceleration or axis.maximum(), "")
    command = COMMANDS[HOME] if settings.home_direction > 0 else 2 * COMMANDS[HOME]  # the next bit is CCW
    axis.request(motion, HOME, *_profile(command, 0, speed, (rate, rate)))
    motion.set(DN=True, IP=True, AC=True)


def _redefine(axis: Axis, motion: MotionControl, kind: Given, _select: Given, position: Resolved) -> None:
    units = number_of(axis.machine, position)
    if word_of(axis.machine, kind, REDEFINITIONS) == "RELATIVE":
        units += float(axis.tag["ActualPosition"])
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    axis.request(motion, SET_POSITION, COMMANDS[SET_POSITION], 0, *_pair(axis.steps(units)))


def _change(
    axis: Axis,
    motion: MotionControl,
    kind: Given,
    change_speed: Given,
    speed: Resolved,
    change_up: Given,
    up: Resolved,
    change_down: Given,
    down: Resolved,
    *others: Given,
) -> None:
    """Change the speed of a manual move; a move can't be changed."""
    words = axis.words
    moving = axis.tag["JogStatus"] and word_of(axis.machine, kind, CHANGED_MOTION) == "JOG"
    if not moving:
        raise MotionError(ILLEGAL_CHANGE)
    speed_unit, up_unit, down_unit = (_unit(axis, unit) for unit in others[4:7])
    changes = [
        word_of(axis.machine, word, NO_YES) == "YES" for word in (change_speed, change_up, change_down)
    ]
    new_speed, new_up, new_down = (
        axis.speed(number_of(axis.machine, speed), speed_unit) if changes[0] else words[4] * 1000 + words[5],
        axis.rate(number_of(axis.machine, up), up_unit) if changes[1] else words[6],
        axis.rate(number_of(axis.machine, down), down_unit) if changes[2] else words[7],
    )
    axis.request(motion, VELOCITY, *_profile(words[0], 0, new_speed, (new_up, new_down)))
    motion.ticket = 0
    motion.set(DN=True)


def _unit(axis: Axis, operand: Given) -> str:
    return word_of(axis.machine, operand, RATE_UNITS)


ANSWERS: Answers = {
    "MSO": (_servo_on, False),
    "MSF": (_servo_off, False),
    "MASD": (lambda axis, motion: _servo_off(axis, motion, shut_down=True), False),
    "MASR": (lambda axis, motion: _reset(axis, motion, restart=True), False),
    "MAFR": (_reset, False),
    "MAM": (_move, True),
    "MAJ": (_jog, True),
    "MAS": (_stop, True),
    "MAH": (_home, True),
    "MRP": (_redefine, True),
    "MCD": (_change, True),
}


def begin(axis: Axis, motion: MotionControl, name: str, operands: tuple[Given, ...]) -> None:
    """Begin an instruction with the operands after the axis and the control, or raise a MotionError."""
    begin_by(ANSWERS, name, axis.check_ready, axis, motion, *operands)


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
