"""Timelines that the manual's arithmetic gives, met exactly at every exchange period [chapter 2].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up, 0.4 s and 1200 steps down.
"""

from __future__ import annotations

import pytest
from bench3601 import HOLD, IMMEDIATE_STOP, MANUAL_CW, RESUME, Bench

EVERY_PERIOD = pytest.mark.parametrize("scan_ms", [0.25, 0.5, 1, 2, 5, 10, 40, 100])


@EVERY_PERIOD
@pytest.mark.rules("PRO-01", "PRO-03", "PRO-04", "PRO-07", "PRO-08", "MOV-05", "MOV-08", "STS-M05", "STS-M06")
def test_relative_move_of_10000_steps_takes_2240_ms(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms)
    bench.relative(10_000).poll(200)
    assert (bench.position, "ACCELERATING" in bench.bits, "MOVING_CW" in bench.bits) == (600, False, True)
    bench.poll(1600)  # 8,200 steps at 5,000/s less the 600 + 1,200 of the ramps: 1.64 s of constant speed
    assert (bench.position, "DECELERATING" in bench.bits) == (8_600, False)
    if scan_ms <= 40:
        bench.poll(40)
        assert (bench.position, "DECELERATING" in bench.bits) == (8_800, True)
        bench.poll(400)
        assert (bench.position, bench.bits) == (10_000, {"MODULE_OK", "MOVE_COMPLETE", "POSITION_INVALID"})
    else:
        bench.poll(500)
        assert (bench.position, "MOVE_COMPLETE" in bench.bits) == (10_000, True)


@EVERY_PERIOD
@pytest.mark.rules("HLD-01", "RSM-01", "RSM-02", "RSM-04", "STS-M02")
def test_hold_at_1_s_stops_at_5800_and_resume_reaches_20000(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms)
    bench.relative(20_000).poll(1000)
    assert bench.position == 600 + 800 * 5
    bench.out(HOLD).poll(400)
    assert (bench.position, bench.bits) == (5_800, {"MODULE_OK", "HOLD_STATE", "POSITION_INVALID"})
    bench.idle(100).command(RESUME)
    # 14,200 steps left: 0.2 s + 0.4 s of ramps, 12,400 steps at 5,000/s are 2.48 s
    took = bench.until("MOVE_COMPLETE")
    assert 0 <= took - 3_080 < scan_ms
    assert bench.position == 20_000


@EVERY_PERIOD
@pytest.mark.rules("MAN-01", "MAN-04", "MAN-05", "MAN-20", "STOP-01")
def test_manual_move_released_at_1_s_stops_at_5800(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms)
    bench.manual().poll(1000)
    assert (bench.position, "MOVING_CW" in bench.bits) == (4_600, True)
    bench.out().poll(400)
    assert (bench.position, bench.bits) == (5_800, {"MODULE_OK", "STOPPED", "POSITION_INVALID"})


@EVERY_PERIOD
@pytest.mark.rules("IST-01", "IST-02", "IST-05", "STOP-03", "POS-02")
def test_immediate_stop_at_400_ms_leaves_1600_steps(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms)
    bench.relative(10_000).poll(400)
    bench.out(IMMEDIATE_STOP).poll(scan_ms)
    assert (bench.position, bench.bits) == (1_600, {"MODULE_OK", "STOPPED", "POSITION_INVALID"})


@EVERY_PERIOD
@pytest.mark.rules("MAN-15", "STS-L02")
def test_the_step_of_a_one_shot_operates_a_switch(scan_ms):
    bench = Bench.configured(scan_ms=scan_ms, machine={"home": (1, 5)})
    bench.command(MANUAL_CW, speed=0).poll(max(scan_ms, 0.5))  # the pulse, and the tick that sees the switch
    assert bench.position == 1
    assert {"MOVING_CW", "IN_HOME"} < bench.bits
