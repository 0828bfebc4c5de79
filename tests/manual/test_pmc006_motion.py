"""What a PMC006x3s does with its motor: steps, speed mode, zero-back, external stops [4.3]."""

from __future__ import annotations

from math import cos, pi, sin

import pytest
from bench006 import MS, Bench006
from scanrack.io_images.pmc006.status import Status1, Status2
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.controllers.pmc006.ramps import Pmc006Speeds, plan_move, plan_run, plan_slowing

# 4.3.3's table, transcribed
ACCELERATIONS = {1: 77440, 2: 48410, 3: 27170, 4: 21510, 5: 14080, 6: 10460, 7: 6915, 8: 5210}


def constant(speed: int = 1000) -> Bench006:
    """Return a bench whose moves have one speed throughout."""
    bench = Bench006()
    bench.set(start_speed=speed, stop_speed=speed, max_speed=speed)
    return bench


@pytest.mark.parametrize(("coefficient", "acceleration"), ACCELERATIONS.items())
def test_4_3_3_a_ramp_takes_the_time_and_distance_of_the_table(coefficient: int, acceleration: int) -> None:
    motion = plan_run(0, 0, 1, Pmc006Speeds(600, 6000, 600, coefficient, 5))
    ramp_s = (6000 - 600) / acceleration
    assert motion.segments[-1].start_ns == pytest.approx(ramp_s * 1e9, abs=2)
    assert motion.travel_at(round(ramp_s * 1e9)) / 1e12 == pytest.approx(ramp_s * (6000 + 600) / 2, abs=1e-3)


def test_4_3_3_the_s_curve_stays_by_the_raised_cosine() -> None:
    motion = plan_run(0, 0, 1, Pmc006Speeds(600, 6000, 600, 3, 3))
    ramp_s = (6000 - 600) / 27170
    for part in range(101):
        at_s = ramp_s * part / 100
        cosine = 600 * at_s + 2700 * (at_s - ramp_s / pi * sin(pi * at_s / ramp_s))
        assert motion.travel_at(round(at_s * 1e9)) / 1e12 == pytest.approx(cosine, abs=0.002 * 5400 * ramp_s)


@pytest.mark.parametrize("up", [True, False])
def test_4_3_3_the_s_curve_meets_the_raised_cosine_in_speed(up: bool) -> None:
    """At 0, 1/3, 1/2, 2/3 and 1 of the ramp's time exactly, elsewhere within 0.6 % of the change of speed."""
    motion = plan_run(0, 0, 1, Pmc006Speeds(600, 6000, 600, 3, 3))
    start_ns, ramp_ns = 0.0, (6000 - 600) / 27170 * 1e9
    if not up:
        motion = plan_slowing(motion, 10**9, 600, 3)
        start_ns = (motion.end_ns or 0) - ramp_ns
    for part in range(1, 120):
        speed = motion.speed_at(round(start_ns + ramp_ns * part / 120)) / 1000
        cosine = 3300 - (1 if up else -1) * 2700 * cos(pi * part / 120)
        assert speed == pytest.approx(cosine, abs=0.006 * 5400)
        if part in (40, 60, 80):
            assert speed == pytest.approx(cosine, abs=0.01)
        # through these points with slope 0 at both ends: 9/4 x^2, a straight line, and the same from the end
        x = part / 120
        shape = min(
            9 / 4 * x**2 if x < 1 / 3 else 3 / 2 * x - 1 / 4, 1 - 9 / 4 * (1 - x) ** 2 if x > 2 / 3 else 1
        )
        assert speed == pytest.approx(600 + 5400 * (shape if up else 1 - shape), abs=0.01)


def test_4_3_3_coefficient_0_is_no_ramp() -> None:
    motion = plan_move(0, 0, 6000, Pmc006Speeds(600, 6000, 600, 0, 0))
    assert (motion.end_ns, len(motion.segments)) == (10**9, 1)


