"""Motion instructions on an ideal axis [MOTION-RM002].

| instruction | ideal axis |
|---|---|
| MSO, MSF, MASD, MASR, MAFR | at once; DN |
| MAM, MAJ | a profile of its own planner, trapezoidal or S-curve; with Merge, it ends all others |
| MCD, MAS | the profile of the planner that it names; MAS of All stops the sum of all |
| MAH | HomePosition at once, as active homing "immediate"; PC a scan later |
| MRP | at once, also in motion |
| MAG | the slave follows the master's position, locked at once; IP until it ends; no axis leads itself |
| MAW, MDW | PC when the axis reaches the position in that direction; for a rotary axis, in any turn |
| MAR, MDR | armed; there is no registration input |
| MRAT, MAAT, MRHD, MAHD | take one scan; PC |
| MGS, MGSD, MGSR, MGSP | act on all axes: there is one group |
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
from .calls import MotionCall, dynamics_at, in_range, merge_at, scaled
from .courses import Kind
from .ideal_axis import BITS, IdealAxis, ahead
from .motion_control import (
    ILLEGAL_CHANGE,
    OUT_OF_RANGE,
    SERVO_OFF,
    SHUT_DOWN,
    Answers,
    Given,
    MotionError,
    begin_by,
)
from .ramps import Dynamics
from .spots import Ideal, settle

ROTARY_SHORTEST, ROTARY_POSITIVE, ROTARY_NEGATIVE = 2, 3, 4
"""Move types of a rotary axis; 0 is absolute, 1 incremental."""


def check_ready(axis: IdealAxis) -> None:
    """Raise a MotionError if the axis accepts no motion at present; virtual axes need no servo."""
    if axis.is_on("ShutdownStatus"):
        raise MotionError(SHUT_DOWN)
    if not (axis.is_on("ServoActionStatus") or axis.part.kind == "AXIS_VIRTUAL"):
        raise MotionError(SERVO_OFF)


def _servo_on(axis: IdealAxis, call: MotionCall) -> None:
    if axis.is_on("ShutdownStatus"):
        raise MotionError(SHUT_DOWN)
    _switch(axis, on=True)
    call.motion.set(DN=True)


def _switch(axis: IdealAxis, *, on: bool) -> None:
    axis.bits(BITS, ServoActionStatus=on, DriveEnableStatus=on)
    axis.hide(active=True)


def servo_off(axis: IdealAxis, now_ns: int, *, shut_down: bool = False) -> None:
    """Switch an axis off; its courses end."""
    axis.rest(now_ns)
    _switch(axis, on=False)
    if shut_down:
        axis.bits(BITS, ShutdownStatus=True)


def restart(axis: IdealAxis) -> None:
    """End a shutdown."""
    axis.bits(BITS, ShutdownStatus=False)
    axis.hide(active=True)


def _off(axis: IdealAxis, call: MotionCall) -> None:
    servo_off(axis, call.now_ns, shut_down=call.name == "MASD")
    call.motion.set(DN=True)


def _reset(axis: IdealAxis, call: MotionCall) -> None:
    if call.name == "MASR":
        restart(axis)
    call.motion.set(DN=True)


def _profile(axis: IdealAxis, call: MotionCall, place: int) -> tuple[Dynamics, bool]:
    """Return the dynamics from the operands at `place`, and whether to merge."""
    speed = axis.instant(call.now_ns).speed
    merge, current = merge_at(call, place + 10, DISABLED_ENABLED, speed)
    return dynamics_at(call, place, axis.maximum, current), merge == "ENABLED"


def _move(axis: IdealAxis, call: MotionCall) -> None:
    kind, where = int(call.number(0)), in_range(call.number(1))
    dynamics, merge = _profile(axis, call, 2)
    if not 0 <= kind <= ROTARY_NEGATIVE:
        raise MotionError(OUT_OF_RANGE)
    present = axis.position(call.now_ns)
    goal = _goal(kind, where, present, axis.settings.unwind)
    axis.begin(call.now_ns, "move", Kind.MOVE, dynamics, call.motion.claim, goal=goal - present, merge=merge)
    axis.hide(target=goal - axis.instant(call.now_ns).travel)
    call.under_way()


def _goal(kind: int, where: float, position: float, unwind: float) -> float:
    """Return the target position of a move with a move type.

    >>> [_goal(kind, 10.0, 350.0, 360.0) for kind in range(5)]
    [10.0, 360.0, 370.0, 370.0, 10.0]
    """
    if kind == 1:
        return position + where
    if not unwind:
        return where
    if kind == 0:
        return position // unwind * unwind + where
    distance = ahead(where - position, unwind)
    if distance and (kind == ROTARY_NEGATIVE or (kind == ROTARY_SHORTEST and distance > unwind / 2)):
        distance -= unwind
    return where + round((position + distance - where) / unwind) * unwind


def _jog(axis: IdealAxis, call: MotionCall) -> None:
    dynamics, merge = _profile(axis, call, 1)
    goal = dynamics.speed * call.sign(0)
    axis.begin(call.now_ns, "jog", Kind.JOG, dynamics, call.motion.claim, goal=goal, merge=merge)
    call.under_way()


STOPS = {
    "JOG": ("jog", Kind.JOG),
    "MOVE": ("move", Kind.MOVE),
    "HOME": ("move", Kind.HOME),
    "GEAR": ("gear", Kind.GEAR),
}
"""Planner and kind of course that a stop type of MAS stops; other stop types don't apply to ideal axes."""


