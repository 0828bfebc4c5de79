"""What holds for every motion: never backwards, exact at its end, steps at exactly their instants."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import pairwise
from operator import ne

import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scanrack.runtime.kinematics import (
    FOREVER,
    MILLI,
    PICO,
    Motion,
    Profile,
    Shape,
    blend,
    change_speed,
    check_blend,
    move,
    ramp_distance,
    register,
    run,
    single_step,
    stop,
    stopping_distance,
)

DAY_NS = 86_400 * 10**9
speeds = st.sampled_from([1, 2, 1000, 5000, 100_000, 999_999, 1_000_000]) | st.integers(1, 1_000_000)
rates = st.sampled_from([1, 3, 7, 10, 20, 1999, 2000]) | st.integers(1, 2000)
distances = st.sampled_from([1, 2, 3, 8_388_607, 8_388_608]) | st.integers(1, 8_388_608)
shapes = st.sampled_from(Shape)
directions = st.sampled_from([1, -1])
origins = st.integers(-(2**31), 2**31)
starts_ns = st.integers(0, DAY_NS)
profiles = st.builds(Profile, speeds, speeds, rates, rates, shapes)
moves = st.builds(
    lambda now, origin, direction, distance, profile: move(now, origin, direction * distance, profile),
    *(starts_ns, origins, directions, distances, profiles),
)
runs = st.builds(run, starts_ns, origins, directions, profiles)
single_steps = st.builds(single_step, starts_ns, origins, directions, speeds)


@st.composite
def blend_legs(draw: st.DrawFn) -> tuple[int, list[tuple[int, int, int, Shape]], int, Shape]:
    """Draw a starting speed, segments that their ramps fit in (often exactly), and the final ramp."""
    start = draw(st.sampled_from([1, 1000, 999_999]) | st.integers(1, 999_999))
    final_rate, final_shape = draw(rates), draw(shapes)
    count = draw(st.integers(2, 16))
    legs: list[tuple[int, int, int, Shape]] = []
    before = start
    for number in range(count):
        speed = draw(st.integers(start, 1_000_000).filter(partial(ne, before)))
        rate, shape = draw(rates), draw(shapes)
        needed = ramp_distance(MILLI * before, MILLI * speed, rate, shape)
        if number == count - 1:
            needed += stopping_distance(MILLI * speed, start, final_rate, final_shape)
        spare = draw(st.sampled_from([0, 0, 1, 5000]) | st.integers(0, 100_000))
        legs.append((max(1, int(-(-needed // PICO)) + spare), speed, rate, shape))
        before = speed
    return start, legs, final_rate, final_shape


@st.composite
def blends(draw: st.DrawFn) -> Motion:
    return blend(draw(starts_ns), draw(origins), draw(directions), *draw(blend_legs()))


def last_joint_ns(motion: Motion) -> int:
    """Return where the motion ends, or a while into its endless cruise."""
    return motion.end_ns if motion.end_ns is not None else motion.segments[-1].start_ns + 10**10


@st.composite
def instants(draw: st.DrawFn, motion: Motion, last_ns: int | None = None) -> int:
    """Draw an instant of a motion, at and about its joints for preference."""
    last = last_joint_ns(motion) if last_ns is None else last_ns
    joints = [segment.start_ns for segment in motion.segments] + [last]
    near_joints = st.builds(lambda joint, off: joint + off, st.sampled_from(joints), st.integers(-2, 2))
    instant = draw(near_joints | st.integers(motion.start_ns, last))
    return min(max(instant, motion.start_ns), last)


@st.composite
def running(draw: st.DrawFn) -> tuple[Motion, int]:
    """Draw a motion and an instant at which it still runs."""
    motion = draw(moves | runs | single_steps | blends())
    if motion.end_ns is None:
        return motion, draw(instants(motion))
    return motion, draw(instants(motion, motion.end_ns - 1))


@st.composite
def changed(draw: st.DrawFn) -> Motion:
    """Draw a motion that took over from another one, once or twice."""
    motion, now = draw(running())
    if draw(st.booleans()):
        motion = change_speed(motion, now, draw(speeds), draw(rates), draw(rates), draw(shapes))
        now = draw(instants(motion))
    if draw(st.booleans()):
        return stop(motion, now, draw(speeds), draw(rates), draw(shapes))
    start, rate, shape = draw(speeds), draw(rates), draw(shapes)
    needed = -(-stopping_distance(motion.speed_at(now), start, rate, shape) // PICO)
    return register(motion, now, draw(st.integers(max(1, needed), needed + 10_000)), start, rate, shape)


motions = moves | runs | single_steps | blends() | changed()


@given(motions)
def test_segments_follow_each_other_without_gap(motion: Motion) -> None:
    assert all(a.until_ns == b.start_ns for a, b in pairwise(motion.segments))
    assert all(segment.start_ns < segment.until_ns for segment in motion.segments)
    assert [segment.end_ns for segment in motion.segments][-1:] in ([], [motion.end_ns])
    if motion.segments:
        assert motion.segments[0].start_ns == motion.start_ns


@given(motions)
def test_travel_has_no_jump_at_a_joint(motion: Motion) -> None:
    # the joint itself is less than a ns before the instant at which the later segment takes over
    for before, after in pairwise(motion.segments):
        made = after.travel_at(after.start_ns) - before.travel_at(after.start_ns - 1)
        assert 0 <= made <= max(before.speed_at(after.start_ns - 1), after.speed_at(after.start_ns)) + 2


@pytest.mark.slow
@given(motions, st.data())
def test_travel_never_goes_back(motion: Motion, data: st.DataObject) -> None:
    times = sorted(data.draw(st.lists(instants(motion), min_size=2, max_size=12)))
    times += [times[-1] + 1, times[-1] + DAY_NS]
    travels = [motion.travel_at(t) for t in times]
    assert travels == sorted(travels)
    steps = [motion.steps_at(t) for t in times]
    assert steps == [travel // PICO for travel in travels]
    assert [motion.position_at(t) for t in times] == [motion.origin + motion.direction * k for k in steps]


@given(motions, st.data())
def test_speed_is_the_slope_of_travel(motion: Motion, data: st.DataObject) -> None:
    segment = data.draw(st.sampled_from(motion.segments or [motion.segment_at(0)]))
    assume(segment.until_ns - segment.start_ns > 1)
    t = data.draw(st.integers(segment.start_ns, min(segment.until_ns, segment.start_ns + DAY_NS) - 1))
    made = segment.travel_at(t + 1) - segment.travel_at(t)
    slopes = segment.speed_at(t), segment.speed_at(t + 1)
    assert min(slopes) - 1 <= made <= max(slopes) + 2  # speeds and travels are rounded down


@given(motions, st.data())
def test_the_instant_of_a_step_is_where_it_is_made(motion: Motion, data: st.DataObject) -> None:
    made = motion.steps_at(data.draw(instants(motion)))
    for k in (made, made + 1):
        instant = motion.instant_of(k)
        if motion.final_steps is not None and k > motion.final_steps:
            assert instant is None
            continue
        assert instant is not None
        assert motion.steps_at(instant) >= k
        assert instant == motion.start_ns or motion.steps_at(instant - 1) < k


@pytest.mark.slow
@given(motions, st.data())
def test_evaluation_does_not_depend_on_its_order(motion: Motion, data: st.DataObject) -> None:
    times = data.draw(st.lists(instants(motion), min_size=2, max_size=8))
    seen = {t: (motion.position_at(t), motion.speed_at(t), motion.ramp_at(t)) for t in times}
    for t in data.draw(st.permutations(times)):
        # a motion of its own for each instant, so that no other one was evaluated before
        rest = None if motion.end_ns is None else motion.segment_at(motion.end_ns)
        fresh = Motion(motion.direction, motion.origin, motion.start_ns, motion.segments, rest)
        assert (fresh.position_at(t), fresh.speed_at(t), fresh.ramp_at(t)) == seen[t]


@given(motions)
def test_standstill_from_the_end_on(motion: Motion) -> None:
    if motion.end_ns is None or motion.final_steps is None:
        assert motion.end_ns is motion.final_steps is None
        assert motion.segments[-1].until_ns == FOREVER
        return
    for t in (motion.end_ns, motion.end_ns + 1, motion.end_ns + 365 * DAY_NS):
        assert (motion.steps_at(t), motion.speed_at(t), motion.ramp_at(t)) == (motion.final_steps, 0, 0)
    assert motion.instant_of(motion.final_steps + 1) is None


@given(starts_ns, origins, directions, distances, profiles)
@example(0, 0, 1, 1, Profile(1, 1_000_000, 1, 2000))
@example(0, 0, 1, 1, Profile(1, 1_000_000, 2000, 1, Shape.TRIANGULAR))
@example(0, 0, -1, 8_388_608, Profile(1, 1_000_000, 2000, 1, Shape.TRAPEZOIDAL))
@example(0, 0, 1, 1, Profile(1_000_000, 1_000_000, 1, 1))
@example(0, 0, 1, 1, Profile(999_999, 1_000_000, 2000, 2000))
def test_a_move_ends_exactly_on_its_distance(
    now: int, origin: int, direction: int, distance: int, profile: Profile
) -> None:
    motion = move(now, origin, direction * distance, profile)
    assert motion.end_ns is not None
    assert motion.travel_at(motion.end_ns) == distance * PICO
    assert motion.position_at(motion.end_ns) == origin + direction * distance
    assert motion.position_at(motion.end_ns - 1) == origin + direction * (distance - 1)
    assert motion.instant_of(distance) == motion.end_ns
    assert motion.position_at(now) == origin


@given(profiles, distances)
def test_a_move_stays_between_its_two_speeds(profile: Profile, distance: int) -> None:
    motion = move(0, 0, distance, profile)
    ends = (t for segment in motion.segments for t in (segment.start_ns, segment.until_ns - 1))
    met = [motion.speed_at(t) for t in ends]
    assert min(met) >= min(profile.start_sps, profile.speed_sps) * MILLI
    assert max(met) <= profile.speed_sps * MILLI


@given(blend_legs(), starts_ns, directions)
def test_a_blend_ends_on_the_sum_of_its_lengths_and_meets_every_joint(
    legs: tuple[int, list[tuple[int, int, int, Shape]], int, Shape], now: int, direction: int
) -> None:
    motion = blend(now, 0, direction, *legs)
    lengths = [leg[0] for leg in legs[1]]
    assert motion.final_steps == sum(lengths)
    begins = {segment.start_ns for segment in motion.segments}
    joints = {motion.instant_of(sum(lengths[:number])) for number in range(len(lengths))}
    assert joints <= begins


@given(blend_legs())
def test_a_blend_segment_one_step_too_short_is_refused(
    legs: tuple[int, list[tuple[int, int, int, Shape]], int, Shape],
) -> None:
    start, segments, rate, shape = legs
    _, speed, own_rate, own_shape = segments[0]
    needed = ramp_distance(MILLI * start, MILLI * speed, own_rate, own_shape)
    short = -(-needed // PICO) - 1
    with pytest.raises(ValueError, match="blend segment 1 is"):
        check_blend(start, [(short, speed, own_rate, own_shape), *segments[1:]], rate, shape)


@given(running(), speeds, rates, shapes)
def test_a_stop_ends_on_the_first_whole_step_that_the_deceleration_allows(
    case: tuple[Motion, int], start: int, rate: int, shape: Shape
) -> None:
    motion, now = case
    held = stop(motion, now, start, rate, shape)
    assert (held.direction, held.origin, held.start_ns) == (motion.direction, motion.origin, now)
    assert held.travel_at(now) == motion.travel_at(now)
    assert held.end_ns is not None
    assert held.final_steps is not None
    speed = motion.speed_at(now)
    if speed < MILLI * start:
        assert (held.end_ns, held.final_steps) == (now, motion.steps_at(now))
        return
    # travel and speed are told rounded down, and a higher speed takes longer to stop
    soonest = motion.travel_at(now) + ramp_distance(speed, MILLI * start, rate, shape)
    latest = motion.travel_at(now) + 1 + ramp_distance(speed + 1, MILLI * start, rate, shape)
    assert soonest <= held.final_steps * PICO < latest + PICO
    assert held.steps_at(held.end_ns) == held.final_steps


@given(running(), rates, shapes, st.data())
def test_a_stop_never_exceeds_the_deceleration(
    case: tuple[Motion, int], rate: int, shape: Shape, data: st.DataObject
) -> None:
    motion, now = case
    start = data.draw(st.integers(1, motion.speed_at(now) // MILLI))
    held = stop(motion, now, start, rate, shape)
    ramp = [segment for segment in held.segments if segment.ramp]
    assume(ramp)
    assert all(segment.ramp == -1 for segment in ramp)
    begin, end = ramp[0].start_ns, ramp[-1].until_ns
    earlier, later = sorted(data.draw(st.tuples(*2 * [st.integers(begin, end - 1)])))
    drop = held.speed_at(earlier) - held.speed_at(later)
    # a rate of 1 is 0.001 thousandths of a step/s in a ns; the speeds are rounded down
    assert (drop - 1) * 1000 < max(1, rate * (later - earlier))


@given(speeds, st.integers(1, 1_000_000), distances, rates, rates, st.data())
def test_a_stop_during_the_final_deceleration_ends_on_the_same_step(
    start: int, more: int, distance: int, up: int, down: int, data: st.DataObject
) -> None:
    # with the same constant rate there is nothing to change (an S-curve would start anew)
    motion = move(0, 0, distance, Profile(start, start + more, up, down))
    ramp = motion.segments[-1]
    assume(ramp.ramp == -1)
    now = data.draw(st.integers(ramp.start_ns, ramp.until_ns - 1))
    assert stop(motion, now, start, down, Shape.CONSTANT).final_steps == distance


@given(running(), speeds, rates, shapes, st.integers(0, 20_000))
def test_a_registration_makes_its_steps_or_refuses(
    case: tuple[Motion, int], start: int, rate: int, shape: Shape, spare: int
) -> None:
    motion, now = case
    needed = -(-stopping_distance(motion.speed_at(now), start, rate, shape) // PICO)
    steps = max(1, needed) + spare
    ended = register(motion, now, steps, start, rate, shape)
    assert ended.final_steps == motion.steps_at(now) + steps
    assert ended.travel_at(now) == motion.travel_at(now)
    assert ended.instant_of(ended.final_steps) == ended.end_ns
    if needed:
        with pytest.raises(ValueError, match=f"must be {needed} or more"):
            register(motion, now, needed - 1, start, rate, shape)


@given(running(), speeds, rates, rates, shapes)
def test_a_speed_change_goes_on_from_where_the_motion_is(
    case: tuple[Motion, int], speed: int, up: int, down: int, shape: Shape
) -> None:
    motion, now = case
    before, after = motion.segment_at(now).exact_speed_at(now), speed * MILLI
    changed = change_speed(motion, now, speed, up, down, shape)
    assert changed.travel_at(now) == motion.travel_at(now)
    assert changed.end_ns is None
    cruise = changed.segments[-1]
    time = shape.factor * 1000 * abs(after - before) / (up if after > before else down)
    # up to the next whole ns; the speed before is rounded by 1e-9 step/s, which takes 0.002 ns at most
    assert -Fraction(2, 1000) <= cruise.start_ns - now - time < 1 + Fraction(2, 1000)
    assert (cruise.ramp, cruise.speed_at(cruise.start_ns)) == (0, after)
    assert {segment.ramp for segment in changed.segments[:-1]} <= {1 if after > before else -1}


@given(runs, st.integers(0, DAY_NS), st.integers(0, DAY_NS), rates, shapes)
def test_a_change_to_the_same_speed_changes_nothing(
    motion: Motion, into_ns: int, later_ns: int, rate: int, shape: Shape
) -> None:
    now = motion.segments[-1].start_ns + into_ns
    same = change_speed(motion, now, motion.speed_at(now) // MILLI, rate, rate, shape)
    assert len(same.segments) == 1
    assert same.travel_at(now + later_ns) == motion.travel_at(now + later_ns)


@given(runs, st.integers(1, 1000))
def test_an_endless_run_stays_exact_for_days(motion: Motion, days: int) -> None:
    cruise = motion.segments[-1]
    speed_sps = cruise.speed_at(cruise.start_ns) // MILLI
    first, later = (motion.travel_at(cruise.start_ns + n * DAY_NS) for n in (0, days))
    assert later - first == speed_sps * 86_400 * days * PICO
    steps = motion.steps_at(cruise.start_ns + days * DAY_NS)
    instant = motion.instant_of(steps)
    assert instant is not None
    assert motion.steps_at(instant) == steps > motion.steps_at(instant - 1)


@given(moves, speeds, rates, shapes)
def test_what_is_over_stays_over(motion: Motion, speed: int, rate: int, shape: Shape) -> None:
    assert motion.end_ns is not None
    held = stop(motion, motion.end_ns, speed, rate, shape)
    assert (held.segments, held.end_ns, held.final_steps) == ((), motion.end_ns, motion.final_steps)
    assert (held.position_at(motion.end_ns), held.ramp_at(motion.end_ns)) == (
        motion.position_at(motion.end_ns),
        0,
    )
    with pytest.raises(ValueError, match="no speed to change"):
        change_speed(motion, motion.end_ns, speed, rate, rate, shape)
    with pytest.raises(ValueError, match="nothing to register"):
        register(motion, motion.end_ns, 1, speed, rate, shape)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (lambda: move(0, 0, 0, Profile(1, 1, 0, 0)), "distance must not be 0"),
        (lambda: run(0, 0, 0, Profile(1, 1, 0, 0)), "direction 0: must be 1"),
        (lambda: single_step(0, 0, 2, 1000), "direction 2: must be 1"),
        (lambda: single_step(0, 0, 1, 0), "speed 0 steps/s: must be 1 or more"),
        (lambda: Profile(0, 1000, 1, 1), "speeds 0 and 1000 steps/s"),
        (lambda: Profile(1, 2, 0, 5), "rates 0 and 5 steps/ms/s"),
        (lambda: Profile(1, 2, 5, 0), "rates 5 and 0 steps/ms/s"),
        (lambda: blend(0, 0, 1, 1000, [], 10, Shape.CONSTANT), "a blend without segments"),
        (
            lambda: change_speed(run(0, 0, 1, Profile(1, 1, 0, 0)), 0, 0, 1, 1, Shape.CONSTANT),
            "speed 0 steps/s: must be 1 or more",
        ),
    ],
)
def test_a_plan_that_cannot_be_is_refused(wrong: Callable[[], object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        wrong()


def test_at_or_below_the_starting_speed_rates_are_ignored() -> None:
    # chapter 4, Manual Move: constant speed mode
    assert [segment.ramp for segment in run(0, 0, 1, Profile(1000, 1000, 0, 0)).segments] == [0]
    assert [segment.ramp for segment in run(0, 0, 1, Profile(1000, 10, -5, 5000)).segments] == [0]
