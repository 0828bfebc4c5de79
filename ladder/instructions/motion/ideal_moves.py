"""Motion instructions on an ideal axis [MOTION-RM002].

| instruction | ideal axis |
|---|---|
| MSO, MSF, MASD, MASR, MAFR | act immediately; DN |
| MAM, MAJ | a profile of a separate planner, trapezoidal or S-curve; with Merge, it ends all other motion |
| MCD, MAS | change or stop the planner that they name; MAS of All stops the sum of all planners |
| MAH | HomePosition immediately, as active homing "immediate"; PC a scan later |
| MRP | acts immediately, also in motion |
| MAG | the slave follows the master's position immediately; IP until it ends; no axis is its own master |
| MAW, MDW | PC when the axis reaches the position in the given direction; for a rotary axis, in any turn |
| MAR, MDR | armed; an ideal axis has no registration input |
| MRAT, MAAT, MRHD, MAHD | one scan; PC |
| MGS, MGSD, MGSR, MGSP | act on all axes, which are one group |
| all others | ER, ERR 25 |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...interpreter import Interpreter
from ...model.operands import Group
from ...model.predefined.motion_types import is_axis
from ...model.predefined.motion_words import (
    CHANGED_MOTION,
    DISABLED_ENABLED,
    RATE_UNITS,
    REDEFINITIONS,
    SPEED_UNITS,
    STOP_TYPES,
)
from .calls import MotionCall, Starter, Starters, dynamics_at, in_range, merge_at, scaled, start
from .courses import Kind
from .ideal_axis import BITS, IdealAxis, all_axes, forward_distance
from .motion_control import (
    ILLEGAL_CHANGE,
    OUT_OF_RANGE,
    SERVO_OFF,
    SHUT_DOWN,
    Argument,
    MotionError,
)
from .ramps import Dynamics
from .spots import Ideal, report

ROTARY_SHORTEST, ROTARY_POSITIVE, ROTARY_NEGATIVE = 2, 3, 4
"""Move types of a rotary axis; 0 is absolute, 1 incremental."""


def check_ready(axis: IdealAxis) -> None:
    """Raise a MotionError if the axis can't accept motion now; a virtual axis needs no servo."""
    if axis.is_on("ShutdownStatus"):
        raise MotionError(SHUT_DOWN)
    if not (axis.is_on("ServoActionStatus") or axis.part.kind == "AXIS_VIRTUAL"):
        raise MotionError(SERVO_OFF)


def _servo_on(axis: IdealAxis, _call: MotionCall) -> None:
    if axis.is_on("ShutdownStatus"):
        raise MotionError(SHUT_DOWN)
    _switch(axis, on=True)


def _switch(axis: IdealAxis, *, on: bool) -> None:
    """Set the servo bits, and mark the axis to be updated after the scan."""
    axis.set_bits(BITS, ServoActionStatus=on, DriveEnableStatus=on)
    axis.set_hidden(active=True)


def servo_off(axis: IdealAxis, now_ns: int, *, shut_down: bool = False) -> None:
    """Switch an axis off; its courses end."""
    axis.stop_at_once(now_ns)
    _switch(axis, on=False)
    if shut_down:
        axis.set_bits(BITS, ShutdownStatus=True)


def restart(axis: IdealAxis) -> None:
    """End a shutdown."""
    axis.set_bits(BITS, ShutdownStatus=False)
    axis.set_hidden(active=True)


def _switch_off(axis: IdealAxis, call: MotionCall) -> None:
    servo_off(axis, call.now_ns, shut_down=call.name == "MASD")


def _reset(axis: IdealAxis, call: MotionCall) -> None:
    """Run MASR, which ends a shutdown, or MAFR, which has no effect on an ideal axis."""
    if call.name == "MASR":
        restart(axis)


def _profile(axis: IdealAxis, call: MotionCall, index: int) -> tuple[Dynamics, bool]:
    """Return the dynamics from the operands starting at `index`, and whether to merge."""
    speed = axis.instant(call.now_ns).speed
    merge, current = merge_at(call, index + 10, DISABLED_ENABLED, speed)
    return dynamics_at(call, index, axis.maximum, current), merge == "ENABLED"


def _move(axis: IdealAxis, call: MotionCall) -> None:
    """Begin MAM; raise a MotionError if an operand is out of range.

    The stored target excludes the present travel of all courses, as `start` does.
    """
    move_type, operand = int(call.number(0)), in_range(call.number(1))
    dynamics, merge = _profile(axis, call, 2)
    if not 0 <= move_type <= ROTARY_NEGATIVE:
        raise MotionError(OUT_OF_RANGE)
    present = axis.position(call.now_ns)
    target = _target_position(move_type, operand, present, axis.settings.unwind)
    distance = target - present
    axis.begin(call.now_ns, "move", Kind.MOVE, dynamics, call.motion.claim, goal=distance, merge=merge)
    axis.set_hidden(target=target - axis.instant(call.now_ns).travel)
    call.show_begun()


