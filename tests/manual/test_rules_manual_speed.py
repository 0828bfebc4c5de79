"""The speed of a manual move is changed while it runs [chapter 4, Manual Move; Command Error 15].

Each test begins with a manual move that has made 1600 steps in 400 ms, at 5000/s by then; starting
speed 1000, acceleration 20, deceleration 10.
"""

from __future__ import annotations

import pytest
from bench3601 import ENCODER, MANUAL_CCW, MANUAL_CW, Bench, configuration

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
STOPPED = {"MODULE_OK", "STOPPED"}
REFUSED = {"COMMAND_ERROR", "INVALID_PROFILE"}


def running(sign: int = 1, **kwargs) -> Bench:
    bench = Bench.ready(**kwargs).manual(sign, ms=400)
    assert bench.position == sign * 1_600
    return bench


# -- legal changes --------------------------------------------------------------------------------

# new speed, ramp in ms, steps that it takes
SPEEDS = [
    pytest.param(3_000, 200, 800, id="slower"),  # 2000/10,000 s at a mean of 4000
    pytest.param(8_000, 150, 975, id="faster"),  # 3000/20,000 s at a mean of 6500
    pytest.param(1_000, 400, 1_200, id="to the starting speed"),
    pytest.param(500, 450, 1_237, id="below the starting speed"),  # 0.45 s at 2750: 1237.5
    pytest.param(1, 500, 1_250, id="to the least speed"),  # 0.4999 s at 2500.5: 1249.99998, and 0.0001 s
]


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("speed", "ms", "steps"), SPEEDS)
@pytest.mark.rules("MAN-11", "MAN-12", "STS-M05", "STS-M06")
def test_a_new_speed_is_ramped_to(speed, ms, steps, sign, scan_ms):
    bench = running(sign, scan_ms=scan_ms).manual(sign, speed=speed)
    way = {"MODULE_OK", "MOVING_CW" if sign > 0 else "MOVING_CCW"}
    ramp = "ACCELERATING" if speed > 5_000 else "DECELERATING"
    assert bench.scan().bits == way | {ramp}
    assert bench.run(ms - 2 * scan_ms).bits == way | {ramp}
    assert bench.scan().bits == way
    assert abs(bench.position) - 1_600 in (steps, steps - (speed == 1))
    here = abs(bench.position)
    assert abs(bench.run(1_000).position) - here in (speed, speed + 1)  # from where in a step it was
    assert (bench.bits, bench.fired) == (way, [])


@EVERY_SCAN
@pytest.mark.parametrize("speed", [1, 1_000_000])
@pytest.mark.parametrize(("up", "down"), [(1, 1), (2_000, 2_000)])
@pytest.mark.rules("MAN-11", "MAN-12", "MAN-14")
def test_the_extremes_are_legal(speed, up, down, scan_ms):
    bench = running(scan_ms=scan_ms).manual(speed=speed, up=up, down=down, ms=100)
    assert (bench.bits & REFUSED, bench.fired) == (set(), [])


@EVERY_SCAN
@pytest.mark.rules("MAN-11", "MAN-12", "MAN-05")
def test_below_the_starting_speed_and_up_again(scan_ms):
    """450 ms to 500/s, 1237.5 steps; 50 ms there, 25; 100 ms up again at 45 and a mean of 2750, 275."""
    bench = running(scan_ms=scan_ms).manual(speed=500, ms=500)
    assert bench.position == 1_600 + 1_262
    bench.manual(speed=5_000, up=45, ms=100)
    assert (bench.position, bench.bits) == (1_600 + 1_537, {"MODULE_OK", "MOVING_CW"})
    bench.idle(scan_ms).until("STOPPED")
    assert bench.position == 1_600 + 2_738  # 1537.5 + 1200, to the next whole step


@EVERY_SCAN
@pytest.mark.rules("MAN-12", "MAN-05", "STOP-01")
def test_released_below_the_starting_speed(scan_ms):
    """There is nothing to ramp down: it stops at once."""
    bench = running(scan_ms=scan_ms).manual(speed=500, ms=500).idle(scan_ms)
    assert (bench.position, bench.bits, bench.fired) == (2_862, STOPPED, [])
    assert bench.run(100).position == 2_862


