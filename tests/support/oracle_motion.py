"""Motion for the oracle of the 3601, in floats: chapter 2 of the manual, written out plainly.

A course is a list of pieces. In each the acceleration is constant or changes at
a constant rate, which is all that the three shapes need [chapter 4, Acceleration Types]:

    constant       one piece at the programmed rate
    triangular S   half of the time from 0 up to that rate, half of it down to 0
    trapezoidal S  a quarter up, half at the rate, a quarter down

so the times are 1, 2 and 4/3 of (Vs - Vo) / a [chapter 2].

Steps, seconds, steps/s. Programmed rates are in steps/ms/s, so they are multiplied by 1000.
"""

from __future__ import annotations

from math import ceil, floor, inf, sqrt

CONSTANT, TRIANGULAR, TRAPEZOIDAL = "constant", "triangular", "trapezoidal"
STRETCH = {CONSTANT: 1.0, TRIANGULAR: 2.0, TRAPEZOIDAL: 4.0 / 3.0}

NUDGE = 1e-8
"""Steps by which a float may fall short of the whole step that it means."""

ROUNDED_S = 5e-9
"""Seconds to which the integers of the module under test may have rounded the time of a ramp."""

JITTER = 1e-9
"""Seconds by which a float may fall short of the instant that it means."""

UP, LEVEL, DOWN = 1, 0, -1


class Piece:
    """A stretch of time in which the acceleration goes from `a0` to `a1`."""

    def __init__(self, seconds, speed, a0=0.0, a1=0.0, ramp=LEVEL):
        self.seconds = seconds
        self.speed = speed
        self.a0 = a0
        self.jerk = (a1 - a0) / seconds
        self.ramp = ramp

    def travel(self, u):
        return self.speed * u + self.a0 * u * u / 2 + self.jerk * u * u * u / 6

    def speed_at(self, u):
        return self.speed + self.a0 * u + self.jerk * u * u / 2


def ramp(v0, v1, rate, shape):
    """Pieces from speed v0 to v1; the programmed rate is the greatest acceleration on the way."""
    if abs(v1 - v0) < 1e-6:
        return []
    a = 1000.0 * rate if v1 > v0 else -1000.0 * rate
    sense = UP if v1 > v0 else DOWN
    seconds = STRETCH[shape] * (v1 - v0) / a
    if shape == CONSTANT:
        parts = [(1.0, a, a)]
    elif shape == TRIANGULAR:
        parts = [(0.5, 0.0, a), (0.5, a, 0.0)]
    else:
        parts = [(0.25, 0.0, a), (0.5, a, a), (0.25, a, 0.0)]
    pieces = []
    speed = v0
    for share, a0, a1 in parts:
        piece = Piece(share * seconds, speed, a0, a1, sense)
        speed = piece.speed_at(piece.seconds)
        pieces.append(piece)
    return pieces


def ramp_distance(v0, v1, rate, shape):
    """Da = Ta * (Vo + Vs) / 2, with the longer times of S-curves [chapter 2; reading A-79]."""
    if v1 == v0:
        return 0.0  # whatever the rate, which a motion at the starting speed may lack
    return STRETCH[shape] * abs(v1 - v0) / (1000.0 * rate) * (v0 + v1) / 2


def cruise(steps, speed):
    if steps == inf:
        return [Piece(inf, speed)]
    if steps <= 1e-9:
        return []
    return [Piece(steps / speed, speed)]


class Course:
    """Pieces one after the other from `began_ns` on, `travelled` steps lying behind."""

    def __init__(self, began_ns, pieces, travelled=0.0):
        self.began_ns = began_ns
        self.rows = []
        t, x = 0.0, float(travelled)
        for piece in pieces:
            self.rows.append((t, x, piece))
            t += piece.seconds
            if piece.seconds < inf:
                x += piece.travel(piece.seconds)
        self.seconds = t
        self.last_step = x

    def at(self, now_ns):
        """Steps travelled (a float), speed, ramp and whether it is all over, at this instant."""
        t = (now_ns - self.began_ns) * 1e-9
        if t >= self.seconds - JITTER:
            return self.last_step, 0.0, LEVEL, True
        for start, x, piece in self.rows:
            u = t - start
            if u < piece.seconds - JITTER or piece.seconds == inf:
                u = max(u, 0.0)
                return x + piece.travel(u), piece.speed_at(u), piece.ramp, False
        raise AssertionError("a course without a piece for this instant")

    def only_brakes_from(self, now_ns):
        """Whether nothing but deceleration is left."""
        t = (now_ns - self.began_ns) * 1e-9
        return all(piece.ramp == DOWN for start, _, piece in self.rows if start + piece.seconds > t + JITTER)

    def is_on_one_piece(self, now_ns, later_ns):
        """Whether one and the same piece has both instants, with neither close to its end."""
        t, later = (now_ns - self.began_ns) * 1e-9, (later_ns - self.began_ns) * 1e-9
        return any(start <= t and later < start + piece.seconds - 1e-6 for start, _, piece in self.rows)


