"""Velocity profiles as the images show them: times, steps and ramp bits [chapter 2; chapter 4].

All from Vo 1000, Vs 5000, acceleration 20, deceleration 10 unless a row says otherwise:

    Ta = 4000/20,000 s = 200 ms    Da = 0.2 * 3000 = 600      times 2 for a triangular, 4/3 for a
    Td = 4000/10,000 s = 400 ms    Dd = 0.4 * 3000 = 1200     trapezoidal S-curve

The image shows an instant in the first scan that ends at it or after it.
"""

from __future__ import annotations

from fractions import Fraction

import pytest
from bench3601 import ENCODER, HOME_CW, Bench, configuration
from motions3601 import FOLLOW, FOLLOW_ONE_TO_ONE

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
CONSTANT, TRIANGULAR, TRAPEZOIDAL = 0, 1, 3
SHAPES = [
    pytest.param(CONSTANT, Fraction(1), id="constant", marks=pytest.mark.rules("PRO-03", "PRO-04")),
    pytest.param(TRIANGULAR, Fraction(2), id="triangular S", marks=pytest.mark.rules("PRO-05")),
    pytest.param(TRAPEZOIDAL, Fraction(4, 3), id="trapezoidal S", marks=pytest.mark.rules("PRO-06")),
    pytest.param(2, Fraction(1), id="bit 1 without bit 0", marks=pytest.mark.rules("PRO-03", "PRO-04")),
]


def shown_at(ms: Fraction | float, scan_ms: float) -> float:
    """The end of the scan in which an instant is first seen."""
    scan = Fraction(scan_ms)
    return float(-(-Fraction(ms) // scan) * scan)


@EVERY_SCAN
@pytest.mark.parametrize(("lsw", "factor"), SHAPES)
@pytest.mark.rules("PRO-01", "PRO-08", "PRO-10")
def test_trapezoidal_profile_of_10000_steps(lsw, factor, scan_ms):
    """Ramps of 200 and 400 ms times the factor, and what they leave of the way at 5 steps/ms."""
    up, down = 200 * factor, 400 * factor
    level = (10_000 - (600 + 1_200) * factor) / 5
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, lsw=lsw)
    assert bench.scan().bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}
    accelerated = bench.until(clear=["ACCELERATING"]) + scan_ms
    assert accelerated == shown_at(up, scan_ms)
    assert bench.position == 600 * factor + (Fraction(accelerated) - up) * 5 // 1
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    slowing = accelerated + bench.until("DECELERATING")
    assert slowing == shown_at(up + level, scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "DECELERATING"}
    done = slowing + bench.until(clear=["DECELERATING"])
    assert done == shown_at(up + level + down, scan_ms)
    assert (bench.position, bench.bits) == (10_000, {"MODULE_OK", "MOVE_COMPLETE"})


# Position at an instant inside each ramp, from the integrals over the shape. With j the jerk:
#   triangular: the rate goes to its full value in half of the ramp, and back in the other half
#   trapezoidal: in a quarter, stays half of the time, and back in a quarter [chapter 4, note 3]
INSIDE_A_RAMP = [
    # 1000 t + 10,000 t^2 at 0.1 s
    pytest.param(CONSTANT, 100, 200, id="constant, halfway up"),
    # j = 20,000/0.2: 1000 t + j t^3/6 at 0.2 s = 200 + 133.3
    pytest.param(TRIANGULAR, 200, 333, id="triangular S, halfway up"),
    # j = 20,000/0.0667: 81.5 steps and 1667 steps/s after 66.7 ms; then 133.3 ms at 20,000 steps/s/s:
    # 81.48 + 222.22 + 177.78
    pytest.param(TRAPEZOIDAL, 200, 481, id="trapezoidal S, three quarters up"),
    # down from 1840 ms and 8800 on; 5000 t - 5000 t^2 at 0.2 s = 800
    pytest.param(CONSTANT, 2_040, 9_600, id="constant, halfway down"),
    # down from 1680 ms and 7600 on, j = 10,000/0.4: 5000 t - j t^3/6 at 0.4 s = 2000 - 266.7
    pytest.param(TRIANGULAR, 2_080, 9_333, id="triangular S, halfway down"),
    # down from 1786.7 ms and 8400 on, j = 10,000/0.1333: 666.67 - 29.63 after 133.3 ms
    pytest.param(TRAPEZOIDAL, 1_920, 9_037, id="trapezoidal S, a quarter down"),
]


@EVERY_SCAN
@pytest.mark.parametrize(("lsw", "ms", "steps"), INSIDE_A_RAMP)
@pytest.mark.rules("PRO-05", "PRO-06", "PRO-10")
def test_position_inside_a_ramp(lsw, ms, steps, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(10_000, lsw=lsw, ms=ms)
    assert bench.position == steps


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    ("rate", "speed", "ms", "steps"),
    [
        # (1100 - 1000)/1000 s at a mean of 1050; 4000/2,000,000 s at a mean of 3000
        pytest.param(1, 1_100, 100, 105, id="1 step/ms/s"),
        pytest.param(20, 5_000, 200, 600, id="20 steps/ms/s"),
        pytest.param(2_000, 5_000, 2, 6, id="2000 steps/ms/s"),
    ],
)
@pytest.mark.rules("PRO-03", "PRO-04", "PRO-07")
def test_rates_are_thousands_of_steps_per_second_and_second(rate, speed, ms, steps, sign, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms)
    start_ns = bench.now_ns
    bench.relative(sign * 10_000, speed=speed, up=rate)
    while bench.now_ns < start_ns + (ms - scan_ms) * 1_000_000:
        assert "ACCELERATING" in bench.scan().bits
    bench.scan()
    assert (bench.position, "ACCELERATING" in bench.bits) == (sign * steps, False)


