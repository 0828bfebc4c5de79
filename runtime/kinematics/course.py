r"""A course: the segments of a motion during planning, in order of time.

A ramp consists of phases, in each of which travel is one polynomial. T is the
time of the ramp, and dv = v1 - v0. In a phase, z is the fraction of T before it,
u the time since its start, and w = u/T:

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

The last phase's end, here 72, is the unit of the table. A given jerk has the same three phases, with parts
that follow from its course (`phases_of`).

The rates are in dv/T: the peak is the programmed rate a, so T = k*dv/a with the
manual's k = 1, 2 and 4/3 [chapter 2]. The trapezoidal rate is constant for half
of the time [chapter 4, Acceleration Types].

Exact results are fractions of a ns and of a step. A course therefore counts time
in ticks, a fraction of a ns in which all phases so far are whole, and refines the
ticks for a new phase where needed. Nothing is rounded; a segment begins at the
first whole ns in its phase.

Speeds are in 1e-9 step/s here. The unit of travel is one unit of speed times one
tick: 1e-18 step divided by the scale, the number of ticks in a ns.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd, lcm

from .motion import Motion
from .segment import FOREVER, Polynomial, Segment, segment
from .shape import FINE, MILLI, PICO, AnyShape, Jerk, Rate, Shape

Phase = tuple[int, int, int, int, int, int]
"""A phase: start and end as parts of the ramp's time, then made, speed, rate, jerk."""

CONSTANT_RATE: tuple[Phase, ...] = ((0, 72, 0, 0, 36, 0),)

PHASES: dict[Shape, tuple[Phase, ...]] = {
    Shape.CONSTANT: CONSTANT_RATE,
    Shape.TRIANGULAR: ((0, 36, 0, 0, 0, 48), (36, 72, 6, 36, 72, -48)),
    Shape.TRAPEZOIDAL: ((0, 18, 0, 0, 0, 64), (18, 54, 1, 12, 48, 0), (54, 72, 19, 60, 48, -64)),
}


def phases_of(rising: Fraction) -> tuple[Phase, ...]:
    """Return the phases of a ramp whose rate rises in a fraction of its time, and falls in an equal one.

    With f that fraction, the peak rate is r = 1/(1 - f), and the rate grows by r/f.

    >>> parts = phases_of(Fraction(1, 4))
    >>> [[Fraction(part, parts[-1][1]) for part in phase] for phase in parts] == [
    ...     [Fraction(part, 72) for part in phase] for phase in PHASES[Shape.TRAPEZOIDAL]]
    True

    Args:
        rising: the fraction, above 0, up to 1/2.
    """
    rise, scale = rising, 1 / (1 - rising)
    rows = (
        (Fraction(0), rise, Fraction(0), Fraction(0), Fraction(0), scale / (6 * rise)),
        (rise, 1 - rise, scale * rise * rise / 6, scale * rise / 2, scale / 2, Fraction(0)),
        (
            1 - rise,
            Fraction(1),
            Fraction(1, 2) - rise + scale * rise * rise / 6,
            1 - scale * rise / 2,
            scale / 2,
            -scale / (6 * rise),
        ),
    )
    denominator = lcm(*(part.denominator for row in rows for part in row))
    scaled = [tuple(int(part * denominator) for part in row) for row in rows]
    return tuple((begin, end, c3, c2, c1, c0) for begin, end, c3, c2, c1, c0 in scaled if begin < end)


_NOTHING = Fraction(0)
_STEP = PICO * FINE


