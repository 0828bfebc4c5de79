"""Registration moves: so many steps after the input, to the step, whatever came before [chapter 4].

Starting speed 1000, speed 5000, acceleration 20, deceleration 10 steps/ms/s:
0.2 s and 600 steps up, 0.4 s and 1200 steps down.
"""

from __future__ import annotations

import pytest
from bench3601 import CONFIGURATION, ENCODER, MANUAL_CW, RELATIVE, Bench, configuration
from registration3601 import EITHER_INPUT, SHAPES, STEPS, TO_STOP, change, give_input, register, release

BOTH_PERIODS = pytest.mark.parametrize("scan_ms", [0.25, 2])
EITHER_WAY = pytest.mark.parametrize("direction", [pytest.param(1, id="cw"), pytest.param(-1, id="ccw")])
EVERY_SHAPE = pytest.mark.parametrize("shape", SHAPES)

STOPPED = {"MODULE_OK", "STOPPED"}


# -- the steps after the input


@BOTH_PERIODS
@EITHER_WAY
@EITHER_INPUT
@pytest.mark.rules("REG-01", "REG-02", "REG-03", "STOP-01")
def test_so_many_steps_after_the_input(by, direction, scan_ms):
    bench = register(Bench.ready(scan_ms=scan_ms), direction).run(1_000)
    assert bench.position == direction * 4600
    give_input(bench, by).run(360 - scan_ms)
    moving = "MOVING_CW" if direction > 0 else "MOVING_CCW"
    assert bench.bits - {"IN_EXTERNAL"} == {"MODULE_OK", moving}
    bench.scan()  # 1800 steps at 5000/s
    assert bench.position == direction * 6400
    bench.run(400 - scan_ms)
    assert bench.bits - {"IN_EXTERNAL"} == {"MODULE_OK", moving, "DECELERATING"}
    bench.scan()
    assert (bench.position, bench.bits - {"IN_EXTERNAL"}) == (direction * (4600 + STEPS), STOPPED)


@EVERY_SHAPE
@EITHER_INPUT
@pytest.mark.rules("REG-02", "REG-03")
@pytest.mark.parametrize("after_ms", [0.25, 1, 3, 50, 100.75, 199.75, 200, 333.25, 400.5, 700])
def test_so_many_steps_from_any_moment_on(after_ms, by, shape):
    """During the acceleration, too: the speed reached is kept (reading A-53)."""
    bench = register(Bench.ready(), lsw=SHAPES[shape]).run(after_ms)
    made = bench.position
    give_input(bench, by).scan()
    assert bench.bits.isdisjoint({"ACCELERATING", "DECELERATING"})
    bench.until("STOPPED")
    assert bench.position == made + STEPS


@pytest.mark.rules("REG-02")
def test_in_the_acceleration_the_speed_is_kept():
    """At 100 ms 200 steps and 3000/s; from there a stop takes 400 steps and 200 ms."""
    bench = register(Bench.ready()).run(100)
    release(bench).run(500)
    assert (bench.position, bench.bits) == (200 + 1500, {"MODULE_OK", "MOVING_CW"})
    assert bench.until("DECELERATING") == 366.75  # (3000 - 400)/3 = 866.67 ms in all
    assert bench.until("STOPPED") == 200


@EVERY_SHAPE
@pytest.mark.rules("REG-02", "REG-20", "CMD-23", "PRF-13")
@pytest.mark.parametrize("after_ms", [800, 800.25, 800.5, 1_000.75])
def test_the_least_distance_is_that_of_the_stop(after_ms, shape):
    """Even if a step is under way when the input comes: 1.25 steps a tick."""
    bench = register(Bench.ready(), steps=TO_STOP[shape], lsw=SHAPES[shape]).run(after_ms)
    made = bench.position
    release(bench).until("STOPPED")
    assert (bench.position, bench.fired) == (made + TO_STOP[shape], [])


