"""An ideal axis: a servo that follows its profile exactly. An axis without a 3601 is an ideal axis.

Its motion is the sum of the simultaneous motions of its planners [MOTION-RM002H p. 124, 129]:

    planner   begun by          shown as                    MAS that ends it alone
    move      MAM, MAH          MoveStatus, HomingStatus    Move, Home
    jog       MAJ               JogStatus                   Jog
    gear      MAG               GearingStatus               Gear
    whole     MCLM, MAS of All  CoordinatedMotionStatus     none

    position = start + travel of each course (`courses`); a course that follows shifts `start`

`target` is the value of `start` after a move, so that the move ends exactly there.

A planner executes one course; a new course continues from its speed. A merge ends all courses and continues
from their sum. After each scan, `update` writes the tag's members and the bits of the instructions whose
motion has ended, whether their rungs are scanned or not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...model.predefined.motion_types import AXIS_MEMBERS, PLANNERS
from ...state.memory import Memory
from .courses import FOLLOWING, Course, Kind
from .ramps import REST, Dynamics, Instant, total
from .spots import Ideal, MotionSpot, settle

BITS = {member.name: member.at for member in AXIS_MEMBERS if member.at}
"""Member and bit number of each named bit of an axis."""

DEFAULT_SPEED, DEFAULT_RATE = 100.0, 1000.0
"""100 % of maximum, in units/s and units/s², if neither the tag nor the rack file has one."""

STOPPED, RUNNING, SHUT = 2, 4, 10
"""CIPAxisState [MOTION-RM003, "CIP Axis State"]."""

STATUS = {
    Kind.MOVE: "MoveStatus",
    Kind.JOG: "JogStatus",
    Kind.HOME: "HomingStatus",
    Kind.STOP: "StoppingStatus",
    Kind.PATH: "CoordinatedMotionStatus",
    Kind.GEAR: "GearingStatus",
}
"""The status bit of each kind of course."""

PLANNER_OF = {
    "MoveStatus": "move",
    "HomingStatus": "move",
    "JogStatus": "jog",
    "GearingStatus": "gear",
    "GearingLockStatus": "gear",
    "CoordinatedMotionStatus": "whole",
}
"""The planner that a status bit shows; other status bits show several planners."""

Masters = Mapping[int, tuple[float, float]]
"""Positions and speeds of the axes on 3601s, by number, for the gears that follow them."""


ROUNDING = 1e-9
"""Distance that counts as 0 on a rotary axis, as a fraction of a turn."""


def ahead(way: float, unwind: float) -> float:
    """Return a distance as a forward distance on a rotary axis, 0 to below `unwind`; a rounding error is 0.

    >>> ahead(-10.0, 360.0), ahead(-1e-12, 360.0)
    (350.0, 0.0)
    """
    forward = way % unwind
    return 0.0 if min(forward, unwind - forward) <= ROUNDING * unwind else forward


class IdealAxis(MotionSpot):
    """An ideal axis in a scan."""

    def __init__(self, memory: Memory, ideal: Ideal, number: int) -> None:
        part, self.settings = ideal.axes[-number - 1]
        super().__init__(memory, part)
        self.ideal, self.number = ideal, number
        self.courses = {planner: Course(self, ideal, planner) for planner in PLANNERS}

    def is_on(self, bit: str) -> bool:
        """Return a bit of the tag."""
        word, _, number = BITS[bit].partition(".")
        return bool(int(self[word]) >> int(number) & 1)

    def maximum(self, name: str) -> float:
        """Return 100 % of a maximum: Speed, Acceleration or Deceleration."""
        limit = self.settings.max_speed if name == "Speed" else self.settings.max_acceleration
        default = DEFAULT_SPEED if name == "Speed" else DEFAULT_RATE
        return limit or float(self[f"Maximum{name}"]) or default

    # --- courses under way

    def instant(self, now_ns: int) -> Instant:
        """Return the motion of the axis, which is the sum of all courses."""
        return total(course.instant(now_ns) for course in self.courses.values())

    def position(self, now_ns: int) -> float:
        """Return the position in units; the position of a master is as of the last `catch_up`."""
        return float(self["~start"]) + self.instant(now_ns).travel

    def begin(
        self,
        now_ns: int,
        planner: str,
        kind: Kind,
        dynamics: Dynamics,
        claim: int,
        *,
        goal: float = 0.0,
        merge: bool = False,
    ) -> None:
        """Begin a course of a planner at its present speed; its previous course ends.

        Args:
            claim: the claim of its instruction, see `MotionControl.claim`.
            goal: see `Course`.
            merge: end all courses, and continue from the speed of the axis.
        """
        course = self.courses[planner]
        entry = (self.instant(now_ns) if merge else course.instant(now_ns)).speed
        for running in self.courses.values() if merge else (course,):
            self._fold(running, now_ns)
            if running.claim != claim:
                running.end()
            running.hide(kind=Kind.NOTHING)
        if kind in FOLLOWING:
            entry = 0.0
        course.begin(now_ns, kind, dynamics, claim, goal=goal, entry=entry)
        self.hide(active=True)
        if kind is not Kind.STOP:
            start = self.position(now_ns)
            self.put(StartActualPosition=start, StartCommandPosition=start)

    def _fold(self, course: Course, now_ns: int) -> None:
        """Add the travel of an ending course to the start; a move's travel does not shift its target."""
        self.shift(course.instant(now_ns).travel, target=course.planner != "move")

    def rest(self, now_ns: int, error: int = 0) -> None:
        """End all courses at once, at the present position."""
        self.hide(start=self.position(now_ns), active=True)
        for course in self.courses.values():
            course.end(error, **({"ER": True} if error else {}))

    def shift(self, way: float, *, target: bool = True) -> None:
        """Shift the position, and the end of a move: for a new reference, or as the axis follows a master."""
        self.hide(start=float(self["~start"]) + way)
        if target:
            self.hide(target=float(self["~target"]) + way)

    def redefine(self, way: float) -> None:
        """Shift the reference of the axis; gears that follow it do not move."""
        self.shift(way)
        self.hide(position=float(self["~position"]) + way)
        for place in range(1, len(self.ideal.axes) + 1):
            slave = IdealAxis(self.memory, self.ideal, -place)
            gear = slave.courses["gear"]
            if gear.kind is Kind.GEAR and slave["~master"] == self.number:
                gear.hide(goal=gear.goal + way)

    # --- after a scan

    def catch_up(self, now_ns: int, masters: Masters, passed: tuple[int, ...] = ()) -> None:
        """Follow the master of a gear until now; the master first follows its own master.

        Args:
            masters: axes on 3601s.
            passed: axes that wait for this one; they end a circular chain.
        """
        gear, number = self.courses["gear"], int(self["~master"])
        if gear.kind is not Kind.GEAR or number in passed:
            return
        if number < 0:
            master = IdealAxis(self.memory, self.ideal, number)
            master.catch_up(now_ns, masters, (*passed, self.number))
            masters = {number: (master.position(now_ns), master.instant(now_ns).speed)}
        if number in masters:
            self.shift(gear.follow(*masters[number], float(self["~ratio"])))

    def update(self, now_ns: int) -> None:
        """End the courses that are over, and write the tag."""
        moving: list[tuple[Course, Instant]] = []
        for course in self.courses.values():
            if course.kind is not Kind.NOTHING:
                present = course.instant(now_ns)
                if course.is_over(now_ns, present):
                    self._end(course, present)
                else:
                    moving.append((course, present))
        self._show(moving)

    def _end(self, course: Course, present: Instant) -> None:
        if course.kind is Kind.HOME:
            self.redefine(float(self["HomePosition"]) - float(self["~start"]))
            self.bits(BITS, AxisHomedStatus=True)
        elif course.kind is Kind.MOVE:
            self.hide(start=float(self["~target"]))
        else:
            self.shift(present.travel, target=course.planner != "move")
        course.end(PC=True)

    def _watch(self, position: float) -> None:
        """End MAW when the axis reaches its position."""
        direction, watched, before = int(self["~watch"]), float(self["~watched"]), float(self["~position"])
        left, travel, unwind = (
            (watched - before) * direction,
            (position - before) * direction,
            self.settings.unwind,
        )
        if unwind:  # `travel` may be short by a rounding error if a move ends there
            left, travel = ahead(left, unwind), travel + ROUNDING * unwind
        if direction and 0 < left <= travel:
            settle(self.memory, self.ideal, int(self["~watch_claim"]), IP=False, PC=True)
            self.hide(watch=0, watch_claim=0)
            self.bits(BITS, WatchEventArmedStatus=False, WatchEventStatus=True)

    def _show(self, moving: Sequence[tuple[Course, Instant]]) -> None:
        present = total((REST, *(instant for _, instant in moving)))
        position, unwind = float(self["~start"]) + present.travel, self.settings.unwind
        self._watch(position)
        shown = position % unwind if unwind else position
        self.put(
            **dict.fromkeys(("ActualPosition", "CommandPosition"), shown),
            **dict.fromkeys(("ActualVelocity", "CommandVelocity", "AverageVelocity"), present.speed),
        )
        on, shut = self.is_on("ServoActionStatus"), self.is_on("ShutdownStatus")
        for course, motion in moving:
            course.settle(ACCEL=motion.change > 0, DECEL=motion.change < 0)
        kinds = {course.kind for course, _ in moving}
        self.bits(
            BITS,
            **{bit: kind in kinds for kind, bit in STATUS.items()},
            GearingLockStatus=Kind.GEAR in kinds,
            AccelStatus=present.change > 0,
            DecelStatus=present.change < 0,
            VelocityStandstillStatus=present.speed == 0,
            InPositionStatus=kinds <= {Kind.GEAR},
            PowerStructureEnabledStatus=on,
        )
        self.put(CIPAxisState=SHUT if shut else RUNNING if on else STOPPED)
        self.hide(position=position, active=bool(kinds or self["~watch"]))


def update_axes(memory: Memory, ideal: Ideal, now_ns: int, masters: Masters) -> None:
    """Update all ideal axes after a scan; gears first, so that a chain of them has no lag."""
    axes = [IdealAxis(memory, ideal, -place) for place in range(1, len(ideal.axes) + 1)]
    active = [candidate for candidate in axes if candidate["~active"]]
    for axis in active:
        axis.catch_up(now_ns, masters)
    for axis in active:
        axis.update(now_ns)
