"""The motor of a PMC006x3s, and how its motions start and end.

    IDLE      at rest
    MOVE      a number of steps                              [4.3.1]
    SPEED     until a stop                                   [4.3.8]
    SLOWING   from SPEED down to the stop speed
    RETREAT   zero-back: forward, away from the switch       [4.3.13]
    SEEK      zero-back: backward, until EXT1 triggers

Motions are closed forms of time, so nothing is computed between two events (`next_ns`).
"""

from __future__ import annotations

from dataclasses import replace
from enum import Enum, auto

from scanrack.io_images.pmc006.status import Status1

from ...kinematics import FOREVER, Motion
from .memory import Memory
from .pins import Pin, Pmc006Pins
from .ramps import Pmc006Speeds, plan_move, plan_run, plan_slowing

RETREAT_DIVISOR = 16
"""Ratio of the stroke to the length of a retreat from the switch [4.3.13]."""


class MotorActivity(Enum):
    """An activity of the motor."""

    IDLE = auto()
    MOVE = auto()
    SPEED = auto()
    SLOWING = auto()
    RETREAT = auto()
    SEEK = auto()


class ExtStop:
    """One external stop.

    Attributes:
        bit: its bit in the values of instructions f and J.
        flag: its bit in status register 1.
        blocks: direction, +1 or -1, in which an active stop refuses steps (interpretation).
    """

    __slots__ = ("_memory", "_pins", "bit", "blocks", "flag", "pin")

    def __init__(
        self, memory: Memory, pins: Pmc006Pins, pin: Pin, flag: Status1, *, bit: int, blocks: int
    ) -> None:
        self._memory = memory
        self._pins = pins
        self.pin = pin
        self.flag = flag
        self.bit = bit
        self.blocks = blocks

    @property
    def armed(self) -> bool:
        """Whether instruction f enables it."""
        return bool(self._memory["ext_stop_enable"] & self.bit)

    @property
    def active(self) -> bool:
        """Whether its pin is at the level that follows the edge selected by J."""
        rising = bool(self._memory["ext_trigger_mode"] & self.bit)
        return bool(self._pins.levels & self.pin) == rising


