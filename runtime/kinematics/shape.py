"""The shapes of a speed change, their times and distances: three with a fixed factor, one with a set jerk.

    T = k * |v1 - v0| / a        D = T * (v0 + v1) / 2

`a` is the programmed rate, which is the peak rate in the three shapes. `k` is the manual's factor for the
acceleration time [chapter 2, Calculating Move Profiles]. The distance formula is exact, since the shapes are
symmetrical about their midpoint.

    shape         k     rate during the ramp
    constant      1     a throughout
    triangular    2     rises to a at T/2, falls again
    trapezoidal   4/3   rises to a at T/4, constant to 3T/4 (50 %), falls again

AMCI's networked drives use a jerk instead. The jerk determines how long the rate takes to rise, and `k`
follows from that; see `Jerk`.

Units throughout the package: time in ns, travel in 1e-12 step (picosteps), speed in 1e-3 step/s. One unit of
speed times one ns is one unit of travel, so all numbers stay integers.
"""

from __future__ import annotations

from enum import Enum
from fractions import Fraction
from math import ceil, isqrt

from scanrack.io_images.dataclass import dataclass

PICO = 10**12
"""Picosteps in a step."""

MILLI = 1000
"""Thousandths of a step/s in a step/s."""

FINE = 10**6
"""The finer unit of plans: speed in 1e-9 step/s, travel in 1e-18 step.

Peak speeds and speeds within a ramp are rounded to 1e-9 step/s, which is about one step in thirty years.
"""

NANO = MILLI * FINE
"""Billionths of a step/s in a step/s."""


Rate = int | Fraction
"""A rate in steps/ms/s, above 0; a fraction if a device's rate is in steps/s/s."""


class Shape(Enum):
    """How the rate changes during a ramp [chapter 4, Acceleration Types].

    >>> Shape.TRAPEZOIDAL.factor
    Fraction(4, 3)
    """

    CONSTANT = (1, 1)
    TRIANGULAR = (2, 1)
    TRAPEZOIDAL = (4, 3)

    def __init__(self, numerator: int, denominator: int) -> None:
        self.numerator = numerator
        self.denominator = denominator

    @property
    def factor(self) -> Fraction:
        """The factor k for the acceleration time [chapter 2]."""
        return Fraction(self.numerator, self.denominator)


@dataclass(frozen=True, slots=True)
class Jerk:
    """How the rate changes for a given jerk, which is a percentage of the rate [SMD manual p. 46].

    The jerk is j = J * a / 100, so the rate rises from zero to any `a` in 100/J seconds.

        full = |v1 - v0| / a, rise = a / j
        full >= rise    trapezoidal    T = full + rise
        full < rise     triangular     T = 2 * sqrt(full * rise), `a` is not reached
    """

    percent: int  # J, from 1

    def course(self, change_nsps: int, rate_spmss: Rate) -> tuple[Fraction, Fraction]:
        """Return the time of a speed change in ns, and the fraction of it during which the rate rises.

        The time of a triangular ramp is rounded up to an even number of ns, so the ramp is never steeper than
        set.

        >>> time_ns, rising = Jerk(400).course(30_000 * NANO, 58)  # SMD manual p. 51
        >>> round(float(time_ns) / 1e9, 4), round(float(1 - 2 * rising), 3)
        (0.7672, 0.348)
        """
        rise = Fraction(10**11, self.percent)
        full = Fraction(change_nsps) / (MILLI * rate_spmss)
        if full >= rise:
            return full + rise, rise / (full + rise)
        square = full * rise
        half = isqrt(ceil(square))
        return Fraction(2 * (half if half * half >= square else half + 1)), Fraction(1, 2)


AnyShape = Shape | Jerk
"""The course of the rate in a ramp."""


def ramp_time(change_nsps: int, rate_spmss: Rate, shape: AnyShape) -> Fraction:
    """Return the unrounded time, in ns, of a speed change of 0 or more."""
    if isinstance(shape, Jerk):
        return shape.course(change_nsps, rate_spmss)[0]
    return Fraction(shape.numerator * change_nsps) / (shape.denominator * MILLI * rate_spmss)


def ramp_distance(from_msps: int, to_msps: int, rate_spmss: Rate, shape: AnyShape) -> Fraction:
    """Return the unrounded distance of a speed change, `k * |v1^2 - v0^2| / (2a)`, in picosteps.

    >>> ramp_distance(1_000_000, 5_000_000, 20, Shape.CONSTANT) / PICO  # chapter 2's example: 600 steps
    Fraction(600, 1)
    """
    if isinstance(shape, Jerk):
        return ramp_time(FINE * abs(to_msps - from_msps), rate_spmss, shape) * (from_msps + to_msps) / 2
    speed_squares = abs(to_msps * to_msps - from_msps * from_msps)
    return Fraction(500 * shape.numerator * speed_squares, shape.denominator * rate_spmss)


def stopping_distance(speed_msps: int, start_sps: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
    """Return the length of the ramp down to the starting speed, in picosteps, rounded up.

    >>> stopping_distance(5_000_000, 1000, 10, Shape.CONSTANT) // PICO  # chapter 2's example: 1200 steps
    1200

    Args:
        speed_msps: current speed, in 1e-3 step/s; at or below the starting speed a stop has no ramp.
        deceleration_spmss: programmed deceleration in steps/ms/s, above 0.
    """
    if speed_msps <= start_sps * MILLI:
        return 0
    return ceil(ramp_distance(speed_msps, start_sps * MILLI, deceleration_spmss, shape))
