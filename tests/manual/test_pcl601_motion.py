"""Motion of the PCL601: profiles by the manual's arithmetic, limits, homing, jog, and what stops it.

Arithmetic: a ramp from B to M at A takes (M - B)/A s and (M^2 - B^2)/2A steps. Most tests use B = 500,
M = 2000, A = 1000: 1.5 s and 1875 steps.
"""

from __future__ import annotations

from math import sqrt

import pytest
from bench601 import MS, Bench601
from scanrack.io_images.pcl601 import Error, Register
from scanrack.runtime import Contact


@pytest.fixture
def bench():
    bench = Bench601()
    bench.set_up()
    return bench


def end_of(bench):
    """Run until the axis is idle; return how long that took from the last command, in s."""
    start = bench.bus.now_ns
    while bench.controller.busy:
        assert bench.bus.next_event_ns() is not None
        bench.bus.run_until(bench.bus.next_event_ns())
    return (bench.bus.now_ns - start) / 1e9


@pytest.mark.parametrize("direction", [1, 0])
@pytest.mark.parametrize("steps", [1, 2, 100, 3750, 3751, 10_000])
def test_relative_move(bench, direction, steps):
    bench.write(Register.DIRECTION, direction)
    bench.write(Register.STEPS, steps)
    begun = bench.bus.now_ns
    bench.controller.do(1)
    bench.controller.settle(begun)
    if steps < 3750:
        peak = sqrt(500**2 + 1000 * steps)
        seconds = 2 * (peak - 500) / 1000
    else:
        seconds = 3 + (steps - 3750) / 2000
    assert end_of(bench) == pytest.approx(seconds, abs=2e-9)
    assert bench.read(Register.POSITION) == bench.position == (steps if direction else -steps)
    assert bench.read(Register.DIRECTION) == direction


def test_the_tutorial_s_profile():
    # A 1000, B 500, M 5000: 4000 steps are too short for M; the peak is sqrt(500^2 + 1000*4000) = 2061.6/s
    bench = Bench601()
    bench.go(4000)
    assert end_of(bench) == pytest.approx(2 * (sqrt(4_250_000) - 500) / 1000, abs=0.003)
    assert bench.read(Register.POSITION) == 4000


@pytest.mark.parametrize(("target", "direction"), [(3000, 1), (-3000, 0)])
def test_absolute_move_sets_the_direction_itself(bench, target, direction):
    bench.write(Register.DIRECTION, 1 - direction)
    bench.go_to(target)
    end_of(bench)
    assert bench.read(Register.POSITION) == target
    assert bench.read(Register.DIRECTION) == direction


def test_absolute_counts_from_the_position_register(bench):
    bench.write(Register.POSITION, 8000)
    bench.go_to(7000)
    end_of(bench)
    assert (bench.read(Register.POSITION), bench.position) == (7000, -1000)


def test_the_register_written_last_decides(bench):
    bench.write(Register.ABS_TARGET, 700)
    bench.write(Register.STEPS, 30)
    bench.code(1)
    end_of(bench)
    assert bench.position == 30
    bench.write(Register.STEPS, 5)
    bench.write(Register.ABS_TARGET, 100)
    bench.code(1)
    end_of(bench)
    assert bench.position == 100


def test_go_again_repeats_a_relative_move_and_has_nothing_to_do_after_an_absolute_one(bench):
    bench.go(100)
    end_of(bench)
    bench.code(1)
    end_of(bench)
    assert bench.position == 200
    bench.go_to(50)
    end_of(bench)
    bench.code(1)
    assert not bench.busy()
    assert (bench.position, bench.errors()) == (50, 0)


def test_go_without_steps_is_nothing(bench):
    bench.code(1)
    assert (bench.busy(), bench.position, bench.errors()) == (False, 0, 0)


@pytest.mark.parametrize(
    ("register", "value"), [(Register.BASE_SPEED, 2000), (Register.MAX_SPEED, 499), (Register.ACCEL, 99)]
)
@pytest.mark.parametrize("code", [1, 2, 3, 4])
def test_speeds_that_do_not_fit_are_the_motor_error(bench, register, value, code):
    bench.write(Register.STEPS, 100)
    bench.write(register, value)
    bench.code(code)
    assert (bench.busy(), bench.errors()) == (False, 16)


