"""Hold and Resume [chapter 4, Hold Move and Resume Move].

The example throughout: relative 20,000 at 5000/s, acceleration 20, deceleration 10, held after 400 ms
at 1600 steps. It stops 400 ms and 1200 steps later at 2800, with 17,200 steps to go. At the same speed
and rates those take 200 + 400 ms of ramps and (17,200 - 1800)/5 = 3080 ms: 3680 ms.
"""

from __future__ import annotations

import pytest
from bench3601 import HOLD, RESUME, Bench
from motions3601 import ENCODER_MOVE, Motion, held

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
HELD = {"MODULE_OK", "HOLD_STATE"}
COMPLETE = {"MODULE_OK", "MOVE_COMPLETE"}

# -- Hold -----------------------------------------------------------------------------------------

# ms after the start, of a move of 20,000 steps: where it stops, and how long that takes
MOMENTS = [
    # the tick of the start: one step at 1000/s, and there is nothing to ramp down
    pytest.param(0.25, 1, 0.75, id="in the first step"),
    # 3000/s and 200 steps after 100 ms: 400 steps in 200 ms
    pytest.param(100, 600, 200, id="accelerating"),
    pytest.param(200, 1_800, 400, id="at the end of the ramp"),
    pytest.param(1_000, 5_800, 400, id="at speed"),
]


@pytest.mark.parametrize(("ms", "position", "lasts"), MOMENTS)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.rules("HLD-01", "STS-M02", "STS-M06")
def test_hold_decelerates_at_the_programmed_rate(ms, position, lasts, sign):
    bench = Bench.ready().relative(sign * 20_000, ms=ms).out(HOLD)
    assert bench.until("HOLD_STATE", clear=["DECELERATING", "MOVING_CW", "MOVING_CCW"]) in (
        lasts,
        lasts + 0.25,
    )
    assert (bench.position, bench.bits) == (sign * position, HELD)


@EVERY_SCAN
@pytest.mark.parametrize(
    ("down", "lsw", "lasts", "steps"),
    [
        # 4000/40,000 s and a mean of 3000 steps/s
        pytest.param(40, 0, 100, 300, id="deceleration 40"),
        pytest.param(1, 0, 4_000, 12_000, id="deceleration 1"),
        pytest.param(10, 1, 800, 2_400, id="triangular S: twice the time"),
    ],
)
@pytest.mark.rules("HLD-01", "PRO-10")
def test_hold_uses_the_deceleration_of_the_move(down, lsw, lasts, steps, scan_ms):
    """And not what the words of the Hold command say."""
    bench = Bench.ready(scan_ms=scan_ms).relative(40_000, down=down, lsw=lsw, ms=1_000)
    there = bench.position
    assert bench.command(HOLD, down=7).until("HOLD_STATE") == lasts
    assert bench.position == there + steps


@EVERY_SCAN
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0, 0, 0, 0, 0, 0, 0), id="zero"),
        pytest.param((0xFF, -1, 32_767, 1_000, -1, -1, 0), id="nothing legal"),
        pytest.param((3, 9_000, 999, 0, 1, 2_001, 2_001), id="out of range"),
    ],
)
@pytest.mark.rules("HLD-05", "HLD-01")
def test_words_1_to_7_of_hold_may_hold_anything(words, scan_ms):
    bench = Bench.ready("2.2", scan_ms=scan_ms).relative(20_000, ms=400).out(HOLD, *words)
    bench.until("HOLD_STATE")
    assert (bench.position, bench.bits, bench.fired) == (2_800, HELD, [])


@EVERY_SCAN
@pytest.mark.parametrize("bit", [bit for bit in range(15) if 1 << bit != HOLD])
@pytest.mark.rules("HLD-02", "CMD-02")
def test_hold_with_another_command_bit(bit, scan_ms):
    """Reading A-33: the move goes on."""
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400)
    bench.idle(scan_ms).command(HOLD | 1 << bit).run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}, ["CMD-02"])
    here = bench.position
    assert bench.run(100).position == here + 500


