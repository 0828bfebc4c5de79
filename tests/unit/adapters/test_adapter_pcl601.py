"""The PCL601 under the 3601's command layer: what is done, what is refused, what a fault comes to."""

from __future__ import annotations

import pytest
from adapterbench import CONFIGURE, AdapterBench, move
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.pcl601 import Register
from scanrack.runtime.machine import Switch
from scanrack.runtime.machine.contacts import GROUND


def test_before_the_first_good_exchange_the_module_is_not_ok():
    bench = AdapterBench()
    assert bench.bits == {"POSITION_INVALID"}
    assert bench.run(40).bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}


def test_a_configuration_shows_when_the_controller_has_it():
    bench = AdapterBench().run(30)
    bench.give(*CONFIGURE, ms=20)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "MODE_CONFIG"}
    bench.release(10)  # leaving waits for it
    assert "MODE_CONFIG" in bench.bits
    assert bench.run(100).bits == {"MODULE_OK", "POSITION_INVALID"}


def test_a_move_takes_the_time_of_the_lower_rate():
    # 1000 to 5000 steps/s at min(20, 10): 0.4 s and 1,200 steps up and down, 7,600 at 5,000/s: 2.32 s
    bench = AdapterBench().configured()
    began = bench.now_ns
    bench.give(*move(10_000, 5000, 20, 10), ms=5000, until="MOVE_COMPLETE")
    assert bench.position == bench.motor == 10_000
    assert 2.32e9 < bench.now_ns - began < 2.42e9


def test_registration_ends_exactly_behind_the_external_input():
    bench = AdapterBench(Switch(InputBit.EXTERNAL, 6000, 6400)).configured()
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=4000, until="STOPPED")
    assert bench.motor == bench.position == 9000


def test_registration_by_the_released_bit_is_exact_from_the_output_on():
    bench = AdapterBench().configured()
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=1000)
    at = bench.motor
    bench.give(0, 0, 3, 0, 5, 0, 20, 20, ms=4000, until="STOPPED")
    assert 3000 < bench.motor - at <= 3000 + 5000 * 0.02  # a request under way, and one write
    bench.release()
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=1000)  # the mark has been taken away again
    assert {"MOVING_CW"} <= bench.bits


def test_an_encoder_move_by_option_slows_down_when_the_count_has_been_read():
    bench = AdapterBench(encoder_move="polled").configured(0x853E, 63, 1, 0)
    bench.give(2, 4, 0, 100, 2, 0, 20, 20, ms=500)
    assert "MOVING_CW" in bench.bits  # the encoder stands still
    bench.module.machine.turn_encoder(100, bench.now_ns, bench.now_ns + 10_000_000)
    bench.run(500, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


def test_home_is_where_the_switch_is_left():
    # home type 1 leaves the switch on the side it came from: the first step off 3000..3500 is 2999
    bench = AdapterBench(Switch(InputBit.HOME, 3000, 3500)).configured()
    bench.give(32, 0, 0, 0, 5, 0, 20, 20, ms=9000, until="AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME"}
    assert (bench.position, bench.motor) == (0, 2999)


def test_a_limit_ends_a_move_as_on_the_3601():
    bench = AdapterBench(Switch(InputBit.CW_LIMIT, 4000, None)).configured()
    bench.give(*move(10_000), ms=3000, until="STOPPED")
    assert {"INPUT_ERROR", "POSITION_INVALID", "STOPPED", "IN_CW_LIMIT"} <= bench.bits
    assert bench.run(50).position == bench.motor == 4000  # the pin stops the clock at once


@pytest.mark.parametrize(("distance", "limit"), [(10_000, InputBit.CCW_LIMIT), (-10_000, InputBit.CW_LIMIT)])
def test_a_limit_behind_ends_a_move_and_is_known_to_lie_there(distance, limit):
    bench = AdapterBench().configured()
    bench.give(*move(distance), ms=500)
    bench.level(limit, True)
    bench.run(60)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "POSITION_INVALID", "STOPPED", f"IN_{limit.name}"}
    bench.release()
    on = (128 if distance > 0 else 256, 0, 0, 0, 2, 0, 20, 20)
    assert bench.give(*on, ms=500).bits >= {"MOVING_CW" if distance > 0 else "MOVING_CCW"}