def test_pairs_are_checked_when_they_are_used(bench):
    bench.write(Register.STEPS, 8_388_608)
    bench.code(1)
    assert (bench.busy(), bench.errors()) == (False, 64)
    bench.code(10)
    bench.write(Register.ABS_TARGET, 8_388_608)
    bench.code(1)
    assert (bench.busy(), bench.errors()) == (False, 32)
    bench.code(10)
    bench.write(Register.POSITION, -8_000_000)
    bench.go_to(8_000_000)
    assert (bench.busy(), bench.errors()) == (False, 32)


def test_slew_and_soft_stop(bench):
    bench.code(4)
    bench.wait(3000)
    bench.code(6)
    at = bench.position
    assert end_of(bench) == pytest.approx(1.5, abs=0.01)
    assert bench.position - at == pytest.approx(1875, abs=15)
    assert bench.errors() == 0


def test_soft_stop_in_an_index_creeps_to_its_end(bench):
    bench.go(4000)
    bench.wait(1000)  # 1500/s at about 1000 steps; 1 s and 1000 steps down, 2000 steps at 500/s: 4 s
    bench.code(6)
    assert end_of(bench) == pytest.approx(5, abs=0.05)
    assert bench.position == 4000


@pytest.mark.parametrize("wait_ms", [1700, 2000, 2345, 2800, 3000, 3110])
def test_soft_stop_on_the_last_ramp_changes_nothing(bench, wait_ms):
    bench.write(Register.STEPS, 4000)
    begun = bench.bus.now_ns
    bench.controller.do(1)
    bench.controller.settle(begun)
    bench.wait(wait_ms)
    bench.controller.do(6)
    bench.controller.settle(bench.bus.now_ns)
    end_of(bench)
    assert bench.position == 4000
    assert bench.bus.now_ns - begun == 3_125_000_000  # 3 s of ramps, 250 steps at 2000/s


def test_soft_stop_when_idle_does_nothing(bench):
    bench.code(6)
    assert (bench.busy(), bench.errors()) == (False, 0)


def test_hard_stop_is_immediate_and_keeps_the_count(bench):
    bench.go(4000)
    bench.wait(1000)
    bench.code(5)
    assert not bench.busy()
    at = bench.position
    bench.wait(500)
    assert bench.position == at == bench.read(Register.POSITION)


@pytest.mark.parametrize(("limit", "direction"), [("hard_plus", 1), ("hard_minus", 0)])
@pytest.mark.parametrize("code", [1, 2, 3, 4])
def test_hard_limits_stop_at_once_in_their_direction(bench, limit, direction, code):
    bench.write(Register.DIRECTION, direction)
    bench.write(Register.STEPS, 9000)
    if direction:
        bench.ge(limit, 1234)
    else:
        bench.le(limit, -1234)
    bench.code(code)
    end_of(bench)
    assert bench.position == (1234 if direction else -1234)
    assert bench.errors() == 0
    bench.code(code)  # into the limit: no step
    assert not bench.busy()
    bench.write(Register.DIRECTION, 1 - direction)
    bench.code(code)
    assert bench.busy()


def test_a_hard_limit_of_the_other_direction_is_not_heeded(bench):
    bench.pin("hard_minus")
    bench.go(100)
    end_of(bench)
    assert bench.position == 100


def test_soft_limit_in_an_index_creeps_to_the_end(bench):
    bench.ge("soft_plus", 3000)
    bench.go(10_000)
    seconds = end_of(bench)
    # 1875 up in 1.5 s, 1125 at 2000/s, 1875 down in 1.5 s, the last 5125 at 500/s
    assert seconds == pytest.approx(1.5 + 1125 / 2000 + 1.5 + 5125 / 500, abs=0.01)
    assert bench.position == 10_000


def test_soft_limit_stops_a_slew_on_a_ramp(bench):
    bench.ge("soft_plus", 3000)
    bench.code(4)
    end_of(bench)
    assert bench.position in (4875, 4876)


