"""The manual's arithmetic in fractions, beside the motions: the same to the last digit.

The oracle knows phases of constant jerk and nothing else: a ramp of time T = k*dv/a rises to the
rate a and falls again (not at all, at once, or with a constant half), from the manual's factors
[chapter 2]; integrated exactly with `Fraction`. Units are steps and seconds.
"""

from __future__ import annotations

from fractions import Fraction
from math import ceil

from hypothesis import assume, given
from hypothesis import strategies as st
from scanrack.runtime.kinematics import MILLI, PICO, Profile, Shape, change_speed, move, run, stop

NS = Fraction(1, 10**9)
EVER = Fraction(10**9)
Phase = tuple[Fraction, Fraction, Fraction]
"""Duration, rate at its begin, jerk."""

speeds = st.sampled_from([1, 1000, 5000, 1_000_000]) | st.integers(1, 1_000_000)
rates = st.sampled_from([1, 3, 7, 10, 20, 1999, 2000]) | st.integers(1, 2000)


def ramp_phases(dv: Fraction, rate_spmss: int | Fraction, shape: Shape) -> list[Phase]:
    """Return the phases of a ramp that changes the speed by dv at a peak rate."""
    a = Fraction(rate_spmss * 1000) * (1 if dv > 0 else -1)
    plain, zero = dv / a, Fraction(0)
    if shape is Shape.CONSTANT:
        return [(plain, a, zero)]
    if shape is Shape.TRIANGULAR:  # 2 Ta, half of it up, half of it down
        half = plain
        return [(half, zero, a / half), (half, a, -a / half)]
    quarter = plain * Fraction(4, 3) / 4  # 4/3 Ta, the constant portion 50 %
    return [(quarter, zero, a / quarter), (2 * quarter, a, zero), (quarter, a, -a / quarter)]


def integrate(speed: Fraction, phases: list[Phase], time: Fraction) -> tuple[Fraction, Fraction]:
    """Return position and speed after `time` of the phases."""
    position = Fraction(0)
    for duration, a, jerk in phases:
        t = min(duration, time)
        position += speed * t + a * t**2 / 2 + jerk * t**3 / 6
        speed += a * t + jerk * t**2 / 2
        time -= t
    return position, speed


def total(phases: list[Phase]) -> Fraction:
    """Return the time of phases one after the other."""
    return sum((phase[0] for phase in phases), Fraction(0))


@st.composite
def long_moves(draw: st.DrawFn) -> tuple[Profile, list[Phase], int]:
    """Draw a move that reaches its programmed speed, as a profile, as phases, and as a distance."""
    start = draw(speeds)
    shape = draw(st.sampled_from(Shape))
    profile = Profile(start, start + draw(speeds), draw(rates), draw(rates), shape)
    up = ramp_phases(Fraction(profile.speed_sps - start), profile.acceleration_spmss, shape)
    down = ramp_phases(Fraction(start - profile.speed_sps), profile.deceleration_spmss, shape)
    ramps = integrate(Fraction(start), up, EVER)[0]
    ramps += integrate(Fraction(profile.speed_sps), down, EVER)[0]
    distance = -(-ramps // 1) + draw(st.sampled_from([0, 1]) | st.integers(0, 8_000_000))
    cruise = (distance - ramps) / profile.speed_sps
    return profile, [*up, (cruise, Fraction(0), Fraction(0)), *down], int(distance)


@given(long_moves(), st.fractions(0, 1), st.sampled_from([1, 250_000, 2_000_000, 100_000_000]))
def test_a_move_is_where_the_arithmetic_is(
    case: tuple[Profile, list[Phase], int], part: Fraction, exchange_ns: int
) -> None:
    profile, phases, distance = case
    motion = move(0, 0, distance, profile)
    # at any ns, and at exchanges of the images, where a program looks
    t_ns = int(part * total(phases) / NS) // exchange_ns * exchange_ns
    position, speed = integrate(Fraction(profile.start_sps), phases, t_ns * NS)
    assert motion.travel_at(t_ns) == position * PICO // 1
    assert motion.steps_at(t_ns) == position // 1
    assert motion.speed_at(t_ns) == (speed * MILLI // 1 if t_ns * NS < total(phases) else 0)


@given(long_moves())
def test_a_move_takes_the_time_of_the_arithmetic(case: tuple[Profile, list[Phase], int]) -> None:
    profile, phases, distance = case
    assert move(0, 0, distance, profile).end_ns == ceil(total(phases) / NS)


@given(long_moves())
def test_the_ramps_take_the_time_of_the_arithmetic(case: tuple[Profile, list[Phase], int]) -> None:
    profile, phases, distance = case
    motion = move(0, 0, distance, profile)
    ramp = len(phases) // 2
    up_ns, down_ns = ceil(total(phases[:ramp]) / NS), ceil(total(phases[: ramp + 1]) / NS)
    assert (motion.ramp_at(up_ns - 1), motion.ramp_at(down_ns)) == (1, -1)
    if up_ns < down_ns:
        assert (motion.ramp_at(up_ns), motion.ramp_at(down_ns - 1)) == (0, 0)


@given(long_moves(), st.fractions(0, 1))
def test_a_stop_from_constant_speed_ends_where_the_arithmetic_says(
    case: tuple[Profile, list[Phase], int], part: Fraction
) -> None:
    profile, phases, distance = case
    motion = move(0, 0, distance, profile)
    ramp = len(phases) // 2
    now_ns = ceil((total(phases[:ramp]) + part * phases[ramp][0]) / NS)
    assume(motion.ramp_at(now_ns) == 0)
    held = stop(motion, now_ns, profile.start_sps, profile.deceleration_spmss, profile.shape)
    down = phases[ramp + 1 :]
    position, speed = integrate(Fraction(profile.start_sps), phases, now_ns * NS)
    stopped = position + integrate(speed, down, EVER)[0]
    assert held.final_steps == ceil(stopped)
    assert held.end_ns == now_ns + ceil(((ceil(stopped) - stopped) / speed + total(down)) / NS)


@given(
    *(speeds, speeds, rates, st.integers(1, 400)),
    *(speeds, rates, st.integers(1, 400), st.sampled_from(Shape)),
)
def test_a_speed_change_at_an_exchange_goes_as_the_arithmetic(
    start: int, more: int, rate: int, exchanges: int, new: int, new_rate: int, later: int, shape: Shape
) -> None:
    # a ramp of constant rate, changed at an exchange every 250 us, in the middle of it or after it
    now_ns, then_ns = 250_000 * exchanges, 250_000 * (exchanges + later)
    phases = [*ramp_phases(Fraction(more), rate, Shape.CONSTANT), (EVER, Fraction(0), Fraction(0))]
    position, speed = integrate(Fraction(start), phases, now_ns * NS)
    assume(speed != new)
    phases = [*ramp_phases(new - speed, new_rate, shape), (EVER, Fraction(0), Fraction(0))]
    position += integrate(speed, phases, (then_ns - now_ns) * NS)[0]
    running = run(0, 0, 1, Profile(start, start + more, rate, rate))
    changed = change_speed(running, now_ns, new, new_rate, new_rate, shape)
    assert changed.travel_at(then_ns) == position * PICO // 1
