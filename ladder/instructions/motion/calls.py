"""Operands of motion instructions on ideal axes and coordinate systems [MOTION-RM002]."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from ...interpreter import Interpreter
from ...model.predefined.motion_words import (
    JERK_UNITS,
    MERGE_SPEEDS,
    NO_YES,
    PROFILES,
    RATE_UNITS,
    SPEED_UNITS,
)
from .motion_control import OUT_OF_RANGE, Given, MotionControl, MotionError, number_of, word_of
from .ramps import Dynamics, shares

LARGEST = 1e15
"""Largest position, distance, speed or rate, in units of the axis."""


class MotionCall(NamedTuple):
    """An instruction that begins, with its operands after the axis, group or system and the control."""

    machine: Interpreter
    motion: MotionControl
    name: str
    operands: Sequence[Given]

    @property
    def now_ns(self) -> int:
        """The time of the scan, in ns."""
        return self.machine.now_ns

    def number(self, place: int) -> float:
        """Return a numeric operand; 0 if it is omitted."""
        return number_of(self.machine, self.operands[place]) if place < len(self.operands) else 0.0

    def word(self, place: int, words: tuple[str, ...]) -> str:
        """Return a keyword operand."""
        return word_of(self.machine, self.operands[place], words) if place < len(self.operands) else ""

    def yes(self, place: int) -> bool:
        """Whether a keyword operand says Yes."""
        return self.word(place, NO_YES) == "YES"

    def under_way(self) -> None:
        """Set the bits that show that the motion has begun."""
        self.motion.set(DN=True, IP=True, AC=True)


Maxima = Callable[[str], float]
"""Returns 100 % of a maximum by name: Speed, Acceleration or Deceleration."""


def dynamics_at(call: MotionCall, place: int, maximum: Maxima, current: float | None = None) -> Dynamics:
    """Return speed, rates and jerks from the ten operands at `place`, or raise a MotionError.

    Args:
        current: present speed of the axis; unless it is 0, a merge at Current uses it instead of the operand.
    """
    speed = current or scaled(call.number(place), call.word(place + 1, SPEED_UNITS), maximum("Speed"))
    up, down = (
        scaled(call.number(place + by), call.word(place + by + 1, RATE_UNITS), maximum(name))
        for by, name in ((2, "Acceleration"), (4, "Deceleration"))
    )
    if call.word(place + 6, PROFILES) != "SCURVE":
        return Dynamics(speed, up, down)
    unit = call.word(place + 9, JERK_UNITS)
    up, up_share = _curved(up, call.number(place + 7), unit, speed)
    down, down_share = _curved(down, call.number(place + 8), unit, speed)
    return Dynamics(speed, up, down, up_share, down_share)


def merge_at(call: MotionCall, place: int, words: tuple[str, ...], speed: float) -> tuple[str, float | None]:
    """Return the merge operand at `place`, and the speed to continue at; None for the programmed speed.

    Args:
        words: the words that the operand can have; the first is Disabled.
        speed: present speed of the axis or coordinate system, units/s.
    """
    merge = call.word(place, words)
    at_current = merge not in ("", "DISABLED") and call.word(place + 1, MERGE_SPEEDS) == "CURRENT"
    return merge, abs(speed) if at_current else None


def scaled(value: float, unit: str, maximum: float) -> float:
    """Return a speed or rate in units of the axis.

    Raises:
        MotionError: it is out of range, or in units of a master or of time.
    """
    if unit == "%OFMAXIMUM":
        value *= maximum / 100
    elif not unit.startswith("UNITSPERSEC"):
        raise MotionError(OUT_OF_RANGE)
    return in_range(value, 1e-9)


def in_range(value: float, least: float = -LARGEST) -> float:
    """Return a number from `least` to `LARGEST`, or raise a MotionError."""
    if not least <= value <= LARGEST:
        raise MotionError(OUT_OF_RANGE)
    return value


def allowed(dynamics: Dynamics) -> Dynamics:
    """Return speed and rates that are finite and above 0, or raise a MotionError."""
    if not dynamics.allowed:
        raise MotionError(OUT_OF_RANGE)
    return dynamics


def _curved(rate: float, jerk: float, unit: str, speed: float) -> tuple[float, float]:
    """Return the rate and ramp share of an S-curve; without a positive jerk there is no S-curve."""
    if not 0 < jerk <= LARGEST:
        return rate, 0.0
    if unit == "UNITSPERSEC3":
        return shares(rate, jerk, speed)
    return rate, min(jerk, 100.0) / 200  # % of time; % of maximum is treated the same way
