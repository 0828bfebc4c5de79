"""A course: the segments of a motion while it is being planned, laid one after the other.

How a ramp from v0 to v1 becomes segments, with T its time, D its distance,
dv = v1 - v0, u from its start, w back from its end, m from its middle:

    constant      x = v0*u + dv*u^2/(2T)
    triangular    x = v0*u + (2/3)*dv*u^3/T^2                       first half
                  x = D - [v1*w - (2/3)*dv*w^3/T^2]                 second half
    trapezoidal   x = v0*u + (8/9)*dv*u^3/T^2                       first quarter
                  x = v0*T/2 + 7*dv*T/72 + m*(v0+v1)/2 + 2*dv*m^2/(3T)    middle half
                  x = D - [v1*w - (8/9)*dv*w^3/T^2]                 last quarter
"""

from __future__ import annotations

from .motion import Motion
from .segment import FOREVER, Cruise, Cubic, Quadratic, Segment
from .shape import Shape, ramp_time_ns


class Course:
    """Segments laid so far, and where they lead.

    Attributes:
        now_ns: end of the segments laid.
        travel: picosteps made there.
        segments: laid so far; none of zero length.
    """

    __slots__ = ("_start_ns", "now_ns", "segments", "travel")

    def __init__(self, now_ns: int, travel: int = 0) -> None:
        self._start_ns = now_ns
        self.now_ns = now_ns
        self.travel = travel
        self.segments: list[Segment] = []

    def ramp(self, from_msps: int, to_msps: int, rate_spmss: int, shape: Shape) -> None:
        """Lay a speed change, up or down."""
        self._ramp(from_msps, to_msps, ramp_time_ns(from_msps, to_msps, rate_spmss, shape), shape)

    def cruise_to(self, travel: int, speed_msps: int) -> None:
        """Lay constant speed up to a travel; the last fraction of a ns is left to the joint."""
        self._cruise((travel - self.travel) // speed_msps, speed_msps)
        self.travel = travel

    def arrive(self, travel: int, from_msps: int, to_msps: int, rate_spmss: int, shape: Shape) -> None:
        """Lay constant speed and a ramp down that ends exactly on a travel.

        A ramp that does not fit into what is left is run in the time that is left; with nothing
        to ramp, the ns in which the travel is reached counts as a whole one.
        """
        left = travel - self.travel
        time_ns = ramp_time_ns(from_msps, to_msps, rate_spmss, shape) if from_msps > to_msps else 0
        time_ns = min(time_ns, 2 * left // (from_msps + to_msps) & ~3)
        if time_ns:
            self.cruise_to(travel - (from_msps + to_msps) * time_ns // 2, from_msps)
            self._ramp(from_msps, to_msps, time_ns, shape)
        else:
            self._cruise(-(-left // from_msps), from_msps)
        self.travel = travel

    def ended(self, direction: int, origin: int) -> Motion:
        """Return the motion that ends where the course leads."""
        return Motion(direction, origin, self._start_ns, self.segments, self.travel)

    def endless(self, direction: int, origin: int, speed_msps: int) -> Motion:
        """Return the motion that goes on at constant speed without end."""
        self.segments.append(Cruise(self.now_ns, FOREVER, self.travel, speed_msps))
        return Motion(direction, origin, self._start_ns, self.segments, None)

    def _cruise(self, time_ns: int, speed_msps: int) -> None:
        if time_ns:
            self.segments.append(Cruise(self.now_ns, self.now_ns + time_ns, self.travel, speed_msps))
            self.now_ns += time_ns

    def _ramp(self, from_msps: int, to_msps: int, time_ns: int, shape: Shape) -> None:
        if time_ns:
            self.segments += _LAY[shape](self.now_ns, self.travel, from_msps, to_msps, time_ns)
            self.now_ns += time_ns
            self.travel += (from_msps + to_msps) * time_ns // 2


def _constant(t_ns: int, x: int, v0: int, v1: int, time: int) -> list[Segment]:
    dv, q = v1 - v0, 2 * time
    ramp = 1 if dv > 0 else -1
    return [Quadratic(t_ns, t_ns + time, ramp, t_ns, dv, q * v0, q * x, q)]


def _triangular(t_ns: int, x: int, v0: int, v1: int, time: int) -> list[Segment]:
    dv, q = v1 - v0, 3 * time * time
    ramp = 1 if dv > 0 else -1
    middle_ns, end_ns, end = t_ns + time // 2, t_ns + time, x + (v0 + v1) * time // 2
    return [
        Cubic(t_ns, middle_ns, ramp, t_ns, 2 * dv, q * v0, q * x, q),
        Cubic(middle_ns, end_ns, ramp, end_ns, -2 * dv, q * v1, q * end, q),
    ]


def _trapezoidal(t_ns: int, x: int, v0: int, v1: int, time: int) -> list[Segment]:
    dv, q, q2 = v1 - v0, 9 * time * time, 72 * time
    ramp = 1 if dv > 0 else -1
    first_ns, middle_ns, last_ns = (t_ns + n * time // 4 for n in (1, 2, 3))
    end_ns, end = t_ns + time, x + (v0 + v1) * time // 2
    middle_c0 = q2 * x + (36 * v0 + 7 * dv) * time * time
    return [
        Cubic(t_ns, first_ns, ramp, t_ns, 8 * dv, q * v0, q * x, q),
        Quadratic(first_ns, last_ns, ramp, middle_ns, 48 * dv, 36 * time * (v0 + v1), middle_c0, q2),
        Cubic(last_ns, end_ns, ramp, end_ns, -8 * dv, q * v1, q * end, q),
    ]


_LAY = {Shape.CONSTANT: _constant, Shape.TRIANGULAR: _triangular, Shape.TRAPEZOIDAL: _trapezoidal}