HOME_CW = (32, 0, 0, 0, 5, 0, 20, 20)
HOME_CCW = (64, 0, 0, 0, 5, 0, 20, 20)


@pytest.mark.parametrize("search", [HOME_CW, HOME_CCW])
def test_a_search_may_begin_on_a_limit_whose_side_is_not_known(search):
    # nothing has moved yet: hard limit + and - are one bit, and the controller's pins decide
    bench = AdapterBench(Switch(InputBit.CW_LIMIT, -500, None), Switch(InputBit.HOME, -3000, -1000))
    bench.give(*CONFIGURE, ms=400).release()
    assert {"IN_CW_LIMIT", "IN_CCW_LIMIT"} <= bench.bits
    bench.give(*search, ms=100)
    towards = search is HOME_CW  # and stands still for two seconds
    assert {"IN_CW_LIMIT"} == bench.bits - {"MODULE_OK", "POSITION_INVALID", "MOVING_CCW", "ACCELERATING"}
    assert ("MOVING_CCW" in bench.bits) is not towards
    bench.run(9000, until="AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME"}
    assert bench.motor == -999  # met and left going CCW


@pytest.mark.parametrize(("search", "limit"), [(HOME_CW, InputBit.CCW_LIMIT), (HOME_CCW, InputBit.CW_LIMIT)])
def test_the_limit_behind_ends_a_search(search, limit):
    bench = AdapterBench().configured()
    bench.give(*search, ms=1000)
    bench.level(limit, True)
    bench.run(60)
    wrong = {"HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}
    assert bench.bits == {"MODULE_OK", *wrong, f"IN_{limit.name}"}
    at = bench.motor
    assert bench.run(3000).motor == bench.position == at


@pytest.mark.slow
@pytest.mark.parametrize(("first", "home"), [(5000, 5000), (5200, 4999)])
def test_a_limit_on_the_switch_or_in_its_ramp_is_left_with_it_and_the_switch_met_slowly(first, home):
    # the ramp down is 600 steps long; on the very edge the limit stops the axis where the switch comes on
    limit, switch = Switch(InputBit.CW_LIMIT, first, None), Switch(InputBit.HOME, 5000, 9000)
    bench = AdapterBench(limit, switch).configured()
    bench.give(*HOME_CW, ms=3000)
    assert {"IN_HOME", "IN_CW_LIMIT"} <= bench.bits
    bench.run(3000, until="AT_HOME")
    assert {"AT_HOME", "MODULE_OK"} <= bench.bits <= {"AT_HOME", "MODULE_OK", "IN_HOME", "IN_CW_LIMIT"}
    assert (bench.position, bench.motor) == (0, home)


@pytest.mark.slow
def test_a_search_that_makes_no_step_finds_a_limit_and_no_home():
    bench = AdapterBench(Switch(InputBit.HOME, -9000, -5000)).configured()
    bench.give(*move(-1000), ms=1000, until="MOVE_COMPLETE").release()
    bench.level(InputBit.CW_LIMIT, True)
    bench.run(60)  # nothing moves: it is taken for the one that was ahead
    assert "IN_CCW_LIMIT" in bench.bits
    bench.give(*HOME_CW, ms=500)
    assert bench.bits == {"MODULE_OK", "IN_CW_LIMIT"}
    bench.level(InputBit.CW_LIMIT, False)
    bench.run(9000, until="AT_HOME")
    assert bench.motor == -4999  # the search was turned round


def test_emergency_stop_through_the_diodes_is_no_limit():
    bench = AdapterBench().configured()
    bench.give(*move(10_000), ms=500)
    bench.level(InputBit.ESTOP, True)
    bench.run(100)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "POSITION_INVALID", "STOPPED", "IN_ESTOP"}
    assert bench.position == bench.motor < 10_000


def test_the_counter_is_moved_before_its_range_ends():
    bench = AdapterBench().configured()
    controller = bench.device.controller
    bench.give(*move(7_500_000, 50_000, 2000, 2000), ms=200)  # the counter is at 1,000,000 when idle
    assert controller.values[Register.POSITION] < 0
    bench.give(16).release()
    assert bench.position == bench.motor > 0


