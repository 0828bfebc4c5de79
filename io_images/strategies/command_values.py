"""Common values of commands, and boundary values; the simplest come first."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from hypothesis import strategies as st

from ..amci3601 import KNOWN, Acceleration, Firmware
from ..amci3601.parameters import LIMITS_3601
from ..thousands import PARAMETER_MAX, PARAMETER_MIN

Result = TypeVar("Result")

STARTING_SPEEDS = (1000, 200, 4000, 50, 333, 1)
"""Starting speeds, steps/s."""

RATES = ((100, 50), (1000, 1000), (2000, 333), (20, 10), (777, 2000), (1, 1))
"""Legal pairs of acceleration and deceleration, steps/ms/s."""

FAULTY_RATES = ((0, 10), (10, 0), (2001, 10), (10, -1))
"""Pairs with one rate out of range."""

DISTANCES = (1000, 200, -300, 3000, -5000, 20_000, 77, 10, 2, 1, -1, 0, PARAMETER_MAX)
"""Distances of short, long, triangular, zero-length and longest moves, steps."""


def pick(make: Callable[..., Result], *lists: Sequence[Any]) -> st.SearchStrategy[Result]:
    """Return a strategy of `make` applied to one value of each list, in a single draw.

    Each draw costs Hypothesis time, so a single string of bytes is drawn, and each byte selects a value.
    Examples shrink toward the first value of each list. No list may have more than 256 values.
    """

    def from_bytes(drawn: bytes) -> Result:
        return make(*(values[len(values) * byte // 256] for values, byte in zip(lists, drawn, strict=True)))

    return st.binary(min_size=len(lists), max_size=len(lists)).map(from_bytes)


def starting_speeds() -> st.SearchStrategy[int]:
    """Return a strategy of legal starting speeds, steps/s."""
    return st.sampled_from(STARTING_SPEEDS) | st.integers(1, LIMITS_3601.speed)


def plain_speeds(starting_speed: int) -> tuple[int, ...]:
    """Return common programmed speeds for a starting speed, steps/s.

    >>> plain_speeds(1000)
    (5000, 2000, 1000, 1001, 20000, 100000)
    """
    likely = (5 * starting_speed, 2 * starting_speed, starting_speed, starting_speed + 1)
    common_speeds = (speed for speed in (5000, 20_000, 100_000) if speed > starting_speed)
    return tuple(dict.fromkeys(speed for speed in (*likely, *common_speeds) if speed <= LIMITS_3601.speed))


def speeds(starting_speed: int) -> st.SearchStrategy[int]:
    """Return a strategy of programmed speeds of at least `starting_speed`, steps/s."""
    return st.sampled_from((*plain_speeds(starting_speed), LIMITS_3601.speed)) | st.integers(
        starting_speed, LIMITS_3601.speed
    )


def rates() -> st.SearchStrategy[tuple[int, int]]:
    """Return a strategy of legal pairs of acceleration and deceleration, steps/ms/s."""
    return st.sampled_from(RATES) | st.tuples(st.integers(1, 2000), st.integers(1, 2000))


def targets() -> st.SearchStrategy[int]:
    """Return a strategy of legal positions and distances, steps, including negative values and limits."""
    return st.sampled_from((*DISTANCES, PARAMETER_MIN)) | st.integers(PARAMETER_MIN, PARAMETER_MAX)


def shapes() -> st.SearchStrategy[Acceleration]:
    """Return a strategy of the three acceleration types."""
    return st.sampled_from(Acceleration)


def firmwares() -> st.SearchStrategy[Firmware]:
    """Return a strategy of the manual's firmware versions, the newest first."""
    return st.sampled_from(KNOWN[::-1])
