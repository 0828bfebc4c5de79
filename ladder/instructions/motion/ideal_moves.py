"""Motion instructions on an ideal axis [MOTION-RM002].

| instruction | ideal axis |
|---|---|
| MSO, MSF, MASD, MASR, MAFR | at once; DN |
| MAM, MAJ, MAS, MCD | a profile from the present speed, trapezoidal or S-curve; it replaces the one before |
| MAH | HomePosition at once, as active homing "immediate"; PC a scan later |
| MRP | at once, also in motion |
| MAG | the slave follows the master's position, locked at once; IP until it ends |
| MAW, MDW | PC when the axis comes to the position in that direction |
| MAR, MDR | armed; no registration input comes |
| MRAT, MAAT, MRHD, MAHD | a scan; PC |
| MGS, MGSD, MGSR, MGSP | all axes: there is one group |
| all others | ER, ERR 25 |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from ...interpreter import Interpreter
from ...model.operands import Group
from ...model.predefined.motion_types import is_axis
from ...model.predefined.motion_words import (
    CHANGED_MOTION,
    JERK_UNITS,
    NO_YES,
    PROFILES,
    RATE_UNITS,
    REDEFINITIONS,
    SPEED_UNITS,
    STOP_TYPES,
)
from .ideal_axis import BITS, Ideal, IdealAxis, Kind, dynamics_of, settle
from .motion_control import (
    ILLEGAL,
    ILLEGAL_CHANGE,
    OUT_OF_RANGE,
    SERVO_OFF,
    SHUT_DOWN,
    Given,
    MotionControl,
    number_of,
    word_of,
)
from .ramps import Dynamics, shares

LARGEST = 1e15
"""Largest position, distance, speed or rate, units."""

ROTARY_SHORTEST, ROTARY_POSITIVE, ROTARY_NEGATIVE = 2, 3, 4
"""Move types of a rotary axis; 0 is absolute, 1 incremental."""


class MotionCall(NamedTuple):
    """An instruction that begins, with its operands after axis, group or system, and the control."""

    machine: Interpreter
    motion: MotionControl
    name: str
    operands: Sequence[Given]

    @property
    def now_ns(self) -> int:
        """Time of the scan."""
        return self.machine.now_ns

    def number(self, place: int) -> float:
        """Return a numeric operand; 0 for one that is left out."""
        return number_of(self.machine, self.operands[place]) if place < len(self.operands) else 0.0

    def word(self, place: int, words: tuple[str, ...]) -> str:
        """Return a keyword operand."""
        return word_of(self.machine, self.operands[place], words) if place < len(self.operands) else ""

    def yes(self, place: int) -> bool:
        """Whether a keyword operand says Yes."""
        return self.word(place, NO_YES) == "YES"

    def under_way(self) -> None:
        """Show that its motion has begun."""
        self.motion.set(DN=True, IP=True, AC=True)


Maxima = Callable[[str], float]
"""100 % of a maximum by name: Speed, Acceleration, Deceleration."""


def dynamics_at(call: MotionCall, place: int, maximum: Maxima) -> Dynamics | None:
    """Return speed, rates and jerks of ten operands from `place` on; None if one is out of range."""
    speed = _scaled(call.number(place), call.word(place + 1, SPEED_UNITS), maximum("Speed"))
    up, down = (
        _scaled(call.number(place + by), call.word(place + by + 1, RATE_UNITS), maximum(name))
        for by, name in ((2, "Acceleration"), (4, "Deceleration"))
    )
    if speed is None or up is None or down is None:
        return None
    if call.word(place + 6, PROFILES) != "SCURVE":
        return Dynamics(speed, up, down)
    unit = call.word(place + 9, JERK_UNITS)
    up, up_share = _curved(up, call.number(place + 7), unit, speed)
    down, down_share = _curved(down, call.number(place + 8), unit, speed)
    return Dynamics(speed, up, down, up_share, down_share)


def _scaled(value: float, unit: str, maximum: float) -> float | None:
    """Return a speed or rate in units of the axis; None beyond the range, or in units of a master or time."""
    if unit == "%OFMAXIMUM":
        value *= maximum / 100
    elif not unit.startswith("UNITSPERSEC"):
        return None
    return value if 1e-9 <= value <= LARGEST else None


def _curved(rate: float, jerk: float, unit: str, speed: float) -> tuple[float, float]:
    """Return the rate of an S-curve and the share of its ramps; a jerk that is not above 0 makes none."""
    if not 0 < jerk <= LARGEST:
        return rate, 0.0
    if unit == "UNITSPERSEC3":
        return shares(rate, jerk, speed)
    return rate, min(jerk, 100.0) / 200  # % of time; % of maximum is taken for it


def refusal_of(axis: IdealAxis) -> int:
    """Return the error code if the axis accepts no motion now, else 0; a virtual axis needs no servo."""
    if axis.is_on("ShutdownStatus"):
        return SHUT_DOWN
    return 0 if axis.is_on("ServoActionStatus") or axis.part.kind == "AXIS_VIRTUAL" else SERVO_OFF


def _servo_on(axis: IdealAxis, call: MotionCall) -> None:
    if axis.is_on("ShutdownStatus"):
        call.motion.refuse(SHUT_DOWN)
        return
    _switch(axis, on=True)
    call.motion.set(DN=True)


def _switch(axis: IdealAxis, *, on: bool) -> None:
    axis.bits(BITS, ServoActionStatus=on, DriveEnableStatus=on)
    axis.hide(active=True)


def servo_off(axis: IdealAxis, now_ns: int, *, shut_down: bool = False) -> None:
    """Switch an axis off; what is under way ends."""
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


def _move(axis: IdealAxis, call: MotionCall) -> None:
    kind, where = int(call.number(0)), call.number(1)
    dynamics = dynamics_at(call, 2, axis.maximum)
    if dynamics is None or not 0 <= kind <= ROTARY_NEGATIVE or not abs(where) <= LARGEST:
        call.motion.refuse(OUT_OF_RANGE)
        return
    goal = _goal(kind, where, axis.position(call.now_ns), axis.settings.unwind)
    axis.begin(call.now_ns, Kind.MOVE, dynamics, goal, call.motion.claim)
    call.under_way()


def _goal(kind: int, where: float, position: float, unwind: float) -> float:
    """Return the position to which a move of a type goes.

    >>> [_goal(kind, 10.0, 350.0, 360.0) for kind in range(5)]
    [10.0, 360.0, 370.0, 370.0, 10.0]
    """
    if kind == 1:
        return position + where
    if not unwind:
        return where
    turns = position // unwind * unwind
    ahead = (where - position) % unwind
    if kind == ROTARY_POSITIVE or (kind == ROTARY_SHORTEST and ahead <= unwind / 2):
        return position + ahead
    if kind == 0:
        return turns + where
    return position + (ahead - unwind if ahead else 0.0)


def _jog(axis: IdealAxis, call: MotionCall) -> None:
    dynamics = dynamics_at(call, 1, axis.maximum)
    if dynamics is None:
        call.motion.refuse(OUT_OF_RANGE)
        return
    way = -1 if call.word(0, ("Forward", "Reverse")) == "REVERSE" else 1
    axis.begin(call.now_ns, Kind.JOG, dynamics, way * dynamics.speed, call.motion.claim)
    call.under_way()


STOPS = {"JOG": Kind.JOG, "MOVE": Kind.MOVE, "HOME": Kind.HOME}
"""What a stop type of MAS ends; All, and what is not here, ends whatever is under way."""


def _stop(axis: IdealAxis, call: MotionCall) -> None:
    what = call.word(0, STOP_TYPES)
    if what in ("ALL", "GEAR"):
        axis.loosen()
    down = call.number(2)
    if call.yes(1):
        down = _scaled(down, call.word(3, RATE_UNITS), axis.maximum("Deceleration")) or 0.0
        if not down:
            call.motion.refuse(OUT_OF_RANGE)
            return
    stop(axis, call, down if call.yes(1) else axis.maximum("Deceleration"), STOPS.get(what, axis.kind))


def stop(axis: IdealAxis, call: MotionCall, down: float, what: Kind) -> None:
    """Stop a course of a kind; of another one, or none, only the instruction ends."""
    present = dynamics_of(axis)
    dynamics = Dynamics(present.speed or 1.0, down, down, present.down_share, present.down_share)
    if axis.kind is Kind.NOTHING or axis.kind is what:
        axis.begin(call.now_ns, Kind.STOP, dynamics, 0.0, call.motion.claim)
        call.motion.set(DN=True, IP=True)
    else:
        call.motion.set(DN=True, PC=True)


def _home(axis: IdealAxis, call: MotionCall) -> None:
    axis.begin(call.now_ns, Kind.HOME, Dynamics(1.0, 1.0, 1.0), 0.0, call.motion.claim)
    call.under_way()


def _redefine(axis: IdealAxis, call: MotionCall) -> None:
    units = call.number(2)
    if not abs(units) <= LARGEST:
        call.motion.refuse(OUT_OF_RANGE)
        return
    relative = call.word(0, REDEFINITIONS) == "RELATIVE"
    axis.shift(units if relative else units - axis.position(call.now_ns))
    axis.hide(active=True)
    call.motion.set(DN=True)


def _change(axis: IdealAxis, call: MotionCall) -> None:
    """Change speed and rates of a jog or a move; what began it goes on."""
    kind = {"JOG": Kind.JOG, "MOVE": Kind.MOVE}.get(call.word(0, CHANGED_MOTION))
    if kind is None or axis.kind is not kind:
        call.motion.refuse(ILLEGAL_CHANGE)
        return
    now = dynamics_of(axis)
    units = ((1, 11, "Speed", now.speed), (3, 12, "Acceleration", now.up), (5, 13, "Deceleration", now.down))
    changed = [
        _scaled(call.number(at + 1), call.word(unit, SPEED_UNITS), axis.maximum(name))
        if call.yes(at)
        else present
        for at, unit, name, present in units
    ]
    speed, up, down = (each or 0.0 for each in changed)
    dynamics = Dynamics(speed, up, down, now.up_share, now.down_share)
    if not dynamics.allowed:
        call.motion.refuse(OUT_OF_RANGE)
        return
    goal = float(axis["~goal"])
    if kind is Kind.JOG:
        goal = speed if goal > 0 else -speed
    axis.begin(call.now_ns, kind, dynamics, goal, int(axis["~claim"]))
    call.motion.set(DN=True)


def _gear(axis: IdealAxis, call: MotionCall) -> None:
    number, seen = position_of(call.machine, call.operands[0])
    ratio = call.number(2)
    if call.word(6, ("Real", "Fraction")).startswith("FRACTION"):
        ratio = call.number(3) / call.number(4) if call.number(4) else 0.0
    way = call.word(1, ("Same", "Opposite", "Reverse", "Unchanged"))
    before = float(axis["~ratio"])
    if way in ("REVERSE", "UNCHANGED"):
        ratio = abs(ratio) * (-1 if (before < 0) != (way == "REVERSE") else 1)
    elif way == "OPPOSITE":
        ratio = -ratio
    if not number or not abs(ratio) <= LARGEST:
        call.motion.refuse(OUT_OF_RANGE)
        return
    settle(axis.memory, axis.ideal, int(axis["~gear_claim"]), IP=False)
    axis.hide(master=number, ratio=ratio, seen=seen, gear_claim=call.motion.claim, active=True)
    call.motion.set(DN=True, IP=True)


def position_of(machine: Interpreter, operand: Given) -> tuple[int, float]:
    """Return number and position of a master axis; 0 for another operand."""
    if not isinstance(operand, Group) or not is_axis(operand.type):
        return 0, 0.0
    number = machine.whole(machine.get(operand.member("~axis")))
    if number < 0:
        return number, IdealAxis(machine.memory, machine.lowered.ideal, number).position(machine.now_ns)
    return number, float(machine.get(operand.member("~position")))


def _watch(axis: IdealAxis, call: MotionCall) -> None:
    way = -1 if call.word(0, ("Forward", "Reverse")) == "REVERSE" else 1
    settle(axis.memory, axis.ideal, int(axis["~watch_claim"]), IP=False)
    axis.hide(watch=way, watched=call.number(1), watch_claim=call.motion.claim, active=True)
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


ANSWERS: Mapping[str, tuple[Callable[[IdealAxis, MotionCall], None], bool]] = {
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
"""Function that begins each instruction, and whether it needs an axis that accepts motion."""


def _group_stop(axis: IdealAxis, call: MotionCall) -> None:
    axis.loosen()
    if axis.kind is not Kind.NOTHING:
        down = axis.maximum("Deceleration")
        axis.begin(call.now_ns, Kind.STOP, Dynamics(1.0, down, down), 0.0, 0)


def _strobe(axis: IdealAxis, call: MotionCall) -> None:
    position = axis.position(call.now_ns)
    axis.put(StrobeActualPosition=position, StrobeCommandPosition=position)


GROUP_ANSWERS: Mapping[str, Callable[[IdealAxis, MotionCall], None]] = {
    "MGS": _group_stop,
    "MGSD": lambda axis, call: servo_off(axis, call.now_ns, shut_down=True),
    "MGSR": lambda axis, _call: restart(axis),
    "MGSP": _strobe,
}
"""What an instruction of a motion group does to each axis."""


def begin(ideal: Ideal, number: int, call: MotionCall) -> None:
    """Begin an instruction of an ideal axis."""
    if call.name not in ANSWERS:
        call.motion.refuse(ILLEGAL)
        return
    axis = IdealAxis(call.machine.memory, ideal, number)
    answer, moves = ANSWERS[call.name]
    refusal = refusal_of(axis) if moves else 0
    if refusal:
        call.motion.refuse(refusal)
    else:
        answer(axis, call)


def begin_of_group(ideal: Ideal, call: MotionCall) -> None:
    """Begin an instruction of the motion group: it is done at once."""
    for place in range(len(ideal.axes)):
        GROUP_ANSWERS[call.name](IdealAxis(call.machine.memory, ideal, -place - 1), call)
    call.motion.set(DN=True, PC=True)
