"""The words of command mode: a command with its parameters [EDS Assem150; SD p. 55].

    word 0    command bits          4, 5    programmed speed
    word 1    modifiers             6, 7    acceleration, deceleration
    2, 3      target, distance      8, 9    motor current, jerk; minimum distance of a registration move

A drive ignores the words that a command does not use [17 p. 80].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from ..number_formats import NumberFormat
from .bits import CommandBit, Modifier
from .models import Model

TARGET_MIN, TARGET_MAX = -8_388_608, 8_388_607
"""Range of positions and distances that the host writes, in any format [SD p. 55; reading R-12]."""


@dataclass(frozen=True)
class DriveCommand:
    """Ten output words, with the meanings that they have for a given model of the family."""

    words: tuple[int, ...]  # unsigned
    model: Model
    format: NumberFormat = NumberFormat.THOUSANDS

    @classmethod
    def of(
        cls, words: Sequence[int], model: Model, format: NumberFormat = NumberFormat.THOUSANDS
    ) -> DriveCommand:
        """Return the command of ten words, signed or unsigned."""
        return cls(tuple(word & 0xFFFF for word in words), model, format)

    @property
    def configures(self) -> bool:
        """Whether the words are in configuration mode."""
        return bool(self.words[0] & CommandBit.MODE_CONFIG)

    @cached_property
    def bits(self) -> CommandBit:
        """The command bits that are on, at the places of the SMD family."""
        return self.model.command_bits(self.words[0])

    @cached_property
    def modifiers(self) -> Modifier:
        """The modifiers of the model that are on."""
        return Modifier(self.words[1]) & self.model.modifiers

    @property
    def lsw(self) -> int:
        """The backplane proximity bit at its place in a 3601's word 1, for a 3601's home search."""
        return 1 << 12 if self.modifiers & Modifier.BACKPLANE_PROXIMITY else 0

    @property
    def reserved_modifiers(self) -> int:
        """The bits of word 1 that are on but have no meaning for the model."""
        return self.words[1] & ~self.model.modifiers.value

    @property
    def enables(self) -> bool:
        """Whether the words enable the driver."""
        return not self.model.enable_bit or bool(self.words[1] & Modifier.ENABLE_DRIVER)

    @property
    def selects_current(self) -> bool:
        """Whether word 8 is the motor current."""
        on_bits, off_bits = self.model.current_keys
        return self.model.modifiers != 0 and self.words[1] & (on_bits | off_bits) == on_bits

    @cached_property
    def target(self) -> int | None:
        """Target, distance or preset in words 2 and 3; None if they are out of range."""
        value = self.format.join(self.words[2], self.words[3])
        return value if value is not None and TARGET_MIN <= value <= TARGET_MAX else None

    @cached_property
    def speed(self) -> int | None:
        """Programmed speed, steps/s; None if the words do not form a valid number."""
        return self.format.join(self.words[4], self.words[5])

    @property
    def minimum_distance(self) -> int | None:
        """Minimum distance of a registration move, words 8 and 9 [reading R-17]; None if out of range."""
        value = self.format.join(self.words[8], self.words[9])
        return value if value is not None and 0 <= value <= TARGET_MAX else None

    @property
    def rates(self) -> tuple[int, int]:
        """Acceleration and deceleration, steps/ms/s."""
        return self.words[6], self.words[7]

    @property
    def current(self) -> int:
        """Motor current, 0.1 A."""
        return self.words[8]

    @property
    def jerk(self) -> int:
        """Jerk, % of the rate per second; 0 = constant acceleration. A registration move has no jerk."""
        registers = self.modifiers & Modifier.REGISTRATION_MOVE
        return 0 if registers or not self.model.jerk else self.words[9]

    def is_in_range(self, starting_speed: int) -> bool:
        """Return whether speed, rates and jerk are within their ranges [EDS; SD p. 55]."""
        limits, speed = self.model.limits, self.speed
        return (
            speed is not None
            and starting_speed <= speed <= limits.speed
            and all(1 <= rate <= limits.rate for rate in self.rates)
            and self.jerk <= limits.jerk
        )

    @property
    def current_is_legal(self) -> bool:
        """Whether the motor current is in range or not selected."""
        return not self.selects_current or self.model.limits.takes_current(self.current)
