r"""A course: the segments of a motion that is being planned, in chronological order.

A ramp consists of phases; within a phase, travel is a single polynomial. T is the time of the ramp, and dv =
v1 - v0. z is the fraction of T before the phase, u the time since its start, and w = u/T:

    x = x0 + T*(v0*z + dv*made) + (v0 + dv*speed)*u + dv*T*(rate*w^2 + jerk*w^3)

    rate of the three shapes, over time            phases, in 72nds
                                             z from, to  made speed rate jerk
    constant      1    ______                   0    72    0    0    36    0
                  0    |    |

    triangular    2    /\                       0    36    0    0     0   48
                  0   /  \                     36    72    6   36    72  -48

    trapezoidal   4/3   ____                    0    18    0    0     0   64
                       /    \                  18    54    1   12    48    0
                  0   /      \                 54    72   19   60    48  -64

All columns are in fractions of the last phase's end, here 72. A ramp with a given jerk has the same three
phases with different numbers (`phases_of`).

The rates are in dv/T: the peak is the programmed rate a, so T = k*dv/a with the manual's k = 1, 2 and 4/3
[chapter 2]. The trapezoidal rate is constant for half the time [chapter 4, Acceleration Types].

Exact results are fractions of a ns and of a step. A course therefore counts time in ticks. A tick is a
fraction of a ns chosen so that every phase lasts a whole number of ticks. A new phase may need finer ticks.
Nothing is rounded; a segment begins at the first whole ns of its phase.

Speeds are in 1e-9 step/s here. The unit of travel is one unit of speed times one tick: 1e-18 step divided by
the scale, the number of ticks in a ns.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

from .motion import Motion
from .segment import FOREVER, Polynomial, Segment, segment
from .shape import FINE, MILLI, PICO, AnyShape, Jerk, Rate, Shape


class Phase(NamedTuple):
    """A row of the table above, in fractions of the last phase's end."""

    start: int
    end: int
    made: int
    speed: int
    rate: int
    jerk: int


CONSTANT_RATE = (Phase(0, 72, 0, 0, 36, 0),)

PHASES: dict[Shape, tuple[Phase, ...]] = {
    Shape.CONSTANT: CONSTANT_RATE,
    Shape.TRIANGULAR: (Phase(0, 36, 0, 0, 0, 48), Phase(36, 72, 6, 36, 72, -48)),
    Shape.TRAPEZOIDAL: (
        Phase(0, 18, 0, 0, 0, 64),
        Phase(18, 54, 1, 12, 48, 0),
        Phase(54, 72, 19, 60, 48, -64),
    ),
}


def phases_of(rising: Fraction) -> tuple[Phase, ...]:
    """Return the phases of a ramp whose rate rises and falls in the same fraction of the time.

    If f is this fraction, the peak rate is r = 1/(1 - f), and the rate grows by r/f.

    >>> parts = phases_of(Fraction(1, 4))
    >>> [[Fraction(part, parts[-1][1]) for part in phase] for phase in parts] == [
    ...     [Fraction(part, 72) for part in phase] for phase in PHASES[Shape.TRAPEZOIDAL]]
    True

    Args:
        rising: the fraction, above 0 and up to 1/2.
    """
    peak_rate, zero = 1 / (1 - rising), Fraction(0)
    made, speed = peak_rate * rising * rising / 6, peak_rate * rising / 2
    rate, jerk = peak_rate / 2, peak_rate / (6 * rising)
    rows = (
        (zero, rising, zero, zero, zero, jerk),
        (rising, 1 - rising, made, speed, rate, zero),
        (1 - rising, Fraction(1), Fraction(1, 2) - rising + made, 1 - speed, rate, -jerk),
    )
    denominator = lcm(*(part.denominator for row in rows for part in row))
    phases = [Phase(*(int(part * denominator) for part in row)) for row in rows]
    return tuple(phase for phase in phases if phase.start < phase.end)


_NOTHING = Fraction(0)
_STEP = PICO * FINE