def _stop(axis: IdealAxis, call: MotionCall) -> None:
    stop_type, down = call.word(0, STOP_TYPES), axis.maximum("Deceleration")
    planner, kind = STOPS.get(stop_type, ("whole", Kind.STOP))
    if call.yes(1):
        down = scaled(call.number(2), call.word(3, RATE_UNITS), down)
    if not stop_type:
        raise MotionError(OUT_OF_RANGE)
    stands = stop_type != "ALL" and axis.courses[planner].kind not in (kind, Kind.STOP)
    moving = not stands and stop(axis, call.now_ns, planner, down, call.motion.claim)
    call.motion.set(DN=True, IP=moving, PC=not moving)


def stop(axis: IdealAxis, now_ns: int, planner: str, down: float, claim: int) -> bool:
    """Bring a planner to rest, or with `whole`, the axis; return whether that takes time."""
    whole = planner == "whole"
    courses = list(axis.courses.values()) if whole else [axis.courses[planner]]
    share = max(
        (course.dynamics.down_share for course in courses if course.kind is not Kind.NOTHING), default=0.0
    )
    axis.begin(now_ns, planner, Kind.STOP, Dynamics(1.0, down, down, share, share), claim, merge=whole)
    moving = axis.courses[planner].instant(now_ns).speed != 0
    if not moving:
        axis.courses[planner].end()
    return moving


def _home(axis: IdealAxis, call: MotionCall) -> None:
    axis.rest(call.now_ns)
    axis.begin(call.now_ns, "move", Kind.HOME, Dynamics(1.0, 1.0, 1.0), call.motion.claim)
    call.under_way()


def _redefine(axis: IdealAxis, call: MotionCall) -> None:
    units = in_range(call.number(2))
    relative = call.word(0, REDEFINITIONS) == "RELATIVE"
    axis.redefine(units if relative else units - axis.position(call.now_ns))
    axis.hide(active=True)
    call.motion.set(DN=True)


def _change(axis: IdealAxis, call: MotionCall) -> None:
    """Change speed and rates of a jog or a move; its instruction continues, and so does the other course."""
    kind = {"JOG": Kind.JOG, "MOVE": Kind.MOVE}.get(call.word(0, CHANGED_MOTION))
    course = axis.courses["jog" if kind is Kind.JOG else "move"]
    if course.kind is not kind:
        raise MotionError(ILLEGAL_CHANGE)
    now = course.dynamics
    units = ((1, 11, "Speed", now.speed), (3, 12, "Acceleration", now.up), (5, 13, "Deceleration", now.down))
    speed, up, down = (
        scaled(call.number(place + 1), call.word(unit, SPEED_UNITS), axis.maximum(name))
        if call.yes(place)
        else present
        for place, unit, name, present in units
    )
    dynamics = Dynamics(speed, up, down, now.up_share, now.down_share)
    goal = course.goal - course.instant(call.now_ns).travel
    if kind is Kind.JOG:
        goal = speed if course.goal > 0 else -speed
    axis.begin(call.now_ns, course.planner, kind, dynamics, course.claim, goal=goal)
    call.motion.set(DN=True)