def test_4_3_3_ramps_that_do_not_fit_are_steepened_and_reach_the_speed() -> None:
    # 300 steps; at coefficient 8 the ramps alone take 2 * (36,000,000 - 360,000) / 10,420 = 6841 steps
    motion = plan_move(0, 0, 300, Pmc006Speeds(600, 6000, 600, 8, 8))
    assert motion.final_steps == 300
    assert motion.speed_at(motion.instant_of(150) or 0) == pytest.approx(6_000_000, rel=0.01)
    assert motion.end_ns == pytest.approx(2 * 300 / (600 + 6000) * 1e9, abs=2)


@pytest.mark.parametrize(("steps", "ns"), [(255, 255 * 2 * 10**9 // 1600), (1, 2 * 10**9 // 1600)])
def test_4_3_3_below_256_steps_the_speed_goes_straight_from_start_to_stop(steps: int, ns: int) -> None:
    motion = plan_move(0, 0, steps, Pmc006Speeds(600, 200_000, 1000, 5, 5))
    assert motion.final_steps == steps
    assert motion.end_ns == pytest.approx(ns, abs=1)


def test_4_3_3_a_move_of_256_steps_has_the_s_curve() -> None:
    assert len(plan_move(0, 0, 256, Pmc006Speeds(600, 6000, 600, 1, 1)).segments) > 1


def test_4_3_8_slowing_ends_on_a_whole_step_after_the_ramp() -> None:
    running = plan_run(0, 0, -1, Pmc006Speeds(600, 5000, 600, 3, 3))
    slowing = plan_slowing(running, 2 * 10**9, 700, 3)
    ramp = (5000**2 - 700**2) / (2 * 27170)
    assert slowing.final_steps is not None
    assert 0 <= slowing.final_steps - running.travel_at(2 * 10**9) / 1e12 - ramp < 1
    assert slowing.speed_at((slowing.end_ns or 0) - 1000) == pytest.approx(700_000, rel=1e-3)


@pytest.mark.parametrize("at_ns", [1_500_000_000, 1_500_000_001, 1_777_123_457, 2_345_678_901])
def test_4_3_8_slowing_ends_when_a_whole_step_is_made(at_ns: int) -> None:
    running = plan_run(0, 0, 1, Pmc006Speeds(600, 5000, 600, 3, 3))
    slowing = plan_slowing(running, at_ns, 700, 3)
    assert slowing.end_ns is not None
    # the last ns at 700 steps/s: within 2 ns' way of the step, 1.4e-6
    assert slowing.travel_at(slowing.end_ns - 1) / 1e12 == pytest.approx(slowing.final_steps, abs=2e-6)
    assert slowing.travel_at(slowing.end_ns - 1_000_000) / 1e12 < (slowing.final_steps or 0) - 0.6


def test_4_3_4_the_position_is_a_signed_number_of_32_bits() -> None:
    """[4.1.4]"""
    axis = Bench006().controller.axis
    for position, steps, after in ((2**31 - 1, 1, -(2**31)), (-(2**31), -1, 2**31 - 1), (0, 7, 7)):
        axis.position = position
        axis.physical += steps
        assert axis.position == after


def test_4_1_2_a_controller_from_the_factory_is_at_255() -> None:
    assert Pmc006().controller.address == 0xFF


def test_4_3_1_a_move_counts_and_busy_tells_of_it() -> None:
    bench = constant()
    bench.ask("s", 3000)
    began_ns = bench.bus.now_ns - 8_333_333  # the answer's time
    assert bench.status1 == Status1.BUSY
    bench.bus.run_until(began_ns + 1_500 * MS)
    assert bench.controller.axis.position == 1500
    bench.bus.run_until(began_ns + 3_000 * MS - 1)
    assert (bench.controller.axis.position, bench.controller.status1) == (2999, Status1.BUSY)
    bench.bus.run_until(began_ns + 3_000 * MS)
    assert (bench.controller.axis.position, bench.controller.status1) == (3000, Status1(0))
    bench.set(direction=0)
    bench.ask("s", 3100)
    bench.wait(4000)
    assert bench.position == -100


def test_4_3_1_a_step_instruction_while_busy_is_ignored() -> None:
    bench = constant()
    bench.ask("s", 500)
    assert bench.ask("s", 500) == 6
    bench.wait(2000)
    assert bench.position == 500


@pytest.mark.parametrize("name", ["start_speed", "stop_speed"])
def test_4_3_9_a_start_or_stop_speed_above_the_maximum_keeps_it_from_starting(name: str) -> None:
    bench = Bench006()
    bench.set(**{name: 6001})
    assert (bench.ask("s", 500), bench.ask("N", 1), bench.status2) == (6, 6, Status2.DIR)
    bench.set(**{name: 6000})
    assert bench.ask("s", 500) == 0


def test_4_3_12_abort_stops_at_once_and_the_next_step_is_taken() -> None:
    bench = constant()
    bench.ask("s", 3000)
    bench.wait(1000)
    bench.ask("I")
    stopped = bench.position
    assert 1000 <= stopped <= 1050
    assert bench.status1 == Status1(0)
    bench.wait(1000)
    assert bench.position == stopped
    bench.ask("s", 10)
    bench.wait(1000)
    assert bench.position == stopped + 10


def test_4_3_12_free_run_ends_the_move_and_refuses_further_ones() -> None:
    bench = constant()
    bench.ask("s", 3000)
    bench.wait(500)
    bench.set(free_run=1)
    position = bench.position
    assert [bench.ask("s", 10), bench.ask("N", 1), bench.ask("8", 1000)] == [6, 6, 6]
    bench.wait(500)
    assert bench.position == position
    bench.set(free_run=0)
    bench.ask("s", 10)
    bench.wait(100)
    assert bench.position == position + 10


def test_4_3_8_speed_mode_runs_at_the_speed_it_was_entered_with() -> None:
    bench = constant()
    bench.set(direction=0)
    assert bench.ask("N", 1) == 1
    assert bench.status2 == Status2.SPEED_MODE
    bench.set(max_speed=5000)
    before = bench.controller.axis.physical
    bench.wait(1000)
    assert bench.controller.axis.physical == before - 1000
    assert [bench.ask("N", 1), bench.ask("s", 5)] == [6, 6]
    assert bench.ask("N", 0) == 0
    bench.wait(100)
    assert (bench.status1, bench.status2) == (Status1(0), Status2(0))


def test_4_3_8_zero_slows_down_and_abort_does_not() -> None:
    bench = Bench006()
    bench.set(max_speed=5000, decel_coefficient=8)
    bench.ask("N", 1)
    bench.wait(2000)
    bench.ask("N", 0)
    began = bench.controller.axis.physical
    assert bench.status1 == Status1.BUSY
    bench.wait(2000)
    # (25,000,000 - 360,000) / 10,420 = 2365 steps, less what the answer's 8.3 ms took at 5000 steps/s
    assert 2315 <= bench.position - began <= 2367
    bench.ask("N", 1)
    bench.wait(2000)
    bench.ask("I")
    stopped = bench.controller.axis.physical
    assert bench.status2 == Status2.DIR
    assert bench.controller.axis.physical == stopped


def test_4_3_8_zero_does_nothing_to_a_move() -> None:
    bench = constant()
    bench.ask("s", 500)
    bench.ask("N", 0)
    bench.wait(1000)
    assert bench.position == 500


def test_4_3_4_the_position_can_be_set_and_is_gone_without_power() -> None:
    bench = constant()
    bench.ask("i", 100_000)
    bench.ask("s", 250)
    bench.wait(1000)
    assert bench.position == 100_250
    bench.ask("m", 64)  # does not rescale it
    assert bench.position == 100_250
    bench.power_cycle()
    assert (bench.position, bench.controller.axis.physical) == (0, 250)


def test_the_position_register_is_32_bits() -> None:
    bench = constant()
    bench.ask("i", 0x7FFFFFFF)
    bench.ask("s", 1)
    bench.wait(100)
    assert bench.position == -0x80000000


@pytest.mark.parametrize(
    ("pin", "enable", "flag", "clear"),
    [(Pin.EXT1, 1, Status1.EXT1, "b"), (Pin.EXT2, 2, Status1.EXT2, "l"), (Pin.EXT2, 3, Status1.EXT2, "l")],
)
@pytest.mark.parametrize("rising", [False, True])
def test_4_3_6_an_external_stop_locks_until_its_flag_is_cleared(
    pin: Pin, enable: int, flag: Status1, clear: str, rising: bool
) -> None:
    bench = constant()
    bench.pin(Pin.EXT1, not rising)
    bench.pin(Pin.EXT2, not rising)
    bench.set(ext_stop_enable=enable, ext_trigger_mode=3 if rising else 0)
    bench.ask("s", 3000)
    bench.wait(500)
    bench.pin(pin, rising)
    stopped = bench.controller.axis.physical
    assert bench.status1 == flag
    bench.pin(pin, not rising)
    assert [bench.ask("s", 10), bench.ask("N", 1), bench.ask("8", 100)] == [6, 6, 6]
    bench.ask("l" if clear == "b" else "b")
    assert bench.status1 == flag
    bench.ask(clear)
    assert bench.status1 == Status1(0)
    assert bench.ask("s", 10) == 0
    bench.wait(100)
    assert bench.position == stopped + 10


def test_4_3_6_an_edge_latches_at_rest_too_and_a_level_that_was_there_does_not() -> None:
    bench = Bench006()
    bench.pin(Pin.EXT1, False)
    bench.set(ext_stop_enable=3)
    assert bench.status1 == Status1(0)
    bench.pin(Pin.EXT1, True)
    assert bench.status1 == Status1(0)
    bench.pin(Pin.EXT1, False)
    assert bench.status1 == Status1.EXT1


@pytest.mark.parametrize(("pin", "bit", "towards"), [(Pin.EXT1, 1, 0), (Pin.EXT2, 2, 1)])
def test_4_1_1_stepping_on_towards_an_active_limit_is_error_7(pin: Pin, bit: int, towards: int) -> None:
    bench = constant()
    bench.pin(pin, False)
    bench.set(ext_stop_enable=bit, direction=towards)
    assert [bench.ask("s", 10), bench.ask("N", 1)] == [7, 7]
    assert bench.status1 == Status1(0)
    bench.set(direction=1 - towards)
    assert bench.ask("s", 10) == 0
    bench.wait(100)
    bench.set(direction=towards, ext_stop_enable=0)
    assert bench.ask("s", 10) == 0


def test_4_3_6_a_switch_on_the_way_stops_the_motor_on_its_step() -> None:
    bench = constant()
    bench.pin(Pin.EXT2, Contact(low=1234))  # high up to 1233
    bench.set(ext_stop_enable=2)
    bench.ask("s", 3000)
    bench.wait(3000)
    assert (bench.position, bench.status1) == (1234, Status1.EXT2)


def zero_back_bench(last_high: int) -> Bench006:
    """Return a bench with an opto on EXT1, blocked (high) up to a position, and rising edges."""
    bench = Bench006()
    bench.set(ext_trigger_mode=3, zero_back_speed=1000)
    bench.pin(Pin.EXT1, Contact(low=last_high + 1))
    return bench


@pytest.mark.parametrize("armed", [0, 1])
def test_4_3_13_zero_back_from_off_the_switch(armed: int) -> None:
    bench = zero_back_bench(-2000)
    bench.set(ext_stop_enable=armed)
    assert bench.ask("8", 20_000) == 0
    bench.wait(500)
    assert bench.status1 == Status1.BUSY | Status1.HOME
    assert bench.status2 & Status2.DIR  # the direction register is left alone
    bench.wait(3000)
    assert bench.status1 == (Status1.EXT1 if armed else Status1(0))
    assert (bench.controller.axis.physical, bench.position) == (-2000, 0)


def test_4_3_13_zero_back_from_on_the_switch_retreats_a_sixteenth_of_the_stroke_first() -> None:
    bench = zero_back_bench(150)
    bench.ask("8", 16_000)
    highest = 0
    for _ in range(60):
        bench.wait(100)
        highest = max(highest, bench.controller.axis.physical)
    assert 980 <= highest <= 1000
    assert (bench.controller.axis.physical, bench.position) == (150, 0)
    assert bench.status1 == Status1(0)


def test_4_3_13_a_retreat_that_does_not_suffice_goes_on() -> None:
    bench = zero_back_bench(150)
    bench.ask("8", 1600)
    bench.wait(3000)
    assert (bench.controller.axis.physical, bench.position, bench.status1) == (150, 0, Status1(0))


def test_4_3_13_a_switch_that_is_never_left_ends_it_after_the_stroke() -> None:
    bench = zero_back_bench(1_000_000)
    bench.ask("8", 1600)
    bench.wait(5000)
    assert (bench.controller.axis.physical, bench.position, bench.status1) == (1600, 1600, Status1(0))


def test_4_3_13_a_stroke_used_up_clears_home_and_leaves_the_position() -> None:
    bench = zero_back_bench(-5000)
    bench.ask("8", 2000)
    bench.wait(5000)
    assert (bench.position, bench.status1) == (-2000, Status1(0))


def test_4_3_13_the_factory_trigger_takes_low_for_the_switch() -> None:
    bench = Bench006()
    bench.pin(Pin.EXT1, Contact(high=-101))  # low up to -101
    bench.ask("8", 2000)
    bench.wait(3000)
    assert (bench.controller.axis.physical, bench.position) == (-101, 0)


def test_4_3_13_ext2_stops_a_zero_back_if_it_is_armed_and_abort_ends_it() -> None:
    bench = zero_back_bench(-5000)
    bench.pin(Pin.EXT2, Contact(high=-301))
    bench.set(ext_stop_enable=2, ext_trigger_mode=1)
    bench.ask("8", 20_000)
    bench.wait(3000)
    assert (bench.position, bench.status1) == (-301, Status1.EXT2)
    bench.ask("l")
    assert bench.ask("8", 20_000) == 0
    bench.ask("I")
    assert bench.status1 == Status1(0)
    assert bench.ask("8", 0) == 6


def test_2_3_the_closed_loop_type_notices_a_stall() -> None:
    bench = Bench006(closed_loop=True)
    bench.ask("s", 5000)
    bench.wait(100)
    bench.controller.stall()
    assert bench.status1 == Status1.STALL
    bench.ask("s", 500)
    assert bench.status1 == Status1.BUSY
    open_loop = constant()
    open_loop.ask("s", 5000)
    open_loop.controller.stall()
    assert open_loop.status1 == Status1.BUSY


def test_4_3_13_zero_back_jumps_to_the_start_speed_and_from_the_stop_speed() -> None:
    """Below 256 steps the speed goes straight from one to the other [4.3.3]."""
    bench = Bench006()
    bench.set(start_speed=100, stop_speed=900, zero_back_speed=1000)
    bench.pin(Pin.EXT1, True)
    bench.ask("8", 200)
    began_ns = bench.bus.now_ns - 8_333_333  # the answer's time
    # v = 100 + 800 t / T with T = 200 / 500 s; after 0.1 s 100 * 0.1 + 1000 * 0.1 ** 2 = 20 steps
    bench.bus.run_until(began_ns + 100 * MS)
    assert bench.controller.axis.position == -20
    bench.bus.run_until(began_ns + 399 * MS)
    assert bench.controller.axis.homing
    bench.bus.run_until(began_ns + 401 * MS)
    assert not bench.controller.axis.homing
    assert bench.controller.axis.position == -200


@pytest.mark.parametrize(
    ("name", "zero_back", "end_ms"), [("start_speed", 100, 2000), ("stop_speed", 100, 2000)]
)
def test_4_3_13_neither_jump_of_a_zero_back_exceeds_its_speed(name: str, zero_back: int, end_ms: int) -> None:
    """Start and stop speed above the speed back to zero: 200 steps at 100 steps/s throughout."""
    bench = Bench006()
    bench.set(start_speed=100, stop_speed=100, zero_back_speed=zero_back)
    bench.set(**{name: 600})
    bench.pin(Pin.EXT1, True)
    bench.ask("8", 200)
    began_ns = bench.bus.now_ns - 8_333_333
    bench.bus.run_until(began_ns + (end_ms - 1) * MS)
    assert bench.controller.axis.homing
    bench.bus.run_until(began_ns + (end_ms + 1) * MS)
    assert not bench.controller.axis.homing
