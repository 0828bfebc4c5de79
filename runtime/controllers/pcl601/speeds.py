"""The speed registers as kinematic profiles."""

from __future__ import annotations

from fractions import Fraction

from scanrack.io_images.pcl601 import Register

from ...kinematics import Motion, Profile, Shape, change_speed, creep, stop
from .register_values import Values


class Pcl601Speeds:
    """Base, maximum and jog speed, and acceleration; none of them changes during a motion."""

    def __init__(self, values: Values) -> None:
        self._values = values

    def fit(self, high: Register = Register.MAX_SPEED) -> bool:
        """Return whether the base speed is below the target speed, and all values are in range."""
        in_range = self._values.in_range(Register.BASE_SPEED, high, Register.ACCEL)
        return in_range and self.base_sps < self._values[high]

    @property
    def base_sps(self) -> int:
        """Base speed in steps/s."""
        return self._values[Register.BASE_SPEED]

    @property
    def jog_sps(self) -> int:
        """Jog speed in steps/s."""
        return self._values[Register.JOG_SPEED]

    @property
    def rate_spmss(self) -> Fraction:
        """Acceleration and deceleration in steps/ms/s; the register is in steps/s/s."""
        return Fraction(self._values[Register.ACCEL], 1000)

    def profile(self) -> Profile:
        """Return the profile of a motion that ramps up to maximum speed."""
        rate_spmss = self.rate_spmss
        return Profile(self.base_sps, self._values[Register.MAX_SPEED], rate_spmss, rate_spmss)

    def at_base(self) -> Profile:
        """Return the profile of a motion at base speed throughout."""
        return Profile(self.base_sps, self.base_sps, 0, 0)

    def change(self, motion: Motion, now_ns: int, speed_sps: int) -> Motion:
        """Plan a ramp to another speed, followed by constant speed."""
        rate_spmss = self.rate_spmss
        return change_speed(motion, now_ns, speed_sps, rate_spmss, rate_spmss, Shape.CONSTANT)

    def creep(self, motion: Motion, now_ns: int) -> Motion:
        """Plan a ramp down to base speed, followed by constant speed to the end of the motion."""
        return creep(motion, now_ns, self.base_sps, self.rate_spmss, Shape.CONSTANT)

    def stop(self, motion: Motion, now_ns: int) -> Motion:
        """Plan a ramp down to base speed, followed by standstill."""
        return stop(motion, now_ns, self.base_sps, self.rate_spmss, Shape.CONSTANT)
