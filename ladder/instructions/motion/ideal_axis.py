"""An ideal axis: a servo that follows its profile exactly. Any axis of a program without a 3601 is one.

    course     move, jog, stop or homing, from a speed on       gear     the master's travel times the ratio
    position = start + travel of the course (`ramps`); a gear shifts `start`

All state lies in hidden members of the axis's tag, so that snapshots, edits and both back ends have it. What
is under way is a function of the time since its begin. After each scan `update` writes the tag's members and
the bits of the instructions whose motion has ended, whether their rungs are scanned or not.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import IntEnum

from ...model.predefined.motion_types import AXIS_MEMBERS, MOTION_BITS
from ...state.memory import Memory, Value
from ...state.regions import converted
from .axes import AxisSettings
from .ramps import Dynamics, Instant, Phases, at, move, ramp

BITS = {each.name: each.at for each in AXIS_MEMBERS if each.at}
"""Member and bit of each named bit of an axis."""

DEFAULT_SPEED, DEFAULT_RATE = 100.0, 1000.0
"""100 % of maximum, units/s and units/s², where neither tag nor rack file has one."""

STOPPED, RUNNING, SHUT = 2, 4, 10
"""CIPAxisState [MOTION-RM003, "CIP Axis State"]."""


class Kind(IntEnum):
    """What an axis does."""

    NOTHING = 0
    MOVE = 1
    JOG = 2
    HOME = 3
    STOP = 4
    PATH = 5  # a coordinate system moves it


MOVING = {
    Kind.MOVE: "MoveStatus",
    Kind.JOG: "JogStatus",
    Kind.HOME: "HomingStatus",
    Kind.STOP: "StoppingStatus",
    Kind.PATH: "CoordinatedMotionStatus",
}
"""The status bit of each kind."""


@dataclass(frozen=True, slots=True)
class MotionPart:
    """A structure of a program, by the path of its tag and its place among the elements of an array."""

    path: str
    index: int
    name: str  # as messages name it
    kind: str = ""  # name of its type


@dataclass(frozen=True, slots=True)
class Ideal:
    """The ideal axes and coordinate systems of a program, and its motion instructions."""

    axes: tuple[tuple[MotionPart, AxisSettings], ...]  # number -1 is the first
    systems: tuple[tuple[MotionPart, tuple[int, ...]], ...]  # number 1 is the first; numbers of its axes
    controls: tuple[MotionPart, ...]  # number 1 is the first

    def carry(self, before: Ideal, memory: Memory) -> None:
        """Give what is under way the numbers of this program after an online edit of another one."""
        controls = _renumbered(before.controls, self.controls)
        axes = _renumbered([part for part, _ in before.axes], [part for part, _ in self.axes])
        for parts, claims in ((self.axes, OF_AXES), (self.systems, OF_SYSTEMS)):
            for part, _ in parts:
                spot = MotionSpot(memory, part)
                for name in claims:
                    number, ticket = divmod(int(spot[f"~{name}"]), 1 << 32)
                    spot.hide(**{name: controls.get(number, 0) << 32 | ticket})
        for part, _ in self.axes:
            spot = MotionSpot(memory, part)
            master = int(spot["~master"])
            if master < 0:
                spot.hide(master=-axes.get(-master, 0))


OF_AXES, OF_SYSTEMS = ("claim", "gear_claim", "watch_claim"), ("claim", "next_claim", "transform")
"""Hidden members that name an instruction."""


def _renumbered(before: Sequence[MotionPart], after: Sequence[MotionPart]) -> dict[int, int]:
    """Return new numbers by old ones, from 1."""
    now = {(part.path.upper(), part.index): number for number, part in enumerate(after, 1)}
    return {number: now.get((part.path.upper(), part.index), 0) for number, part in enumerate(before, 1)}


class MotionSpot:
    """A structure in memory: `spot["~kind"]`, `spot.put(MoveStatus=True)`."""

    def __init__(self, memory: Memory, part: MotionPart) -> None:
        self.memory, self.part = memory, part

    def __getitem__(self, name: str) -> Value:
        """Return a member."""
        return self.memory.read(self.memory.layout.leaf(f"{self.part.path}.{name}"), self.part.index)

    def put(self, **members: Value) -> None:
        """Set members that lie in no array."""
        for name, value in members.items():
            leaf = self.memory.layout.leaf(f"{self.part.path}.{name}")
            self.memory.write(leaf, self.part.index, converted(leaf.type, value))

    def hide(self, **members: Value) -> None:
        """Set hidden members."""
        self.put(**{f"~{name}": value for name, value in members.items()})

    def row(self, name: str, values: Iterable[float]) -> None:
        """Set the elements of an array member."""
        leaf = self.memory.layout.leaf(f"{self.part.path}.{name}")
        for place, value in enumerate(values, self.part.index * leaf.dims[-1]):
            self.memory.write(leaf, place, converted(leaf.type, value))

    def bits(self, places: dict[str, str], **bits: bool) -> None:
        """Set bits by name, whose word and number `places` has."""
        words: dict[str, int] = {}
        for name, on in bits.items():
            word, _, bit = places[name].partition(".")
            value = words[word] if word in words else int(self[word])
            words[word] = value | 1 << int(bit) if on else value & ~(1 << int(bit))
        self.put(**words)


FLAGS = {name: f"FLAGS.{bit}" for name, bit in MOTION_BITS.items()}


def settle(memory: Memory, ideal: Ideal, claim: int, error: int = 0, **bits: bool) -> None:
    """Set bits of the instruction of a claim, if it has not begun another time since."""
    number, ticket = claim >> 32, claim & 0xFFFF_FFFF
    if not number:
        return
    control = MotionSpot(memory, ideal.controls[number - 1])
    if control["~ticket"] == ticket:
        control.bits(FLAGS, **bits)
        if error:
            control.put(ERR=error)


def dynamics_of(spot: MotionSpot) -> Dynamics:
    """Return the dynamics of what is under way."""
    names = ("~speed", "~up", "~down", "~up_share", "~down_share")
    return Dynamics(*(float(spot[name]) for name in names))


class IdealAxis(MotionSpot):
    """An ideal axis in a scan."""

    def __init__(self, memory: Memory, ideal: Ideal, number: int) -> None:
        part, self.settings = ideal.axes[-number - 1]
        super().__init__(memory, part)
        self.ideal, self.number = ideal, number

    @property
    def kind(self) -> Kind:
        """What it does."""
        return Kind(int(self["~kind"]))

    def is_on(self, bit: str) -> bool:
        """Return a bit of the tag."""
        word, _, number = BITS[bit].partition(".")
        return bool(int(self[word]) >> int(number) & 1)

    def maximum(self, name: str) -> float:
        """Return 100 % of a maximum: Speed, Acceleration or Deceleration."""
        own = self.settings.max_speed if name == "Speed" else self.settings.max_acceleration
        default = DEFAULT_SPEED if name == "Speed" else DEFAULT_RATE
        return own or float(self[f"Maximum{name}"]) or default

    # --- the course

    def phases(self) -> Phases:
        """Return the phases of the course."""
        kind, entry = self.kind, float(self["~entry"])
        if kind in (Kind.NOTHING, Kind.HOME, Kind.PATH):
            return ()
        if kind is Kind.MOVE:
            return move(float(self["~goal"]) - float(self["~start"]), entry, dynamics_of(self))
        return ramp(entry, float(self["~goal"]) if kind is Kind.JOG else 0.0, dynamics_of(self))

    def instant(self, now_ns: int) -> Instant:
        """Return where it is on its course."""
        last = float(self["~goal"]) if self.kind is Kind.JOG else 0.0
        return at(self.phases(), (now_ns - int(self["~begun_ns"])) / 1e9, last)

    def position(self, now_ns: int) -> float:
        """Return its position, units."""
        return float(self["~start"]) + self.instant(now_ns).travel

    def begin(self, now_ns: int, kind: Kind, dynamics: Dynamics, goal: float, claim: int) -> None:
        """Begin a course from the present position and speed; the one before ends.

        Args:
            goal: position of a move, speed of a jog.
            claim: of the instruction that follows it, see `MotionControl.claim`.
        """
        present, before = self.instant(now_ns), int(self["~claim"])
        start = float(self["~start"]) + present.travel
        if before != claim:
            settle(self.memory, self.ideal, before, IP=False, AC=False)
        self.hide(
            kind=kind, begun_ns=now_ns, claim=claim, start=start, entry=present.speed, goal=goal, active=True
        )
        self.hide(
            speed=dynamics.speed,
            up=dynamics.up,
            down=dynamics.down,
            up_share=dynamics.up_share,
            down_share=dynamics.down_share,
        )
        if kind is not Kind.STOP:
            self.put(StartActualPosition=start, StartCommandPosition=start)

    def rest(self, now_ns: int, error: int = 0) -> None:
        """End everything at once, where the axis is."""
        self.hide(start=self.position(now_ns), kind=Kind.NOTHING, active=True)
        self.loosen()
        settle(self.memory, self.ideal, int(self["~claim"]), error, IP=False, AC=False, **_failed(error))
        self.hide(claim=0)

    def loosen(self) -> None:
        """End a gear."""
        settle(self.memory, self.ideal, int(self["~gear_claim"]), IP=False)
        self.hide(master=0, gear_claim=0, active=True)

    def shift(self, way: float) -> None:
        """Move position and goal of a move: another reference, or a gear."""
        self.hide(start=float(self["~start"]) + way)
        if self.kind is Kind.MOVE:
            self.hide(goal=float(self["~goal"]) + way)

    # --- after a scan

    def gear(self, now_ns: int, master: float) -> None:
        """Follow a master's position, units of the master."""
        self.shift((master - float(self["~seen"])) * float(self["~ratio"]))
        self.hide(seen=master)

    def update(self, now_ns: int) -> None:
        """End what is over, and write the tag."""
        kind, present = self.kind, self.instant(now_ns)
        if kind in (Kind.MOVE, Kind.HOME, Kind.STOP) and present.over and now_ns > int(self["~begun_ns"]):
            self._end(kind, present)
            kind, present = self.kind, self.instant(now_ns)
        position = float(self["~start"]) + present.travel
        self._watch(position)
        self._show(now_ns, position, kind, present)

    def _end(self, kind: Kind, present: Instant) -> None:
        goal = float(self["~goal"]) if kind is Kind.MOVE else float(self["~start"]) + present.travel
        if kind is Kind.HOME:
            goal = float(self["HomePosition"])
            self.bits(BITS, AxisHomedStatus=True)
        settle(self.memory, self.ideal, int(self["~claim"]), IP=False, AC=False, PC=True)
        self.hide(kind=Kind.NOTHING, start=goal, claim=0)

    def _watch(self, position: float) -> None:
        """End MAW when the axis comes to its position."""
        way, there, before = int(self["~watch"]), float(self["~watched"]), float(self["~position"])
        if way and (before < there <= position if way > 0 else before > there >= position):
            settle(self.memory, self.ideal, int(self["~watch_claim"]), IP=False, PC=True)
            self.hide(watch=0, watch_claim=0)
            self.bits(BITS, WatchEventArmedStatus=False, WatchEventStatus=True)

    def _show(self, now_ns: int, position: float, kind: Kind, present: Instant) -> None:
        geared = bool(self["~master"])
        seconds = (now_ns - int(self["~shown_ns"])) / 1e9
        speed = present.speed
        if (geared or kind is Kind.PATH) and seconds > 0:
            speed = (position - float(self["~position"])) / seconds
        unwind = self.settings.unwind
        shown = position % unwind if unwind else position
        self.put(
            **dict.fromkeys(("ActualPosition", "CommandPosition"), shown),
            **dict.fromkeys(("ActualVelocity", "CommandVelocity", "AverageVelocity"), speed),
        )
        on, shut = self.is_on("ServoActionStatus"), self.is_on("ShutdownStatus")
        self.bits(
            BITS,
            **{bit: kind is each for each, bit in MOVING.items()},
            GearingStatus=geared,
            GearingLockStatus=geared,
            AccelStatus=present.change > 0,
            DecelStatus=present.change < 0,
            VelocityStandstillStatus=speed == 0,
            InPositionStatus=kind is Kind.NOTHING,
            PowerStructureEnabledStatus=on,
        )
        self.put(CIPAxisState=SHUT if shut else RUNNING if on else STOPPED)
        self.hide(position=position, shown_ns=now_ns)
        self.hide(active=kind is not Kind.NOTHING or geared or bool(self["~watch"]) or speed != 0)


def _failed(error: int) -> dict[str, bool]:
    return {"ER": True} if error else {}


def update_axes(memory: Memory, ideal: Ideal, now_ns: int, master: dict[int, float]) -> None:
    """Update all ideal axes after a scan; courses first, then gears in the order of the axes.

    Args:
        master: positions of the axes on 3601s, by number.
    """
    axes = [IdealAxis(memory, ideal, -place) for place in range(1, len(ideal.axes) + 1)]
    active = [each for each in axes if each["~active"]]
    for each in active:
        number = int(each["~master"])
        if number:
            each.gear(now_ns, master[number] if number > 0 else axes[-number - 1].position(now_ns))
    for each in active:
        each.update(now_ns)
