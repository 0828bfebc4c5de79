"""Conversion of a 3601 profile to the PCL601's registers.

    starting speed  base speed, steps/s; one less than the speed if the speed is not above it
    speed           maximum speed, steps/s
    rates           acceleration, steps/s/s: 1000 per step/ms/s, of the lower of the two
    S-curve         the constant rate with the same ramp time: 1/2 (triangular), 3/4 (trapezoidal)

Nothing is rounded: 1000 times a whole number is divisible by 2 and by 4.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from ....kinematics import Profile, Shape

STEPS_MAX = 8_388_607
SPEED_MAX = 50_000
BASE_MAX = 5_000
WITHOUT_RAMP = 9_999_999
"""Acceleration of a motion whose speed is one step/s above its base speed."""


@dataclass(frozen=True, slots=True)
class Drive:
    """Speeds and acceleration in the device's registers."""

    base_sps: int  # speed at which a motion begins and ends
    max_sps: int  # above the base speed
    accel_sps2: int  # acceleration of both ramps, steps/s/s

    @property
    def rate_spmss(self) -> Fraction:
        """The acceleration in steps/ms/s."""
        return Fraction(self.accel_sps2, 1000)

    @property
    def profile(self) -> Profile:
        """The profile that the device runs."""
        return Profile(self.base_sps, self.max_sps, self.rate_spmss, self.rate_spmss)


def drive_for(profile: Profile) -> Drive:
    """Convert a profile; its speed is 2 to 50,000 steps/s.

    >>> drive_for(Profile(1000, 5000, 20, 10, Shape.TRAPEZOIDAL))
    Drive(base_sps=1000, max_sps=5000, accel_sps2=7500)
    >>> drive_for(Profile(1000, 1000, 20, 20))
    Drive(base_sps=999, max_sps=1000, accel_sps2=9999999)
    """
    if not profile.has_ramps:
        return Drive(max(1, profile.speed_sps - 1), max(2, profile.speed_sps), WITHOUT_RAMP)
    assert isinstance(profile.shape, Shape)  # the words of a 3601 have no jerk
    rate = min(profile.acceleration_spmss, profile.deceleration_spmss) / profile.shape.factor
    return Drive(profile.start_sps, profile.speed_sps, int(1000 * rate))
