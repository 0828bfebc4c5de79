"""Converts a profile of the 3601 to the words of a drive.

starting speed  from the drive's configuration; no motion is slower
speed, rates    the same, in the same units
S-curve         a jerk J: the rate takes 100/J s to reach its peak. A ramp that takes `full` s at its peak
rate
                takes 2 full as a triangle and 4/3 full as a trapezoid, so 100/J = full, or full/3

The jerk is a whole number, and the same jerk applies to both ramps [SMD p. 46].
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from ....kinematics import Jerk, Profile, Shape
from ...amci3601.axis_protocol import BlendProgram

JERK_MAX = 5_000

FULL_PER_RISE = {Shape.TRIANGULAR: 1, Shape.TRAPEZOIDAL: 3}
"""The duration that the ramp would have at its peak rate, divided by the time in which the rate rises."""


@dataclass(frozen=True, slots=True)
class DriveProfile:
    """A motion in the drive's terms: speeds in steps/s, rates in steps/ms/s.

    Attributes:
        jerk: 1 to 5,000; 0 for constant rates.
        program: the program of a blend move, otherwise None.
    """

    start_sps: int
    max_sps: int
    acceleration: int
    deceleration: int
    jerk: int = 0
    program: BlendProgram | None = None

    @property
    def profile(self) -> Profile:
        """The profile that the drive runs."""
        shape = Jerk(self.jerk) if self.jerk else Shape.CONSTANT
        return Profile(self.start_sps, self.max_sps, self.acceleration, self.deceleration, shape)


def exact_jerk(profile: Profile) -> Fraction:
    """Return the jerk of a profile's S-curve, the lower one of its two ramps; 0 if it has no S-curve.

    >>> exact_jerk(Profile(1000, 11_000, 100, 100, Shape.TRAPEZOIDAL))
    Fraction(3000, 1)
    """
    if not profile.has_ramps or profile.shape not in FULL_PER_RISE:
        return Fraction(0)
    rate = min(profile.acceleration_spmss, profile.deceleration_spmss)
    full_s = Fraction(profile.speed_sps - profile.start_sps) / (1000 * Fraction(rate))
    assert isinstance(profile.shape, Shape)
    return 100 * FULL_PER_RISE[profile.shape] / full_s


def jerk_is_exact(profile: Profile) -> bool:
    """Return whether the drive runs a profile's S-curve as a 3601 does."""
    jerk = exact_jerk(profile)
    rates_fit = jerk == 0 or profile.acceleration_spmss == profile.deceleration_spmss
    return rates_fit and jerk.denominator == 1 and jerk <= JERK_MAX


def drive_profile(profile: Profile, start_sps: int) -> DriveProfile:
    """Convert a profile; a jerk is rounded down, to a gentler value.

    Args:
        start_sps: starting speed in the drive's configuration; motions that would be slower run at this
            speed.

    >>> drive_profile(Profile(1000, 4000, 20, 10, Shape.TRIANGULAR), 1000)
    DriveProfile(start_sps=1000, max_sps=4000, acceleration=20, deceleration=10, jerk=333, program=None)
    """
    speed = max(start_sps, profile.speed_sps)
    if not profile.has_ramps:
        return DriveProfile(start_sps, speed, 1, 1)
    jerk = min(JERK_MAX, int(exact_jerk(profile)))
    up_rate, down_rate = int(profile.acceleration_spmss), int(profile.deceleration_spmss)
    return DriveProfile(start_sps, speed, up_rate, down_rate, jerk)


Segment = tuple[int, int, int, int]
"""Steps, speed in steps/s, acceleration and deceleration in steps/ms/s."""


def segments_of(program: BlendProgram, start_sps: int) -> list[Segment]:
    """Return a blend program as the drive's segments; constant rates only.

    A drive ramps down into and out of its last segment at one rate. If the 3601's program has two rates, the
    last segment is split after the first ramp.

    >>> program = BlendProgram(((1000, 4000, 20, Shape.CONSTANT), (1000, 2000, 20, Shape.CONSTANT)), 40,
    ...                        Shape.CONSTANT)
    >>> segments_of(program, 1000)
    [(1000, 4000, 20, 20), (300, 2000, 20, 20), (700, 2000, 20, 40)]
    """
    legs = [(length, speed, int(rate), int(rate)) for length, speed, rate, _ in program.segments]
    length, speed, rate, _ = legs.pop()
    speed_before = legs[-1][1] if legs else start_sps
    if speed < speed_before and rate != program.final_deceleration:
        ramp_steps = -(-(speed_before**2 - speed**2) // (2000 * rate))  # rounded up
        legs.append((ramp_steps, speed, rate, rate))
        length -= ramp_steps
    return [*legs, (length, speed, rate, program.final_deceleration)]