@EITHER_INPUT
@pytest.mark.rules("REG-02", "MAN-02")
@pytest.mark.parametrize("speed", [1, 800, 1000])
@pytest.mark.parametrize("steps", [1, 2])
def test_at_or_below_the_starting_speed_there_is_nothing_to_decelerate(steps, speed, by):
    """Reading A-55; the rates are not looked at (A-81)."""
    bench = register(Bench.ready(scan_ms=2), steps=steps, speed=speed, up=0, down=0).run(3_000)
    made = bench.position
    assert made == 3 * speed
    give_input(bench, by)
    # The step under way at the tick of the input is the first of them: 1000/speed ms each.
    assert 0 <= bench.until("STOPPED") - steps * 1000 / speed < 2
    assert bench.position == made + steps


@pytest.mark.rules("REG-01")
def test_target_zero_is_a_plain_manual_move():
    bench = register(Bench.ready(), steps=0).run(400)
    release(bench).run(400)
    assert (bench.position, bench.bits) == (1600 + 1200, STOPPED)


@pytest.mark.rules("REG-01")
@pytest.mark.parametrize("target", [(3, 0), (1, 200), (0, 1500 - 501)], ids=str)
def test_either_target_word_makes_it_a_registration_move(target):
    bench = Bench.ready()
    bench.out(MANUAL_CW, 0, *target, 1, 0, 20, 10).run(400)
    release(bench).until("STOPPED")
    assert bench.position == 400 + 1000 * target[0] + target[1]


@pytest.mark.rules("REG-06", "REG-03")
def test_an_input_that_goes_away_again_has_counted():
    bench = register(Bench.ready()).run(400)
    bench.inputs(external=1).run(0.5).inputs(external=0).until("STOPPED")
    assert bench.position == 1600 + STEPS


@pytest.mark.rules("REG-03")
def test_the_second_input_adds_nothing():
    bench = register(Bench.ready()).run(400)
    bench.inputs(external=1).run(100)
    release(bench).run(100).inputs(external=0).until("STOPPED")
    assert bench.position == 1600 + STEPS


@pytest.mark.rules("REG-03", "CFG-14")
@pytest.mark.parametrize(
    ("direction", "config"),
    [
        pytest.param(1, CONFIGURATION, id="cw"),
        pytest.param(-1, configuration(add=ENCODER), id="the encoder's bit is that of a CCW manual move"),
    ],
)
def test_a_request_for_configuration_resets_the_bit(direction, config):
    """Reading A-10."""
    bench = register(Bench.ready(), direction).run(400)
    bench.out(*config).run(1)
    assert {"MOVING_CW" if direction > 0 else "MOVING_CCW", "COMMAND_ERROR"} <= bench.bits
    took = bench.until("MODE_CONFIG")
    assert (1 + took, bench.module.machine.shaft) == (360 + 400 + 0.25, direction * (1600 + STEPS))


@pytest.mark.rules("REG-02", "CMD-03")
def test_under_a_command_error_the_inputs_still_count():
    """Reading A-104."""
    bench = register(Bench.ready()).run(400)
    words = list(bench.outputs)
    bench.out(RELATIVE, *words[1:]).run(0.25)  # a move before the last one is complete; the manual bit is 0
    assert bench.fired == ["CMD-03"]
    bench.until("STOPPED")
    assert bench.position == 1600 + STEPS


# -- speeds and rates meanwhile