def test_home_type_0(bench):
    bench.ge("soft_plus", 3000)
    bench.ge("home", 6000)
    bench.code(2)
    seconds = end_of(bench)
    assert seconds == pytest.approx(1.5 + 1125 / 2000 + 1.5 + (6000 - 4875) / 500, abs=0.01)
    assert (bench.position, bench.read(Register.POSITION)) == (6000, 6000)  # the counter is left alone


def test_home_type_0_with_the_home_limit_first_is_a_hard_stop(bench):
    bench.ge("home", 3000)
    bench.code(2)
    end_of(bench)
    assert bench.position == 3000


def test_home_type_0_on_the_switch_ends_with_no_step(bench):
    bench.pin("home")
    bench.code(2)
    assert (bench.busy(), bench.position) == (False, 0)


def test_home_type_1(bench):
    bench.write(Register.DIRECTION, 0)
    bench.le("home", -3000)
    bench.code(3)
    seconds = end_of(bench)
    # stops 1875 beyond the switch, comes back 1876 at 500/s to where it is released
    assert bench.position == -2999
    assert seconds == pytest.approx(1.5 + 1125 / 2000 + 1.5 + 1876 / 500, abs=0.02)
    assert bench.read(Register.DIRECTION) == 0


def test_home_type_1_on_the_switch_reverses_at_base_speed(bench):
    bench.ge("home", -100)
    bench.code(3)
    assert end_of(bench) == pytest.approx(101 / 500, abs=0.01)
    assert bench.position == -101


def test_home_type_1_with_a_short_switch_looks_for_it_again(bench):
    bench.pin("home", Contact(3000, 3100))
    bench.ge("in3", 4000)  # something else happens on the way back
    bench.code(3)
    end_of(bench)
    assert bench.position == 2999


def test_home_is_heeded_by_homing_only(bench):
    bench.ge("home", 500)
    bench.go(1000)
    end_of(bench)
    assert bench.position == 1000


def test_jog_runs_at_base_speed_while_grounded(bench):
    bench.pin("jog_minus")
    bench.wait(1000)
    assert bench.position == -500
    assert bench.controller.busy
    bench.pin("jog_minus", "open")
    assert not bench.busy()
    assert bench.read(Register.DIRECTION) == 0
    bench.go(100)
    end_of(bench)
    assert bench.position == -600


def test_fast_jog_ramps_up_and_down(bench):
    bench.pin("fast_jog")
    bench.pin("jog_plus")
    bench.wait(2500)  # 1.5 s up: 1875 steps; 1 s at 2000/s
    assert bench.position == 3875
    bench.pin("fast_jog", "open")
    bench.wait(2500)  # 1875 down, 1 s at 500/s
    assert bench.position == 6250
    bench.pin("jog_plus", "open")
    assert not bench.busy()


def test_releasing_a_fast_jog_ramps_down_and_stops(bench):
    bench.pin("fast_jog")
    bench.pin("jog_plus")
    bench.wait(2500)
    bench.pin("jog_plus", "open")
    assert end_of(bench) == pytest.approx(1.5, abs=0.001)
    assert bench.position == pytest.approx(3875 + 1875, abs=1)


def test_jog_needs_base_below_jog_speed(bench):
    bench.write(Register.JOG_SPEED, 500)
    bench.pin("jog_plus")
    bench.wait(100)
    assert (bench.position, bench.errors()) == (0, 16)


def test_jog_waits_for_the_end_of_a_motion(bench):
    bench.go(1000)
    bench.pin("jog_minus")
    bench.wait(5000)
    assert bench.position < 1000
    assert bench.read(Register.DIRECTION) == 0


def test_both_jog_inputs_are_none(bench):
    bench.pin("jog_plus")
    bench.wait(100)
    bench.pin("jog_minus")
    bench.wait(100)
    assert (bench.position, bench.controller.busy) == (50, False)
    bench.pin("jog_plus", "open")
    bench.wait(100)
    assert bench.position == 0


def test_jog_into_limits(bench):
    bench.ge("hard_plus", 200)
    bench.pin("jog_plus")
    bench.wait(2000)
    assert (bench.position, bench.busy()) == (200, False)
    bench.pin("hard_plus", "open")
    bench.ge("soft_plus", 300)
    bench.wait(2000)
    assert (bench.position, bench.busy()) == (300, False)


