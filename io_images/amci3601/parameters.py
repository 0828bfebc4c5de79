"""Output words 2 to 7 of command mode as numbers, and their ranges [chapter 5, notes 4 to 8].

The module's minimum programmed speed is its configured starting speed; this file only checks that the speed
is at least 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum

from ..dataclass import dataclass
from ..thousands import PARAMETER_MAX, PARAMETER_MIN, is_legal_pair, join_thousands


@dataclass(frozen=True, slots=True)
class Limits:
    """The largest values in a module's commands; the defaults are the limits of a 3601.

    Distances are limited only by the range of their words, `thousands.PARAMETER_MAX`.

    >>> Limits().takes_speed(1_000_001), Limits(speed=2_000_000).takes_speed(1_000_001)
    (False, True)
    """

    speed: int = 1_000_000  # programmed or starting speed, steps/s, from 1; 0 is a one-shot manual move
    rate: int = 2_000  # acceleration or deceleration, steps/ms/s, from 1

    def takes_speed(self, speed: int | None) -> bool:
        """Return whether a speed is legal (steps/s)."""
        return speed is not None and 1 <= speed <= self.speed

    def takes_rate(self, rate: int) -> bool:
        """Return whether an acceleration or deceleration is legal (steps/ms/s)."""
        return 1 <= rate <= self.rate


LIMITS_3601 = Limits()
"""The limits of a 3601 [chapter 5, notes 4 to 8]."""


def target_in_range(target: int | None) -> bool:
    """Return whether a target position is legal: -8,388,608 to 8,388,607 steps or counts."""
    return target is not None and PARAMETER_MIN <= target <= PARAMETER_MAX


@dataclass(frozen=True, slots=True)
class Parameters:
    """Output words 2 to 7 as numbers, legal or not.

    >>> Parameters.read((0x0002, 0, 12, 345, 5, -1, 20, 10))
    Parameters(target=12345, speed=None, acceleration=20, deceleration=10)
    """

    target: int | None  # steps or counts; None for an illegal pair of words (CMD-04)
    speed: int | None  # steps/s; None for an illegal pair of words
    acceleration: int  # steps/ms/s
    deceleration: int  # steps/ms/s

    @classmethod
    def read(cls, words: Sequence[int]) -> Parameters:
        """Read the parameters from eight signed output words."""
        return cls(_pair(words[2], words[3]), _pair(words[4], words[5]), words[6], words[7])

    @property
    def target_in_range(self) -> bool:
        """Whether the target is legal."""
        return target_in_range(self.target)

    def rates_in_range(self, limits: Limits) -> bool:
        """Return whether acceleration and deceleration are legal."""
        return limits.takes_rate(self.acceleration) and limits.takes_rate(self.deceleration)


def require(name: str, value: int, least: int, greatest: int) -> None:
    """Raise a ValueError if a value is out of range."""
    if not isinstance(value, int):
        raise ValueError(f"{name} {value!r} is not allowed: must be a whole number, {least} to {greatest}")
    if not least <= value <= greatest:
        raise ValueError(f"{name} {value} is out of range: must be {least} to {greatest}")


def require_member(name: str, value: object, kind: type[Enum]) -> None:
    """Raise a ValueError unless a value is a member of the enumeration."""
    if not isinstance(value, kind):
        choices = ", ".join(f"{kind.__name__}.{member.name}" for member in kind)
        raise ValueError(f"{name} {value!r} is not allowed; choose from {choices}")


def _pair(msw: int, lsw: int) -> int | None:
    """Return the value of two words; None if they are not a legal pair."""
    return join_thousands(msw, lsw) if is_legal_pair(msw, lsw) else None
