"""Segments: stretches of a motion in which travel is one polynomial of time.

With u = t - anchor and everything an integer:

    Cruise       travel = x + v*u
    Quadratic    travel = floor((c2*u^2 + c1*u + c0) / q)     constant rate
    Cubic        travel = floor((c3*u^3 + c1*u + c0) / q)     rate from or to zero

A cubic is anchored where its rate is zero, at the outer end of an S-curve, so
it needs no term in u^2; in the second half of a ramp u is negative.

A step is made when travel reaches it. Because floor(n/q) >= m says the same as
n >= m*q, the instant of a step is found exactly, without a fraction.
"""

from __future__ import annotations

from math import gcd, isqrt

from .shape import PICO

FOREVER = 1 << 100
"""End of what never ends, in ns; later than any instant."""


class Segment:
    """A stretch of a motion, from `start_ns` up to, not including, `until_ns`.

    Attributes:
        start_ns: its first instant.
        until_ns: the instant at which the next one takes over; `FOREVER` for an endless cruise.
        ramp: +1 accelerating, -1 decelerating, 0 at constant speed.
    """

    __slots__ = ("ramp", "start_ns", "until_ns")

    def __init__(self, start_ns: int, until_ns: int, ramp: int) -> None:
        self.start_ns = start_ns
        self.until_ns = until_ns
        self.ramp = ramp

    @property
    def end_ns(self) -> int | None:
        """`until_ns`, or None for an endless cruise."""
        return None if self.until_ns == FOREVER else self.until_ns

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the motion began, for an instant within the segment."""
        raise NotImplementedError

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the motion began, for an instant within the segment."""
        raise NotImplementedError

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down, for an instant within the segment."""
        raise NotImplementedError

    def instant_of(self, steps: int) -> int:
        """Return the instant at which that many steps are made.

        They must not be made yet at `start_ns`, and must be at `until_ns`; the last ns belongs
        to the joint with the next segment, which may be a fraction of that ns ahead.
        """
        raise NotImplementedError


class Cruise(Segment):
    """Constant speed.

    >>> cruise = Cruise(100, FOREVER, 0, 5_000_000)
    >>> cruise.steps_at(1_000_000_100), cruise.instant_of(5000), cruise.end_ns
    (5000, 1000000100, None)

    Args:
        start_ns: its first instant.
        until_ns: its end.
        travel: picosteps made at `start_ns`.
        speed_msps: in 1e-3 step/s.
    """

    __slots__ = ("_c0", "_c1", "_step", "speed_msps", "travel")

    def __init__(self, start_ns: int, until_ns: int, travel: int, speed_msps: int) -> None:
        super().__init__(start_ns, until_ns, 0)
        self.travel = travel
        self.speed_msps = speed_msps
        common = gcd(speed_msps, PICO)  # floor((x + v*u) / step) in the shortest numbers
        self._c1 = speed_msps // common
        self._c0 = travel // common
        self._step = PICO // common

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the motion began."""
        return self.travel + self.speed_msps * (t_ns - self.start_ns)

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the motion began."""
        return (self._c0 + self._c1 * (t_ns - self.start_ns)) // self._step

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s."""
        return self.speed_msps

    def instant_of(self, steps: int) -> int:
        """Return the instant at which that many steps are made."""
        duration = -((self._c0 - steps * self._step) // self._c1)
        return min(self.start_ns + duration, self.until_ns)


class Quadratic(Segment):
    """Constant rate: a ramp of constant rate, or the middle of a trapezoidal S-curve.

    Args:
        start_ns: its first instant.
        until_ns: its end.
        ramp: +1 or -1.
        anchor_ns: the instant at which u is 0.
        c2: coefficient of u^2.
        c1: coefficient of u.
        c0: constant term.
        q: the divisor, greater than 0.
    """

    __slots__ = ("_steps_q", "anchor_ns", "c0", "c1", "c2", "q")

    def __init__(
        self, start_ns: int, until_ns: int, ramp: int, anchor_ns: int, c2: int, c1: int, c0: int, q: int
    ) -> None:
        super().__init__(start_ns, until_ns, ramp)
        common = gcd(c2, c1, c0, q)  # short numbers are quick numbers
        self.anchor_ns = anchor_ns
        self.c2 = c2 // common
        self.c1 = c1 // common
        self.c0 = c0 // common
        self.q = q // common
        self._steps_q = self.q * PICO

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the motion began."""
        u = t_ns - self.anchor_ns
        return ((self.c2 * u + self.c1) * u + self.c0) // self.q

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the motion began."""
        u = t_ns - self.anchor_ns
        return ((self.c2 * u + self.c1) * u + self.c0) // self._steps_q

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down."""
        return (2 * self.c2 * (t_ns - self.anchor_ns) + self.c1) // self.q

    def instant_of(self, steps: int) -> int:
        """Return the instant at which that many steps are made.

        The root of c2*u^2 + c1*u = goal in the form 2*goal / (c1 + sqrt(c1^2 + 4*c2*goal)), which
        loses nothing for small c2; the integer square root leaves it a ns off at most.
        """
        c2, c1 = self.c2, self.c1
        goal = steps * self._steps_q - self.c0
        root = isqrt(max(0, c1 * c1 + 4 * c2 * goal))
        low, high = self.start_ns - self.anchor_ns, self.until_ns - self.anchor_ns
        u = min(max(2 * goal // (c1 + root), low + 1), high)
        while u < high and (c2 * u + c1) * u < goal:
            u += 1
        while u > low + 1 and (c2 * (u - 1) + c1) * (u - 1) >= goal:
            u -= 1
        return self.anchor_ns + u


class Cubic(Segment):
    """Rate that grows from zero or falls to zero: the outer parts of an S-curve.

    Args:
        start_ns: its first instant.
        until_ns: its end.
        ramp: +1 or -1.
        anchor_ns: the instant at which u is 0, where the rate is zero: one of the segment's ends.
        c3: coefficient of u^3.
        c1: coefficient of u.
        c0: constant term.
        q: the divisor, greater than 0.
    """

    __slots__ = ("_steps_q", "anchor_ns", "c0", "c1", "c3", "q")

    def __init__(
        self, start_ns: int, until_ns: int, ramp: int, anchor_ns: int, c3: int, c1: int, c0: int, q: int
    ) -> None:
        super().__init__(start_ns, until_ns, ramp)
        common = gcd(c3, c1, c0, q)
        self.anchor_ns = anchor_ns
        self.c3 = c3 // common
        self.c1 = c1 // common
        self.c0 = c0 // common
        self.q = q // common
        self._steps_q = self.q * PICO

    def travel_at(self, t_ns: int) -> int:
        """Return the picosteps made since the motion began."""
        u = t_ns - self.anchor_ns
        return ((self.c3 * u * u + self.c1) * u + self.c0) // self.q

    def steps_at(self, t_ns: int) -> int:
        """Return the whole steps made since the motion began."""
        u = t_ns - self.anchor_ns
        return ((self.c3 * u * u + self.c1) * u + self.c0) // self._steps_q

    def speed_at(self, t_ns: int) -> int:
        """Return the speed in 1e-3 step/s, rounded down."""
        u = t_ns - self.anchor_ns
        return (3 * self.c3 * u * u + self.c1) // self.q

    def instant_of(self, steps: int) -> int:
        """Return the instant at which that many steps are made.

        Newton's method in integers. The curve bends one way only, so it converges from one side;
        the bracket (low, high] makes it end on the least u that has reached the goal.
        """
        c3, c1 = self.c3, self.c1
        goal = steps * self._steps_q - self.c0
        low, high = self.start_ns - self.anchor_ns, self.until_ns - self.anchor_ns
        u = self._guess(goal)
        while high - low > 1:
            u = min(max(u, low + 1), high - 1)
            bend = c3 * u * u
            excess = (bend + c1) * u - goal
            if excess >= 0:
                high = u
            else:
                low = u
            u -= excess // (3 * bend + c1)
        return self.anchor_ns + high

    def _guess(self, goal: int) -> int:
        """Return about the u at which c3*u^3 + c1*u is `goal`: by the greater of the two terms alone."""
        size = abs(goal)
        guess = size // self.c1
        if self.c3 > 0:
            guess = min(guess, 2 << (size // self.c3).bit_length() // 3)
        return guess if goal > 0 else -guess