@BOTH_PERIODS
@pytest.mark.rules("REG-08")
@pytest.mark.parametrize(
    ("speed", "to_stop"),
    [
        pytest.param(4000, 750, id="4000"),  # 15e6/20,000 steps from 4000 to 1000/s
        pytest.param(1000, 0, id="the starting speed"),
        pytest.param(500, 0, id="below the starting speed"),
    ],
)
def test_the_speed_may_be_reduced_before_the_input(speed, to_stop, scan_ms):
    """From 5000/s at 10; the distance is exact at every speed."""
    bench = register(Bench.ready(scan_ms=scan_ms)).run(400)
    change(bench, w4=speed // 1000, w5=speed % 1000).scan()
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING"}
    bench.run((5000 - speed) / 10)
    before = bench.position
    bench.run(100)
    assert bench.position - before == speed // 10
    made = bench.position
    release(bench)
    took_ms = (STEPS - to_stop) * 1000 / speed + max(0, speed - 1000) / 10
    assert -1000 / speed < bench.until("STOPPED") - took_ms < scan_ms  # a step may be under way
    assert (bench.position, bench.fired) == (made + STEPS, [])


@EVERY_SHAPE
@EITHER_INPUT
@pytest.mark.rules("REG-08", "REG-02")
@pytest.mark.parametrize("reduced_ms", [1, 60, 150.25, 700])
@pytest.mark.parametrize("speed", [700, 1300, 4100])
def test_so_many_steps_wherever_the_speed_is_when_the_input_comes(speed, reduced_ms, by, shape):
    """Reduced in the acceleration or later; the input comes in the ramp that this begins."""
    bench = register(Bench.ready(), lsw=SHAPES[shape]).run(reduced_ms)
    change(bench, w4=speed // 1000, w5=speed % 1000).run(17.25)
    made = bench.position
    give_input(bench, by).until("STOPPED")
    assert (bench.position, bench.fired) == (made + STEPS, [])


@pytest.mark.rules("REG-08", "REG-25", "CMD-27", "PRF-17")
@pytest.mark.parametrize("speed", [(4, 1), (5, 0)], ids=["4001", "what it was at first"])
def test_a_speed_that_was_reduced_may_not_be_raised_again(speed):
    bench = register(Bench.ready()).run(400)
    change(bench, w4=4).run(200)
    change(bench, w4=speed[0], w5=speed[1]).run(0.25)
    assert bench.fired == ["CMD-27", "PRF-17"]


@pytest.mark.rules("REG-08", "REG-02")
def test_the_acceleration_type_stays_that_of_the_start():
    """From 4000/s at 10 a stop takes 750 steps, with an S 1500, and there are only 1200."""
    bench = register(Bench.ready(), steps=1200).run(400)
    change(bench, w1=SHAPES["triangular S"], w4=4).run(200)
    made = bench.position
    release(bench)
    assert 0 <= bench.until("STOPPED") - (450 / 4 + 300) < 0.5
    assert bench.position == made + 1200


@pytest.mark.rules("REG-08", "REG-09")
def test_rates_may_change_after_the_speed_has():
    """What counts is whether they differ from those of the start when the speed changes."""
    bench = register(Bench.ready()).run(400)
    change(bench, w4=4).run(200)
    change(bench, w6=30).run(10)
    assert bench.fired == []
    change(bench, w4=3).run(10)
    assert bench.fired == ["CMD-28", "PRF-18"]


@pytest.mark.rules("REG-15")
@pytest.mark.parametrize("speed", [9000, 6, 0])
@pytest.mark.parametrize("down", [10, 2000, 0])
@EITHER_INPUT
def test_speed_and_rates_are_ignored_after_the_input(by, down, speed):
    bench = register(Bench.ready()).run(400)
    give_input(bench, by).run(100)
    bench.out(*list(bench.outputs)[:4], speed // 1000, speed % 1000, 20, down)
    took = bench.until("STOPPED")
    assert (bench.position, bench.fired, 100 + took) == (1600 + STEPS, [], 360 + 400)


@pytest.mark.rules("REG-09")
@pytest.mark.parametrize("rates", [(1, 10), (20, 2000), (0, 0), (-5, 2001)])
def test_rates_alone_have_no_effect(rates):
    bench = register(Bench.ready()).run(400)
    change(bench, w6=rates[0], w7=rates[1]).run(100)
    release(bench)
    assert bench.until("STOPPED") == 360 + 400
    assert (bench.position, bench.fired) == (2100 + STEPS, [])