# N = Da + Dd with the peak speed instead of Vs: k * (Vp^2 - Vo^2) * (1/40,000 + 1/20,000). With a peak
# of 3000 steps/s that is 600, 1200 and 800 steps; Ta = 100 ms times the factor, Td twice that.
TRIANGLES = [
    pytest.param(600, CONSTANT, 100, 300, id="constant, peak at 3000/s"),
    pytest.param(1_200, TRIANGULAR, 200, 600, id="triangular S, peak at 3000/s"),
    pytest.param(800, TRAPEZOIDAL, Fraction(400, 3), 400, id="trapezoidal S, peak at 3000/s"),
    pytest.param(1_800, CONSTANT, 200, 600, id="constant, just room for both ramps"),
    # Vp = 4998.67: (3998.67/20,000)(1 + 2) s
    pytest.param(1_799, CONSTANT, Fraction("199.93"), Fraction("599.80"), id="constant, a step less"),
]


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("steps", "lsw", "up", "total"), TRIANGLES)
@pytest.mark.rules("PRO-02")
def test_move_too_short_for_both_ramps(steps, lsw, up, total, sign, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(sign * steps, lsw=lsw)
    accelerated = bench.until(clear=["ACCELERATING"])
    assert accelerated == shown_at(up, scan_ms)
    assert "DECELERATING" in bench.bits  # no constant speed in between
    assert accelerated + bench.until("MOVE_COMPLETE") == shown_at(total, scan_ms)
    assert (bench.position, bench.bits) == (sign * steps, {"MODULE_OK", "MOVE_COMPLETE"})


@EVERY_SCAN
@pytest.mark.rules("PRO-02", "PRO-08")
def test_a_move_with_room_for_both_ramps_has_constant_speed_in_between(scan_ms):
    """1850 steps: 600 + 1200 for the ramps, 50 at 5 steps/ms."""
    bench = Bench.ready(scan_ms=scan_ms).relative(1_850, ms=200)
    assert bench.bits == {"MODULE_OK", "MOVING_CW"}
    bench.run(8)
    assert (bench.position, bench.bits) == (640, {"MODULE_OK", "MOVING_CW"})
    assert bench.until("DECELERATING") == 2
    assert bench.until("MOVE_COMPLETE") == 400


@EVERY_SCAN
@pytest.mark.rules("PRO-09")
def test_a_speed_equal_to_the_starting_speed_gives_no_ramps(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).relative(100, speed=1_000)
    for scan in range(1, round(100 / scan_ms)):
        assert bench.scan().bits == {"MODULE_OK", "MOVING_CW"}
        assert bench.position == int(scan * scan_ms)  # 1 step/ms
    assert bench.scan().bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == 100


@pytest.mark.parametrize(
    ("speed", "last_ms"),
    [pytest.param(1_000, 10_000, id="no ramps"), pytest.param(5_000, 2_240, id="ramps")],
)
@pytest.mark.rules("PRO-01", "PRO-09")
def test_first_and_last_pulse_are_at_the_starting_speed(speed, last_ms):
    """A step takes 1 ms at 1000/s; on the ramps 0.990 and 0.995 ms: 1000 t + 10,000 t^2 = 1."""
    bench = Bench.ready(scan_ms=0.25).relative(10_000, speed=speed)
    bench.run(0.75)
    assert bench.position == 0
    bench.run(0.25)
    assert bench.position == 1
    bench.run(last_ms - 2)
    assert bench.position == (9_999 if speed == 1_000 else 9_998)
    bench.run(0.25)
    assert (bench.position, "MOVE_COMPLETE" in bench.bits) == (9_999, False)
    bench.run(0.75)
    assert (bench.position, "MOVE_COMPLETE" in bench.bits) == (10_000, True)


# -- where S-curves are not available -------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize("lsw", [TRIANGULAR, TRAPEZOIDAL])
@pytest.mark.rules("PRO-12", "CMD-10")
def test_homing_has_no_s_curve(lsw, scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).command(HOME_CW, lsw=lsw, ms=scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-10"])
    assert bench.run(50).position == 0


@EVERY_SCAN
@pytest.mark.rules("PRO-12")
def test_homing_does_not_look_at_bit_1_without_bit_0(scan_ms):
    bench = Bench.ready(scan_ms=scan_ms).command(HOME_CW, lsw=2, ms=scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "MOVING_CW", "ACCELERATING"}, [])


@EVERY_SCAN
@pytest.mark.parametrize("lsw", [TRIANGULAR, TRAPEZOIDAL])
@pytest.mark.rules("PRO-12", "CMD-36", "FOL-18")
def test_the_encoder_follower_has_no_s_curve(lsw, scan_ms):
    bench = Bench.ready(config=configuration(add=ENCODER), scan_ms=scan_ms)
    bench.out(0, FOLLOW | lsw, *FOLLOW_ONE_TO_ONE).run(scan_ms)
    assert (bench.bits, bench.fired) == ({"MODULE_OK", "COMMAND_ERROR"}, ["CMD-36"])
