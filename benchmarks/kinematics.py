"""What motions cost: evaluating one, planning one, finding the instant of a step.

The floor is a bare loop that multiplies and divides integers of the same size,
`travel + speed * u` floored to steps, in the same run. Everything measured is
also checked: counts against chapter 2's arithmetic in fractions, ends against
the distance, instants by the steps made at them and 1 ns before.

    python benchmarks/kinematics.py            a table
    python benchmarks/kinematics.py --smoke    a short run that only checks
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from fractions import Fraction

from scanrack.runtime.kinematics import (
    PICO,
    Motion,
    Profile,
    Segment,
    Shape,
    blend,
    change_speed,
    move,
    register,
    run,
    stop,
)

SECOND = 10**9
DISTANCE = 8_000_000
RATES = {"round rates": (100, 50), "rates 7 and 11": (7, 11)}
MADE_HALF_WAY = {
    Shape.CONSTANT: Fraction(1, 8),
    Shape.TRIANGULAR: Fraction(1, 12),
    Shape.TRAPEZOIDAL: Fraction(7, 72),
}
"""What a change of speed adds to the travel by the middle of its ramp, in changes times the ramp's time."""
ROUNDS = 7


def per_call_ns(function: Callable[[int], object], arguments: Sequence[int], rounds: int) -> float:
    """Return the ns that a call takes, best of some rounds."""
    best = float("inf")
    for _ in range(rounds):
        start = time.perf_counter_ns()
        for argument in arguments:
            function(argument)
        best = min(best, time.perf_counter_ns() - start)
    return best / len(arguments)


def floor_ns(count: int, rounds: int) -> float:
    """Return the ns of one multiply, add, divide on integers of the size of a travel."""
    travel, speed = 600 * PICO, 100_000_000

    def steps(u: int) -> int:
        return (travel + speed * u) // PICO

    times = spread(0, 10 * SECOND, count)
    check(steps(SECOND), 600 + 100_000, "the floor's count")
    return per_call_ns(steps, times, rounds)


