"""The PMC006x3s under the 3601's command layer: what is done, what is refused, what a fault comes to."""

from __future__ import annotations

import pytest
from adapterbench import AdapterBench006, move
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime.machine import Switch

HOME_SWITCH = Switch(InputBit.HOME, None, -3000)


def test_a_move_ends_on_its_step():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=5000, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == 10_000


@pytest.mark.parametrize(
    ("words", "options", "reason"),
    [
        ((0x843C, 63, 0, 64), {}, "starting speed"),
        ((0x843D, 63, 1, 0), {}, "capture input"),
        ((0x843E, 63, 1, 0), {}, "external input"),
        ((0x843E, 63, 1, 0), {"hold": "immediate"}, "FSET"),
        ((0x853C, 63, 1, 0), {}, "encoder"),
        ((0x863C, 63, 1, 0), {}, "diagnostic feedback"),
        ((0x843C, 0x1F, 1, 0), {}, "levels of home switch and CCW limit"),
    ],
)
def test_a_configuration_beyond_the_controller_is_refused(words, options, reason):
    bench = AdapterBench006(**options).give(*words, ms=600)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "MODE_CONFIG"}
    assert bench.reasons == [reason]


@pytest.mark.parametrize(
    ("words", "bits", "reason"),
    [
        (move(10, 5000, 20, 5), {"INVALID_PROFILE", "COMMAND_ERROR"}, "rate"),
        ((2, 4, 0, 100, 5, 0, 20, 20), {"COMMAND_ERROR"}, None),  # no encoder: the 3601's own rule is first
        ((128, 0, 0, 500, 5, 0, 100, 100), {"INVALID_PROFILE", "COMMAND_ERROR"}, "registration move"),
        ((128, 0, 0, 0, 0, 64), {"INVALID_PROFILE", "COMMAND_ERROR"}, "speed"),
        ((32, 0, 0, 0, 2, 0, 20, 20), {"HOME_INVALID", "COMMAND_ERROR"}, "find home CW"),
    ],
)
def test_a_command_beyond_the_controller_is_refused_before_anything_is_sent(words, bits, reason):
    bench = AdapterBench006().configured()
    assert {"MODULE_OK"} | bits <= bench.give(*words).bits
    assert bench.reasons == ([] if reason is None else [reason])
    assert bench.motor == 0


def test_home_is_where_the_switch_is_met():
    bench = AdapterBench006(HOME_SWITCH).configured()
    bench.give(64, 0, 0, 0, 2, 0, 20, 20, ms=9000, until="AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "IN_CCW_LIMIT"}
    assert (bench.position, bench.motor) == (0, -3000)
    bench.release()
    bench.give(*move(5000), ms=5000, until="MOVE_COMPLETE")  # CW, off the switch that is the limit, too
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert (bench.position, bench.motor) == (5000, 2000)


def test_a_stroke_without_a_switch_is_no_home():
    bench = AdapterBench006(home_stroke=2000).configured()
    bench.give(64, 0, 0, 0, 2, 0, 20, 20, ms=9000, until="HOME_INVALID")
    assert {"HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"} <= bench.bits
    assert bench.motor == -2000


def test_a_limit_stops_the_motor_by_itself_and_it_can_be_left():
    bench = AdapterBench006(Switch(InputBit.CW_LIMIT, 4000, None)).configured()
    bench.give(*move(10_000), ms=3000, until="STOPPED")
    assert {"INPUT_ERROR", "POSITION_INVALID", "STOPPED", "IN_CW_LIMIT"} <= bench.bits
    bench.run(200)
    assert bench.position == bench.motor == 4000
    bench.release()
    bench.give(2048).release(300)
    bench.give(256, 0, 0, 0, 2, 0, 20, 20, ms=1000)
    assert "MOVING_CCW" in bench.bits
    bench.release(1500)
    assert bench.position == bench.motor < 4000


def test_hold_is_refused_and_the_move_goes_on():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=800)
    bench.give(4, ms=5000, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", "COMMAND_ERROR"}
    assert bench.motor == 10_000


def test_hold_by_option_stops_at_once_and_resumes():
    bench = AdapterBench006(hold="immediate").configured()
    bench.give(*move(10_000), ms=1000)
    bench.give(4, ms=500)
    assert bench.bits == {"MODULE_OK", "HOLD_STATE"}
    assert 0 < bench.position == bench.motor < 10_000
    bench.give(8, 0, 0, 0, 5, 0, 20, 20, ms=5000, until="MOVE_COMPLETE")
    assert bench.position == bench.motor == 10_000


@pytest.mark.parametrize("after_ms", range(0, 700, 53))
@pytest.mark.parametrize("lost", [1, 2])
def test_lost_replies_never_double_a_motion(after_ms, lost):
    bench = AdapterBench006().configured()
    bench.give(*move(400, 4000, 100, 100), ms=after_ms)
    bench.module.controller.line.faults.drop_next = lost
    bench.run(1500)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == 400


def test_registration_by_option_ends_behind_the_place_at_which_it_was_noticed():
    bench = AdapterBench006(registration="polled").configured()
    bench.give(128, 0, 3, 0, 2, 0, 20, 20, ms=1000)
    at = bench.motor
    bench.give(0, 0, 3, 0, 2, 0, 20, 20, ms=5000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "STOPPED"}
    assert 3000 <= bench.position - at <= 3000 + 2000 * 0.06  # a poll of 50 ms, and what was under way
    assert bench.position == bench.motor


def test_the_nearest_rate_by_option():
    bench = AdapterBench006(accel_rounding="nearest").configured()
    bench.give(*move(1000, 2000, 1, 1), ms=3000, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}


def test_a_power_cycled_controller_is_noticed():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=900)
    bench.module.cycle_device()
    bench.run(300)
    assert list(bench.image) == [0x6400, 0, 0, 0, 0, 0, 0, 0]


def test_a_line_that_was_down_leaves_the_axis_stopped():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=900)
    bench.module.controller.line.take_down()
    assert bench.run(600).bits == {"POSITION_INVALID"}
    bench.module.controller.line.put_up()
    bench.run(900)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    assert bench.position == bench.motor < 10_000


@pytest.mark.parametrize("after_ms", [0, 9, 42])
def test_a_reply_that_is_on_the_line_when_the_power_goes_answers_nothing_later(after_ms):
    """A PMC006's replies do not say to what; one taken for the next makes all that follow wrong."""
    bench = AdapterBench006(scan_ms=1).configured()
    bench.run(after_ms)
    bench.module.power_cycle()
    bench.release(300).configured()
    bench.give(*move(400, 4000, 100, 100), ms=600)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == 400