@pytest.mark.slow
def test_a_slew_goes_to_the_end_of_the_counters_range_and_begins_anew_behind_it():
    """Somebody has turned the counter to 7,900,000, which is position 0 then: its end is at 8,000,000."""
    bench = AdapterBench().configured()
    bench.device.controller.values[Register.POSITION] = 7_900_000
    bench.run(100).give(512).release()
    at = bench.motor
    slew = (128, 0, 0, 0, 50, 0, 2000, 2000)
    bench.give(*slew, ms=4000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "STOPPED", "INVALID_PROFILE", "COMMAND_ERROR"}
    assert bench.position == bench.motor - at
    assert 100_000 < bench.position < 100_000 + 50_000 * 0.06  # read every 30 ms, and the ramp
    bench.release().give(2048).release()
    assert bench.give(*slew, ms=1000).bits == {"MODULE_OK", "MOVING_CW"}


def test_a_controller_that_moves_by_itself_makes_the_position_invalid():
    bench = AdapterBench().configured()
    bench.device.controller.pins.connect("jog_plus", GROUND)
    bench.device.controller.settle(bench.now_ns)
    assert bench.run(100).bits == {"MODULE_OK", "POSITION_INVALID"}
    assert bench.position > 0


def test_a_power_cycled_controller_is_noticed_in_mid_move():
    bench = AdapterBench().configured()
    bench.give(*move(10_000), ms=500)
    bench.module.cycle_device()
    at = bench.motor
    bench.run(200)
    assert list(bench.image) == [0x6400, 0, 0, 0, 0, 0, 0, 0]
    assert bench.motor == at


def test_after_a_loss_the_axis_is_stopped_and_commands_need_a_new_edge():
    bench = AdapterBench().configured()
    bench.give(*move(10_000), ms=500)
    line = bench.module.controller.line
    line.take_down()
    assert bench.run(400).bits == {"POSITION_INVALID"}
    bench.give(*move(300), ms=50)
    line.put_up()
    bench.run(600)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    assert bench.position == bench.motor
    at = bench.motor
    bench.run(300)
    assert bench.motor == at
    bench.release()
    bench.give(*move(300), ms=500, until="MOVE_COMPLETE")
    assert bench.motor == at + 300


def test_a_pulse_of_20_ms_is_seen_whenever_it_comes():
    # 8.6 ms of status or 6.9 ms of position lie between two looks at the inputs, 6.3 ms each
    bench = AdapterBench(scan_ms=1).configured(0x843F, 63, 1, 0)
    for pause_ms in range(30):
        bench.run(40 + pause_ms)
        bench.level(InputBit.CAPTURE, True)
        bench.run(20, until="IN_CAPTURE")
        bench.level(InputBit.CAPTURE, False)
        bench.run(12, until="IN_CAPTURE")  # what has been read is still on its way
        assert "IN_CAPTURE" in bench.bits, pause_ms


def test_what_is_done_otherwise_is_told_once():
    bench = AdapterBench().configured()
    alike, different = (2, 0, 0, 100, 2, 0, 20, 20), (2, 0, 0, 100, 2, 0, 20, 10)
    s_curve, without_ramp = (2, 1, 0, 100, 2, 0, 20, 20), (2, 1, 0, 100, 1, 0, 20, 10)
    for words, told in (
        (alike, []),
        (without_ramp, []),
        (different, ["different rates"]),
        (different, ["different rates"]),
        (s_curve, ["different rates", "S-curve"]),
        (s_curve, ["different rates", "S-curve"]),
    ):
        bench.give(*words, ms=600, until="MOVE_COMPLETE").release()
        assert bench.told("substitution") == told
    assert bench.motor == 600


def test_what_is_refused_is_not_done_otherwise():
    bench = AdapterBench(strict=True).configured()
    bench.give(2, 0, 0, 100, 2, 0, 20, 10)
    assert bench.bits == {"MODULE_OK", "INVALID_PROFILE", "COMMAND_ERROR"}
    assert (bench.reasons, bench.told("substitution")) == (["different rates"], [])