def spread(begin: int, end: int, count: int) -> list[int]:
    """Return so many instants, evenly from begin up to end."""
    return [begin + (end - begin) * n // count for n in range(count)]


def check(found: object, expected: object, what: str) -> None:
    """Stop the benchmark if it measured something wrong."""
    if found != expected:
        raise SystemExit(f"{what} is {found}, should be {expected}")


def check_motion(motion: Motion, profile: Profile) -> None:
    """Check a move's counts after half of its first ramp and in its cruise, and its end."""
    start, speed = profile.start_sps, profile.speed_sps
    assert isinstance(profile.shape, Shape)
    seconds = profile.shape.factor * (speed - start) / (1000 * profile.acceleration_spmss)
    half_ns = int(seconds * SECOND / 2)
    if half_ns * 2 == seconds * SECOND:
        made = start * seconds / 2 + (speed - start) * seconds * MADE_HALF_WAY[profile.shape]
        check(motion.steps_at(half_ns), made // 1, "the count half way up")
    later_ns = cruise_of(motion).start_ns + 12_345_678
    made = seconds * (start + speed) / 2 + speed * (Fraction(later_ns, SECOND) - seconds)
    check(motion.steps_at(later_ns), made // 1, "the count in the cruise")
    check(motion.end_ns is not None and motion.position_at(motion.end_ns), DISTANCE, "the end")


def cruise_of(motion: Motion) -> Segment:
    """Return the first segment at constant speed."""
    return next(segment for segment in motion.segments if segment.ramp == 0)


def measure_segment(motion: Motion, segment: Segment, count: int, rounds: int) -> tuple[float, float, float]:
    """Return the ns of a count by the segment, by the motion, and of the instant of a step."""
    times = spread(segment.start_ns, segment.until_ns, count)
    steps = sorted({segment.steps_at(t) + 1 for t in times[: -len(times) // 8 : 8]})
    for k in steps[:: len(steps) // 50 + 1]:
        instant = motion.instant_of(k)
        found = instant is not None and (motion.steps_at(instant), motion.steps_at(instant - 1))
        check(found, (k, k - 1), f"steps at and before the instant of step {k}")
    return (
        per_call_ns(segment.steps_at, times, rounds),
        per_call_ns(motion.position_at, times, rounds),
        per_call_ns(motion.instant_of, steps, rounds),
    )


def evaluations(profiles: dict[str, Profile], count: int, rounds: int, floor: float) -> None:
    """Print the cost of the kinds of segments in every profile, in ns."""
    print(f"{'ns':<46}" + "".join(f" {what:>8} ratio" for what in ("count", "position", "instant")))
    for name, profile in profiles.items():
        motion = move(0, 0, DISTANCE, profile)
        check_motion(motion, profile)
        segments = motion.segments[0], cruise_of(motion), motion.segments[-1]
        for what, segment in zip(("first ramp", "cruise", "last ramp"), segments, strict=True):
            costs = measure_segment(motion, segment, count, rounds)
            figures = "".join(f" {cost:>8.0f} {cost / floor:>5.1f}" for cost in costs)
            print(f"{f'{name}, {what}':<46}{figures}")


def plans_of(profile: Profile) -> dict[str, tuple[Callable[[int], Motion], int | None]]:
    """Return how each plan is made, `n` being one thing or another, and the steps that it has to make."""
    rates = up, down = int(profile.acceleration_spmss), int(profile.deceleration_spmss)
    start, shape = profile.start_sps, profile.shape
    running = run(0, 0, 1, profile)
    now_ns = running.segments[-1].start_ns + SECOND
    made = running.steps_at(now_ns)
    legs = [(2_000_000, 50_000, up, shape), (3_000_000, 100_000, up, shape), (3_000_000, 60_000, down, shape)]
    return {
        "move": (lambda n: move(n, 0, DISTANCE, profile), DISTANCE),
        "short move": (lambda n: move(n, 0, 777, profile), 777),
        "run": (lambda n: run(n, 0, 1, profile), None),
        "change of speed": (lambda n: change_speed(running, now_ns + n, 7000, *rates, shape), None),
        "stop": (lambda n: stop(running, now_ns + n, start, down, shape), None),
        "registration": (lambda n: register(running, now_ns, DISTANCE, start, down, shape), made + DISTANCE),
        "blend of 3": (lambda n: blend(n, 0, 1, start, legs, down, shape), DISTANCE),
    }


def plans(profiles: dict[str, Profile], count: int, rounds: int, floor: float) -> None:
    """Print the cost of every plan, in us, and check the steps that it makes."""
    print(f"\n{'us':<46} {'plan':>8} ratio")
    for name, profile in profiles.items():
        for what, (plan, steps) in plans_of(profile).items():
            if steps is not None:
                check(plan(0).final_steps, steps, f"the steps of a {what}")
            cost = per_call_ns(plan, range(count), rounds)
            print(f"{f'{name}, {what}':<46} {cost / 1000:>8.1f} {cost / floor:>5.0f}")


def main(arguments: Sequence[str]) -> None:
    """Run what was asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--smoke", action="store_true", help="a short run that only checks")
    given = parser.parse_args(arguments)
    count, rounds = (200, 1) if given.smoke else (4_000, ROUNDS)
    floor = floor_ns(count, 5 * rounds)
    print(f"floor: {floor:.0f} ns for a multiply, an add and a divide\n")
    profiles = {
        f"{name}, {shape.name.lower()}": Profile(1000, 100_000, *rates, shape)
        for name, rates in RATES.items()
        for shape in Shape
    }
    evaluations(profiles, count, rounds, floor)
    plans(profiles, max(count // 20, 2), rounds, floor)


if __name__ == "__main__":
    main(sys.argv[1:])