class SimulatedPmc006Axis:
    """The motor and its motions.

    Attributes:
        doing: the current activity.
        physical: steps since power-up, with sign; commands never set it.
        flags: latched emergency stops of EXT1 and EXT2, as in status register 1.
        stalled: whether the motor has stalled since the last start.
    """

    def __init__(self, memory: Memory, pins: Pmc006Pins) -> None:
        self._memory = memory
        self._pins = pins
        self._ext1 = ExtStop(memory, pins, Pin.EXT1, Status1.EXT1, bit=1, blocks=-1)
        self._ext2 = ExtStop(memory, pins, Pin.EXT2, Status1.EXT2, bit=2, blocks=+1)
        self._motion: Motion | None = None
        self._zero = 0  # physical position at which the position register reads 0
        self._stroke = self._retreated = 0  # of a zero-back: steps allowed, and steps away from the switch
        self.doing = MotorActivity.IDLE
        self.physical = 0
        self.flags = Status1(0)
        self.stalled = False

    # -- state -------------------------------------------------------------------------------

    @property
    def position(self) -> int:
        """The position register, steps: signed 32 bits."""
        return (self.physical - self._zero + (1 << 31)) % (1 << 32) - (1 << 31)

    @position.setter
    def position(self, value: int) -> None:
        self._zero = self.physical - value

    @property
    def moving(self) -> bool:
        """Whether a motion is in progress."""
        return self.doing is not MotorActivity.IDLE

    @property
    def homing(self) -> bool:
        """Whether a zero-back is in progress."""
        return self.doing in (MotorActivity.RETREAT, MotorActivity.SEEK)

    @property
    def direction(self) -> int:
        """+1 or -1, as set by instruction d."""
        return 1 if self._memory["direction"] else -1

    # -- commands ---------------------------------------------------------------------------

    @property
    def may_start(self) -> bool:
        """Whether a motion can begin: at rest, not released, and no emergency stop latched."""
        return not (self.moving or self._memory["free_run"] or self.flags)

    @property
    def speeds_fit(self) -> bool:
        """Whether neither the start speed nor the stop speed exceeds the maximum speed [4.3.9]."""
        edge_speeds = self._memory["start_speed"], self._memory["stop_speed"]
        return max(edge_speeds) <= self._memory["max_speed"]

    @property
    def against_limit(self) -> bool:
        """Whether an armed and active limit blocks the selected direction [4.1.1, error 07]."""
        stops = self._ext1, self._ext2
        return any(stop.armed and stop.active and stop.blocks == self.direction for stop in stops)

    def step(self, now_ns: int, steps: int) -> None:
        """Begin a move in the selected direction."""
        distance = self.direction * steps
        self._begin(MotorActivity.MOVE, plan_move(now_ns, self.physical, distance, self._speeds()))

    def run(self, now_ns: int) -> None:
        """Begin to run at the maximum speed in the selected direction."""
        self._begin(MotorActivity.SPEED, plan_run(now_ns, self.physical, self.direction, self._speeds()))

    def slow_down(self, now_ns: int) -> None:
        """Ramp down from speed mode; do nothing in another mode."""
        if self.doing is MotorActivity.SPEED and self._motion is not None:
            ramp = self._memory["stop_speed"], self._memory["decel_coefficient"]
            self._begin(MotorActivity.SLOWING, plan_slowing(self._motion, now_ns, *ramp))

    def zero_back(self, now_ns: int, stroke: int) -> None:
        """Begin to search for the switch on EXT1 within a stroke."""
        self._stroke, self._retreated = stroke, 0
        if self._ext1.active:
            self._retreat(now_ns)
        else:
            self._seek(now_ns)

    def halt(self) -> None:
        """End any motion at once, without a ramp."""
        self._motion = None
        self.doing = MotorActivity.IDLE

    def power_up(self) -> None:
        """Restart: the motor rests in place, and its position register is 0."""
        self.halt()
        self.position = 0
        self.flags = Status1(0)
        self.stalled = False

    # -- time --------------------------------------------------------------------------------

    def next_ns(self) -> int:
        """Return the instant of the next pin change or the end of the motion, or FOREVER."""
        motion = self._motion
        if motion is None:
            return FOREVER
        end_ns = FOREVER if motion.end_ns is None else motion.end_ns
        change = self._pins.next_change(self.physical, motion.direction)
        reached_ns = None if change is None else motion.instant_of(abs(change - motion.origin))
        return end_ns if reached_ns is None else min(reached_ns, end_ns)

    def go_to(self, now_ns: int) -> None:
        """Update the position to `now_ns`, which must not be after `next_ns`."""
        if self._motion is not None:
            self.physical = self._motion.position_at(now_ns)

    def end_if_due(self, now_ns: int) -> None:
        """End a motion that has made its last step."""
        motion = self._motion
        if motion is None or motion.end_ns is None or now_ns < motion.end_ns:
            return
        if self.doing is MotorActivity.RETREAT:
            self._retreat_ended(now_ns)
        else:
            self.halt()

    def on_pins(self, changed: int, _levels: int) -> None:
        """React to pins that have changed."""
        for stop in (self._ext1, self._ext2):
            if changed & stop.pin and stop.active:
                self._triggered(stop)

    def stall(self) -> None:
        """Stop the motor, because the encoder shows that the motor has stalled."""
        self.halt()
        self.stalled = True

    # -- inside ------------------------------------------------------------------------------

    def _begin(self, doing: MotorActivity, motion: Motion) -> None:
        self.doing = doing
        self._motion = motion
        self.stalled = False

    def _speeds(self) -> Pmc006Speeds:
        """Return the speeds and ramps in the parameters, for moves and for speed mode."""
        memory = self._memory
        return Pmc006Speeds(
            start_sps=memory["start_speed"],
            max_sps=memory["max_speed"],
            stop_sps=memory["stop_speed"],
            acceleration=memory["accel_coefficient"],
            deceleration=memory["decel_coefficient"],
        )

    def _zero_speeds(self) -> Pmc006Speeds:
        """Return the speeds of a zero-back; instruction 9's speed also limits the start and stop speeds."""
        speeds, top_sps = self._speeds(), self._memory["zero_back_speed"]
        return replace(
            speeds,
            start_sps=min(speeds.start_sps, top_sps),
            max_sps=top_sps,
            stop_sps=min(speeds.stop_sps, top_sps),
        )

    def _retreat(self, now_ns: int) -> None:
        """Move away from the switch by a part of the stroke, see `RETREAT_DIVISOR`."""
        distance = max(1, self._stroke // RETREAT_DIVISOR)
        self._retreated += distance
        self._begin(MotorActivity.RETREAT, plan_move(now_ns, self.physical, distance, self._zero_speeds()))

    def _retreat_ended(self, now_ns: int) -> None:
        """Seek the switch; if it is still active, retreat further within the stroke."""
        if not self._ext1.active:
            self._seek(now_ns)
        elif self._retreated < self._stroke:
            self._retreat(now_ns)
        else:
            self.halt()

    def _seek(self, now_ns: int) -> None:
        """Move toward the switch, at most over the stroke."""
        self._begin(MotorActivity.SEEK, plan_move(now_ns, self.physical, -self._stroke, self._zero_speeds()))

    def _triggered(self, stop: ExtStop) -> None:
        """Handle the edge of an external stop: the end of a zero-back, or an emergency stop."""
        is_home = stop is self._ext1 and self.doing is MotorActivity.SEEK
        if is_home or stop.armed:
            self.halt()
        if is_home:
            self.position = 0
        if stop.armed:
            self.flags |= stop.flag
