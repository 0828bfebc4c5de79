"""Segments: parts of a motion in which travel is a single polynomial of time.

With u = t - start_ns and integers only:

    travel = floor((c3*u^3 + c2*u^2 + c1*u + c0) / q)     picosteps

    Segment     the rate changes, in the outer phases of an S-curve
    Quadratic   c3 = 0: constant rate
    Cruise      c3 = c2 = 0: constant speed

The coefficients represent every fraction in a profile exactly. A step occurs when travel reaches it. Because
floor(n/q) >= m is equivalent to n >= m*q, integer arithmetic also finds the instant of a step exactly.
"""

from __future__ import annotations

from fractions import Fraction
from math import gcd, isqrt

from typing_extensions import override

from .shape import PICO

Polynomial = tuple[int, int, int, int, int]
"""(c3, c2, c1, c0, q)"""

FOREVER = 1 << 100
"""End of an endless segment, in ns; later than any instant."""


class Segment:
    """A part of a motion, from `start_ns` up to but not including `until_ns`.

    Its methods accept instants from `start_ns` to `until_ns`, both included.

    Attributes:
        ramp: +1 when accelerating, -1 when decelerating, 0 at constant speed.
        c3: coefficient of u^3; c2, c1 and c0 are the coefficients of the lower powers.
        q: divisor of the polynomial, greater than 0.
    """

    __slots__ = (
        "_c0",
        "_c1",
        "_c2",
        "_c3",
        "_step",
        "c0",
        "c1",
        "c2",
        "c3",
        "q",
        "ramp",
        "start_ns",
        "until_ns",
    )

    def __init__(self, start_ns: int, until_ns: int, ramp: int, polynomial: Polynomial) -> None:
        self.start_ns = start_ns
        self.until_ns = until_ns
        self.ramp = ramp
        c3, c2, c1, c0, divisor = polynomial
        self.c3, self.c2, self.c1, self.c0, self.q = c3, c2, c1, c0, divisor
        # The same polynomial in steps, in the smallest numbers with the same floor, for the scan loop.
        step = divisor * PICO
        common = gcd(c3, c2, c1, step)
        self._c3, self._c2, self._c1, self._c0 = c3 // common, c2 // common, c1 // common, c0 // common
        self._step = step // common

    @property
    def end_ns(self) -> int | None:
        """`until_ns`, or None for an endless cruise."""
        return None if self.until_ns == FOREVER else self.until_ns

    def exact_travel_at(self, t_ns: int) -> Fraction:
        """Return the picosteps made since the motion began, unrounded."""
        elapsed = t_ns - self.start_ns
        return Fraction(((self.c3 * elapsed + self.c2) * elapsed + self.c1) * elapsed + self.c0, self.q)

    def exact_speed_at(self, t_ns: int) -> Fraction:
        """Return the speed in 1e-3 step/s, unrounded."""
        elapsed = t_ns - self.start_ns
        return Fraction((3 * self.c3 * elapsed + 2 * self.c2) * elapsed + self.c1, self.q)

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the motion began, rounded down."""
        elapsed = t_ns - self.start_ns
        return (((self.c3 * elapsed + self.c2) * elapsed + self.c1) * elapsed + self.c0) // self.q

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down."""
        elapsed = t_ns - self.start_ns
        return ((3 * self.c3 * elapsed + 2 * self.c2) * elapsed + self.c1) // self.q

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the motion began."""
        elapsed = t_ns - self.start_ns
        return (((self._c3 * elapsed + self._c2) * elapsed + self._c1) * elapsed + self._c0) // self._step

    @property
    def step(self) -> int:
        """The length of a step in the units of `terms`."""
        return self._step

    def terms(self, first_ns: int, every_ns: int) -> tuple[int, int, int, int]:
        """Return the travel at first_ns + k * every_ns as a polynomial of k, lowest power first.

        The polynomial divided by `step` and rounded down equals `steps_at`.
        """
        c3, c2, c1, c0, elapsed = self._c3, self._c2, self._c1, self._c0, first_ns - self.start_ns
        return (
            ((c3 * elapsed + c2) * elapsed + c1) * elapsed + c0,
            ((3 * c3 * elapsed + 2 * c2) * elapsed + c1) * every_ns,
            (3 * c3 * elapsed + c2) * every_ns**2,
            c3 * every_ns**3,
        )

    def instant_of(self, steps: int) -> int:
        """Return the first instant at which a number of steps is made.

        This is Newton's method in integers. The curve bends only one way, so the method converges from one
        side. The bracket (low, high] makes it end on the first u that reaches the travel.

        Args:
            steps: number of steps, not yet reached at `start_ns` and reached by `until_ns`.
        """
        c3, c2, c1 = self._c3, self._c2, self._c1
        target_travel = steps * self._step - self._c0
        low, high = 0, self.until_ns - self.start_ns
        elapsed = self._guess(target_travel)
        while high - low > 1:
            elapsed = min(max(elapsed, low + 1), high - 1)
            excess = ((c3 * elapsed + c2) * elapsed + c1) * elapsed - target_travel
            if excess >= 0:
                high = elapsed
            else:
                low = elapsed
            elapsed -= excess // ((3 * c3 * elapsed + 2 * c2) * elapsed + c1)
        return self.start_ns + high

    def _guess(self, target_travel: int) -> int:
        """Estimate the u that reaches a travel: the lowest u at which a single term reaches it."""
        guess = target_travel // self._c1
        if self._c2 > 0:
            guess = min(guess, isqrt(target_travel // self._c2))
        if self._c3 > 0:
            guess = min(guess, 2 << (target_travel // self._c3).bit_length() // 3)
        return guess


class Quadratic(Segment):
    """A segment of constant rate: a constant-rate ramp, or the middle of a trapezoidal S-curve."""

    __slots__ = ()

    @override
    def steps_at(self, t_ns: int) -> int:
        elapsed = t_ns - self.start_ns
        return ((self._c2 * elapsed + self._c1) * elapsed + self._c0) // self._step

    @override
    def instant_of(self, steps: int) -> int:
        """Return the first instant at which a number of steps is made.

        u is the root of c2*u^2 + c1*u = travel. The form 2*travel / (c1 + sqrt(c1^2 + 4*c2*travel)) is exact
        for small c2. The integer square root makes u less than 0.5 ns too late, and the integer division less
        than 1 ns too early, so u is the instant or one ns before it.
        """
        c2, c1 = self._c2, self._c1
        target_travel = steps * self._step - self._c0
        high = self.until_ns - self.start_ns
        root = isqrt(max(0, c1 * c1 + 4 * c2 * target_travel))
        elapsed = min(2 * target_travel // (c1 + root), high)
        if elapsed < high and (c2 * elapsed + c1) * elapsed < target_travel:
            elapsed += 1
        return self.start_ns + elapsed


class Cruise(Segment):
    """A segment of constant speed.

    >>> cruise = Cruise(100, FOREVER, 0, (0, 0, 5_000_000, 0, 1))
    >>> cruise.steps_at(1_000_000_100), cruise.instant_of(5000), cruise.end_ns
    (5000, 1000000100, None)
    """

    __slots__ = ()

    @override
    def steps_at(self, t_ns: int) -> int:
        return (self._c1 * (t_ns - self.start_ns) + self._c0) // self._step

    @override
    def instant_of(self, steps: int) -> int:
        return self.start_ns - (self._c0 - steps * self._step) // self._c1


def segment(start_ns: int, until_ns: int, ramp: int, polynomial: Polynomial) -> Segment:
    """Return the simplest kind of segment for a polynomial; arguments as for `Segment`."""
    c3, c2, *_ = polynomial
    if c3:
        return Segment(start_ns, until_ns, ramp, polynomial)
    return (Quadratic if c2 else Cruise)(start_ns, until_ns, ramp, polynomial)
