"""A networked drive behind the words of a 3601: motions, refusals, losses, and claims of rest."""

from __future__ import annotations

import pytest
from adapterbench import MS, AdapterBenchDrive, move
from rest_claims import violations
from scanrack.io_images.amci3601 import CommandMsw, InputBit
from scanrack.io_images.drives.bits import CommandBit
from scanrack.runtime.machine import Switch
from scanrack.runtime.modules.adapters.amci_drive.driver import AmciDriver

HOME = Switch(InputBit.HOME, 8000, 8500)
RATES = (5, 0, 100, 100)
STOP, HOLD, RESUME, RESET = (16,), (4,), (8, 0, 0, 0, *RATES), (2048,)
BLEND = [(0, 0x300, 2, 0, 0, 20), (0, 0x300, 1, 0, 3, 0, 20), (0, 0x300, 1, 500, 5, 0, 20)]


def configured(*switches: Switch, **options: object) -> AdapterBenchDrive:
    return AdapterBenchDrive(*switches, **options).configured()  # type: ignore[arg-type, return-value]


def test_a_move_ends_where_it_should():
    bench = configured()
    bench.give(*move(3000), ms=3000, until="MOVE_COMPLETE")
    assert (bench.position, bench.motor, bench.lies) == (3000, 3000, [])


def test_a_held_move_slows_down_and_goes_on():
    bench = configured()
    bench.give(*move(3000), ms=300).give(*HOLD, ms=600)
    assert "HOLD_STATE" in bench.bits
    assert 0 < bench.position == bench.motor < 3000
    bench.release(20).give(*RESUME, ms=2000, until="MOVE_COMPLETE")
    assert bench.motor == 3000


def test_a_jog_changes_its_speed_without_a_stop():
    bench = configured()
    bench.give(128, 0, 0, 0, 2, 0, 100, 100, ms=300)
    before = bench.motor
    bench.run(100)
    slow, before = bench.motor - before, bench.motor
    bench.give(128, 0, 0, 0, 8, 0, 100, 100, ms=200)
    before = bench.motor
    bench.run(100)
    assert (slow, bench.motor - before) == (200, 800)
    bench.release(500)
    assert bench.bits == {"MODULE_OK", "STOPPED"}


def test_home_is_where_the_drive_finds_it():
    bench = configured(HOME)
    bench.give(CommandMsw.FIND_HOME_CW.value, 0, 0, 0, *RATES, ms=10_000, until="AT_HOME")
    assert (bench.position, bench.motor, bench.lies) == (0, 8000, [])
    bench.release().give(*move(-100), ms=1000, until="MOVE_COMPLETE")
    assert bench.motor == 7900


def test_a_registration_move_ends_so_many_steps_after_its_bit():
    bench = configured()
    bench.give(128, 0, 2, 0, *RATES, ms=300)
    released_at = bench.motor
    bench.give(0, 0, 2, 0, *RATES, ms=2000, until="STOPPED")
    assert 2000 <= bench.motor - released_at <= 2000 + 5 * 10  # 5 steps a millisecond, two scans or so
    assert bench.reasons == []


def test_a_registration_move_ends_so_many_steps_after_its_input():
    bench = AdapterBenchDrive(Switch(InputBit.EXTERNAL, 3000, 3100), in1="external", unwired="inactive")
    bench.configured(0x8416, 63, 1, 0)  # external input, home and CW limit
    bench.give(128, 0, 2, 0, *RATES, ms=5000, until="STOPPED")
    assert bench.motor == 5000  # exact: the drive itself has the input


def test_a_blend_move_is_an_assembled_move_both_ways():
    bench = configured()
    for block in BLEND:
        bench.give(*block, ms=20).give(0, 0x100, ms=20)
    for command, end in ((CommandMsw.RUN_BLEND_CW, 2500), (CommandMsw.RUN_BLEND_CCW, 0)):
        bench.release(20).give(command.value, ms=3000, until="MOVE_COMPLETE")
        assert (bench.position, bench.motor, bench.lies) == (end, end, [])
    assert bench.reasons == []


