"""Motion instructions on a 3601, as requests to the block that owns the module's words (`axis3601.rung`).

| instruction | 3601 |
|---|---|
| MSO | configures the module if the rack has a configuration; then the axis accepts commands |
| MSF, MASD | brings the axis to rest; it accepts no commands |
| MASR, MAFR | Reset Errors |
| MAM | absolute or relative move; MAJ: manual move; MAS: hold, or release |
| MAH | Find Home |
| MRP | Preset Position |
| MCD | changes the speed of a manual move |

A request is a ticket of the axis; see `axis3601.rung`. The instruction's bits follow the request: IP while it
is under way, PC or DN when it has ended, ER if the axis failed. A newer request ends IP without PC. A program
with functions that a 3601 lacks is refused when it is built.

A 3601 executes one command and superimposes nothing. MAM and MAJ replace a motion of their own kind. During
another motion, they are refused without Merge (ERR 22); with Merge, the axis comes to rest in between.
"""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.thousands import split_thousands

from ...model.predefined.motion_words import (
    CHANGED_MOTION,
    DISABLED_ENABLED,
    MERGE_SPEEDS,
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
from .calls import MotionCall, Starter, Starters, start
from .motion_control import (
    AXIS_FAULT,
    AXIS_NOT_CONFIGURED,
    ILLEGAL_CHANGE,
    IN_MOTION,
    OUT_OF_RANGE,
    SHUT_DOWN,
    MotionControl,
    MotionError,
)


def _profile(command: int, target: int, speed: int, rates: Sequence[int]) -> tuple[int, ...]:
    """Return the output words of a motion, in the module's units."""
    return command, 0, *split_thousands(target), *split_thousands(speed), *rates


def _servo_on(axis: Axis, call: MotionCall) -> None:
    """Run MSO: turn the servo on, or first request the configuration; `follow` then turns the servo on."""
    if axis.tag["ShutdownStatus"]:
        raise MotionError(SHUT_DOWN)
    if axis.status != 0:
        axis.tag.set(ServoActionStatus=True, DriveEnableStatus=True)
        call.motion.set(DN=True)
    elif axis.settings.configuration:
        axis.request(call.motion, CONFIGURE, *axis.settings.configuration)
    else:
        raise MotionError(AXIS_NOT_CONFIGURED)


def _servo_off(axis: Axis, call: MotionCall) -> None:
    """Run MSF or MASD: turn the servo off and halt the axis.

    The instruction is done at once, so it does not follow the request of the halt.
    """
    axis.tag.set(ServoActionStatus=False, DriveEnableStatus=False)
    if call.name == "MASD":
        axis.tag.set(ShutdownStatus=True)
    if axis.state["Running"]:
        axis.request(call.motion, HALT)
        call.motion.ticket = 0
    call.motion.set(DN=True)


def _reset(axis: Axis, call: MotionCall) -> None:
    """Run MASR or MAFR: request Reset Errors; MASR also ends a shutdown."""
    if call.name == "MASR":
        axis.tag.set(ShutdownStatus=False)
    if axis.status == 0:
        raise MotionError(AXIS_NOT_CONFIGURED)
    axis.request(call.motion, RESET, COMMANDS[RESET])


def _move(axis: Axis, call: MotionCall) -> None:
    """Begin MAM; raise a MotionError unless its move type is absolute (0) or relative (1)."""
    kind = {0: ABSOLUTE, 1: RELATIVE}.get(int(call.number(0)))
    target = axis.steps(call.number(1))
    if kind is None:
        raise MotionError(OUT_OF_RANGE)
    _begin_motion(axis, call, index=2, kind=kind, command=COMMANDS[kind], target=target)


def _jog(axis: Axis, call: MotionCall) -> None:
    command = 256 if call.direction_sign(0) < 0 else 128
    _begin_motion(axis, call, index=1, kind=VELOCITY, command=command, target=0)


STOPPED_BY = {"MOVE": (ABSOLUTE, RELATIVE), "JOG": (VELOCITY,), "HOME": (HOME,)}
"""Kinds of requests that each stop type of MAS ends; other stop types don't apply to a 3601."""


def _begin_motion(axis: Axis, call: MotionCall, *, index: int, kind: int, command: int, target: int) -> None:
    """Request a move or a jog; the operand at `index` is its speed, and Merge is ten operands later."""
    present = axis.kind_under_way
    merge = call.keyword(index + 10, DISABLED_ENABLED) == "ENABLED"
    if not merge and any(present in kinds and kind not in kinds for kinds in STOPPED_BY.values()):
        raise MotionError(IN_MOTION)
    speed = axis.speed(call.number(index), call.keyword(index + 1, SPEED_UNITS))
    rates = [
        axis.rate(call.number(index + offset), call.keyword(index + offset + 1, RATE_UNITS))
        for offset in (2, 4)
    ]
    if merge and present and call.keyword(index + 11, MERGE_SPEEDS) == "CURRENT":
        speed = axis.requested_speed or speed
    axis.request(call.motion, kind, *_profile(command, target, speed, rates))
    call.motion.set(DN=True, IP=True, AC=True)


def _stop(axis: Axis, call: MotionCall) -> None:
    """Run MAS: request a halt if a motion of its stop type is under way, otherwise set PC."""
    stop_type = call.keyword(0, STOP_TYPES)
    if stop_type == "ALL" or axis.kind_under_way in (*STOPPED_BY.get(stop_type, ()), HALT):
        call.motion.set(DN=True, IP=True)
        axis.request(call.motion, HALT)
    else:
        call.motion.set(DN=True, PC=True)


def _home(axis: Axis, call: MotionCall) -> None:
    """Begin MAH with the speed and rates of the rack file or the tag; the axis must be at rest."""
    settings = axis.settings
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    speed = axis.speed(settings.home_speed or float(axis.tag["HomeSpeed"]), "")
    rate = axis.rate(settings.home_acceleration or axis.max_acceleration(), "")
    command = COMMANDS[HOME] if settings.home_direction > 0 else 2 * COMMANDS[HOME]  # the next bit is CCW
    axis.request(call.motion, HOME, *_profile(command, 0, speed, (rate, rate)))
    call.motion.set(DN=True, IP=True, AC=True)


def _redefine(axis: Axis, call: MotionCall) -> None:
    """Run MRP: request Preset Position; the axis must be at rest."""
    units = call.number(2)
    if call.keyword(0, REDEFINITIONS) == "RELATIVE":
        units += float(axis.tag["ActualPosition"])
    if axis.status != STANDSTILL:
        raise MotionError(IN_MOTION)
    axis.request(call.motion, SET_POSITION, COMMANDS[SET_POSITION], 0, *split_thousands(axis.steps(units)))


def _change(axis: Axis, call: MotionCall) -> None:
    """Change the speed and rates of a manual move; MCD can't change other moves.

    It is done at once, so it does not follow its request.
    """
    if not axis.tag["JogStatus"] or call.keyword(0, CHANGED_MOTION) != "JOG":
        raise MotionError(ILLEGAL_CHANGE)
    command, *_, up, down = axis.output_words
    speed = axis.requested_speed
    if call.says_yes(1):
        speed = axis.speed(call.number(2), call.keyword(11, SPEED_UNITS))
    if call.says_yes(3):
        up = axis.rate(call.number(4), call.keyword(12, RATE_UNITS))
    if call.says_yes(5):
        down = axis.rate(call.number(6), call.keyword(13, RATE_UNITS))
    axis.request(call.motion, VELOCITY, *_profile(command, 0, speed, (up, down)))
    call.motion.ticket = 0
    call.motion.set(DN=True)


STARTERS: Starters = {
    "MSO": Starter(_servo_on),
    "MSF": Starter(_servo_off),
    "MASD": Starter(_servo_off),
    "MASR": Starter(_reset),
    "MAFR": Starter(_reset),
    "MAM": Starter(_move, moves=True),
    "MAJ": Starter(_jog, moves=True),
    "MAS": Starter(_stop, moves=True),
    "MAH": Starter(_home, moves=True),
    "MRP": Starter(_redefine, moves=True),
    "MCD": Starter(_change, moves=True),
}


def begin(axis: Axis, call: MotionCall) -> None:
    """Begin an instruction on a 3601, or raise a MotionError."""
    start(STARTERS, axis, call, Axis.check_ready)


def follow(axis: Axis, motion: MotionControl, name: str) -> None:
    """Update an instruction's bits from its request, and forget a finished request.

    MSO turns the servo on when its configuration is finished.
    """
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
