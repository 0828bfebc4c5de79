"""Operands of motion instructions [MOTION-RM002]."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from ...interpreter import Interpreter
from ...model.operands import DOUBLE
from ...model.predefined.motion_words import (
    JERK_UNITS,
    MERGE_SPEEDS,
    NO_YES,
    PROFILES,
    RATE_UNITS,
    SPEED_UNITS,
)
from ...model.predefined.words import plain
from ...model.types import DINT
from .motion_control import ILLEGAL, OUT_OF_RANGE, Argument, MotionControl, MotionError
from .ramps import Dynamics, shares

LARGEST = 1e15
"""Largest position, distance, speed or rate, in axis units."""


class MotionCall(NamedTuple):
    """A starting motion instruction; its operands follow the axis, group or system, and the control."""

    machine: Interpreter
    motion: MotionControl
    name: str
    operands: Sequence[Argument]

    @property
    def now_ns(self) -> int:
        """The time of the scan, in ns."""
        return self.machine.now_ns

    def number(self, index: int) -> float:
        """Return a numeric operand; 0 if it is omitted or a keyword."""
        operand = self.operands[index] if index < len(self.operands) else ""
        return 0.0 if isinstance(operand, str) else float(self.machine.number(operand, DOUBLE))

    def keyword(self, index: int, keywords: tuple[str, ...]) -> str:
        """Return a keyword operand in the form of `plain`; "" if it is omitted or a number out of range."""
        operand = self.operands[index] if index < len(self.operands) else ""
        if isinstance(operand, str):
            return operand
        number = int(self.machine.number(operand, DINT.bits))
        return plain(keywords[number]) if 0 <= number < len(keywords) else ""

    def says_yes(self, index: int) -> bool:
        """Return whether a keyword operand is Yes."""
        return self.keyword(index, NO_YES) == "YES"

    def direction_sign(self, index: int) -> int:
        """Return the sign of a direction operand: -1 for Reverse, otherwise 1."""
        return -1 if self.keyword(index, ("Forward", "Reverse")) == "REVERSE" else 1

    def show_begun(self) -> None:
        """Set the bits that indicate the beginning of a motion."""
        self.motion.set(IP=True, AC=True)


class Starter(NamedTuple):
    """How an instruction begins on an axis or a coordinate system."""

    begin: Callable[[Any, MotionCall], None]  # raises a MotionError for a refused instruction
    moves: bool = False  # whether it needs an axis that accepts motion


Starters = Mapping[str, Starter]
"""Starters by instruction name."""


def start(starters: Starters, axis: Any, call: MotionCall, check_ready: Callable[[Any], object]) -> None:
    """Begin an instruction with its starter, or raise a MotionError.

    Args:
        starters: the starters for this kind of axis or coordinate system.
        axis: the axis or coordinate system.
        call: the instruction.
        check_ready: raises a MotionError if the axis can't accept motion now.
    """
    if call.name not in starters:
        raise MotionError(ILLEGAL)
    starter = starters[call.name]
    if starter.moves:
        check_ready(axis)
    starter.begin(axis, call)


Maxima = Callable[[str], float]
"""Returns the value that is 100 % of the maximum Speed, Acceleration or Deceleration, by name."""


def dynamics_at(call: MotionCall, index: int, maximum: Maxima, current: float | None = None) -> Dynamics:
    """Return speed, rates and jerks from the ten operands beginning at `index`, or raise a MotionError.

    Args:
        current: speed for a merge at Current, which replaces the speed operand; 0 or None to use the operand.
    """
    speed = current or scaled(call.number(index), call.keyword(index + 1, SPEED_UNITS), maximum("Speed"))
    up, down = (
        scaled(call.number(index + offset), call.keyword(index + offset + 1, RATE_UNITS), maximum(name))
        for offset, name in ((2, "Acceleration"), (4, "Deceleration"))
    )
    if call.keyword(index + 6, PROFILES) != "SCURVE":
        return Dynamics(speed, up, down)
    unit = call.keyword(index + 9, JERK_UNITS)
    up, up_share = _curved(up, call.number(index + 7), unit, speed)
    down, down_share = _curved(down, call.number(index + 8), unit, speed)
    return Dynamics(speed, up, down, up_share, down_share)


def merge_at(
    call: MotionCall, index: int, keywords: tuple[str, ...], speed: float
) -> tuple[str, float | None]:
    """Return the merge operand at `index`, and the speed to continue at (None for the programmed speed).

    Args:
        keywords: the keywords of the operand; the first is Disabled.
        speed: current speed of the axis or coordinate system, units/s.
    """
    merge = call.keyword(index, keywords)
    at_current = merge not in ("", "DISABLED") and call.keyword(index + 1, MERGE_SPEEDS) == "CURRENT"
    return merge, abs(speed) if at_current else None


def scaled(value: float, unit: str, maximum: float) -> float:
    """Return a speed or rate in axis units.

    Raises:
        MotionError: the value is out of range, or its unit is master units or time.
    """
    if unit == "%OFMAXIMUM":
        value *= maximum / 100
    elif not unit.startswith("UNITSPERSEC"):
        raise MotionError(OUT_OF_RANGE)
    return in_range(value, 1e-9)


def in_range(value: float, least: float = -LARGEST) -> float:
    """Return the value if it is between `least` and `LARGEST`; otherwise raise a MotionError."""
    if not least <= value <= LARGEST:
        raise MotionError(OUT_OF_RANGE)
    return value


def allowed(dynamics: Dynamics) -> Dynamics:
    """Return speed and rates if they are finite and above 0; otherwise raise a MotionError."""
    if not dynamics.allowed:
        raise MotionError(OUT_OF_RANGE)
    return dynamics


def _curved(rate: float, jerk: float, unit: str, speed: float) -> tuple[float, float]:
    """Return the rate and ramp share of an S-curve; the share is 0 if the jerk is not above 0."""
    if not 0 < jerk <= LARGEST:
        return rate, 0.0
    if unit == "UNITSPERSEC3":
        return shares(rate, jerk, speed)
    return rate, min(jerk, 100.0) / 200  # % of time; % of maximum is treated the same way