@pytest.mark.parametrize(
    ("words", "options", "reason", "bit"),
    [
        ((128, 0, 0, 0, 0, 500, 20, 20), {}, "speed", "INVALID_PROFILE"),
        ((32, 0, 0, 0, 5, 0, 20, 20), {"in1": "none", "unwired": "inactive"}, "home input", "HOME_INVALID"),
    ],
)  # fmt: skip
def test_what_a_drive_cannot_do_is_refused_before_anything_is_sent(words, options, reason, bit):
    bench = configured(**options)
    sent = bench.device.drive.words
    bench.give(*words, ms=40)
    assert bench.reasons == [reason]
    assert {bit, "COMMAND_ERROR"} <= bench.bits
    assert bench.device.drive.words == sent
    assert bench.motor == 0


def test_a_configuration_with_more_inputs_than_are_wired_is_refused():
    bench = AdapterBenchDrive()
    bench.give(0x843C, 63, 1, 0, ms=100)
    assert "CONFIG_ERROR" in bench.bits
    assert bench.reasons == ["inputs"]


@pytest.mark.parametrize(
    ("lsw", "rates", "jerk", "substituted"),
    [
        (0, (30, 30), 0, []),
        (1, (30, 30), 750, []),  # 4000 steps/s at 30 steps/ms/s: 2/15 s, which is 100/750 s
        (3, (30, 30), 2250, []),  # a third of that
        (1, (30, 20), 500, ["S-curve"]),  # 0.2 s for the gentler ramp
        (3, (2000, 2000), 5000, ["S-curve"]),  # the drive's highest
    ],
)
def test_an_s_curve_is_a_jerk(lsw, rates, jerk, substituted):
    bench = configured()
    bench.give(2, lsw, 20, 0, 5, 0, *rates, ms=100)
    events = [event.name for event in bench.module.events if event.kind == "substitution"]
    assert (bench.device.drive.words[9], events) == (jerk, substituted)
    strict = configured(strict=True)
    strict.give(2, lsw, 20, 0, 5, 0, *rates, ms=100)
    assert (strict.reasons, strict.motor != 0) == (substituted, not substituted)


def test_nothing_is_written_before_a_configuration():
    bench = AdapterBenchDrive()
    drive = bench.device.drive
    drive.obey((0, 0x8000, 7, *(0,) * 7))
    bench.run(500)
    assert drive.words[2] == 7
    assert "MODULE_OK" in bench.bits


def test_a_lost_link_is_a_lost_controller():
    bench = configured()
    bench.give(*move(20_000), ms=300)
    bench.module.controller.line.take_down()
    bench.run(700)
    assert "MODULE_OK" not in bench.bits
    bench.module.controller.line.put_up()
    bench.release(1000)
    assert {"MODULE_OK", "STOPPED", "POSITION_INVALID"} <= bench.bits
    assert (bench.position - bench.motor, bench.device.motor_turns) == (0, False)


def test_a_drive_that_was_off_has_to_be_configured_again():
    bench = configured()
    bench.give(*move(3000), ms=120)
    bench.module.cycle_device()
    bench.run(500)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}  # what it refuses then is no error
    bench.release().configured()


def test_a_lost_answer_to_a_start_starts_nothing_twice():
    bench = configured()
    bench.module.controller.line.faults.drop_next = 1
    bench.give(*move(500, 1000), ms=3000, until="MOVE_COMPLETE")
    assert isinstance(bench.module.driver, AmciDriver)
    assert (bench.motor, bench.module.driver.late) == (500, 1)
    assert "1 exchange took longer than the RPI of 8 ms" in [
        event.text for event in bench.module.events if event.name == "controller error"
    ]


def test_a_stop_button_of_the_drive_alone_shows_as_a_move_that_stopped_short():
    bench = configured()
    bench.give(*move(20_000), ms=300)
    drive = bench.device.drive
    drive.obey((CommandBit.IMMEDIATE_STOP.value, *drive.words[1:]))
    bench.run(200)
    assert "POSITION_INVALID" in bench.bits
    assert bench.now_ns % MS == 0


@pytest.mark.parametrize("seed", [0, 1, 14])
def test_claims_are_true_and_edges_count(seed):  # 14: one answer is from before a write
    assert violations(seed, "drive") == []


@pytest.mark.slow
@pytest.mark.parametrize("first", range(0, 200, 25))
def test_claims_are_true_and_edges_count_in_200_sequences(first):
    assert {
        seed: wrong for seed in range(first, first + 25) if (wrong := violations(seed, "drive")) != []
    } == {}
