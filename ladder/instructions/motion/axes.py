"""Axes of a program, from `[axes]` in a rack file. An axis without a slot is ideal; see `ideal_axis`.

[axes.Feed]
slot = 1
counts_per_unit = 1000           # motor steps per axis unit
configuration = [0x843C, 0x003C, 0, 500, 0, 0, 0, 0]   # if the program does not

[axes.Table]                     # ideal, like an axis without a table
unwind = 360
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

from scanrack.io_images.amci3601.parameters import LIMITS_3601, Limits
from scanrack.io_images.dataclass import dataclass

from ...model.errors import LadderError

WORDS = 8
"""Number of a 3601's output words, and of words in its configuration."""


@dataclass(frozen=True, slots=True)
class MotionData:
    """Data of axes and coordinate systems in an export, by uppercase tag name."""

    systems: Mapping[str, Sequence[str]] = field(default_factory=dict)  # names of each system's axes
    unwinds: Mapping[str, float] = field(default_factory=dict)  # unwind of rotary axes, units


@dataclass(frozen=True, slots=True)
class AxisSettings:
    """Settings of a program's axis in the rack; an out-of-range value raises a LadderError."""

    slot: int = 0  # slot of its 3601, 0 for an ideal axis
    counts_per_unit: float = 1.0  # steps per unit of the axis, above 0
    max_speed: float = 0.0  # 100 % of maximum, units/s; 0 = MaximumSpeed of the tag
    max_acceleration: float = 0.0  # 100 % of maximum, units/s²; 0 = MaximumAcceleration of the tag
    home_speed: float = 0.0  # units/s; 0 = HomeSpeed of the tag
    home_acceleration: float = 0.0  # both rates, units/s²; 0 = `max_acceleration`
    home_direction: int = 1  # 1 clockwise, -1 counterclockwise
    configuration: tuple[int, ...] = ()  # eight words that MSO sends; none if the program configures it
    round_trip_ms: int = 10  # time for words to cross the backplane both ways, ms
    unwind: float = 0.0  # ideal rotary axis: positions are from 0 to below this, units; 0 = a linear axis
    limits: Limits = LIMITS_3601  # limits of the module in its slot

    def __post_init__(self) -> None:
        if not 0 < self.counts_per_unit < float("inf"):
            raise LadderError(f"counts_per_unit {self.counts_per_unit} is out of range; must be above 0")
        for name in ("max_speed", "max_acceleration", "home_speed", "home_acceleration", "unwind"):
            if not 0 <= getattr(self, name) < float("inf"):
                raise LadderError(f"{name} {getattr(self, name)} is out of range; must be 0 or more")
        if self.home_direction not in (1, -1):
            raise LadderError(f"home_direction is {self.home_direction}; must be 1 or -1")
        if len(self.configuration) not in (0, WORDS):
            raise LadderError(f"configuration has {len(self.configuration)} words; must be {WORDS}")
        for word in self.configuration:
            if not -32_768 <= word <= 0xFFFF:
                raise LadderError(f"configuration word {word} is out of range; must be -32,768 to 65,535")