def _target_position(move_type: int, operand: float, position: float, unwind: float) -> float:
    """Return the target position of a move, given its move type; `unwind` is 0 for a linear axis.

    >>> [_target_position(move_type, 10.0, 350.0, 360.0) for move_type in range(5)]
    [10.0, 360.0, 370.0, 370.0, 10.0]
    """
    if move_type == 1:
        return position + operand
    if not unwind:
        return operand
    if move_type == 0:
        return position // unwind * unwind + operand
    distance = forward_distance(operand - position, unwind)
    is_backward_shorter = move_type == ROTARY_SHORTEST and distance > unwind / 2
    if distance and (move_type == ROTARY_NEGATIVE or is_backward_shorter):
        distance -= unwind
    return operand + round((position + distance - operand) / unwind) * unwind


def _jog(axis: IdealAxis, call: MotionCall) -> None:
    dynamics, merge = _profile(axis, call, 1)
    goal = dynamics.speed * call.direction_sign(0)
    axis.begin(call.now_ns, "jog", Kind.JOG, dynamics, call.motion.claim, goal=goal, merge=merge)
    call.show_begun()


STOPS = {
    "JOG": ("jog", Kind.JOG),
    "MOVE": ("move", Kind.MOVE),
    "HOME": ("move", Kind.HOME),
    "GEAR": ("gear", Kind.GEAR),
}
"""Planner and kind of course that a stop type of MAS stops; other stop types don't apply to ideal axes."""


def _stop(axis: IdealAxis, call: MotionCall) -> None:
    """Run MAS: bring the planner of its stop type to rest, with PC at once if nothing moves."""
    stop_type, deceleration = call.keyword(0, STOP_TYPES), axis.maximum("Deceleration")
    planner, kind = STOPS.get(stop_type, ("whole", Kind.STOP))
    if call.says_yes(1):
        deceleration = scaled(call.number(2), call.keyword(3, RATE_UNITS), deceleration)
    if not stop_type:
        raise MotionError(OUT_OF_RANGE)
    has_course = stop_type == "ALL" or axis.courses[planner].kind in (kind, Kind.STOP)
    moving = has_course and stop(axis, call.now_ns, planner, deceleration, call.motion.claim)
    call.motion.set(IP=moving, PC=not moving)


def stop(axis: IdealAxis, now_ns: int, planner: str, down: float, claim: int) -> bool:
    """Bring a planner (or for `whole`, the axis) to rest; return whether it was moving."""
    all_planners = planner == "whole"
    courses = list(axis.courses.values()) if all_planners else [axis.courses[planner]]
    share = max(
        (course.dynamics.down_share for course in courses if course.kind is not Kind.NOTHING), default=0.0
    )
    axis.begin(now_ns, planner, Kind.STOP, Dynamics(1.0, down, down, share, share), claim, merge=all_planners)
    moving = axis.courses[planner].instant(now_ns).speed != 0
    if not moving:
        axis.courses[planner].end()
    return moving


def _home(axis: IdealAxis, call: MotionCall) -> None:
    axis.stop_at_once(call.now_ns)
    axis.begin(call.now_ns, "move", Kind.HOME, Dynamics(1.0, 1.0, 1.0), call.motion.claim)
    call.show_begun()


def _redefine(axis: IdealAxis, call: MotionCall) -> None:
    units = in_range(call.number(2))
    relative = call.keyword(0, REDEFINITIONS) == "RELATIVE"
    axis.redefine(units if relative else units - axis.position(call.now_ns))
    axis.set_hidden(active=True)


def _change(axis: IdealAxis, call: MotionCall) -> None:
    """Change the speed and rates of a jog or move; the instruction that began it stays active."""
    kind = {"JOG": Kind.JOG, "MOVE": Kind.MOVE}.get(call.keyword(0, CHANGED_MOTION))
    course = axis.courses["jog" if kind is Kind.JOG else "move"]
    if course.kind is not kind:
        raise MotionError(ILLEGAL_CHANGE)
    present = course.dynamics

    def value(index: int, unit_index: int, maximum: str, unchanged: float) -> float:
        """Return the operand after `index` if the operand at `index` is Yes; otherwise return `unchanged`."""
        if not call.says_yes(index):
            return unchanged
        unit = call.keyword(unit_index, SPEED_UNITS)
        return scaled(call.number(index + 1), unit, axis.maximum(maximum))

    speed = value(1, 11, "Speed", present.speed)
    up, down = value(3, 12, "Acceleration", present.up), value(5, 13, "Deceleration", present.down)
    changed = Dynamics(speed, up, down, present.up_share, present.down_share)
    goal = course.goal - course.instant(call.now_ns).travel
    if kind is Kind.JOG:
        goal = speed if course.goal > 0 else -speed
    axis.begin(call.now_ns, course.planner, kind, changed, course.claim, goal=goal)


