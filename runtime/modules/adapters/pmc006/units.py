"""Conversion of a 3601 profile to the PMC006's parameters.

    starting speed  start and stop speed, steps/s; the speed itself if that is lower
    speed           maximum speed, steps/s; less for a move that is shorter than its ramps
    rates           coefficients 1 to 8: the largest rate of the table up to the programmed one
    S-curve         the ramps are always S-shaped

Coefficient 0 means no ramp, and is never sent.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import isqrt

from scanrack.io_images.pmc006.instructions import ACCELERATIONS_PPS2

from ....controllers.pmc006.ramps import Pmc006Speeds
from ....kinematics import Profile, Rate

START_MIN, START_MAX = 65, 30_000
SPEED_MAX = 256_000
RATE_MIN = 6
"""Lowest rate of the table, in steps/ms/s."""


def coefficient_for(rate_spmss: Rate, *, nearest: bool = False) -> int:
    """Return the coefficient for a programmed rate, which must be at least 6 steps/ms/s unless `nearest`.

    >>> [coefficient_for(rate) for rate in (6, 7, 10, 11, 15, 22, 28, 49, 78, 2000)]
    [8, 7, 7, 6, 5, 4, 3, 2, 1, 1]
    >>> [coefficient_for(rate, nearest=True) for rate in (1, 6, 9, 77)]
    [8, 8, 6, 1]
    """
    rate_pps2 = 1000 * Fraction(rate_spmss)
    coefficients = range(1, 9)  # from the highest rate to the lowest
    if nearest:
        return min(coefficients, key=lambda coefficient: abs(ACCELERATIONS_PPS2[coefficient] - rate_pps2))
    return next(coefficient for coefficient in coefficients if ACCELERATIONS_PPS2[coefficient] <= rate_pps2)


def speeds_for(profile: Profile, *, nearest: bool = False) -> Pmc006Speeds:
    """Convert a profile, whose speed must be 65 to 256,000 steps/s, to the device's speeds."""
    base = profile.base_sps
    if not profile.has_ramps:
        return Pmc006Speeds(base, base, base, 1, 1)  # no ramps, so the coefficients have no effect
    up_coefficient = coefficient_for(profile.acceleration_spmss, nearest=nearest)
    down_coefficient = coefficient_for(profile.deceleration_spmss, nearest=nearest)
    return Pmc006Speeds(base, profile.speed_sps, base, up_coefficient, down_coefficient)


def fitted(speeds: Pmc006Speeds, steps: int) -> Pmc006Speeds:
    """Return speeds whose ramps fit a number of steps; otherwise the device would steepen the ramps.

    >>> fitted(Pmc006Speeds(1000, 5000, 1000, 6, 6), 1500).max_sps  # 10460 steps/s/s: the peak at 750 steps
    4085
    """
    up_pps2, down_pps2 = ACCELERATIONS_PPS2[speeds.acceleration], ACCELERATIONS_PPS2[speeds.deceleration]
    inverse_rates = Fraction(1, up_pps2) + Fraction(1, down_pps2)
    peak_sps = isqrt(int(speeds.start_sps**2 + 2 * steps / inverse_rates))
    return replace(speeds, max_sps=max(speeds.start_sps, min(speeds.max_sps, peak_sps)))