def test_a_hard_stop_ends_a_jog_until_the_input_is_released(bench):
    bench.pin("jog_plus")
    bench.wait(100)
    bench.code(5)
    bench.wait(100)
    at = bench.position
    assert not bench.busy()
    bench.pin("jog_plus", "open")
    bench.pin("jog_plus")
    bench.wait(100)
    assert bench.position == at + 50


def test_power_loss_ends_a_motion_where_it_is(bench):
    bench.code(4)
    bench.wait(1000)
    at = bench.position
    bench.unit.power_cycle(bench.bus.now_ns)
    bench.wait(1000)
    assert (bench.position, bench.read(Register.POSITION), bench.busy()) == (at, 0, False)


def test_motor_current_is_an_output_of_its_own(bench):
    bench.write(Register.MOTOR_CURRENT, 0)
    assert bench.read(Register.MOTOR_CURRENT) == 0
    assert bench.controller.outputs == 0


def test_the_line_is_as_slow_as_its_baud_rate(bench):
    # 8 characters there, 3.5 of silence, 8 back: 19.5 of 286.46 µs; the bench waits 2 ms before it sends
    begun = bench.bus.now_ns
    bench.ask("01 06 00 06 07 d0")
    bench.bus.run_until(bench.bus.quiet_since_ns)
    assert (bench.bus.quiet_since_ns - begun) / MS == pytest.approx(2 + 19.5 * 11 / 38.4, abs=0.001)


LAST = 8_388_607
"""End of the position register's range, either way [Set Position; Appendix 1, 4x13 and 4x14]."""


@pytest.mark.parametrize("position", [LAST + 1, -LAST - 1, 2_147_483_640, -(1 << 31)])
def test_a_position_out_of_range_is_refused(bench, position):
    assert bench.write(Register.POSITION, position) == 3
    assert bench.read(Register.ERROR_CODE) == Error.RANGE
    assert bench.read(Register.POSITION) == 0


@pytest.mark.parametrize("position", [LAST, -LAST])
def test_the_last_position_is_taken(bench, position):
    assert bench.write(Register.POSITION, position) is None
    assert bench.read(Register.POSITION) == position


@pytest.mark.parametrize("code", [1, 2, 3, 4])
@pytest.mark.parametrize("direction", [1, 0])
def test_a_position_out_of_range_in_halves_moves_nothing(bench, code, direction):
    assert bench.ask("01 06 00 0d 00 80") is not None  # the high half alone: 8,388,608
    bench.write(Register.STEPS, 20)
    bench.write(Register.DIRECTION, direction)
    bench.code(code)
    bench.wait(500)
    assert (bench.position, bench.busy()) == (0, False)
    assert bench.read(Register.ERROR_CODE) == Error.RANGE


@pytest.mark.parametrize(("direction", "sign"), [(1, 1), (0, -1)])
def test_an_index_ends_within_the_range(bench, direction, sign):
    bench.write(Register.POSITION, sign * (LAST - 20))
    bench.write(Register.DIRECTION, direction)
    for steps, made in ((21, 0), (20, 20), (1, 20)):
        bench.write(Register.STEPS, steps)
        bench.code(1)
        end_of(bench)
        assert bench.position == sign * made
        assert bool(bench.read(Register.ERROR_CODE)) is (steps != 20)
        bench.code(10)


@pytest.mark.parametrize("begin", [2, 3, 4, "jog_plus"])
def test_motion_without_a_target_stops_at_the_end_of_the_range(bench, begin):
    bench.write(Register.POSITION, LAST - 300)
    if isinstance(begin, int):
        bench.code(begin)
    else:
        bench.pin(begin)
    bench.wait(3000)
    assert (bench.position, bench.read(Register.POSITION), bench.busy()) == (300, LAST, False)
    assert bench.read(Register.ERROR_CODE) == Error.RANGE
    bench.code(10)
    bench.write(Register.DIRECTION, 0)  # away from it there is room
    bench.write(Register.STEPS, 50)
    bench.code(1)
    end_of(bench)
    assert bench.position == 250
    assert not bench.read(Register.ERROR_CODE)