class Course:
    """The segments of a motion that is being planned.

    Attributes:
        scale: ticks in a ns.
        end_ticks: end of the segments, in ticks.
        travel: travel at the end of the segments, in 1e-18 step divided by the scale.
        segments: segments that contain a whole ns.
    """

    __slots__ = ("_start_ns", "end_ticks", "scale", "segments", "travel")

    def __init__(self, now_ns: int, travel: Fraction = _NOTHING) -> None:
        self._start_ns = now_ns
        self.scale = travel.denominator
        self.end_ticks = now_ns * self.scale
        self.travel = travel.numerator
        self.segments: list[Segment] = []

    def ramp(self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> None:
        """Append a speed change, up or down."""
        ticks, phases = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        self._ramp(from_nsps, to_nsps, ticks, phases)

    def cruise_to(self, steps: int, speed_nsps: int) -> None:
        """Append travel at constant speed up to a whole number of steps."""
        self._cruise(steps * _STEP * self.scale - self.travel, speed_nsps)

    def cruise_over(self, steps: Fraction, speed_nsps: int) -> None:
        """Append travel at constant speed over a length in steps, which need not be whole."""
        length = steps * _STEP
        self._refine_to(length.denominator)
        self._cruise(int(length * self.scale), speed_nsps)

    def ramp_over(
        self, steps: Fraction, from_nsps: int, to_nsps: int, phases: tuple[Phase, ...] = CONSTANT_RATE
    ) -> None:
        """Append a speed change over a length in steps, which need not be whole.

        Its time follows from the length, `2 * length / (v0 + v1)`.
        """
        time_ns = 2 * steps * _STEP / (from_nsps + to_nsps)
        self._refine_to(phases[-1].end * time_ns.denominator)
        self._ramp(from_nsps, to_nsps, int(time_ns * self.scale), phases)

    def steps_left(self, steps: int) -> Fraction:
        """Return the distance, in steps, from the end of the segments to a whole number of steps."""
        return steps - Fraction(self.travel, _STEP * self.scale)

    def steps_to_stop(self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> int:
        """Return the first whole number of steps at which a ramp down from here on can end."""
        ticks, _ = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        end = self.travel + (from_nsps + to_nsps) * ticks // 2
        return -(-end // (_STEP * self.scale))

    def arrive(self, steps: int, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> None:
        """Append travel at constant speed and then a ramp down, ending exactly on a number of steps.

        A ramp that is too long is shortened.
        """
        if from_nsps <= to_nsps:
            self.cruise_to(steps, from_nsps)
            return
        sum_nsps = from_nsps + to_nsps
        ticks, phases = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        self._cruise(steps * _STEP * self.scale - self.travel - sum_nsps * ticks // 2, from_nsps)
        travel_left = steps * _STEP * self.scale - self.travel
        ramp_divisor = 2 * sum_nsps if isinstance(shape, Shape) else sum_nsps * phases[-1].end
        self._refine(ramp_divisor // gcd(ramp_divisor, travel_left))
        travel_left = steps * _STEP * self.scale - self.travel
        self._ramp(from_nsps, to_nsps, 2 * travel_left // sum_nsps, phases)

    def ended(self, direction: int, origin: int) -> Motion:
        """Return a motion that ends with the course."""
        end_ns = -(-self.end_ticks // self.scale)
        standstill = segment(end_ns, FOREVER, 0, (0, 0, 0, self.travel, self.scale * FINE))
        return Motion(direction, origin, self._start_ns, self.segments, standstill)

    def endless(self, direction: int, origin: int, speed_nsps: int) -> Motion:
        """Return a motion that continues at constant speed after the course and never ends."""
        self._append(self.end_ticks, FOREVER * self.scale, 0, (0, 0, speed_nsps, self.travel, 1))
        return Motion(direction, origin, self._start_ns, self.segments)

    def _refine(self, factor: int) -> None:
        """Divide every tick into a number of ticks."""
        self.scale *= factor
        self.end_ticks *= factor
        self.travel *= factor

    def _refine_to(self, denominator: int) -> None:
        """Refine the ticks so that 1/denominator of a ns is a whole number of ticks."""
        self._refine(denominator // gcd(denominator, self.scale))

    def _ramp_ticks(
        self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape
    ) -> tuple[int, tuple[Phase, ...]]:
        """Return the time of a ramp in ticks, and its phases; refine the ticks so that phases end on them."""
        if isinstance(shape, Jerk):
            if from_nsps == to_nsps:
                return 0, CONSTANT_RATE
            time_ns, rising = shape.course(abs(to_nsps - from_nsps), rate_spmss)
            self._refine_to(lcm(time_ns.denominator, (time_ns * rising).denominator))
            return int(time_ns * self.scale), phases_of(rising)
        dividend = shape.numerator * abs(to_nsps - from_nsps) * rate_spmss.denominator
        divisor = shape.denominator * rate_spmss.numerator * MILLI
        self._refine_to(4 * divisor // gcd(4 * divisor, dividend))  # the phases end on quarters
        return dividend * self.scale // divisor, PHASES[shape]

    def _cruise(self, length: int, speed_nsps: int) -> None:
        """Append travel at constant speed over a length in units of travel, if the length is positive."""
        if length > 0:
            factor = speed_nsps // gcd(speed_nsps, length)
            self._refine(factor)
            end = self.end_ticks + length * factor // speed_nsps
            self._append(self.end_ticks, end, 0, (0, 0, speed_nsps, self.travel, 1))
            self.end_ticks, self.travel = end, self.travel + length * factor

    def _ramp(self, from_nsps: int, to_nsps: int, ticks: int, phases: tuple[Phase, ...]) -> None:
        """Append the phases of a speed change that lasts a number of ticks; append nothing for 0 ticks."""
        if ticks:
            change, unit = to_nsps - from_nsps, phases[-1].end
            for phase in phases:
                begin = self.end_ticks + ticks * phase.start // unit
                end = self.end_ticks + ticks * phase.end // unit
                polynomial = _polynomial(
                    phase, unit, travel=self.travel, from_nsps=from_nsps, change=change, ticks=ticks
                )
                self._append(begin, end, 1 if change > 0 else -1, polynomial)
            self.end_ticks += ticks
            self.travel += (from_nsps + to_nsps) * ticks // 2

    def _append(self, begin: int, end: int, ramp: int, polynomial: Polynomial) -> None:
        """Append a phase from `begin` to `end` in ticks; its polynomial counts the ticks from `begin`."""
        scale = self.scale
        start_ns, until_ns = -(-begin // scale), -(-end // scale)
        if start_ns < until_ns:
            skipped = start_ns * scale - begin
            self.segments.append(segment(start_ns, until_ns, ramp, _in_ns(polynomial, scale, skipped)))


def _polynomial(
    phase: Phase, unit: int, *, travel: int, from_nsps: int, change: int, ticks: int
) -> Polynomial:
    """Return the travel in a phase of a ramp as a polynomial of its ticks, using the formula above.

    Args:
        unit: the end of the last phase.
        travel: travel at the beginning of the ramp.
        change: speed change in the ramp, in 1e-9 step/s, with sign.
        ticks: time of the ramp.
    """
    square = ticks * ticks
    return (
        phase.jerk * change,
        phase.rate * change * ticks,
        (unit * from_nsps + phase.speed * change) * square,
        (unit * travel + (phase.start * from_nsps + phase.made * change) * ticks) * square,
        unit * square,
    )


def _in_ns(polynomial: Polynomial, scale: int, skipped: int) -> Polynomial:
    """Convert a polynomial to picosteps over the ns after the first `skipped` ticks of a phase."""
    c3, c2, c1, c0, divisor = polynomial
    return (
        c3 * scale**3,
        (c2 + 3 * c3 * skipped) * scale**2,
        (c1 + (2 * c2 + 3 * c3 * skipped) * skipped) * scale,
        ((c3 * skipped + c2) * skipped + c1) * skipped + c0,
        divisor * scale * FINE,
    )
