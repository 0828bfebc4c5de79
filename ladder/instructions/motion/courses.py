"""Courses: the motions of the planners of ideal axes and coordinate systems, as functions of time.

    move        to a distance          home        at once
    jog, stop   to a speed             gear, path  follow another position

A course is stored in hidden members of its tag, with the planner's name as prefix, so that snapshots, edits
and both back ends include it.
"""

from __future__ import annotations

from dataclasses import fields
from enum import IntEnum

from ...state.memory import Value
from .ramps import REST, Dynamics, Instant, Phases, instant_at, move, ramp
from .spots import ENDED, Ideal, MotionSpot, report


class Kind(IntEnum):
    """The kind of motion of a course."""

    NOTHING = 0
    MOVE = 1
    JOG = 2
    HOME = 3
    STOP = 4
    PATH = 5  # the path of a coordinate system moves the axis
    GEAR = 6


FOLLOWING = (Kind.GEAR, Kind.PATH)
ENDING = (Kind.MOVE, Kind.HOME, Kind.STOP)
"""Kinds of courses that end on their own."""

DYNAMICS = tuple(field.name for field in fields(Dynamics))
"""Names of the hidden members for speed and rates."""


class Course:
    """A planner of an axis or of a coordinate system.

    `goal` is the distance of a move, the speed of a jog, or, for a course that follows a master, the master's
    last position. `entry` is the speed at `begun_ns`, or, for a course that follows a master, its present
    speed.
    """

    def __init__(self, spot: MotionSpot, ideal: Ideal, planner: str = "") -> None:
        self._spot, self._ideal, self.planner = spot, ideal, planner
        self._prefix = f"{planner}_" if planner else ""

    def _member(self, name: str) -> Value:
        return self._spot[f"~{self._prefix}{name}"]

    def set_hidden(self, **members: Value) -> None:
        """Set hidden members."""
        self._spot.set_hidden(**{f"{self._prefix}{name}": value for name, value in members.items()})

    @property
    def kind(self) -> Kind:
        """The kind of the course."""
        return Kind(int(self._member("kind")))

    @property
    def claim(self) -> int:
        """The claim of the course's instruction; see `MotionControl.claim`."""
        return int(self._member("claim"))

    @property
    def goal(self) -> float:
        """The goal of the course: a distance, a speed or a position."""
        return float(self._member("goal"))

    @property
    def dynamics(self) -> Dynamics:
        """Speed and rates of the course."""
        return Dynamics(*(float(self._member(name)) for name in DYNAMICS))

    def _phases(self, kind: Kind) -> Phases:
        """Return the phases of the course's profile; none if it ends at once or follows a master."""
        entry = float(self._member("entry"))
        if kind is Kind.MOVE:
            return move(self.goal, entry, self.dynamics)
        if kind in (Kind.JOG, Kind.STOP):
            return ramp(entry, self.goal, self.dynamics)
        return ()

    def instant(self, now_ns: int) -> Instant:
        """Return the motion of the course at a time; the travel is 0 if it follows a master."""
        kind = self.kind
        if kind in FOLLOWING:
            return Instant(0.0, float(self._member("entry")), 0.0, False)
        if kind is Kind.NOTHING:
            return REST
        last = self.goal if kind is Kind.JOG else 0.0
        return instant_at(self._phases(kind), (now_ns - int(self._member("begun_ns"))) / 1e9, last)

    def is_over(self, now_ns: int, present: Instant) -> bool:
        """Return whether the course has ended; a course can't end in the scan in which it began."""
        return present.over and self.kind in ENDING and now_ns > int(self._member("begun_ns"))

    def begin(
        self,
        now_ns: int,
        kind: Kind,
        dynamics: Dynamics,
        claim: int,
        *,
        goal: float = 0.0,
        entry: float = 0.0,
    ) -> None:
        """Replace this course with a new one."""
        self.set_hidden(kind=kind, begun_ns=now_ns, claim=claim, entry=entry, goal=goal)
        self.set_hidden(**{name: getattr(dynamics, name) for name in DYNAMICS})

    def follow(self, position: float, speed: float, ratio: float = 1.0) -> float:
        """Return the travel of the axis: its master's travel since the last call, multiplied by a ratio.

        Store the master's position for the next call, and the speed of the axis.
        """
        travel = (position - self.goal) * ratio
        self.set_hidden(goal=position, entry=speed * ratio)
        return travel

    def report(self, error: int = 0, **bits: bool) -> None:
        """Set bits of the course's instruction."""
        report(self._spot.memory, self._ideal, self.claim, error, **bits)

    def end(self, error: int = 0, **bits: bool) -> None:
        """End the course, clear IP and AC of its instruction, and set the given bits."""
        if self.kind is not Kind.NOTHING:
            self.report(error, **ENDED, **bits)
            self.set_hidden(kind=Kind.NOTHING, claim=0)
