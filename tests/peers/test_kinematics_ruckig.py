"""Motions of constant rate beside ruckig, an online trajectory generator that others wrote.

Ruckig plans the time-optimal trajectory between two states under limits of speed and rate; with no
limit of jerk, that is the manual's trapezoidal or triangular profile [chapter 2].
"""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, reject
from hypothesis import strategies as st
from scanrack.runtime.kinematics import MILLI, PICO, Motion, Profile, Shape, change_speed, move, run, stop

ruckig = pytest.importorskip("ruckig", reason="the peer, ruckig, is not installed")


def tolerance_steps(speed_sps: float, way_steps: float) -> float:
    """Return how far apart the two may be: 2 ns at the speed, as times are whole ns, and errors of floats."""
    return 1e-3 + 2e-9 * speed_sps + 1e-11 * abs(way_steps)


starts = st.integers(1, 10_000)  # from about 200,000 on, ruckig loses its way in floats
speeds = st.integers(1, 1_000_000)
rates = st.integers(1, 2000)
parts = st.lists(st.floats(0, 1), min_size=5, max_size=5)


def trajectory(acceleration_spmss: int, deceleration_spmss: int, **state: Any) -> Any:
    """Return ruckig's trajectory of one axis for the given state and limits."""
    task = ruckig.InputParameter(1)
    task.max_acceleration = [acceleration_spmss * 1000.0]
    task.min_acceleration = [-deceleration_spmss * 1000.0]
    for name, value in state.items():
        setattr(task, name, value)
    result = ruckig.Trajectory(1)
    try:
        ruckig.Ruckig(1).calculate(task, result)
    except ruckig.RuckigError:  # it gives up on some ramps of a few us
        reject()
    return result


def assert_follows(motion: Motion, peer: Any, parts: list[float], begin_ns: int, top_sps: int) -> None:
    """Assert that a motion is where ruckig is, at parts of the trajectory's time."""
    for part in parts:
        at_ns = int(part * peer.duration * 1e9)
        [position] = peer.at_time(at_ns * 1e-9)[0]
        travel = motion.travel_at(begin_ns + at_ns) / PICO
        assert travel == pytest.approx(position, rel=0, abs=tolerance_steps(top_sps, position))


@given(st.integers(1, 8_388_608), starts, speeds, rates, rates, parts)
def test_a_move(distance: int, start: int, more: int, up: int, down: int, parts: list[float]) -> None:
    motion = move(0, 0, distance, Profile(start, start + more, up, down))
    peer = trajectory(
        up,
        down,
        max_velocity=[float(start + more)],
        current_velocity=[float(start)],
        target_velocity=[float(start)],
        target_position=[float(distance)],
    )
    assert motion.end_ns == pytest.approx(peer.duration * 1e9, rel=1e-12, abs=2)
    assert_follows(motion, peer, parts, 0, start + more)


def velocity_control(
    motion: Motion, now_ns: int, to_sps: int, acceleration_spmss: int, deceleration_spmss: int
) -> Any:
    """Return ruckig's change from the motion's present speed to another one."""
    segment = motion.segment_at(now_ns)
    return trajectory(
        acceleration_spmss,
        deceleration_spmss,
        control_interface=ruckig.ControlInterface.Velocity,
        current_position=[float(segment.exact_travel_at(now_ns) / PICO)],
        current_velocity=[float(segment.exact_speed_at(now_ns) / MILLI)],
        target_velocity=[float(to_sps)],
    )


@given(speeds, speeds, rates, speeds, rates, rates, st.floats(0, 1.2), parts)
def test_a_speed_change(
    start: int, more: int, rate: int, to: int, up: int, down: int, when: float, parts: list[float]
) -> None:
    motion = run(0, 0, 1, Profile(start, start + more, rate, rate))
    now_ns = int(when * more / rate * 1e6)
    changed = change_speed(motion, now_ns, to, up, down, Shape.CONSTANT)
    peer = velocity_control(motion, now_ns, to, up, down)
    assert changed.segments[-1].start_ns - now_ns == pytest.approx(peer.duration * 1e9, rel=1e-12, abs=5)
    assert_follows(changed, peer, parts, now_ns, max(start + more, to))


@given(speeds, speeds, rates, rates, st.floats(0, 1.2), parts)
def test_a_stop(start: int, more: int, rate: int, down: int, when: float, parts: list[float]) -> None:
    motion = run(0, 0, 1, Profile(start, start + more, rate, rate))
    now_ns = int(when * more / rate * 1e6)
    held = stop(motion, now_ns, start, down, Shape.CONSTANT)
    peer = velocity_control(motion, now_ns, start, 1, down)
    assert held.final_steps is not None
    assert held.end_ns is not None
    # ruckig does not know of steps: it ramps down at once, the motion when the rest ends on a step
    [stopped] = peer.at_time(peer.duration)[0]
    later_steps = held.final_steps - stopped
    tolerance = tolerance_steps(start + more, stopped)
    assert -tolerance < later_steps < 1 + tolerance
    wait_ns = held.end_ns - now_ns - peer.duration * 1e9
    assert wait_ns * motion.speed_at(now_ns) / PICO == pytest.approx(later_steps, rel=0, abs=tolerance)
    for part in parts:
        at_ns = int(part * peer.duration * 1e9)
        [position] = peer.at_time(at_ns * 1e-9)[0]
        travel = held.travel_at(held.end_ns - int(peer.duration * 1e9) + at_ns) / PICO
        assert travel == pytest.approx(position + later_steps, rel=0, abs=tolerance)