@EVERY_SCAN
@pytest.mark.rules("HLD-01")
def test_a_second_hold_while_the_axis_is_stopping_is_ignored(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, ms=400).out(HOLD).run(100)
    bench.idle(scan_ms).out(HOLD).run(300 - scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (2_800, HELD, [])
    bench.idle().command(RESUME).until("MOVE_COMPLETE")
    assert bench.position == 20_000


# A move of 10,000 begins to decelerate after 1840 ms at 8800 and ends after 2240 ms.
@EVERY_SCAN
@pytest.mark.parametrize("lsw", [0, 1, 3], ids=["constant", "triangular S", "trapezoidal S"])
@pytest.mark.parametrize("percent", [2, 40, 80, 98])
@pytest.mark.parametrize("by", ["hold", "external"])
@pytest.mark.rules("HLD-01", "EXT-02", "MC-01")
def test_a_move_that_is_stopping_already_is_not_held(lsw, percent, by, scan_ms):
    """It is on its way to its target and gets there; ramps of 400, 800 and 533.3 ms from constant speed."""
    free = Bench.ready(scan_ms=scan_ms).relative(10_000, lsw=lsw)
    starts = free.until("DECELERATING")
    lasts = free.until("MOVE_COMPLETE")
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, lsw=lsw, ms=starts + lasts * percent // 100)
    bench.out(HOLD) if by == "hold" else bench.inputs(external=1)
    bench.until(clear=["DECELERATING"])
    assert (bench.position, bench.bits - {"IN_EXTERNAL"}, bench.fired) == (10_000, COMPLETE, [])
    assert bench.now_ns == free.now_ns


@EVERY_SCAN
@pytest.mark.rules("HLD-01", "MC-01")
def test_hold_that_needs_all_of_the_rest_stops_on_the_target(scan_ms):
    """1800 steps: both ramps and nothing in between; held at the top there are 1200 left to stop in."""
    bench = Bench.ready(scan_ms=scan_ms).relative(1_800, ms=200).out(HOLD)
    assert bench.until(clear=["DECELERATING"]) == 400
    assert (bench.position, bench.bits) == (1_800, COMPLETE)


@pytest.mark.parametrize(
    ("ms", "position", "end"),
    [
        pytest.param(98.5, 99, "HOLD_STATE", id="in the last step but one"),
        pytest.param(99.5, 100, "MOVE_COMPLETE", id="in the last step"),
    ],
)
@pytest.mark.rules("HLD-01", "MC-01")
def test_hold_in_the_last_step_of_a_move_without_ramps(ms, position, end):
    """A step that has begun is finished, 100 of them at 1000/s; the last one is the end of the move."""
    bench = Bench.ready().relative(100, speed=1_000, ms=ms).out(HOLD)
    assert bench.until(end) == 0.5
    assert (bench.position, bench.bits) == (position, {"MODULE_OK", end})


# -- Hold where it is refused, to the end of the motion -------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("HLD-06", "CMD-07")
def test_hold_in_homing_leaves_its_error_and_home_is_found(scan_ms):
    """Reading A-25: the error stays until it is reset."""
    bench = Motion.of("home cw").started(400, scan_ms=scan_ms, machine={"home": (3_000, 3_500)})
    bench.out(HOLD).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    bench.until("AT_HOME")
    assert (bench.position, bench.bits) == (0, {"MODULE_OK", "AT_HOME", "COMMAND_ERROR", "IN_HOME"})
    assert bench.fired == ["CMD-07"]
    assert bench.idle(scan_ms).reset_errors(scan_ms).bits == {"MODULE_OK", "AT_HOME", "IN_HOME"}


@EVERY_SCAN
@pytest.mark.rules("HLD-07", "CMD-19", "MC-01")
def test_hold_in_a_blend_move_leaves_its_error_until_the_end(scan_ms):
    """600 + 25,000 steps of the profile; the error goes off with Move Complete and commands work again."""
    bench = Motion.of("blend ccw").started(400, scan_ms=scan_ms)
    bench.out(HOLD).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CCW", "BLEND_RUNNING", "COMMAND_ERROR"}
    while "BLEND_RUNNING" in bench.bits:
        assert "COMMAND_ERROR" in bench.bits
        bench.scan()
    assert (bench.position, bench.bits, bench.fired) == (-25_000, COMPLETE, ["CMD-19"])
    bench.idle(scan_ms).relative(100).until("MOVE_COMPLETE")
    assert bench.position == -24_900


@EVERY_SCAN
@pytest.mark.rules("CMD-19", "HLD-07")
def test_another_error_in_a_blend_move_does_not_go_off_by_itself(scan_ms):
    bench = Motion.of("blend cw").started(400, scan_ms=scan_ms)
    bench.relative(100, ms=scan_ms).until("MOVE_COMPLETE")
    assert (bench.bits, bench.fired) == (COMPLETE | {"COMMAND_ERROR"}, ["CMD-03"])


@EVERY_SCAN
@pytest.mark.parametrize("option", [True, False])
@pytest.mark.rules("HLD-09", "ENC-06")
def test_switch_for_the_error_of_hold_in_an_encoder_move(option, scan_ms):
    """Reading A-23: chapter 4 says "ignored", Command Error 7 lists encoder moves."""
    motion = Motion.of("relative encoder cw")
    bench = motion.started(400, scan_ms=scan_ms, hold_error_in_encoder_move=option)
    bench.out(HOLD, ENCODER_MOVE).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"} | ({"COMMAND_ERROR"} if option else set())
    assert bench.fired == (["CMD-07"] if option else [])
    bench.turn_encoder(20_000, ms=2).until("MOVE_COMPLETE")


# -- Resume ---------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("RSM-01", "RSM-02", "RSM-04", "HLD-12")
def test_resume_goes_on_from_where_the_move_stopped(scan_ms):
    bench = held(scan_ms=scan_ms).run(50).command(RESUME).scan()
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "ACCELERATING"}, [])
    assert bench.position in (2_800, 2_802)  # 1000 t + 10,000 t^2 after 0.25 or 2 ms
    bench.run(3_680 - 2 * scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING"}
    assert (bench.scan().position, bench.bits) == (20_000, COMPLETE)


@EVERY_SCAN
@pytest.mark.parametrize("target", [(0, 0), (-20, 0), (20, 1), (1, -1), (9_000, 0)])
@pytest.mark.rules("HLD-03")
def test_the_target_of_resume_is_ignored(target, scan_ms):
    """Even if it is out of range or no value."""
    bench = held(scan_ms=scan_ms).out(RESUME, 0, *target, 5, 0, 20, 10)
    assert bench.until("MOVE_COMPLETE") == 3_680
    assert (bench.position, bench.fired) == (20_000, [])


@EVERY_SCAN
@pytest.mark.rules("HLD-03", "RSM-01", "MOV-02")
def test_an_absolute_move_is_resumed_to_its_target(scan_ms):
    bench = Bench.ready(position=-500, scan_ms=scan_ms).absolute(-20_500, ms=400)
    bench.out(HOLD).until("HOLD_STATE")
    assert bench.position == -3_300
    assert bench.idle(scan_ms).command(RESUME, 100).until("MOVE_COMPLETE") == 3_680
    assert bench.position == -20_500


@EVERY_SCAN
@pytest.mark.parametrize(
    ("lsw", "speed", "up", "down", "total"),
    [
        # 17,200 steps; ramps from 1000 to 3000/s of 100 ms and 200 steps, 400 ms and 800 steps
        pytest.param(0, 3_000, 20, 5, 500 + 16_200 / 3, id="speed and deceleration changed"),
        # 0.1 s and 300 steps, 0.4 s and 1200 steps
        pytest.param(0, 5_000, 40, 10, 500 + 15_700 / 5, id="acceleration changed"),
        # twice the ramps of the example: 400 + 800 ms, 1200 + 2400 steps
        pytest.param(1, 5_000, 20, 10, 1_200 + 13_600 / 5, id="triangular S"),
        # 4/3 of them
        pytest.param(3, 5_000, 20, 10, 800 + 14_800 / 5, id="trapezoidal S"),
        pytest.param(0, 1_000, 20, 10, 17_200, id="at the starting speed"),
    ],
)
@pytest.mark.rules("HLD-13", "RSM-03", "RSM-01")
def test_speed_rates_and_shape_are_those_of_the_resume_words(lsw, speed, up, down, total, scan_ms):
    bench = held(scan_ms=scan_ms).command(RESUME, lsw=lsw, speed=speed, up=up, down=down)
    took = bench.until("MOVE_COMPLETE", ms=20_000)
    assert 0 <= took - total < scan_ms
    assert bench.position == 20_000


@EVERY_SCAN
@pytest.mark.rules("RSM-03")
def test_an_s_curve_is_not_remembered_from_the_held_move(scan_ms):
    """Held with a triangular S-curve after 1 s: 800 ms and 2400 steps; 15,000 steps left at constant rates.

    1200 + 600 * 5 = 4200 steps after 1 s, 6600 when held: 13,400 left, 600 ms of ramps and 11,600/5.
    """
    bench = Bench.ready(scan_ms=scan_ms).relative(20_000, lsw=1, ms=1_000)
    assert bench.out(HOLD, 1).until("HOLD_STATE") == 800
    assert bench.position == 6_600
    assert bench.idle(scan_ms).command(RESUME).until("MOVE_COMPLETE") == 600 + 11_600 / 5


@EVERY_SCAN
@pytest.mark.rules("RSM-05", "RSM-01")
def test_a_move_may_be_held_and_resumed_many_times(scan_ms):
    """Each time 100 ms up to 3000/s and 200 steps, then 200 ms and 400 steps down."""
    bench = Bench.ready(scan_ms=scan_ms).relative(6_050)
    for times in range(1, 11):
        bench.run(100).out(HOLD).run(200)
        assert (bench.position, bench.bits) == (600 * times, HELD)
        bench.idle(scan_ms).command(RESUME)
    bench.until("MOVE_COMPLETE")
    assert (bench.position, bench.bits, bench.fired) == (6_050, COMPLETE, [])
    bench.idle(scan_ms).command(RESUME).run(scan_ms)
    assert (bench.bits, bench.fired) == (COMPLETE | {"COMMAND_ERROR"}, ["CMD-08"])
