"""Coordinated motion of ideal axes [MOTION-RM002, "Multi-axis Coordinated Motion Instructions"].

| instruction | ideal coordinate system |
|---|---|
| MCLM, MCPM | straight to the position with one profile; a second instruction waits or merges |
| MCCM | the same, straight to the end of the circle |
| MCCD, MCS, MCSD, MCSR | change speed and rates; stop; shut down its axes; end the shutdown |
| MCT, MCTO | active until MCS ends it; no axis moves with it |
| MCTP, MCTPO | the given position, unchanged |

Ideal axes that the export names for the system move with it; the system's own positions move in any case.
Other motion of an axis is superimposed, unless All Motion is merged. All termination types end at the
position.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from ...interpreter.files import Elements
from ...model.errors import LadderError
from ...model.operands import Group, Place
from ...model.types import Elementary, Structure
from ...state.memory import Memory
from .calls import MotionCall, Starter, Starters, allowed, dynamics_at, in_range, merge_at, start
from .courses import DYNAMICS, Course, Kind
from .ideal_axis import IdealAxis, all_axes
from .ideal_moves import check_ready, restart, servo_off
from .motion_control import ILLEGAL_CHANGE, OUT_OF_RANGE, QUEUE_FULL, MotionError
from .ramps import Dynamics
from .spots import ENDED, Ideal, MotionSpot, report

SIZE = 6
"""Number of coordinates of a system."""

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


class IdealSystem(MotionSpot):
    """An ideal coordinate system in a scan; its course is the travel along the path."""

    def __init__(self, memory: Memory, ideal: Ideal, number: int) -> None:
        part, numbers = ideal.systems[number - 1]
        super().__init__(memory, part)
        self.ideal = ideal
        # None for an axis on a 3601 and for a coordinate without an axis, which do not move with the system
        self.axes = [
            IdealAxis(memory, ideal, axis_number) if axis_number < 0 else None for axis_number in numbers
        ]
        self.course = Course(self, ideal)

    @property
    def kind(self) -> Kind:
        """The kind of the system's course."""
        return self.course.kind

    def end(self, name: str) -> list[float]:
        """Return an endpoint of the path by name: `from`, `to`, or `next` (where the pending path ends)."""
        return [float(self[f"~{name}{coordinate}"]) for coordinate in range(SIZE)]

    def set_end(self, name: str, values: list[float]) -> None:
        """Set an end of the path."""
        self.set_hidden(**{f"{name}{coordinate}": value for coordinate, value in enumerate(values)})

    def path(self, now_ns: int) -> list[float]:
        """Return the present position on the path; `from` if no path is active."""
        origin, destination = self.end("from"), self.end("to")
        length, instant = math.dist(origin, destination), self.course.instant(now_ns)
        if instant.over and self.kind is Kind.MOVE:
            fraction = 1.0
        else:
            fraction = instant.travel / length if length else 0.0
        return [a + (b - a) * fraction for a, b in zip(origin, destination, strict=True)]

    def positions(self, now_ns: int) -> list[float]:
        """Return the present position of the axes, or of the path for coordinates without an axis."""
        positions = self.path(now_ns)
        for coordinate, axis in enumerate(self.axes):
            if axis is not None:
                positions[coordinate] = axis.position(now_ns)
        return positions

    def begin(
        self,
        now_ns: int,
        goal: list[float],
        dynamics: Dynamics,
        claim: int,
        *,
        entry: float = 0.0,
        merge: bool = False,
    ) -> None:
        """Begin a path at the present position and a given speed; a merge ends other motion of the axes."""
        present = self.positions(now_ns)
        self.set_end("from", present)
        self.set_end("to", goal)
        self.course.begin(now_ns, Kind.MOVE, dynamics, claim, goal=math.dist(present, goal), entry=entry)
        for axis, position in zip(self.axes, present, strict=False):
            if axis is not None:
                axis.begin(now_ns, "whole", Kind.PATH, dynamics, 0, goal=position, merge=merge)

    def begin_from_here(self, now_ns: int, kind: Kind, dynamics: Dynamics, claim: int) -> None:
        """Begin another course on the same path, from the present position and speed."""
        present = self.course.instant(now_ns)
        goal = self.course.goal - present.travel if kind is Kind.MOVE else 0.0
        self.set_end("from", self.path(now_ns))
        self.course.begin(now_ns, kind, dynamics, claim, goal=goal, entry=present.speed)

    def stop_at_once(self, now_ns: int, *, pending: bool = True) -> None:
        """End the path and its following axes at the present position; end the pending path."""
        self.set_end("from", self.positions(now_ns))
        self.course.end()
        for _, axis in self._following_axes():
            axis.courses["whole"].end()
        if pending:
            self.drop_pending()

    def drop_pending(self) -> None:
        """End the pending path."""
        report(self.memory, self.ideal, int(self["~next_claim"]), **ENDED)
        self.set_hidden(waiting=0, next_claim=0)

    def store_pending(self, goal: list[float], dynamics: Dynamics, claim: int) -> None:
        """Store the pending path."""
        self.set_end("next", goal)
        self.set_hidden(waiting=1, next_claim=claim)
        self.set_hidden(**{f"next_{name}": getattr(dynamics, name) for name in DYNAMICS})

    def update(self, now_ns: int) -> None:
        """Move the axes, end the paths that are over, and write the tag."""
        if self.kind is not Kind.NOTHING:
            if any(axis is not None and axis.courses["whole"].kind is not Kind.PATH for axis in self.axes):
                self.stop_at_once(now_ns)
            self.carry(now_ns)
            if self.course.is_over(now_ns, self.course.instant(now_ns)):
                self._end(now_ns)
        self._show(now_ns)

    def _following_axes(self) -> Iterator[tuple[int, IdealAxis]]:
        """Yield the axes that follow the path, with their coordinate numbers."""
        for coordinate, axis in enumerate(self.axes):
            if axis is not None and axis.courses["whole"].kind is Kind.PATH:
                yield coordinate, axis

    def carry(self, now_ns: int) -> None:
        """Move the axes along the path."""
        if self.kind is Kind.NOTHING:
            return
        path, origin, destination = self.path(now_ns), self.end("from"), self.end("to")
        speed = self.course.instant(now_ns).speed / (math.dist(origin, destination) or 1.0)
        for coordinate, axis in self._following_axes():
            axis_speed = speed * (destination[coordinate] - origin[coordinate])
            axis.shift(axis.courses["whole"].follow(path[coordinate], axis_speed))

    def _end(self, now_ns: int) -> None:
        """End the path with PC, and begin any pending path."""
        self.course.report(PC=True)
        self.stop_at_once(now_ns, pending=False)
        if self["~waiting"]:
            dynamics = Dynamics(*(float(self[f"~next_{name}"]) for name in DYNAMICS))
            claim = int(self["~next_claim"])
            self.set_hidden(waiting=0, next_claim=0)
            self.begin(now_ns, self.end("next"), dynamics, claim)
            self.course.report(AC=True)

    def _show(self, now_ns: int) -> None:
        """Write the positions and status bits to the tag."""
        positions, kind, present = self.positions(now_ns), self.kind, self.course.instant(now_ns)
        self.set_array("ActualPosition", positions)
        self.set_array("CommandPosition", positions)
        waiting, transform = bool(self["~waiting"]), bool(self["~transform"])
        self.set_bits(
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


def catch_up(memory: Memory, ideal: Ideal, now_ns: int) -> None:
    """Move axes that follow a path or a gear's master, before an instruction uses their positions."""
    for number in range(1, len(ideal.systems) + 1):
        IdealSystem(memory, ideal, number).carry(now_ns)
    for axis in all_axes(memory, ideal):
        axis.catch_up(now_ns, {})


# --- operands


def _numbers(call: MotionCall, index: int) -> list[float]:
    """Return the elements of an array operand, at most as many as a system has coordinates."""
    operand = call.operands[index] if index < len(call.operands) else 0.0
    if not isinstance(operand, (Group, Place)):
        return []
    elements = Elements(call.machine, operand)
    return [float(elements[number]) for number in range(min(len(elements), SIZE))]


def _member(call: MotionCall, index: int, name: str, default: float = 0.0) -> float:
    """Return a number from a structure operand; the default if it has no member of that name."""
    operand = call.operands[index]
    member = operand.find_member(name) if isinstance(operand, Group) else None
    return default if member is None else float(call.machine.get(member))


def _destination(start: list[float], operand: list[float], *, relative: bool) -> list[float]:
    """Return the target position, or raise a MotionError. Omitted coordinates keep their values."""
    goal = list(start)
    for coordinate, number in enumerate(operand):
        goal[coordinate] = start[coordinate] + number if relative else number
    return list(map(in_range, goal))


MERGES = ("Disabled", "Coordinated Motion", "All Motion")
"""Merge keywords: a new path ends no motion, other paths of its system, or all motion of its axes [p.
449]."""


def _begin_or_store(
    system: IdealSystem,
    call: MotionCall,
    operand: list[float],
    dynamics: Dynamics,
    *,
    relative: bool,
    merge: str = "DISABLED",
) -> None:
    """Begin a path, or store it until the present path ends."""
    now_ns, claim = call.now_ns, call.motion.claim
    begins = system.kind is Kind.NOTHING or merge != "DISABLED"
    last_goal = "next" if system["~waiting"] else "to"
    origin = system.positions(now_ns) if begins else system.end(last_goal)
    goal = _destination(origin, operand, relative=relative)
    if begins:
        entry = system.course.instant(now_ns).speed
        system.stop_at_once(now_ns)
        system.begin(now_ns, goal, dynamics, claim, entry=entry, merge=merge == "ALLMOTION")
        call.show_begun()
    elif system["~waiting"]:
        raise MotionError(QUEUE_FULL)
    else:
        system.store_pending(goal, dynamics, claim)
        call.motion.set(IP=True)


# --- instructions


def _line(system: IdealSystem, call: MotionCall, dynamics_index: int = 2) -> None:
    """Begin MCLM or MCCM; `dynamics_index` is the index of the speed operand."""
    speed = system.course.instant(call.now_ns).speed
    merge, current = merge_at(call, dynamics_index + 11, MERGES, speed)
    dynamics = dynamics_at(call, dynamics_index, RATES.__getitem__, current)
    relative = call.number(0) == 1
    _begin_or_store(system, call, _numbers(call, 1), dynamics, relative=relative, merge=merge or "DISABLED")


def _path(system: IdealSystem, call: MotionCall) -> None:
    """Begin MCPM: PATH_DATA has the position and the move type, DYNAMICS_DATA speed and rates."""
    path = call.operands[0]
    coordinates: list[float] = []
    if isinstance(path, Group) and isinstance(path.type, Structure):
        member = path.type.member("Position")
        if member is not None and member.dims and isinstance(member.type, Elementary):
            array = replace(path, type=member.type, path=f"{path.path}.{member.name}", dims=member.dims)
            coordinates = _numbers(call._replace(operands=[array]), 0)
    rates = (in_range(_member(call, 2, name, most)) for name, most in RATES.items())
    relative = _member(call, 0, "MoveType") == 1
    _begin_or_store(system, call, coordinates, allowed(Dynamics(*rates)), relative=relative)


def _stop(system: IdealSystem, call: MotionCall) -> None:
    """Run MCS: end the transform if its motion type includes it, and bring the path to rest.

    PC is immediate if no path is active.
    """
    motion_type = call.keyword(0, ("All", "Coordinated Move", "Coordinated Transform"))
    if motion_type in ("ALL", "COORDINATEDTRANSFORM", "COORDINATEDMOTION"):
        report(system.memory, system.ideal, int(system["~transform"]), IP=False)
        system.set_hidden(transform=0)
    if motion_type == "COORDINATEDTRANSFORM" or system.kind is Kind.NOTHING:
        call.motion.set(PC=True)
        return
    present = system.course.dynamics
    down = call.number(2) if call.says_yes(1) else present.down
    dynamics = allowed(Dynamics(present.speed, down, down, present.down_share, present.down_share))
    system.course.report(**ENDED)
    system.drop_pending()
    system.begin_from_here(call.now_ns, Kind.STOP, dynamics, call.motion.claim)
    call.motion.set(IP=True)


def _change(system: IdealSystem, call: MotionCall) -> None:
    """Run MCCD: continue the path with the changed speed and rates. Values without a Yes do not change."""
    if system.kind is not Kind.MOVE:
        raise MotionError(ILLEGAL_CHANGE)
    dynamics = system.course.dynamics
    speed, up, down = (
        call.number(index + 1) if call.says_yes(index) else unchanged
        for index, unchanged in ((1, dynamics.speed), (4, dynamics.up), (7, dynamics.down))
    )
    changed = allowed(Dynamics(speed, up, down, dynamics.up_share, dynamics.down_share))
    system.begin_from_here(call.now_ns, Kind.MOVE, changed, system.course.claim)


def _shut(system: IdealSystem, call: MotionCall) -> None:
    system.stop_at_once(call.now_ns)
    for axis in _axes_of(system):
        servo_off(axis, call.now_ns, shut_down=True)
    system.set_bits(BITS, ShutdownStatus=True)


def _restart(system: IdealSystem, _call: MotionCall) -> None:
    for axis in _axes_of(system):
        restart(axis)
    system.set_bits(BITS, ShutdownStatus=False)


def _transform(system: IdealSystem, call: MotionCall) -> None:
    """Run MCT or MCTO: show it as active in place of the previous transform."""
    report(system.memory, system.ideal, int(system["~transform"]), IP=False)
    system.set_hidden(transform=call.motion.claim)
    call.motion.set(IP=True)


def _calculate(_system: IdealSystem, call: MotionCall) -> None:
    """Copy the reference position to the transform position."""
    try:
        source, target = (Elements(call.machine, call.operands[index]) for index in (4, 5))  # type: ignore[arg-type]
    except (LadderError, IndexError):
        raise MotionError(OUT_OF_RANGE) from None
    for index in range(min(len(source), len(target), SIZE)):
        target[index] = source[index]
    call.motion.set(PC=True)


def _axes_of(system: IdealSystem) -> list[IdealAxis]:
    return [axis for axis in system.axes if axis is not None]


STARTERS: Starters = {
    "MCLM": Starter(_line, moves=True),
    "MCCM": Starter(lambda system, call: _line(system, call, 5), moves=True),
    "MCPM": Starter(_path, moves=True),
    "MCCD": Starter(_change, moves=True),
    "MCS": Starter(_stop),
    "MCSD": Starter(_shut),
    "MCSR": Starter(_restart),
    "MCT": Starter(_transform, moves=True),
    "MCTO": Starter(_transform, moves=True),
    "MCTP": Starter(_calculate),
    "MCTPO": Starter(_calculate),
}


def begin(ideal: Ideal, number: int, call: MotionCall) -> None:
    """Begin an instruction on an ideal coordinate system, or raise a MotionError."""
    system = IdealSystem(call.machine.memory, ideal, number)
    start(STARTERS, system, call, _check_ready)
    call.motion.set(DN=True)


def _check_ready(system: IdealSystem) -> None:
    for axis in _axes_of(system):
        check_ready(axis)
