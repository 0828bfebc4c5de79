"""The PMC006x3s under the 3601's command layer: what is done, what is refused, what a fault comes to."""

from __future__ import annotations

import pytest
from adapterbench import CONFIGURE_006, AdapterBench006, move
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import signed_word
from scanrack.runtime.machine import Switch

HOME_SWITCH = Switch(InputBit.HOME, None, -3000)


def test_a_move_ends_on_its_step():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=5000, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == 10_000


@pytest.mark.slow
def test_home_is_where_the_switch_is_met():
    bench = AdapterBench006(HOME_SWITCH).configured()
    bench.give(64, 0, 0, 0, 2, 0, 20, 20, ms=9000, until="AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "IN_CCW_LIMIT"}
    assert (bench.position, bench.motor) == (0, -3000)
    bench.release()
    bench.give(*move(5000), ms=5000, until="MOVE_COMPLETE")  # CW, off the switch that is the limit, too
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert (bench.position, bench.motor) == (5000, 2000)


ON_THE_SWITCH = {"MODULE_OK", "IN_HOME", "IN_CCW_LIMIT"}


def on_the_switch(**options):
    """At position 500, with 5000 steps of home switch ahead."""
    bench = AdapterBench006(Switch(InputBit.HOME, None, 5000), **options)
    bench.give(*CONFIGURE_006, ms=400).release(20)
    bench.give(512, 0, 0, 500).release(20)
    assert (bench.bits, bench.position) == (ON_THE_SWITCH, 500)
    return bench


@pytest.mark.parametrize(
    ("words", "position"),
    [
        pytest.param((2, 0, 0, 1), 501, id="relative CW"),
        pytest.param((2, 0, 0, 0), None, id="relative by nothing"),
        pytest.param((2, 0, 0, -1), None, id="relative CCW"),
        pytest.param((1, 0, 0, 501), 501, id="absolute CW"),
        pytest.param((1, 0, 0, 500), None, id="absolute to where it stands"),
        pytest.param((1, 0, 0, 499), None, id="absolute CCW"),
    ],
)
def test_only_cw_leads_off_the_home_switch_that_is_the_limit_too(words, position):
    bench = on_the_switch()
    bench.give(*words, 5, 0, 20, 20, ms=500)
    if position is None:
        assert (bench.bits, bench.position) == (ON_THE_SWITCH | {"INPUT_ERROR"}, 500)
    else:
        assert (bench.bits, bench.position) == (ON_THE_SWITCH | {"MOVE_COMPLETE"}, position)


def test_a_move_off_the_home_switch_can_be_held_on_it_and_resumed():
    bench = on_the_switch(hold="immediate")
    bench.give(*move(10_000), ms=700)
    bench.give(4, ms=500)
    assert bench.bits == ON_THE_SWITCH | {"HOLD_STATE"}
    bench.give(8, 0, 0, 0, 5, 0, 20, 20, ms=5000, until="MOVE_COMPLETE")
    assert (bench.bits, bench.motor) == ({"MODULE_OK", "MOVE_COMPLETE"}, 10_000)


def test_a_stroke_without_a_switch_is_no_home():
    bench = AdapterBench006(home_stroke=2000).configured()
    bench.give(64, 0, 0, 0, 2, 0, 20, 20, ms=9000, until="HOME_INVALID")
    assert {"HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"} <= bench.bits
    assert bench.motor == -2000


@pytest.mark.slow
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


@pytest.mark.slow
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
    bench.run(500)
    assert list(bench.image) == [0x6400, 0, 0, 0, 0, 0, 0, 0]


def test_a_line_that_was_down_leaves_the_axis_stopped():
    bench = AdapterBench006().configured()
    bench.give(*move(10_000), ms=900)
    bench.module.controller.line.take_down()
    assert bench.run(600).bits == {"POSITION_INVALID"}
    bench.module.controller.line.put_up()
    bench.run(1200)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    assert bench.position == bench.motor < 10_000


def test_without_the_line_the_mode_bit_of_configuration_mode_stays_with_the_plcs():
    bench = AdapterBench006()
    bench.give(*CONFIGURE_006, ms=400)
    bench.module.controller.line.take_down()
    bench.run(600)
    assert bench.image[0] == signed_word(0x8400)  # MODE_CONFIG, POSITION_INVALID
    bench.module.plc_run(False)
    assert "MODE_CONFIG" in bench.release().bits  # program mode takes nobody out of configuration mode
    bench.module.plc_run(True)
    assert bench.release().bits == {"POSITION_INVALID"}
    bench.module.controller.line.put_up()
    assert bench.run(1200).bits == {"MODULE_OK", "POSITION_INVALID"}


@pytest.mark.slow
@pytest.mark.parametrize("after_ms", range(40, 65, 5))
def test_a_counter_that_is_put_back_as_the_line_fails_moves_nothing(after_ms):
    bench = AdapterBench006().configured()
    bench.give(
        *move(-600_000, 200_000, 2000, 2000), ms=9000, until="MOVE_COMPLETE"
    )  # so near to 0: back to 1,000,000
    bench.run(after_ms)
    bench.module.controller.line.faults.drop_next = 3
    bench.run(2000)
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID"}
    assert bench.position == bench.motor == -600_000


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


@pytest.mark.parametrize(
    ("ailment", "within_ms"),
    [({"supply_v": 5.0}, 150), ({"overheated": True}, 900)],  # the second status comes with each tenth poll
)
def test_a_controller_that_is_unfit_is_not_ok_until_it_is_well_again(ailment, within_ms):
    bench = AdapterBench006().configured()
    controller = bench.device.controller
    well = {name: getattr(controller, name) for name in ailment}
    for name, value in ailment.items():
        setattr(controller, name, value)
    assert bench.run(within_ms).bits == set()
    assert bench.run(1000).bits == set()
    assert len([event for event in bench.module.events if event.kind == "adapter"]) == 1
    for name, value in well.items():
        setattr(controller, name, value)
    assert bench.run(within_ms).bits == {"MODULE_OK"}


def test_a_controller_that_is_unfit_claims_no_rest():
    bench = AdapterBench006().configured()
    bench.give(*move(50), ms=800, until="MOVE_COMPLETE").release()
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    controller = bench.device.controller
    well, controller.supply_v = controller.supply_v, 5.0
    assert bench.run(200).bits == set()
    controller.supply_v = well
    assert bench.run(200).bits == {"MODULE_OK", "MOVE_COMPLETE"}


def test_a_reply_that_may_be_late_tells_nothing_of_the_supply():
    # replies do not name their requests: the low byte of a position may look like a supply that is too low
    bench = AdapterBench006().configured()
    bench.module.controller.line.faults.drop_next = 1
    bench.run(150)
    assert bench.module.driver.master.overdue == 1
    bench.device.controller.supply_v = 5.0
    assert bench.run(600).bits == {"MODULE_OK"}  # for a second after the reply was lost
    assert bench.run(600).bits == set()


def test_a_motor_that_was_released_has_lost_its_position():
    bench = AdapterBench006().configured()
    bench.device.controller.memory["free_run"] = 1
    assert bench.run(900).bits == {"MODULE_OK", "POSITION_INVALID"}


def test_a_stalled_motor_has_lost_its_position():
    bench = AdapterBench006().configured()
    bench.device.controller.axis.stalled = True
    assert bench.run(200).bits == {"MODULE_OK", "POSITION_INVALID"}
    bench.release(100).give(512).release()
    assert bench.bits == {"MODULE_OK"}  # told once


def test_a_new_speed_by_option_is_run_at_after_a_stop():
    """2000 steps/s, a stop at 77 steps/ms/s, 4000 steps/s; 60,000 steps in 20 s are 3,000 steps/s."""
    bench = AdapterBench006(respeed="restart").configured()
    bench.give(128, 0, 0, 0, 2, 0, 100, 100, ms=1000)
    at = bench.motor
    bench.give(128, 0, 0, 0, 4, 0, 100, 100, ms=1000)
    assert "MOVING_CW" in bench.bits
    assert 1600 < at < 2000
    at = bench.motor
    bench.run(1000)
    assert 3990 <= bench.motor - at <= 4010
    bench.release(500)
    assert bench.bits == {"MODULE_OK", "STOPPED"}
    assert bench.position == bench.motor


def test_a_speed_change_is_refused_and_stops_the_move():
    bench = AdapterBench006().configured()
    bench.give(128, 0, 0, 0, 2, 0, 100, 100, ms=1000)
    bench.give(128, 0, 0, 0, 4, 0, 100, 100, ms=1000)
    assert bench.bits == {"MODULE_OK", "STOPPED", "INVALID_PROFILE", "COMMAND_ERROR"}
    assert bench.reasons == ["speed change"]


def test_reset_errors_clears_an_external_stop_that_is_not_active_any_more():
    bench = AdapterBench006().configured()
    flags = bench.device.controller.axis
    bench.give(*move(10_000), ms=800)
    bench.level(InputBit.CW_LIMIT, True)
    bench.run(200)
    bench.release()
    bench.give(2048).release()
    assert flags.flags  # still active
    bench.level(InputBit.CW_LIMIT, False)
    bench.run(100)
    assert flags.flags
    bench.give(2048).release()
    assert not flags.flags


def test_start_speed_and_current_are_set_with_the_configuration():
    bench = AdapterBench006(peak_current=1500).configured()
    memory = bench.device.controller.memory
    assert (memory["start_speed"], memory["stop_speed"], memory["peak_current"]) == (1000, 1000, 1500)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"peak_current": 399}, "option peak_current: 399 is not allowed: 400 to 3000 mA"),
        ({"peak_current": 1.5}, "option peak_current: 1.5 is not allowed"),
        ({"home_stroke": 0}, "option home_stroke: 0 is not allowed: 1 to 2147483647 steps"),
        ({"home_stroke": True}, "option home_stroke: True is not allowed"),
    ],
)
def test_an_option_out_of_range_is_named(options, said):
    with pytest.raises(ValueError, match=said):
        AdapterBench006(**options)