def _gear(axis: IdealAxis, call: MotionCall) -> None:
    number, seen = position_of(call.machine, call.operands[0])
    ratio = call.number(2)
    if call.word(6, ("Real", "Fraction")).startswith("FRACTION"):
        ratio = call.number(3) / call.number(4) if call.number(4) else 0.0
    direction = call.word(1, ("Same", "Opposite", "Reverse", "Unchanged"))
    before = float(axis["~ratio"])
    if direction in ("REVERSE", "UNCHANGED"):
        ratio = abs(ratio) * (-1 if (before < 0) != (direction == "REVERSE") else 1)
    elif direction == "OPPOSITE":
        ratio = -ratio
    if number in (0, axis.number):
        raise MotionError(OUT_OF_RANGE)
    in_range(ratio)
    axis.begin(call.now_ns, "gear", Kind.GEAR, Dynamics(1.0, 1.0, 1.0), call.motion.claim, goal=seen)
    axis.hide(master=number, ratio=ratio)
    axis.catch_up(call.now_ns, {})
    call.motion.set(DN=True, IP=True)


def position_of(machine: Interpreter, operand: Given) -> tuple[int, float]:
    """Return the number and position of a master axis; 0 for other operands."""
    if not isinstance(operand, Group) or not is_axis(operand.type):
        return 0, 0.0
    number = machine.whole(machine.get(operand.member("~axis")))
    if number < 0:
        return number, IdealAxis(machine.memory, machine.lowered.ideal, number).position(machine.now_ns)
    return number, float(machine.get(operand.member("~position")))


def _watch(axis: IdealAxis, call: MotionCall) -> None:
    settle(axis.memory, axis.ideal, int(axis["~watch_claim"]), IP=False)
    axis.hide(watch=call.sign(0), watched=call.number(1), watch_claim=call.motion.claim, active=True)
    axis.bits(BITS, WatchEventArmedStatus=True, WatchEventStatus=False)
    call.motion.set(DN=True, IP=True)


def _unwatch(axis: IdealAxis, call: MotionCall) -> None:
    settle(axis.memory, axis.ideal, int(axis["~watch_claim"]), IP=False)
    axis.hide(watch=0, watch_claim=0)
    axis.bits(BITS, WatchEventArmedStatus=False)
    call.motion.set(DN=True)


def _arm(axis: IdealAxis, call: MotionCall) -> None:
    second = call.number(4 if call.name == "MAR" else 0) == 2
    armed = "RegEvent2ArmedStatus" if second else "RegEvent1ArmedStatus"
    axis.bits(BITS, **{armed: call.name == "MAR"})
    call.motion.set(DN=True, IP=call.name == "MAR")


def _done(_axis: IdealAxis, call: MotionCall) -> None:
    call.motion.set(DN=True, PC=True)


ANSWERS: Answers = {
    "MSO": (_servo_on, False),
    "MSF": (_off, False),
    "MASD": (_off, False),
    "MASR": (_reset, False),
    "MAFR": (_reset, False),
    "MAM": (_move, True),
    "MAJ": (_jog, True),
    "MAS": (_stop, False),
    "MAH": (_home, True),
    "MRP": (_redefine, False),
    "MCD": (_change, True),
    "MAG": (_gear, True),
    "MAW": (_watch, False),
    "MDW": (_unwatch, False),
    "MAR": (_arm, False),
    "MDR": (_arm, False),
    "MRAT": (_done, False),
    "MAAT": (_done, False),
    "MRHD": (_done, False),
    "MAHD": (_done, False),
}


def _group_stop(axis: IdealAxis, call: MotionCall) -> None:
    if any(course.kind is not Kind.NOTHING for course in axis.courses.values()):
        stop(axis, call.now_ns, "whole", axis.maximum("Deceleration"), 0)


def _strobe(axis: IdealAxis, call: MotionCall) -> None:
    position = axis.position(call.now_ns)
    axis.put(StrobeActualPosition=position, StrobeCommandPosition=position)


GROUP_ANSWERS: Mapping[str, Callable[[IdealAxis, MotionCall], None]] = {
    "MGS": _group_stop,
    "MGSD": lambda axis, call: servo_off(axis, call.now_ns, shut_down=True),
    "MGSR": lambda axis, _call: restart(axis),
    "MGSP": _strobe,
}
"""The action of each motion group instruction on an axis."""


def begin(ideal: Ideal, number: int, call: MotionCall) -> None:
    """Begin an instruction on an ideal axis, or raise a MotionError."""
    axis = IdealAxis(call.machine.memory, ideal, number)
    begin_by(ANSWERS, call.name, lambda: check_ready(axis), axis, call)


def begin_of_group(ideal: Ideal, call: MotionCall) -> None:
    """Begin an instruction on the motion group; it is done at once."""
    for place in range(len(ideal.axes)):
        GROUP_ANSWERS[call.name](IdealAxis(call.machine.memory, ideal, -place - 1), call)
    call.motion.set(DN=True, PC=True)