class Course:
    """The segments so far, and their end."""

    __slots__ = ("_start_ns", "now", "scale", "segments", "travel")

    def __init__(self, now_ns: int, travel: Fraction = _NOTHING) -> None:
        self._start_ns = now_ns
        self.scale = travel.denominator  # ticks in a ns
        self.now = now_ns * self.scale  # end of the segments, in ticks
        self.travel = travel.numerator  # travel at that end, in 1e-18 step divided by the scale
        self.segments: list[Segment] = []  # only segments that contain a whole ns

    def ramp(self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> None:
        """Append a speed change, up or down."""
        ticks, phases = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        self._ramp(from_nsps, to_nsps, ticks, phases)

    def cruise_to(self, steps: int, speed_nsps: int) -> None:
        """Append constant speed up to a number of whole steps."""
        self._cruise(steps * _STEP * self.scale - self.travel, speed_nsps)

    def cruise_over(self, steps: Fraction, speed_nsps: int) -> None:
        """Append constant speed over a length in steps, which need not be whole."""
        length = steps * _STEP
        self._refine(length.denominator // gcd(length.denominator, self.scale))
        self._cruise(int(length * self.scale), speed_nsps)

    def ramp_over(
        self, steps: Fraction, from_nsps: int, to_nsps: int, phases: tuple[Phase, ...] = CONSTANT_RATE
    ) -> None:
        """Append a speed change over a length in steps, which need not be whole.

        Its time follows from the length, `2 * length / (v0 + v1)`.
        """
        time_ns = 2 * steps * _STEP / (from_nsps + to_nsps)
        self._refine_to(phases[-1][1] * time_ns.denominator)
        self._ramp(from_nsps, to_nsps, int(time_ns * self.scale), phases)

    def steps_left(self, steps: int) -> Fraction:
        """Return the steps that remain to a number of whole steps."""
        return steps - Fraction(self.travel, _STEP * self.scale)

    def steps_to_stop(self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> int:
        """Return the first whole number of steps at which a ramp down that begins here or later can end."""
        ticks, _ = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        end = self.travel + (from_nsps + to_nsps) * ticks // 2
        return -(-end // (_STEP * self.scale))

    def arrive(self, steps: int, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape) -> None:
        """Append constant speed, then any ramp down, to an exact number of steps; shorten a longer ramp."""
        if from_nsps <= to_nsps:
            self.cruise_to(steps, from_nsps)
            return
        sum_nsps = from_nsps + to_nsps
        ticks, phases = self._ramp_ticks(from_nsps, to_nsps, rate_spmss, shape)
        self._cruise(steps * _STEP * self.scale - self.travel - sum_nsps * ticks // 2, from_nsps)
        travel_left = steps * _STEP * self.scale - self.travel
        ramp_divisor = 2 * sum_nsps if isinstance(shape, Shape) else sum_nsps * phases[-1][1]
        self._refine(ramp_divisor // gcd(ramp_divisor, travel_left))
        travel_left = steps * _STEP * self.scale - self.travel
        self._ramp(from_nsps, to_nsps, 2 * travel_left // sum_nsps, phases)

    def ended(self, direction: int, origin: int) -> Motion:
        """Return the course as a motion that ends with it."""
        standstill = segment(
            -(-self.now // self.scale), FOREVER, 0, (0, 0, 0, self.travel, self.scale * FINE)
        )
        return Motion(direction, origin, self._start_ns, self.segments, standstill)

    def endless(self, direction: int, origin: int, speed_nsps: int) -> Motion:
        """Return the course as a motion that continues at constant speed without end."""
        self._lay(self.now, FOREVER * self.scale, 0, (0, 0, speed_nsps, self.travel, 1))
        return Motion(direction, origin, self._start_ns, self.segments)

    def _refine(self, factor: int) -> None:
        self.scale *= factor
        self.now *= factor
        self.travel *= factor

    def _refine_to(self, denominator: int) -> None:
        """Refine the ticks so that a fraction of a ns with this denominator is whole."""
        self._refine(denominator // gcd(denominator, self.scale))

    def _ramp_ticks(
        self, from_nsps: int, to_nsps: int, rate_spmss: Rate, shape: AnyShape
    ) -> tuple[int, tuple[Phase, ...]]:
        """Return the time of a ramp in ticks, and its phases, which end on whole ticks."""
        if isinstance(shape, Jerk):
            if from_nsps == to_nsps:
                return 0, CONSTANT_RATE
            time_ns, rising = shape.course(abs(to_nsps - from_nsps), rate_spmss)
            self._refine_to(lcm(time_ns.denominator, (time_ns * rising).denominator))
            return int(time_ns * self.scale), phases_of(rising)
        dividend = shape.numerator * abs(to_nsps - from_nsps) * rate_spmss.denominator
        divisor = shape.denominator * rate_spmss.numerator * MILLI
        ticks_needed = 4 * divisor // gcd(4 * divisor, dividend)
        self._refine(ticks_needed // gcd(ticks_needed, self.scale))
        return dividend * self.scale // divisor, PHASES[shape]

    def _cruise(self, length: int, speed_nsps: int) -> None:
        """Append constant speed over a length in the unit of travel, if it is positive."""
        if length > 0:
            factor = speed_nsps // gcd(speed_nsps, length)
            self._refine(factor)
            end = self.now + length * factor // speed_nsps
            self._lay(self.now, end, 0, (0, 0, speed_nsps, self.travel, 1))
            self.now, self.travel = end, self.travel + length * factor

    def _ramp(self, from_nsps: int, to_nsps: int, ticks: int, phases: tuple[Phase, ...]) -> None:
        if ticks:
            change = to_nsps - from_nsps
            for phase in phases:
                begin, end = (self.now + ticks * bound // phases[-1][1] for bound in phase[:2])
                polynomial = _polynomial(phase, phases[-1][1], self.travel, from_nsps, change, ticks)
                self._lay(begin, end, 1 if change > 0 else -1, polynomial)
            self.now += ticks
            self.travel += (from_nsps + to_nsps) * ticks // 2

    def _lay(self, begin: int, end: int, ramp: int, polynomial: Polynomial) -> None:
        """Append a phase, given as a polynomial of the ticks since its start."""
        scale = self.scale
        start_ns, until_ns = -(-begin // scale), -(-end // scale)
        if start_ns < until_ns:
            late_ticks = start_ns * scale - begin
            self.segments.append(segment(start_ns, until_ns, ramp, _in_ns(polynomial, scale, late_ticks)))


def _polynomial(phase: Phase, whole: int, travel: int, from_nsps: int, change: int, ticks: int) -> Polynomial:
    """Return the travel in a phase of a ramp, by the formula above, as a polynomial of its ticks."""
    past_ticks, _, travel_made, speed, rate, jerk = phase
    square = ticks * ticks
    return (
        jerk * change,
        rate * change * ticks,
        (whole * from_nsps + speed * change) * square,
        (whole * travel + (past_ticks * from_nsps + travel_made * change) * ticks) * square,
        whole * square,
    )


def _in_ns(polynomial: Polynomial, scale: int, late: int) -> Polynomial:
    """Return the picosteps as a polynomial of the ns since `late` ticks after the phase began."""
    c3, c2, c1, c0, divisor = polynomial
    return (
        c3 * scale**3,
        (c2 + 3 * c3 * late) * scale**2,
        (c1 + (2 * c2 + 3 * c3 * late) * late) * scale,
        ((c3 * late + c2) * late + c1) * late + c0,
        divisor * scale * FINE,
    )