def test_a_single_step_leaves_an_active_cw_limit():
    """A manual move may leave an end limit [3601 manual, chapter 4], and its single step at speed 0, too."""
    bench = AdapterBench006(Switch(InputBit.CW_LIMIT, 500, None)).configured()
    bench.give(128, 0, 0, 0, 2, 0, 20, 20, ms=1500).release()
    bench.give(2048).release()
    assert bench.motor == 500
    bench.give(256, 0, 0, 0, 0, 0, 20, 20).release()
    assert bench.motor == 499
    assert "COMMAND_ERROR" not in bench.bits


def test_a_limit_that_was_left_by_a_single_step_is_armed_again():
    bench = AdapterBench006(Switch(InputBit.CW_LIMIT, 500, None)).configured()
    bench.give(128, 0, 0, 0, 2, 0, 20, 20, ms=1500).release()
    bench.give(256, 0, 0, 0, 0, 0, 20, 20).release()
    bench.give(*move(300, 2000), ms=600)
    assert bench.motor == 500
    assert {"INPUT_ERROR", "IN_CW_LIMIT"} <= bench.bits


def test_a_search_for_home_may_begin_at_the_cw_limit():
    """A limit opposite to the search that is active at its start has no effect [3601 manual, chapter 4]."""
    switches = Switch(InputBit.HOME, None, -500), Switch(InputBit.CW_LIMIT, 500, None)
    bench = AdapterBench006(*switches).configured()
    bench.give(128, 0, 0, 0, 2, 0, 20, 20, ms=1500).release()
    bench.give(64, 0, 0, 0, 2, 0, 20, 20, ms=2000).release()
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "IN_CCW_LIMIT"}
    assert (bench.motor, bench.position) == (-500, 0)


@pytest.mark.parametrize(
    ("options", "told"), [({}, ["ramps"]), ({"accel_rounding": "nearest"}, []), ({"strict": True}, [])]
)
def test_that_ramps_are_others_is_told_once(options, told):
    bench = AdapterBench006(**options).configured()
    for _ in range(2):
        bench.give(*move(100, 2000), ms=600).release()
    assert bench.told("substitution") == told
