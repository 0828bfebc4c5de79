r"""Courses of an ideal axis: speeds over time, as closed forms.

    speed   |      ______            a ramp takes  T = change / (rate * (1 - share))
            |     /      \           and goes      T * (begin + end) / 2
            |____/________\____ time

`share` is the fraction of a ramp's time during which the rate rises; it falls again during an equal fraction.
0 is a trapezoidal profile, and 0.5 is an S-curve of 100 % of time. A jerk in % of time is rate² / speed *
(200 / % - 1); it reaches the rate after %/200 of the ramp [MOTION-RM002, "Profile Operand"].

All results depend only on the time since the beginning, not on how often they are computed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Dynamics:
    """Speed and rates of a course, in units of the axis; all are finite and above 0."""

    speed: float  # units/s
    up: float  # acceleration, units/s²
    down: float  # deceleration, units/s²
    up_share: float = 0.0  # 0 to 0.5
    down_share: float = 0.0

    @property
    def allowed(self) -> bool:
        """Whether all numbers are in range."""
        return all(0 < rate < math.inf for rate in (self.speed, self.up, self.down))


class Phase(NamedTuple):
    """A ramp, or a stretch of constant speed."""

    seconds: float
    begin: float  # units/s, with its sign
    end: float
    share: float = 0.0


Phases = tuple[Phase, ...]


class Instant(NamedTuple):
    """The motion of an axis at a time in its course."""

    travel: float  # units since the beginning
    speed: float  # units/s
    rate: float  # mean acceleration of the present ramp, units/s²
    over: bool  # whether all phases are over; the last speed stays

    @property
    def change(self) -> int:
        """1 when accelerating, -1 when decelerating, else 0."""
        direction = self.speed or self.rate
        return (direction * self.rate > 0) - (direction * self.rate < 0)


REST = Instant(0.0, 0.0, 0.0, True)


def total(instants: Iterable[Instant]) -> Instant:
    """Superimpose motions by adding their travels, speeds and rates."""
    travels, speeds, rates, overs = zip(*instants, strict=True)
    return Instant(sum(travels), sum(speeds), sum(rates), all(overs))


def shares(rate: float, jerk: float, speed: float) -> tuple[float, float]:
    """Return the rate that a ramp to a speed can reach with a jerk in units/s³, and the ramp share.

    >>> shares(100.0, 1000.0, 20.0)  # 0.1 s of 0.3 s
    (100.0, 0.3333333333333333)
    >>> shares(100.0, 1000.0, 2.5)  # too short to reach the rate: 0.1 s in all, half of it rising
    (50.0, 0.5)
    """
    if rate * rate < jerk * speed:
        rising = rate / jerk
        return rate, rising / (speed / rate + rising)
    return math.sqrt(speed * jerk), 0.5


def ramp(begin: float, end: float, dynamics: Dynamics) -> Phases:
    """Return the ramps for a change of speed. If the speed passes through zero, two ramps are returned."""
    if begin * end < 0:
        return (*ramp(begin, 0.0, dynamics), *ramp(0.0, end, dynamics))
    if abs(end) > abs(begin):
        rate, share = dynamics.up, dynamics.up_share
    else:
        rate, share = dynamics.down, dynamics.down_share
    return (Phase(abs(end - begin) / (rate * (1 - share)), begin, end, share),) if begin != end else ()


def move(distance: float, speed: float, dynamics: Dynamics) -> Phases:
    """Return the phases of a move over a distance from a present speed.

    A move that overshoots because the speed is too high reverses to its goal.

    >>> [round(phase.seconds, 3) for phase in move(10.0, 0.0, Dynamics(5.0, 10.0, 5.0))]
    [0.5, 1.25, 1.0]
    """
    direction = 1.0 if distance >= 0 else -1.0
    stop = ramp(speed, 0.0, dynamics)
    stopping = length(stop)
    if speed * direction < 0 or abs(stopping) > abs(distance):
        return (*stop, *move(distance - stopping, 0.0, dynamics)) if speed else ()
    up, down = (  # length of the ramp from or to rest, divided by the square of the speed
        1 / (2 * rate * (1 - share))
        for rate, share in ((dynamics.up, dynamics.up_share), (dynamics.down, dynamics.down_share))
    )
    peak = dynamics.speed
    if abs(speed) < peak:
        peak = min(peak, math.sqrt((abs(distance) + speed * speed * up) / (up + down)))
    to_peak, to_rest = ramp(speed, direction * peak, dynamics), ramp(direction * peak, 0.0, dynamics)
    cruise = abs(distance) - abs(length(to_peak)) - abs(length(to_rest))
    if peak <= 0 or cruise <= 0:
        return (*to_peak, *to_rest)
    return (*to_peak, Phase(cruise / peak, direction * peak, direction * peak), *to_rest)


def length(phases: Phases) -> float:
    """Return the total travel of phases."""
    return sum(phase.seconds * (phase.begin + phase.end) / 2 for phase in phases)


def instant_at(phases: Phases, seconds: float, last: float = 0.0) -> Instant:
    """Return the motion at a time in seconds after the beginning.

    Args:
        last: the speed after the phases.
    """
    travel = 0.0
    for phase in phases:
        if seconds < phase.seconds:
            return _instant_in_phase(phase, travel, seconds)
        travel += phase.seconds * (phase.begin + phase.end) / 2
        seconds -= phase.seconds
    return Instant(travel + last * seconds, last, 0.0, True)


def _instant_in_phase(phase: Phase, travel: float, seconds: float) -> Instant:
    """Return the motion at a time in a phase; `travel` is the distance before the phase."""
    fraction = seconds / phase.seconds
    speed, travelled = _unit_ramp(fraction, phase.share)
    change = phase.end - phase.begin
    return Instant(
        travel + phase.seconds * (phase.begin * fraction + change * travelled),
        phase.begin + change * speed,
        change / phase.seconds,
        False,
    )


def _unit_ramp(time: float, share: float) -> tuple[float, float]:
    """Return the speed and travel, at a time of 0 to 1 s, of a ramp from speed 0 to 1 in 1 s."""
    if share <= 0:
        return time, time * time / 2
    if time > 0.5:
        speed, travelled = _unit_ramp(1 - time, share)
        return 1 - speed, time - 0.5 + travelled
    peak = 1 / (1 - share)
    if time < share:
        return peak * time * time / (2 * share), peak * time**3 / (6 * share)
    return peak * (time - share / 2), peak * (time * time - share * time + share * share / 3) / 2
