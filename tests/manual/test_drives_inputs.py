"""Inputs, homing, driver, encoder and connection of AMCI's networked drives, row by row with the page."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from drive_unit import ENABLE, Unit, ready
from scanrack.io_images.drives.rules import ROWS
from scanrack.runtime.machine import Jam, MachineSpec
from scanrack.runtime.modules.drives.drive_options import DriveOptions, SmdOptions

pytestmark = pytest.mark.rules

CW_LIMIT, CCW_LIMIT, CAPTURE, ESTOP, HOME = 0x8001, 0x8002, 0x8005, 0x8006, 0x8007
BOTH_LIMITS = 0x8001 | 2 << 3
HOME_AND_CW = 0x8007 | 1 << 3
HOME_AND_CCW = 0x8007 | 2 << 3

ROW = re.compile(r"^\| (R-\d+) \| (.*) \| (.*) \| ([ABC]) \| (.*) \|$", re.MULTILINE)
READINGS = {
    number: cells
    for number, *cells in ROW.findall((Path(__file__).parents[2] / "docs" / "readings.md").read_text("utf-8"))
}
"""What is open, what scanrack does, confidence, and options or why there is none, by number."""
OPTION = re.compile(r"`(\w+)`: `(.*?)`")


class TestLevels:
    def test_17_p84_active_inputs(self):
        unit = ready().input(1)
        assert unit.status & {"INPUT_1", "INPUT_2"} == {"INPUT_1"}
        assert unit.input(2).status >= {"INPUT_1", "INPUT_2"}

    def test_eds_active_low(self):
        unit = ready(changed={1: 0})
        assert unit.status >= {"INPUT_1", "INPUT_2"}
        assert unit.input(1).status & {"INPUT_1", "INPUT_2"} == {"INPUT_2"}

    def test_smd_p13_capture(self):
        unit = ready(changed={0: CAPTURE | 0x0400, 6: 2048}).command(2, (3, 0), ms=500).input(1)
        assert 1500 < 1000 * unit.word(6) + unit.word(7) < 2200
        assert unit.wait(2000).word(6) < 3


class TestLimits:
    @pytest.mark.parametrize("configured", [CW_LIMIT, CCW_LIMIT])
    def test_17_p82_either_limit_ends_a_move(self, configured):
        unit = ready(changed={0: configured}).command(2, (20, 0), ms=600).input(1)
        assert unit.status >= {"INPUT_ERROR", "POSITION_INVALID", "LIMIT_CONDITION", "STOPPED"}
        assert not unit.status & {"MOVE_COMPLETE", "COMMAND_ERROR"}
        assert unit.rules[-2:] == ["INP-02", "POS-04"]

    def test_17_p84_the_limit_condition_ends_with_the_switch_and_the_error_does_not(self):
        unit = ready(changed={0: CW_LIMIT}).command(2, (20, 0), ms=600).input(1).input(1, on=False)
        assert "LIMIT_CONDITION" not in unit.status
        assert "INPUT_ERROR" in unit.write(0, ENABLE).status
        assert "INPUT_ERROR" not in unit.command(0x400).status

    def test_17_p84_reset_errors_ends_the_limit_condition(self):
        unit = ready(changed={0: CW_LIMIT}).command(2, (20, 0), ms=600).input(1).command(0x400)
        assert not unit.status & {"LIMIT_CONDITION", "INPUT_ERROR"}

    def test_17_p82_a_jog_toward_an_active_limit(self):
        unit = ready(changed={0: CW_LIMIT}).input(1).command(0x80, ms=100)
        assert unit.status >= {"INPUT_ERROR", "STOPPED"}
        assert unit.position == 0
        assert "COMMAND_ERROR" not in unit.status

    @pytest.mark.parametrize("command", [{"bit": 0x100}, {"bit": 2, "target": (-5, 0)}])
    def test_r39_away_from_an_active_limit(self, command):
        unit = ready(changed={0: CW_LIMIT}).input(1).command(**command, ms=100)
        assert "MOVING_CCW" in unit.status
        assert "INPUT_ERROR" not in unit.status

    def test_the_axis_stops_at_the_limit_switch(self):
        unit = ready(changed={0: CW_LIMIT}).switch(1, 3000, None).command(2, (20, 0), ms=3000)
        # a sample every 250 us at 5 steps/ms
        assert 3000 <= unit.position <= 3002

    def test_anf2_readme_only_a_jog_leaves_a_limit(self):
        unit = Unit("anf2").write(0x8428, 0x0018, 0, 100, 0, 0, 0, 0, 0, 0).write(*(0,) * 10)
        unit.drive.operate(unit.drive.terminals[3], True)
        unit.wait(1).write(2, 0, 0xFFFF, 0xF000, 0, 1000, 20, 20, 0, 0, ms=100)
        assert unit.status >= {"COMMAND_ERROR", "STOPPED"}
        unit.write(*(0,) * 10).write(0x0800).write(0)
        unit.write(0x100, 0, 0, 0, 0, 1000, 20, 20, ms=100)
        assert "MOVING_CCW" in unit.status


class TestEmergencyStop:
    def test_17_p82_in_a_move(self):
        unit = ready(changed={0: ESTOP}).command(2, (20, 0), ms=600).input(1)
        assert unit.status >= {"INPUT_ERROR", "POSITION_INVALID", "STOPPED", "DRIVE_ENABLED"}

    def test_17_p82_at_rest(self):
        unit = ready(changed={0: ESTOP}).input(1)
        assert unit.status >= {"INPUT_ERROR", "STOPPED"}

    def test_no_move_begins_while_it_is_active(self):
        unit = ready(changed={0: ESTOP}).input(1).command(0x400).command(2, (1, 0), ms=500)
        assert unit.position == 0
        assert "INPUT_ERROR" in unit.status


class TestHoming:
    @pytest.mark.parametrize("bit", [0x20, 0x40])
    def test_r19_ends_at_the_edge_with_position_0(self, bit):
        sign = 1 if bit == 0x20 else -1
        unit = ready(changed={0: HOME}).switch(1, *sorted((sign * 1000, sign * 1500)))
        unit.command(bit, speed=(2, 0), rates=(100, 100), ms=6000)
        assert unit.status >= {"AT_HOME", "STOPPED"}
        assert not unit.status & {"MOVE_COMPLETE", "POSITION_INVALID", "COMMAND_ERROR"}
        assert unit.position == 0
        assert abs(unit.drive.machine.shaft - sign * 1000) <= 1

    def test_r19_begins_on_the_switch(self):
        unit = ready(changed={0: HOME}).switch(1, -50, 400)
        unit.command(0x20, speed=(2, 0), rates=(100, 100), ms=6000)
        assert "AT_HOME" in unit.status
        assert abs(unit.drive.machine.shaft + 50) <= 1

    def test_r19_a_limit_in_the_way_reverses_the_search_after_2_s(self):
        unit = ready(changed={0: HOME_AND_CW}).switch(1, -900, -500).switch(2, 2000, None)
        unit.command(0x20, speed=(2, 0), rates=(100, 100), ms=1500)
        assert "STOPPED" in unit.status
        assert "INPUT_ERROR" not in unit.status
        assert "AT_HOME" in unit.wait(7000).status

    def test_17_p82_the_opposite_limit_ends_the_search(self):
        unit = ready(changed={0: HOME_AND_CCW}).switch(1, 90_000, None).switch(2, 500, 800)
        unit.command(0x20, speed=(2, 0), rates=(100, 100), ms=1500)
        assert unit.status >= {"INPUT_ERROR", "STOPPED"}
        assert "INP-04" in unit.rules

    def test_sd_p23_hold_does_not_end_it(self):
        unit = ready(changed={0: HOME}).switch(1, 9000, None)
        unit.command(0x20, speed=(2, 0), rates=(100, 100), ms=500).write(0x24)
        assert unit.status >= {"COMMAND_ERROR", "MOVING_CW"}


class TestDriver:
    def test_17_p84_hot(self):
        unit = ready()
        unit.drive.set_temperature(90)
        assert "TEMPERATURE_90C" not in unit.status
        unit.drive.set_temperature(90.5)
        assert "TEMPERATURE_90C" in unit.status

    def test_17_p84_a_fault_cuts_the_motion_and_clears_itself(self):
        unit = ready().command(2, (20, 0), ms=600)
        unit.drive.set_driver_fault(True)
        assert unit.wait(1).status >= {"DRIVER_FAULT", "STOPPED", "POSITION_INVALID", "DRIVE_ENABLED"}
        assert "CMD-08" in unit.command(2, (1, 0)).rules
        unit.drive.set_driver_fault(False)
        assert "DRIVER_FAULT" not in unit.status

    def test_17_p84_no_fault_while_the_driver_is_disabled(self):
        unit = ready().write(0, 0)
        unit.drive.set_driver_fault(True)
        assert "DRIVER_FAULT" not in unit.wait(1).status
        assert "DRIVER_FAULT" in unit.write(0, ENABLE).status

    def test_17_p84_encoder_error(self):
        unit = ready()
        unit.drive.set_encoder_error(True)
        assert "ENCODER_ERROR" in unit.status

    def test_r11_heartbeat(self):
        unit = Unit()
        seen = [unit.wait(250).word(1) >> 11 & 1 for _ in range(8)]
        assert seen == [0, 1, 1, 0, 0, 1, 1, 0]


STALLING = {0: 0xA400, 6: 1024}


class TestStall:
    def test_sd2_p42_a_shaft_that_does_not_follow(self):
        unit = Unit(machine=MachineSpec(jams=(Jam(1000, 1),))).configure(STALLING).preset()
        unit.command(2, (20, 0), ms=3000)
        assert unit.status >= {"STALL_DETECTED", "STOPPED", "POSITION_INVALID"}
        assert unit.position == 1000 + 2048 // 8

    def test_17_p82_not_without_stall_detection(self):
        unit = Unit(machine=MachineSpec(jams=(Jam(1000, 1),))).configure({0: 0x8400, 6: 1024}).preset()
        assert unit.command(2, (3, 0), ms=3000).position == 3000
        assert "STALL_DETECTED" not in unit.status

    def test_reset_errors_clears_it(self):
        unit = Unit().configure(STALLING).preset().command(2, (20, 0), ms=500)
        unit.drive.stall()
        assert "STALL_DETECTED" in unit.status
        assert "STALL_DETECTED" not in unit.command(0x400).status


class TestConnection:
    def test_17_p82_p84_the_cable(self):
        unit = ready().command(2, (20, 0), ms=600)
        unit.drive.set_cable(False)
        assert unit.status >= {"POSITION_INVALID", "MOVING_CW"}
        assert not unit.status & {"CONNECTION_LOST", "INPUT_ERROR"}
        unit.drive.set_cable(True)
        assert unit.status >= {"CONNECTION_LOST", "INPUT_ERROR", "POSITION_INVALID"}
        assert not unit.command(0x400).status & {"CONNECTION_LOST", "INPUT_ERROR"}

    def test_r22_a_time_out_is_an_immediate_stop(self):
        unit = ready().command(2, (20, 0), ms=600)
        unit.drive.lose_connection()
        assert unit.status >= {"STOPPED", "POSITION_INVALID"}
        assert "DRIVE_ENABLED" not in unit.status

    def test_r10_an_idle_scanner(self):
        unit = ready()
        unit.drive.plc_run(False)
        assert "PLC_IN_PROGRAM_MODE" in unit.status
        assert unit.command(2, (1, 0), ms=500).position == 0
        unit.drive.plc_run(True)
        assert unit.wait(1).status >= {"DRIVE_ENABLED"}
        assert unit.position == 0


class TestReadingsByOption:
    def test_r01_codes(self):
        codes = (0, 7, 2, 3, 4, 5, 6, 1)  # 1 and 7 change places
        unit = ready(changed={0: HOME}, input_codes=codes).input(1).command(0x80, ms=100)
        assert "INPUT_ERROR" in unit.status

    def test_r02_low_word_first(self):
        unit = Unit(low_word_first=True).configure({1: 0x0203}).preset(70_000)
        assert (unit.word(2), unit.word(3)) == (4464, 1)

    def test_r06_save_and_read_back(self):
        unit = Unit(save_bit=12, read_back_bit=13).configure({1: 0x1003})
        assert unit.drive.memory.writes == 1
        unit.write(0xA000, at=1).write(0x8000)
        assert unit.word(4) == 2048

    def test_r11_heartbeat(self):
        assert Unit(heartbeat_ms=100).wait(150).word(1) >> 11 & 1 == 1

    def test_r15_hold_at_rest(self):
        assert "COMMAND_ERROR" not in ready(hold_at_rest_refused=False).command(4).status

    def test_r16_a_bad_jog_change(self):
        unit = ready(jog_stops_on_bad_values=True).command(0x80, ms=500).write(0, 0, at=4, ms=600)
        assert unit.status >= {"INVALID_JOG_CHANGE", "STOPPED"}

    def test_r22_a_time_out(self):
        unit = ready(timeout_stops=False).command(2, (20, 0), ms=600)
        unit.drive.lose_connection()
        assert unit.status >= {"MOVING_CW", "DRIVE_ENABLED"}

    def test_r24_immediate_stop(self):
        unit = ready(error_locks_stop=True).command(2, (20, 0), ms=300).command(2, (1, 0))
        assert "MOVING_CW" in unit.command(0x10).status

    def test_r41_samples(self):
        unit = ready(changed={0: CW_LIMIT}, input_scan_us=100_000).command(2, (20, 0), ms=610).input(1)
        assert "MOVING_CW" in unit.status
        assert "STOPPED" in unit.wait(100).status

    def test_r42_stall(self):
        unit = Unit(machine=MachineSpec(jams=(Jam(1000, 1),)), stall_degrees=180)
        unit.configure({0: 0xA400, 6: 1024}).preset().command(2, (20, 0), ms=3000)
        assert unit.position == 1000 + 1024

    def test_each_option_that_a_reading_names_exists_and_is_tested(self):
        named = dict(OPTION.findall("".join(text for *_, text in READINGS.values())))
        assert {name: json.loads(value) for name, value in named.items()} == {
            name: json.loads(json.dumps(SmdOptions.model_fields[name].default)) for name in named
        }
        assert set(named) < set(SmdOptions.model_fields)
        build = {"encoder_fitted", "in1", "in2", "stored"}
        assert set(named) | build == set(SmdOptions.model_fields) | set(DriveOptions.model_fields)

    def test_a_guess_has_an_option_or_says_why_not(self):
        for number, (*_, confidence, option_or_reason) in READINGS.items():
            assert (confidence == "C") == bool(option_or_reason), number

    def test_a_rule_names_readings_of_the_page(self):
        assert {each for row in ROWS for each in row.reading} <= set(READINGS)