@EVERY_SCAN
@pytest.mark.rules("MAN-11", "MAN-05")
def test_changed_while_accelerating_and_while_decelerating(scan_ms):
    """3000/s and 200 steps after 100 ms; to 2000/s at 10, 100 ms and 250 steps; half of the way to 4000/s.

    2000 t + 10,000 t^2 at 50 ms are 125 steps, the speed then 3000: 200 ms and 400 steps to stop.
    """
    bench = Bench.ready(scan_ms=scan_ms).manual(ms=100).manual(speed=2_000, ms=100)
    assert (bench.position, bench.bits) == (450, {"MODULE_OK", "MOVING_CW"})
    bench.manual(speed=4_000, ms=50).idle(200)
    assert (bench.position, bench.bits) == (975, STOPPED)


@EVERY_SCAN
@pytest.mark.rules("MAN-11")
def test_changed_again_before_the_first_change_is_done(scan_ms):
    """To 3000: after 100 ms at 4000/s and 450 steps; back to 5000 at 20: 50 ms and 225 steps."""
    bench = running(scan_ms=scan_ms).manual(speed=3_000, ms=100).manual(speed=5_000, ms=50)
    assert (bench.position, bench.bits) == (1_600 + 675, {"MODULE_OK", "MOVING_CW"})


@EVERY_SCAN
@pytest.mark.rules("MAN-11", "MAN-05")
def test_a_release_in_the_same_image_wins(scan_ms):
    """However wrong the new speed is: the bit is released, and that ends the move."""
    bench = running(scan_ms=scan_ms).out(0, 0, 0, 0, 2_000, 1_000, 0, 0).run(400)
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED, [])


# -- rates ----------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.parametrize(("up", "down"), [(40, 40), (0, 0), (-1, 2_001), (20, 9)])
@pytest.mark.rules("MAN-13", "MAN-14", "CMD-15", "PRF-10")
def test_new_rates_alone_have_no_effect(up, down, scan_ms):
    """Legal or not: no ramp now, and the old deceleration at the end."""
    bench = running(scan_ms=scan_ms).manual(up=up, down=down, ms=100)
    assert (bench.position, bench.bits, bench.fired) == (2_100, {"MODULE_OK", "MOVING_CW"}, [])
    bench.idle(400)
    assert (bench.position, bench.bits) == (3_300, STOPPED)


@EVERY_SCAN
@pytest.mark.rules("MAN-13")
def test_new_rates_take_effect_with_a_new_speed(scan_ms):
    """Deceleration 40 from 5000 to 3000: 50 ms, 200 steps; then to rest: 50 ms, 100 steps."""
    bench = running(scan_ms=scan_ms).manual(down=40, ms=100)
    bench.manual(down=40, speed=3_000, ms=50)
    assert (bench.position, bench.bits) == (2_100 + 200, {"MODULE_OK", "MOVING_CW"})
    bench.out(0, 0, 0, 0, 3, 0, 20, 7).run(50)
    assert (bench.position, bench.bits) == (2_400, STOPPED)


@EVERY_SCAN
@pytest.mark.rules("MAN-13", "MAN-11")
def test_a_new_acceleration_takes_effect_with_a_new_speed(scan_ms):
    """Acceleration 40 from 5000 to 9000: 100 ms, 700 steps."""
    bench = running(scan_ms=scan_ms).manual(up=40, speed=9_000, ms=100 - scan_ms)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "ACCELERATING"}
    assert (bench.scan().position, bench.bits) == (2_300, {"MODULE_OK", "MOVING_CW"})


# -- changes that are refused ---------------------------------------------------------------------

SPEED_WORDS = [
    pytest.param((0, 0), id="0, reading A-41"),
    pytest.param((1_000, 1), id="1,000,001"),
    pytest.param((0, -1), id="-1"),
    pytest.param((-5, 0), id="-5000"),
    pytest.param((4, 1_000), id="lower word 1000"),
    pytest.param((6, -1), id="lower word negative"),
    pytest.param((-1, 1), id="words of opposite signs"),
]
RATES = [
    pytest.param((0, 10), id="acceleration 0"),
    pytest.param((2_001, 10), id="acceleration 2001"),
    pytest.param((-1, 10), id="acceleration -1"),
    pytest.param((20, 0), id="deceleration 0"),
    pytest.param((20, 2_001), id="deceleration 2001"),
    pytest.param((20, -1), id="deceleration -1"),
]


