"""Output words 2 to 7 of command mode as numbers, and their ranges [chapter 5, notes 4 to 8].

The minimum programmed speed is the starting speed, which only the module knows: here it is 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from ..thousands import PARAMETER_MAX, PARAMETER_MIN, is_legal_pair, join_thousands

SPEED_MAX = 1_000_000
"""Maximum programmed or starting speed, steps/s; the minimum is 1, or 0 for a one-shot manual move."""

RATE_MAX = 2_000
"""Maximum acceleration or deceleration, steps/ms/s; the minimum is 1."""

DISTANCE_MAX = 8_388_607
"""Maximum steps of a minimum registration distance, of a blend segment, and of all segments."""


def target_in_range(target: int | None) -> bool:
    """Whether a target position is legal: -8,388,608 to 8,388,607 steps or counts."""
    return target is not None and PARAMETER_MIN <= target <= PARAMETER_MAX


def speed_in_range(speed: int | None) -> bool:
    """Whether a speed is legal: 1 to 1,000,000 steps/s."""
    return speed is not None and 1 <= speed <= SPEED_MAX


def rate_in_range(rate: int) -> bool:
    """Whether an acceleration or deceleration is legal: 1 to 2000 steps/ms/s."""
    return 1 <= rate <= RATE_MAX


@dataclass(frozen=True, slots=True)
class Parameters:
    """Output words 2 to 7 as numbers, legal or not.

    >>> Parameters.read((0x0002, 0, 12, 345, 5, -1, 20, 10))
    Parameters(target=12345, speed=None, acceleration=20, deceleration=10)
    """

    target: int | None  # steps or counts; None for an illegal pair of words (CMD-04)
    speed: int | None  # steps/s; None likewise
    acceleration: int  # steps/ms/s
    deceleration: int  # steps/ms/s

    @classmethod
    def read(cls, words: Sequence[int]) -> Parameters:
        """Read them from eight signed output words."""
        return cls(_pair(words[2], words[3]), _pair(words[4], words[5]), words[6], words[7])

    @property
    def target_in_range(self) -> bool:
        """Whether the target is legal."""
        return target_in_range(self.target)

    @property
    def speed_in_range(self) -> bool:
        """Whether the speed is legal."""
        return speed_in_range(self.speed)

    @property
    def rates_in_range(self) -> bool:
        """Whether acceleration and deceleration are legal."""
        return rate_in_range(self.acceleration) and rate_in_range(self.deceleration)


def require(what: str, value: int, least: int, greatest: int) -> None:
    """Raise a ValueError for a value out of range."""
    if not isinstance(value, int):
        raise ValueError(f"{what} {value!r} is not allowed: must be a whole number, {least} to {greatest}")
    if not least <= value <= greatest:
        raise ValueError(f"{what} {value} is out of range: must be {least} to {greatest}")


def require_member(what: str, value: object, kind: type[Enum]) -> None:
    """Raise a ValueError unless `value` is a member of the enumeration."""
    if not isinstance(value, kind):
        raise ValueError(
            f"{what} {value!r} is not allowed; choose from {', '.join(map(str, _members(kind)))}"
        )


def _members(kind: type[Enum]) -> list[str]:
    return [f"{kind.__name__}.{member.name}" for member in kind]


def _pair(msw: int, lsw: int) -> int | None:
    return join_thousands(msw, lsw) if is_legal_pair(msw, lsw) else None