def _gear(axis: IdealAxis, call: MotionCall) -> None:
    """Run MAG: begin to follow the master's position at a ratio.

    Reverse and Unchanged apply to the sign of the previous ratio. Raise a MotionError if the master does not
    exist or is the axis itself.
    """
    number, position = position_of(call.machine, call.operands[0])
    ratio = call.number(2)
    if call.keyword(6, ("Real", "Fraction")).startswith("FRACTION"):
        ratio = call.number(3) / call.number(4) if call.number(4) else 0.0
    direction = call.keyword(1, ("Same", "Opposite", "Reverse", "Unchanged"))
    if direction in ("REVERSE", "UNCHANGED"):
        was_opposite = float(axis["~ratio"]) < 0
        ratio = -abs(ratio) if was_opposite != (direction == "REVERSE") else abs(ratio)
    elif direction == "OPPOSITE":
        ratio = -ratio
    if number in (0, axis.number):
        raise MotionError(OUT_OF_RANGE)
    in_range(ratio)
    axis.begin(call.now_ns, "gear", Kind.GEAR, Dynamics(1.0, 1.0, 1.0), call.motion.claim, goal=position)
    axis.set_hidden(master=number, ratio=ratio)
    axis.catch_up(call.now_ns, {})
    call.motion.set(IP=True)


def position_of(machine: Interpreter, operand: Argument) -> tuple[int, float]:
    """Return the number and position of a master axis; 0 for other operands."""
    if not isinstance(operand, Group) or not is_axis(operand.type):
        return 0, 0.0
    number = machine.whole(machine.get(operand.member("~axis")))
    if number < 0:
        return number, IdealAxis(machine.memory, machine.lowered.ideal, number).position(machine.now_ns)
    return number, float(machine.get(operand.member("~position")))


def _watch(axis: IdealAxis, call: MotionCall) -> None:
    """Arm MAW; the axis's previous MAW ends."""
    report(axis.memory, axis.ideal, int(axis["~watch_claim"]), IP=False)
    axis.set_hidden(watch=call.direction_sign(0), watched=call.number(1))
    axis.set_hidden(watch_claim=call.motion.claim, active=True)
    axis.set_bits(BITS, WatchEventArmedStatus=True, WatchEventStatus=False)
    call.motion.set(IP=True)


def _unwatch(axis: IdealAxis, _call: MotionCall) -> None:
    """Disarm MAW."""
    report(axis.memory, axis.ideal, int(axis["~watch_claim"]), IP=False)
    axis.set_hidden(watch=0, watch_claim=0)
    axis.set_bits(BITS, WatchEventArmedStatus=False)


def _arm(axis: IdealAxis, call: MotionCall) -> None:
    """Arm (MAR) or disarm (MDR) a registration event, which never occurs on an ideal axis."""
    arms = call.name == "MAR"
    event = 2 if call.number(4 if arms else 0) == 2 else 1
    axis.set_bits(BITS, **{f"RegEvent{event}ArmedStatus": arms})
    call.motion.set(IP=arms)


def _finish_at_once(_axis: IdealAxis, call: MotionCall) -> None:
    call.motion.set(PC=True)


STARTERS: Starters = {
    "MSO": Starter(_servo_on),
    "MSF": Starter(_switch_off),
    "MASD": Starter(_switch_off),
    "MASR": Starter(_reset),
    "MAFR": Starter(_reset),
    "MAM": Starter(_move, moves=True),
    "MAJ": Starter(_jog, moves=True),
    "MAS": Starter(_stop),
    "MAH": Starter(_home, moves=True),
    "MRP": Starter(_redefine),
    "MCD": Starter(_change, moves=True),
    "MAG": Starter(_gear, moves=True),
    "MAW": Starter(_watch),
    "MDW": Starter(_unwatch),
    "MAR": Starter(_arm),
    "MDR": Starter(_arm),
    "MRAT": Starter(_finish_at_once),
    "MAAT": Starter(_finish_at_once),
    "MRHD": Starter(_finish_at_once),
    "MAHD": Starter(_finish_at_once),
}


def _group_stop(axis: IdealAxis, call: MotionCall) -> None:
    if any(course.kind is not Kind.NOTHING for course in axis.courses.values()):
        stop(axis, call.now_ns, "whole", axis.maximum("Deceleration"), 0)


def _strobe(axis: IdealAxis, call: MotionCall) -> None:
    position = axis.position(call.now_ns)
    axis.put(StrobeActualPosition=position, StrobeCommandPosition=position)


GROUP_ACTIONS: Mapping[str, Callable[[IdealAxis, MotionCall], None]] = {
    "MGS": _group_stop,
    "MGSD": lambda axis, call: servo_off(axis, call.now_ns, shut_down=True),
    "MGSR": lambda axis, _call: restart(axis),
    "MGSP": _strobe,
}
"""The action of each motion group instruction on an axis."""


def begin(ideal: Ideal, number: int, call: MotionCall) -> None:
    """Begin an instruction on an ideal axis, or raise a MotionError."""
    start(STARTERS, IdealAxis(call.machine.memory, ideal, number), call, check_ready)
    call.motion.set(DN=True)


def begin_of_group(ideal: Ideal, call: MotionCall) -> None:
    """Begin an instruction on the motion group; it is done immediately."""
    for axis in all_axes(call.machine.memory, ideal):
        GROUP_ACTIONS[call.name](axis, call)
    call.motion.set(DN=True, PC=True)