def is_refused(bench: Bench, sign: int) -> None:
    """It decelerates at once, with the rate that was valid last, and keeps its position."""
    way = "MOVING_CW" if sign > 0 else "MOVING_CCW"
    assert bench.bits == {"MODULE_OK", way, "DECELERATING"} | REFUSED
    assert set(bench.fired) == {"CMD-15", "PRF-10"}
    bench.run(400 - bench.scan_ns / 1_000_000)
    assert (bench.position, bench.bits) == (sign * 2_800, STOPPED | REFUSED)
    assert bench.reset_errors().bits == STOPPED
    bench.absolute(0).until("MOVE_COMPLETE")


@EVERY_SCAN
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("words", SPEED_WORDS)
@pytest.mark.rules("MAN-14", "CMD-15", "PRF-10", "MAN-20")
def test_a_new_speed_that_is_not_legal(words, sign, scan_ms):
    bench = running(sign, scan_ms=scan_ms)
    bench.out(MANUAL_CW if sign > 0 else MANUAL_CCW, 0, 0, 0, *words, 20, 10).run(scan_ms)
    is_refused(bench, sign)


@EVERY_SCAN
@pytest.mark.parametrize("speed", [3_000, 7_000, 500])
@pytest.mark.parametrize("rates", RATES)
@pytest.mark.rules("MAN-14", "CMD-15", "PRF-10", "MAN-20")
def test_a_new_speed_with_rates_that_are_not_legal(rates, speed, scan_ms):
    bench = running(scan_ms=scan_ms).manual(speed=speed, up=rates[0], down=rates[1], ms=scan_ms)
    is_refused(bench, 1)


@EVERY_SCAN
@pytest.mark.rules("MAN-14", "CMD-15")
def test_rates_that_went_bad_before_are_checked_when_the_speed_changes(scan_ms):
    bench = running(scan_ms=scan_ms).manual(up=0, ms=scan_ms)
    assert bench.fired == []
    bench.manual(up=0, speed=6_000, ms=scan_ms)
    assert set(bench.fired) == {"CMD-15", "PRF-10"}


@EVERY_SCAN
@pytest.mark.rules("MAN-14", "CMD-15", "MAN-12")
def test_a_refused_change_below_the_starting_speed_stops_at_once(scan_ms):
    bench = running(scan_ms=scan_ms).manual(speed=500, ms=500).manual(speed=0, ms=scan_ms)
    assert (bench.position, bench.bits) == (2_862, STOPPED | REFUSED)


@EVERY_SCAN
@pytest.mark.rules("MAN-05", "MAN-14")
def test_a_stop_that_has_begun_is_not_changed_by_words(scan_ms):
    bench = running(scan_ms=scan_ms).idle(100)
    bench.out(0, 0, 5, 0, 0, 0, 2_000, 2_000).run(300)
    assert (bench.position, bench.bits, bench.fired) == (2_800, STOPPED, [])


@EVERY_SCAN
@pytest.mark.rules("RST-03", "MAN-11", "MAN-05")
def test_under_a_command_error_the_speed_is_fixed_and_the_bit_still_counts(scan_ms):
    """Reading A-104. The error comes from the follower bit, which leaves the command word as it is."""
    bench = Bench.ready(config=configuration(add=ENCODER), scan_ms=scan_ms).manual(ms=400)
    bench.manual(lsw=0x0080, ms=scan_ms)
    assert bench.fired == ["CMD-30"]
    bench.manual(lsw=0x0080, speed=3_000, ms=100).manual(lsw=0x0080, speed=0, ms=100)
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "COMMAND_ERROR"}
    here = bench.position
    bench.idle(scan_ms).until("STOPPED")
    # released 0.25 of a step, or none, after a whole one: the stop ends on a whole step
    assert (bench.position, bench.bits) == (here + 1_200 + (scan_ms < 1), STOPPED | {"COMMAND_ERROR"})
    assert bench.fired == ["CMD-30"]
