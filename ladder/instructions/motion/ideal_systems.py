"""Coordinated motion of ideal axes [MOTION-RM002, "Multi-axis Coordinated Motion Instructions"].

| instruction | ideal coordinate system |
|---|---|
| MCLM, MCPM | straight to the position, along one profile; a second one waits until the first is over |
| MCCM | the same, straight to the end of the circle |
| MCCD, MCS, MCSD, MCSR | speed and rates; stop; shutdown of its axes and its end |
| MCT, MCTO | active until MCS ends it; no axis moves with it |
| MCTP, MCTPO | the position as it was given |

Axes that the export names for the system move with it, if they are ideal; the system's own positions move in
any case. All terminations are those at the position.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from ...interpreter.files import Elements
from ...model.errors import LadderError
from ...model.operands import Group, Place
from ...model.types import Elementary, Structure
from ...state.memory import Memory
from .ideal_axis import Ideal, IdealAxis, Kind, MotionSpot, dynamics_of, settle
from .ideal_moves import LARGEST, MotionCall, dynamics_at, refusal_of, restart, servo_off
from .motion_control import ILLEGAL, ILLEGAL_CHANGE, OUT_OF_RANGE, QUEUE_FULL
from .ramps import Dynamics, Instant, Phases, at, move, ramp

SIZE = 6
"""Coordinates of a system."""

RATES = {"Speed": 100.0, "Acceleration": 1000.0, "Deceleration": 1000.0}
"""100 % of the maxima of a system, units/s and units/s²."""

BITS = {
    "ShutdownStatus": "CoordinateSystemStatus.1",
    "MotionStatus": "CoordinateSystemStatus.3",
    "AccelStatus": "CoordinateMotionStatus.0",
    "DecelStatus": "CoordinateMotionStatus.1",
    "StoppingStatus": "CoordinateMotionStatus.4",
    "MoveStatus": "CoordinateMotionStatus.6",
    "MovePendingStatus": "CoordinateMotionStatus.8",
    "MovePendingQueueFullStatus": "CoordinateMotionStatus.9",
    "TransformSourceStatus": "CoordinateMotionStatus.10",
    "TransformTargetStatus": "CoordinateMotionStatus.11",
}

_DYNAMICS = ("speed", "up", "down", "up_share", "down_share")


class IdealSystem(MotionSpot):
    """An ideal coordinate system in a scan; its course is the length of the path."""

    def __init__(self, memory: Memory, ideal: Ideal, number: int) -> None:
        part, numbers = ideal.systems[number - 1]
        super().__init__(memory, part)
        self.ideal = ideal
        self.axes = [IdealAxis(memory, ideal, each) if each < 0 else None for each in numbers]

    @property
    def kind(self) -> Kind:
        """What it does."""
        return Kind(int(self["~kind"]))

    def end(self, name: str) -> list[float]:
        """Return an end of the path: `from`, `to`, or `next` of the pending one."""
        return [float(self[f"~{name}{place}"]) for place in range(SIZE)]

    def set_end(self, name: str, values: list[float]) -> None:
        """Set an end of the path."""
        self.hide(**{f"{name}{place}": value for place, value in enumerate(values)})

    @property
    def length(self) -> float:
        """Length of its path."""
        return math.dist(self.end("from"), self.end("to"))

    def phases(self) -> Phases:
        """Return the phases of its course."""
        entry = float(self["~entry"])
        if self.kind is Kind.MOVE:
            return move(self.length, entry, dynamics_of(self))
        return ramp(entry, 0.0, dynamics_of(self)) if self.kind is Kind.STOP else ()

    def instant(self, now_ns: int) -> Instant:
        """Return where it is on its path."""
        return at(self.phases(), (now_ns - int(self["~begun_ns"])) / 1e9)

    def positions(self, now_ns: int) -> list[float]:
        """Return its present position: that of its axes, where it has any."""
        own = self.end("from")
        if self.kind is Kind.NOTHING:
            there = [None if each is None else each.position(now_ns) for each in self.axes]
            return [*(a if b is None else b for a, b in zip(own, there, strict=False)), *own[len(there) :]]
        length, present = self.length, self.instant(now_ns)
        part = 1.0 if present.over and self.kind is Kind.MOVE else present.travel / length if length else 0.0
        return [a + (b - a) * part for a, b in zip(own, self.end("to"), strict=True)]

    def begin(self, now_ns: int, goal: list[float], dynamics: Dynamics, claim: int) -> None:
        """Begin a path from the present position."""
        self.set_end("from", self.positions(now_ns))
        self.set_end("to", goal)
        self.course(now_ns, Kind.MOVE, dynamics, 0.0, claim)
        for axis in self.axes:
            if axis is not None:
                axis.begin(now_ns, Kind.PATH, dynamics, 0.0, 0)

    def course(self, now_ns: int, kind: Kind, dynamics: Dynamics, entry: float, claim: int) -> None:
        """Note what is under way from now on."""
        self.hide(kind=kind, begun_ns=now_ns, entry=entry, claim=claim)
        self.hide(**{name: getattr(dynamics, name) for name in _DYNAMICS})

    def again(self, now_ns: int, kind: Kind, dynamics: Dynamics, claim: int) -> None:
        """Go on from the present place and speed in another way."""
        present = self.instant(now_ns)
        self.set_end("from", self.positions(now_ns))
        self.course(now_ns, kind, dynamics, present.speed, claim)

    def rest(self, now_ns: int, *, all_of_it: bool = True) -> None:
        """End the path where it is, and the pending one."""
        self.set_end("from", self.positions(now_ns))
        for name in ("claim", *(["next_claim"] if all_of_it else [])):
            settle(self.memory, self.ideal, int(self[f"~{name}"]), IP=False, AC=False)
            self.hide(**{name: 0})
        self.hide(kind=Kind.NOTHING)
        if all_of_it:
            self.hide(waiting=0)

    def wait(self, goal: list[float], dynamics: Dynamics, claim: int) -> None:
        """Note the pending path."""
        self.set_end("next", goal)
        self.hide(waiting=1, next_claim=claim)
        self.hide(**{f"next_{name}": getattr(dynamics, name) for name in _DYNAMICS})

    def update(self, now_ns: int) -> None:
        """Move the axes, end what is over, and write the tag."""
        if self.kind is not Kind.NOTHING:
            if any(axis is not None and axis.kind is not Kind.PATH for axis in self.axes):
                self.rest(now_ns)
            self._carry(self.positions(now_ns))
            if self.instant(now_ns).over and now_ns > int(self["~begun_ns"]):
                self._end(now_ns)
        self._show(now_ns)

    def _carry(self, positions: list[float]) -> None:
        for axis, position in zip(self.axes, positions, strict=False):
            if axis is not None and axis.kind is Kind.PATH:
                axis.hide(start=position)

    def _end(self, now_ns: int) -> None:
        settle(self.memory, self.ideal, int(self["~claim"]), IP=False, AC=False, PC=True)
        self.hide(claim=0)
        self.rest(now_ns, all_of_it=False)
        for axis in self.axes:
            if axis is not None and axis.kind is Kind.PATH:
                axis.hide(kind=Kind.NOTHING)
        if self["~waiting"]:
            dynamics = Dynamics(*(float(self[f"~next_{name}"]) for name in _DYNAMICS))
            claim = int(self["~next_claim"])
            self.hide(waiting=0, next_claim=0)
            self.begin(now_ns, self.end("next"), dynamics, claim)

    def _show(self, now_ns: int) -> None:
        positions, kind, present = self.positions(now_ns), self.kind, self.instant(now_ns)
        self.row("ActualPosition", positions)
        self.row("CommandPosition", positions)
        waiting, transform = bool(self["~waiting"]), bool(self["~transform"])
        self.bits(
            BITS,
            MotionStatus=kind is not Kind.NOTHING,
            MoveStatus=kind is Kind.MOVE,
            StoppingStatus=kind is Kind.STOP,
            AccelStatus=present.change > 0,
            DecelStatus=present.change < 0,
            MovePendingStatus=waiting,
            MovePendingQueueFullStatus=waiting,
            TransformSourceStatus=transform,
        )


def update_systems(memory: Memory, ideal: Ideal, now_ns: int) -> None:
    """Update all ideal coordinate systems after a scan."""
    for number in range(1, len(ideal.systems) + 1):
        system = IdealSystem(memory, ideal, number)
        if system["~kind"] or system["~transform"] or system["CoordinateMotionStatus"]:
            system.update(now_ns)


# --- operands


def _numbers(call: MotionCall, place: int) -> list[float]:
    """Return the elements of an array operand, as many as a system has at most."""
    operand = call.operands[place] if place < len(call.operands) else 0.0
    if not isinstance(operand, (Group, Place)):
        return []
    elements = Elements(call.machine, operand)
    return [float(elements[each]) for each in range(min(len(elements), SIZE))]


def _member(call: MotionCall, place: int, name: str, default: float = 0.0) -> float:
    """Return a number in a structure operand, the default if it has no such member."""
    operand = call.operands[place]
    if isinstance(operand, Group) and isinstance(operand.type, Structure):
        member = operand.type.member(name)
        if member is not None and not member.at and not member.dims and isinstance(member.type, Elementary):
            return float(call.machine.get(operand.member(name)))
    return default


def _goal(system: IdealSystem, call: MotionCall, given: list[float], *, relative: bool) -> list[float] | None:
    """Return the position to go to; None if one is out of range. What is not given stays."""
    here = system.end("next") if system["~waiting"] else system.end("to")
    if system.kind is Kind.NOTHING:
        here = system.positions(call.now_ns)
    goal = [
        there + number if relative else number
        for there, number in zip(here, [*given, *([0.0] * SIZE)], strict=False)
    ]
    if not relative:
        goal[len(given) :] = here[len(given) :]
    return goal if all(abs(each) <= LARGEST for each in goal) else None


def _go(system: IdealSystem, call: MotionCall, goal: list[float] | None, dynamics: Dynamics | None) -> None:
    if goal is None or dynamics is None:
        call.motion.refuse(OUT_OF_RANGE)
    elif system.kind is Kind.NOTHING:
        system.begin(call.now_ns, goal, dynamics, call.motion.claim)
        call.under_way()
    elif system["~waiting"]:
        call.motion.refuse(QUEUE_FULL)
    else:
        system.wait(goal, dynamics, call.motion.claim)
        call.motion.set(DN=True, IP=True)


# --- instructions


def _line(system: IdealSystem, call: MotionCall) -> None:
    goal = _goal(system, call, _numbers(call, 1), relative=call.number(0) == 1)
    _go(system, call, goal, dynamics_at(call, 2, RATES.__getitem__))


def _circle(system: IdealSystem, call: MotionCall) -> None:
    goal = _goal(system, call, _numbers(call, 1), relative=call.number(0) == 1)
    _go(system, call, goal, dynamics_at(call, 5, RATES.__getitem__))


def _path(system: IdealSystem, call: MotionCall) -> None:
    """MCPM: PATH_DATA has the position and the move type, DYNAMICS_DATA speed and rates."""
    path = call.operands[0]
    given: list[float] = []
    if isinstance(path, Group) and isinstance(path.type, Structure):
        member = path.type.member("Position")
        if member is not None and member.dims and isinstance(member.type, Elementary):
            array = replace(path, type=member.type, path=f"{path.path}.{member.name}", dims=member.dims)
            given = _numbers(call._replace(operands=[array]), 0)
    speed, up, down = (_member(call, 2, name, most) for name, most in RATES.items())
    dynamics = Dynamics(speed, up, down)
    goal = _goal(system, call, given, relative=_member(call, 0, "MoveType") == 1)
    _go(system, call, goal, dynamics if dynamics.allowed and max(speed, up, down) <= LARGEST else None)


def _stop(system: IdealSystem, call: MotionCall) -> None:
    what = call.word(0, ("All", "Coordinated Move", "Coordinated Transform"))
    if what in ("ALL", "COORDINATEDTRANSFORM", "COORDINATEDMOTION"):
        settle(system.memory, system.ideal, int(system["~transform"]), IP=False)
        system.hide(transform=0)
    if what == "COORDINATEDTRANSFORM" or system.kind is Kind.NOTHING:
        call.motion.set(DN=True, PC=True)
        return
    now = dynamics_of(system)
    down = call.number(2) if call.yes(1) else now.down
    dynamics = Dynamics(now.speed, down, down, now.down_share, now.down_share)
    if not dynamics.allowed:
        call.motion.refuse(OUT_OF_RANGE)
        return
    settle(system.memory, system.ideal, int(system["~next_claim"]), IP=False, AC=False)
    settle(system.memory, system.ideal, int(system["~claim"]), IP=False, AC=False)
    system.hide(waiting=0, next_claim=0)
    system.again(call.now_ns, Kind.STOP, dynamics, call.motion.claim)
    call.motion.set(DN=True, IP=True)


def _change(system: IdealSystem, call: MotionCall) -> None:
    if system.kind is not Kind.MOVE:
        call.motion.refuse(ILLEGAL_CHANGE)
        return
    now = dynamics_of(system)
    speed, up, down = (
        call.number(place + 1) if call.yes(place) else present
        for place, present in ((1, now.speed), (4, now.up), (7, now.down))
    )
    dynamics = Dynamics(speed, up, down, now.up_share, now.down_share)
    if not dynamics.allowed:
        call.motion.refuse(OUT_OF_RANGE)
        return
    system.again(call.now_ns, Kind.MOVE, dynamics, int(system["~claim"]))
    call.motion.set(DN=True)


def _shut(system: IdealSystem, call: MotionCall) -> None:
    system.rest(call.now_ns)
    for axis in _own(system):
        servo_off(axis, call.now_ns, shut_down=True)
    system.bits(BITS, ShutdownStatus=True)
    call.motion.set(DN=True)


def _restart(system: IdealSystem, call: MotionCall) -> None:
    for axis in _own(system):
        restart(axis)
    system.bits(BITS, ShutdownStatus=False)
    call.motion.set(DN=True)


def _transform(system: IdealSystem, call: MotionCall) -> None:
    settle(system.memory, system.ideal, int(system["~transform"]), IP=False)
    system.hide(transform=call.motion.claim)
    call.motion.set(DN=True, IP=True)


def _calculate(_system: IdealSystem, call: MotionCall) -> None:
    """Copy the reference position to the transform position."""
    try:
        source, target = (Elements(call.machine, call.operands[place]) for place in (4, 5))  # type: ignore[arg-type]
    except (LadderError, IndexError):
        call.motion.refuse(OUT_OF_RANGE)
        return
    for place in range(min(len(source), len(target), SIZE)):
        target[place] = source[place]
    call.motion.set(DN=True, PC=True)


def _own(system: IdealSystem) -> Iterator[IdealAxis]:
    return (each for each in system.axes if each is not None)


ANSWERS: Mapping[str, tuple[Callable[[IdealSystem, MotionCall], None], bool]] = {
    "MCLM": (_line, True),
    "MCCM": (_circle, True),
    "MCPM": (_path, True),
    "MCCD": (_change, True),
    "MCS": (_stop, False),
    "MCSD": (_shut, False),
    "MCSR": (_restart, False),
    "MCT": (_transform, True),
    "MCTO": (_transform, True),
    "MCTP": (_calculate, False),
    "MCTPO": (_calculate, False),
}
"""Function that begins each instruction, and whether it needs axes that accept motion."""


def begin(ideal: Ideal, number: int, call: MotionCall) -> None:
    """Begin an instruction of an ideal coordinate system."""
    if call.name not in ANSWERS:
        call.motion.refuse(ILLEGAL)
        return
    system = IdealSystem(call.machine.memory, ideal, number)
    answer, moves = ANSWERS[call.name]
    refusals = (refusal_of(each) for each in _own(system)) if moves else ()
    refusal = next(filter(None, refusals), 0)
    if refusal:
        call.motion.refuse(refusal)
    else:
        answer(system, call)
