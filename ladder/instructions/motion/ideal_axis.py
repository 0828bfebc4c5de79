"""An ideal axis: a servo that follows its profile exactly. An axis without a 3601 is ideal.

Its motion is the sum of the simultaneous motions of its planners [MOTION-RM002H p. 124, 129]:

    planner   begun by          shown as                    MAS that ends it alone
    move      MAM, MAH          MoveStatus, HomingStatus    Move, Home
    jog       MAJ               JogStatus                   Jog
    gear      MAG               GearingStatus               Gear
    whole     MCLM, MAS of All  CoordinatedMotionStatus     none

    position = start + travel of each course (`courses`); a course that follows shifts `start`

`target` is the value of `start` after a move, so that the move ends exactly there.

A planner executes one course; a new course continues from its speed. A merge ends all courses and continues
from their sum. After each scan, `update` writes the tag's members, and the bits of instructions that have
ended. It does so whether their rungs are scanned or not.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...model.predefined.motion_types import AXIS_MEMBERS, PLANNERS
from ...state.memory import Memory
from .courses import FOLLOWING, Course, Kind
from .ramps import REST, Dynamics, Instant, total
from .spots import Ideal, MotionSpot, report

BITS = {member.name: member.at for member in AXIS_MEMBERS if member.at}
"""Word and bit number of each named bit of an axis, such as `MotionStatus.1`."""

DEFAULT_SPEED, DEFAULT_RATE = 100.0, 1000.0
"""100 % of maximum, in units/s and units/s², if neither the tag nor the rack file specifies it."""

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
"""The planner that a status bit shows; other status bits show all planners."""

Masters = Mapping[int, tuple[float, float]]
"""Position and speed of each axis on a 3601, by number, for the gears that follow it."""

ROUNDING = 1e-9
"""Distance that counts as 0 on a rotary axis, as a fraction of a turn."""


def forward_distance(distance: float, unwind: float) -> float:
    """Return a distance as a forward distance on a rotary axis, at least 0 and less than `unwind`.

    A difference that is only a rounding error counts as 0.

    >>> forward_distance(-10.0, 360.0), forward_distance(-1e-12, 360.0)
    (350.0, 0.0)
    """
    forward = distance % unwind
    return 0.0 if min(forward, unwind - forward) <= ROUNDING * unwind else forward


class IdealAxis(MotionSpot):
    """An ideal axis in a scan."""

    def __init__(self, memory: Memory, ideal: Ideal, number: int) -> None:
        part, self.settings = ideal.axes[-number - 1]  # numbers are -1, -2, ...
        super().__init__(memory, part)
        self.ideal, self.number = ideal, number
        self.courses = {planner: Course(self, ideal, planner) for planner in PLANNERS}

    def is_on(self, bit: str) -> bool:
        """Return a bit of the tag."""
        word, _, number = BITS[bit].partition(".")
        return bool(int(self[word]) >> int(number) & 1)

    def maximum(self, name: str) -> float:
        """Return the maximum (100 %) of Speed, Acceleration or Deceleration."""
        limit = self.settings.max_speed if name == "Speed" else self.settings.max_acceleration
        default = DEFAULT_SPEED if name == "Speed" else DEFAULT_RATE
        return limit or float(self[f"Maximum{name}"]) or default

    # --- courses under way

    def instant(self, now_ns: int) -> Instant:
        """Return the motion of the axis: the sum of all courses."""
        return total(course.instant(now_ns) for course in self.courses.values())

    def position(self, now_ns: int) -> float:
        """Return the position in units. The position of a geared axis is as of the last `catch_up`."""
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
        """Begin a course at the planner's present speed; its previous course ends.

        Args:
            claim: the claim of the course's instruction; see `MotionControl.claim`.
            goal: see `Course`.
            merge: end all courses, and continue from the speed of the axis.
        """
        course = self.courses[planner]
        entry = (self.instant(now_ns) if merge else course.instant(now_ns)).speed
        for running in self.courses.values() if merge else (course,):
            self._fold(running, now_ns)
            if running.claim != claim:
                running.end()
            running.set_hidden(kind=Kind.NOTHING)
        if kind in FOLLOWING:
            entry = 0.0
        course.begin(now_ns, kind, dynamics, claim, goal=goal, entry=entry)
        self.set_hidden(active=True)
        if kind is not Kind.STOP:
            start = self.position(now_ns)
            self.put(StartActualPosition=start, StartCommandPosition=start)

    def _fold(self, course: Course, now_ns: int) -> None:
        """Add an ending course's travel to `start`; a move's travel does not shift its target."""
        self.shift(course.instant(now_ns).travel, target=course.planner != "move")

    def stop_at_once(self, now_ns: int, error: int = 0) -> None:
        """End all courses at once, at the present position."""
        self.set_hidden(start=self.position(now_ns), active=True)
        for course in self.courses.values():
            course.end(error, **({"ER": True} if error else {}))

    def shift(self, distance: float, *, target: bool = True) -> None:
        """Shift the position by a distance; with `target`, also shift the end of a move."""
        self.set_hidden(start=float(self["~start"]) + distance)
        if target:
            self.set_hidden(target=float(self["~target"]) + distance)

    def redefine(self, distance: float) -> None:
        """Shift the reference of the axis; gears that follow it do not move."""
        self.shift(distance)
        self.set_hidden(position=float(self["~position"]) + distance)
        for slave in all_axes(self.memory, self.ideal):
            gear = slave.courses["gear"]
            if gear.kind is Kind.GEAR and slave["~master"] == self.number:
                gear.set_hidden(goal=gear.goal + distance)

    # --- after a scan

    def catch_up(self, now_ns: int, masters: Masters, waiting: tuple[int, ...] = ()) -> None:
        """Update a geared axis to its master's position; the master first catches up with its own master.

        Args:
            now_ns: the time of the scan, ns.
            masters: axes on 3601s.
            waiting: axes that wait for this axis; a circular chain ends at one of them.
        """
        gear, number = self.courses["gear"], int(self["~master"])
        if gear.kind is not Kind.GEAR or number in waiting:
            return
        if number < 0:
            master = IdealAxis(self.memory, self.ideal, number)
            master.catch_up(now_ns, masters, (*waiting, self.number))
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
        """End a course with PC, and add its travel to `start`. After a move, `start` is exactly `target`.

        A home search redefines the position instead.
        """
        if course.kind is Kind.HOME:
            self.redefine(float(self["HomePosition"]) - float(self["~start"]))
            self.set_bits(BITS, AxisHomedStatus=True)
        elif course.kind is Kind.MOVE:
            self.set_hidden(start=float(self["~target"]))
        else:
            self.shift(present.travel, target=course.planner != "move")
        course.end(PC=True)

    def _check_watch(self, position: float) -> None:
        """End MAW if the axis has reached the watched position since the last scan."""
        direction, last_position = int(self["~watch"]), float(self["~position"])
        to_watched = (float(self["~watched"]) - last_position) * direction
        travel, unwind = (position - last_position) * direction, self.settings.unwind
        if unwind:  # `travel` may be short by a rounding error if a move ends there
            to_watched, travel = forward_distance(to_watched, unwind), travel + ROUNDING * unwind
        if direction and 0 < to_watched <= travel:
            report(self.memory, self.ideal, int(self["~watch_claim"]), IP=False, PC=True)
            self.set_hidden(watch=0, watch_claim=0)
            self.set_bits(BITS, WatchEventArmedStatus=False, WatchEventStatus=True)

    def _show(self, moving: Sequence[tuple[Course, Instant]]) -> None:
        """Write the tag's members, report ACCEL and DECEL to the instructions, and check MAW.

        While the axis moves or MAW is armed, it stays active so that the next scan updates it.
        """
        present = total((REST, *(instant for _, instant in moving)))
        position, unwind = float(self["~start"]) + present.travel, self.settings.unwind
        self._check_watch(position)
        shown = position % unwind if unwind else position
        self.put(
            **dict.fromkeys(("ActualPosition", "CommandPosition"), shown),
            **dict.fromkeys(("ActualVelocity", "CommandVelocity", "AverageVelocity"), present.speed),
        )
        servo_on, shut_down = self.is_on("ServoActionStatus"), self.is_on("ShutdownStatus")
        for course, motion in moving:
            course.report(ACCEL=motion.change > 0, DECEL=motion.change < 0)
        kinds = {course.kind for course, _ in moving}
        self.set_bits(
            BITS,
            **{bit: kind in kinds for kind, bit in STATUS.items()},
            GearingLockStatus=Kind.GEAR in kinds,
            AccelStatus=present.change > 0,
            DecelStatus=present.change < 0,
            VelocityStandstillStatus=present.speed == 0,
            InPositionStatus=kinds <= {Kind.GEAR},
            PowerStructureEnabledStatus=servo_on,
        )
        state = RUNNING if servo_on else STOPPED
        self.put(CIPAxisState=SHUT if shut_down else state)
        self.set_hidden(position=position, active=bool(kinds or self["~watch"]))


def all_axes(memory: Memory, ideal: Ideal) -> list[IdealAxis]:
    """Return all ideal axes of a program."""
    return [IdealAxis(memory, ideal, -number) for number in range(1, len(ideal.axes) + 1)]


def update_axes(memory: Memory, ideal: Ideal, now_ns: int, masters: Masters) -> None:
    """Update all ideal axes after a scan; gears come first, so a chain of gears has no lag."""
    active = [axis for axis in all_axes(memory, ideal) if axis["~active"]]
    for axis in active:
        axis.catch_up(now_ns, masters)
    for axis in active:
        axis.update(now_ns)