def whole(x):
    """Whole steps: the last one that has been made."""
    return floor(x + NUDGE)


def is_close_call(x, v):
    """Whether rounding decides if the next whole step has been made; exactly on it, it does not."""
    return NUDGE < abs(x - round(x)) < NUDGE + v * ROUNDED_S


def move(now_ns, steps, vo, vs, acceleration, deceleration, shape):
    """A move of so many steps: trapezoidal, or triangular if there is no room for both ramps."""
    up = ramp_distance(vo, vs, acceleration, shape)
    down = ramp_distance(vo, vs, deceleration, shape)
    if up + down > steps:
        inverse = 1 / (1000.0 * acceleration) + 1 / (1000.0 * deceleration)
        vs = sqrt(vo * vo + 2 * steps / (STRETCH[shape] * inverse))
        up = ramp_distance(vo, vs, acceleration, shape)
        down = ramp_distance(vo, vs, deceleration, shape)
    pieces = ramp(vo, vs, acceleration, shape)
    pieces += cruise(steps - up - down, vs)
    pieces += ramp(vs, vo, deceleration, shape)
    return Course(now_ns, pieces)


def run(now_ns, vo, vs, acceleration, shape):
    """From the starting speed to the programmed one, and on at it; at or below Vo without a ramp."""
    pieces = ramp(vo, vs, acceleration, shape) if vs > vo else []
    return Course(now_ns, pieces + cruise(inf, vs))


def change(course, now_ns, vs, acceleration, deceleration, shape):
    """From the present speed to another one, and on at it."""
    x, v, _, _ = course.at(now_ns)
    rate = acceleration if vs > v else deceleration
    return Course(now_ns, ramp(v, vs, rate, shape) + cruise(inf, vs), x)


def stop(course, now_ns, vo, deceleration, shape):
    """A controlled stop: on at the present speed for less than a step, then the ramp to Vo.

    It ends on the first whole step on which it can end. Below the starting speed it ends at once.
    """
    x, v, _, _ = course.at(now_ns)
    if v < vo - 1e-6:
        return Course(now_ns, [], whole(x))
    way = ramp_distance(vo, v, deceleration, shape)
    last = ceil(x + way - NUDGE)
    return Course(now_ns, cruise(last - x - way, v) + ramp(v, vo, deceleration, shape), x)


def register(course, now_ns, steps, vo, deceleration, shape):
    """So many steps more, deceleration included: on at the present speed, then the ramp to Vo.

    If a step is under way and all of them are needed to stop in, the ramp is shorter by that fraction.
    """
    x, v, _, _ = course.at(now_ns)
    way = ramp_distance(vo, v, deceleration, shape) if v > vo else 0.0
    left = whole(x) + max(steps, ceil(way - NUDGE)) - x
    rate = deceleration * max(1.0, way / left)
    pieces = ramp(v, vo, rate, shape) if v > vo else []
    return Course(now_ns, cruise(left - way, v) + pieces, x)


def blend(now_ns, vo, segments, final_deceleration, final_shape):
    """Each segment ramps from the speed of the one before and goes on at its own; the last one also stops."""
    pieces = []
    speed = vo
    for index, (length, vs, rate, shape) in enumerate(segments):
        way = ramp_distance(speed, vs, rate, shape)
        pieces += ramp(speed, vs, rate, shape)
        if index < len(segments) - 1:
            pieces += cruise(length - way, vs)
        else:
            way += ramp_distance(vs, vo, final_deceleration, final_shape)
            pieces += cruise(length - way, vs) + ramp(vs, vo, final_deceleration, final_shape)
        speed = vs
    return Course(now_ns, pieces)
