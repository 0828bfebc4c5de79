"""Commands of AMCI's networked drives: edges, refusals, presets, moves, row by row with the page."""

from __future__ import annotations

import pytest
from drive_unit import ENABLE, VALID, Unit, ready

pytestmark = pytest.mark.rules

ENCODER = {0: 0x8400, 6: 1024}


class TestRefusals:
    def refused(self, unit: Unit, rule: str) -> None:
        assert rule in unit.rules
        assert "COMMAND_ERROR" in unit.status

    def test_smd_p68_two_rising_bits(self):
        unit = ready().command(3, (0, 500))
        self.refused(unit, "CMD-01")
        assert unit.wait(500).position == 0

    def test_smd_p68_a_bit_that_is_on_does_not_count(self):
        unit = ready().command(2, (0, 500), ms=500)
        unit.write(2 | 0x200, ENABLE, 0, 7)
        assert "CMD-01" not in unit.rules
        assert unit.position == 7

    @pytest.mark.parametrize("bit", [0, 3, 6, 10])
    def test_smd_p72_a_reserved_bit_of_command_word_1(self, bit):
        self.refused(ready().command(2, (0, 500), modifiers=1 << bit), "CMD-02")

    @pytest.mark.parametrize(
        ("change", "good"),
        [
            ({"speed": (1, 0)}, True),
            ({"speed": (0, 999)}, False),
            ({"speed": (2999, 999)}, True),
            ({"speed": (3000, 0)}, False),
            ({"speed": (1, 1000)}, False),
            ({"rates": (1, 1)}, True),
            ({"rates": (0, 10)}, False),
            ({"rates": (20, 0)}, False),
            ({"rates": (5000, 5000)}, True),
            ({"rates": (5001, 10)}, False),
            ({"rates": (20, 5001)}, False),
            ({"jerk": 5000}, True),
            ({"jerk": 5001}, False),
            ({"jerk": 65_535}, False),
            ({"target": (1, 1000)}, False),
            ({"target": (1, -5)}, False),
            ({"target": (8388, 608)}, False),
            ({"current": 9}, True),
            ({"current": 9, "modifiers": 2}, False),
            ({"current": 35, "modifiers": 2}, False),
            ({"current": 34, "modifiers": 2}, True),
        ],
    )
    def test_sd_p55_and_eds_ranges_of_a_move(self, change, good):
        unit = ready().command(2, **({"target": (0, 200)} | change))
        assert ("CMD-03" in unit.rules) is not good
        assert ("COMMAND_ERROR" in unit.status) is not good

    def test_3401_p29_a_move_in_a_move(self):
        unit = ready().command(2, (5, 0), ms=300).command(2, (0, 100))
        self.refused(unit, "CMD-04")
        assert unit.wait(2000).position == 5000

    def test_17_p82_an_absolute_move_without_a_valid_position(self):
        self.refused(Unit().configure().command(1, (1, 0)), "CMD-05")

    @pytest.mark.parametrize("bit", [0x04, 0x08])
    def test_sd_p23_nothing_to_hold_or_resume(self, bit):
        self.refused(ready().command(bit), "CMD-06" if bit == 4 else "CMD-07")

    def test_smd_p59_a_move_with_the_driver_disabled(self):
        unit = ready().write(0, 0).write(2, 0, 0, 500, 5, 0, 20, 10, ms=500)
        self.refused(unit, "CMD-08")
        assert unit.position == 0

    def test_sd2_p59_no_configuration(self):
        unit = Unit().command(0x200, (0, 7))
        self.refused(unit, "CMD-09")
        assert unit.command(0x400).status >= {"ACKNOWLEDGE", "CONFIG_ERROR"}
        assert "COMMAND_ERROR" not in unit.status

    def test_17_p80_no_profile(self):
        self.refused(ready().command(0x2000), "CMD-10")

    @pytest.mark.parametrize("command", [{"bit": 0x4000}, {"bit": 2, "target": (0, 9), "modifiers": 4}])
    def test_eds_no_encoder(self, command):
        self.refused(ready().command(**command), "CMD-12")

    def test_r24_moves_wait_for_reset_errors_and_immediate_stop_does_not(self):
        unit = ready().command(2, (20, 0), ms=300).command(2, (1, 0))
        unit.command(0x10)
        assert unit.status >= {"STOPPED", "COMMAND_ERROR", "POSITION_INVALID"}
        unit.command(2, (1, 0), ms=300)
        self.refused(unit, "CMD-13")
        unit.command(0x400).command(2, (1, 0), ms=900)
        assert unit.status >= {"MOVE_COMPLETE"}

    @pytest.mark.parametrize("bit", [12, 14])
    def test_smd_p40_synchrostep(self, bit):
        self.refused(ready().command(2, (0, 9), modifiers=1 << bit), "CMD-14")

    def test_smd_p67_a_registration_distance_shorter_than_its_ramp(self):
        # 5000 to 1000 steps/s at 10 steps/ms/s: 1200 steps
        self.refused(ready().command(0x80, (1, 199), modifiers=0x80), "CMD-15")
        assert "CMD-15" not in ready().command(0x80, (1, 200), modifiers=0x80).rules

    def test_17_p80_a_segment_without_programming(self):
        self.refused(ready().command(0x1000), "CMD-16")

    def test_anf2_has_no_assembled_moves(self):
        unit = Unit("anf2").write(0x8400, 0, 0, 100, 0, 0, 0, 0, 0, 0).write(*(0,) * 10)
        self.refused(unit.write(0x1000), "CMD-17")

    def test_r43_no_home_input(self):
        self.refused(ready().command(0x20), "CMD-21")

    @pytest.mark.parametrize("bit", [0x200, 0x4000])
    def test_a_preset_in_a_motion(self, bit):
        unit = ready(changed=ENCODER).command(2, (20, 0), ms=300).write(2 | bit)
        self.refused(unit, "CMD-04")

    def test_smd_p38_a_segment_shorter_than_its_ramps(self):
        unit = ready().write(0x0800, ENABLE).write(0x1800, ENABLE, 0, 10, 9, 0, 20, 10, 0, 0)
        unit.write(0x0800).write(0, ENABLE).command(0x2000)
        self.refused(unit, "CMD-18")


class TestErrors:
    def test_17_p82_only_reset_errors_clears_a_command_error(self):
        unit = ready().command(0x04)
        assert "COMMAND_ERROR" in unit.write(0, ENABLE, ms=500).status
        assert "COMMAND_ERROR" in unit.configure().status
        assert "COMMAND_ERROR" not in unit.command(0x400).status

    def test_smd_p83_the_acknowledge_lasts_as_long_as_the_bit(self):
        unit = ready().command(0x400, ms=500)
        assert "ACKNOWLEDGE" in unit.status
        assert "ACKNOWLEDGE" not in unit.write(0, ENABLE).status

    def test_17_p80_reset_errors_is_no_bit_11(self):
        unit = ready().command(0x800)
        assert unit.status >= {"ASSEMBLED_MODE", "WAITING_FOR_SEGMENT"}
        assert "ACKNOWLEDGE" not in unit.status


class TestPresets:
    @pytest.mark.parametrize("value", [0, 7, -345, 12_345, -7_654_321, 8_388_607, -8_388_608])
    def test_sd_p51_position(self, value):
        unit = Unit().configure().preset(value)
        assert unit.position == value
        assert "POSITION_INVALID" not in unit.status

    @pytest.mark.parametrize("words", [(8388, 608), (1, 1000), (-1, 1)])
    def test_sd_p55_a_position_out_of_range(self, words):
        unit = Unit().configure().command(0x200, words)
        assert unit.status >= {"COMMAND_ERROR", "POSITION_INVALID"}
        assert "ACKNOWLEDGE" not in unit.status

    def test_17_p80_unused_words_hold_anything(self):
        unit = Unit().configure().write(0x200, ENABLE, 0, 9, 77, 65_535, 0, 0, 99, 9999)
        assert unit.position == 9
        assert "COMMAND_ERROR" not in unit.status

    def test_encoder(self):
        unit = ready(changed=ENCODER).command(0x4000, (12, 345))
        assert unit.word(4), unit.word(5) == (12, 345)
        assert "ACKNOWLEDGE" in unit.status
        assert unit.position == 0

    def test_r14_encoder_to_position(self):
        unit = ready(changed=ENCODER).command(0x4000, (0, 55)).command(0x200, (0, 7), modifiers=1 << 13)
        assert unit.position == 55

    def test_the_encoder_follows_the_shaft(self):
        # 1024 counts and 2048 steps per turn
        unit = ready(changed=ENCODER).command(2, (3, 0), ms=2000)
        assert (unit.word(4), unit.word(5)) == (1, 500)


class TestMoves:
    def test_smd_p83_stopped_stands_with_the_others(self):
        unit = ready()
        assert "STOPPED" in unit.status
        unit.command(2, (0, 500), ms=100)
        assert "STOPPED" not in unit.status
        assert unit.wait(500).status >= {"STOPPED", "MOVE_COMPLETE"}

    def test_r37_no_distance(self):
        assert ready().command(2).status >= {"STOPPED", "MOVE_COMPLETE"}

    @pytest.mark.parametrize(("target", "moving"), [((2, 0), "MOVING_CW"), ((-2, 0), "MOVING_CCW")])
    def test_directions_and_ramps(self, target, moving):
        unit = ready().command(2, target, ms=100)
        assert unit.status >= {moving, "ACCELERATING"}
        # 200 ms up with 600 steps, 40 ms at 5000 steps/s, 400 ms down with 1200
        assert not unit.wait(120).status & {"ACCELERATING", "DECELERATING"}
        assert unit.wait(200).status >= {moving, "DECELERATING"}

    def test_an_absolute_move_goes_to_the_position(self):
        unit = Unit().configure().preset(500).command(1, (-2, 0), ms=2000)
        assert unit.position == -2000

    def test_smd_p72_current_and_jerk_last_programmed(self):
        unit = ready().command(2, (0, 100), current=15, jerk=77, modifiers=2, ms=500)
        assert (unit.word(8), unit.word(9)) == (15, 77)
        unit.command(2, (0, 100), current=15, ms=500)
        assert (unit.word(8), unit.word(9)) == (28, 0)

    def test_sd_p23_hold_and_resume(self):
        unit = ready().command(2, (20, 0), ms=1000).command(4, ms=600)
        assert unit.status >= {"HOLD_STATE", "STOPPED"}
        assert not unit.status & {"MOVE_COMPLETE", "POSITION_INVALID", "COMMAND_ERROR"}
        # 1 s at the profile and 400 ms down: 600 + 4000 + 1200 steps
        assert unit.position == 5800
        unit.command(8, (0, 99), speed=(10, 0), rates=(100, 100), ms=3000)
        assert unit.status >= {"MOVE_COMPLETE"}
        assert unit.position == 20_000

    def test_sd_p23_a_bad_resume_leaves_the_hold(self):
        unit = ready().command(2, (20, 0), ms=1000).command(4, ms=600).command(8, speed=(0, 500))
        assert unit.status >= {"HOLD_STATE", "COMMAND_ERROR"}

    def test_a_hold_within_the_last_ramp_completes_the_move(self):
        unit = ready().command(2, (2, 0), ms=400).command(4, ms=1000)
        assert unit.position == 2000
        assert "MOVE_COMPLETE" in unit.status

    def test_another_command_ends_a_hold(self):
        unit = ready().command(2, (20, 0), ms=1000).command(4, ms=600).preset(0)
        assert "HOLD_STATE" not in unit.status
        assert "CMD-07" in unit.command(8).rules

    def test_smd_p83_immediate_stop(self):
        unit = ready().command(2, (20, 0), ms=600).command(0x10)
        assert unit.status >= {"STOPPED", "POSITION_INVALID"}
        assert not unit.status & {"MOVE_COMPLETE", "COMMAND_ERROR"}

    def test_smd_control_server_stops_in_the_write_that_drops_the_move(self):
        unit = ready().command(2, (20, 0), ms=600).write(0x10)
        assert unit.status >= {"STOPPED", "POSITION_INVALID"}

    def test_r33_the_enable_bit_is_removed(self):
        unit = ready().command(2, (20, 0), ms=600).write(0, at=1)
        assert unit.status >= {"STOPPED", "POSITION_INVALID"}

    def test_r18_an_indexed_move_waits_for_its_input(self):
        unit = ready(changed={0: 0x8003}).command(2, (1, 0), modifiers=0x100, ms=500)
        assert unit.position == 0
        assert unit.input(1, ms=900).position == 1000
        assert "MOVE_COMPLETE" in unit.status

    def test_r18_a_zero_word_cancels_an_indexed_move(self):
        unit = ready(changed={0: 0x8003}).command(2, (1, 0), modifiers=0x100).write(0)
        assert unit.input(1, ms=900).position == 0

    def test_k_p69_an_encoder_move_ramps_down_from_its_count(self):
        # 1024 counts at 2048 steps, at 5000 steps/s; then 1200 steps down
        unit = ready(changed=ENCODER).command(2, (1, 24), modifiers=4, ms=3000)
        assert unit.position == pytest.approx(2048 + 1200, abs=3)
        assert "MOVE_COMPLETE" in unit.status


class TestJogs:
    def test_eds_as_long_as_the_bit_is_on(self):
        unit = ready().command(0x80, ms=700)
        assert "MOVING_CW" in unit.status
        # 600 steps in 200 ms, then 5 steps/ms
        assert unit.position == 600 + 2500
        unit.write(0, ms=600)
        assert unit.status == {"STOPPED", "MODULE_OK", "DRIVE_ENABLED"}
        assert unit.position == 600 + 2500 + 1200

    def test_17_p84_bad_values_are_an_invalid_jog_change(self):
        unit = ready().command(0x80, ms=500).write(0, 0, at=4)
        assert unit.status >= {"INVALID_JOG_CHANGE", "MOVING_CW"}
        assert "COMMAND_ERROR" not in unit.status
        assert "INVALID_JOG_CHANGE" not in unit.write(8, 0, at=4, ms=300).status
        before = unit.position
        assert unit.wait(100).position - before == 800

    def test_eds_bad_values_at_the_start_are_a_command_error(self):
        assert "CMD-03" in ready().command(0x80, speed=(0, 0)).rules

    def test_sd_p23_hold_is_an_error_and_the_jog_goes_on(self):
        unit = ready().command(0x80, ms=500).write(0x84)
        assert unit.status >= {"COMMAND_ERROR", "MOVING_CW"}

    def test_r38_jog_after_jog(self):
        unit = ready().command(0x80, ms=500).write(0, ms=2).write(0x80, ms=500)
        assert "COMMAND_ERROR" not in unit.status
        assert "MOVING_CW" in unit.status

    def test_the_other_direction_waits_for_the_stop(self):
        assert "CMD-04" in ready().command(0x80, ms=500).command(0x100).rules

    def test_smd_p13_the_input_that_stops_a_jog(self):
        unit = ready(changed={0: 0x8004}).command(0x80, ms=500).input(1, ms=600)
        assert unit.status >= {"STOPPED"}
        assert not unit.status & {"POSITION_INVALID", "INPUT_ERROR", "COMMAND_ERROR"}

    def test_smd_p67_registration(self):
        unit = ready(changed={0: 0x8004}).command(0x80, (3, 0), modifiers=0x80, ms=500)
        at = unit.position
        unit.input(1, ms=2000)
        assert unit.position == pytest.approx(at + 3000, abs=2)
        assert "STOPPED" in unit.status

    def test_r17_as_on_a_3601_only_a_lower_speed_is_followed(self):
        unit = ready(changed={0: 0x8004}).command(0x80, (3, 0), modifiers=0x80, ms=500).write(6, 0, at=4)
        assert unit.status >= {"INVALID_JOG_CHANGE", "MOVING_CW"}
        assert "INVALID_JOG_CHANGE" not in unit.write(2, 0, at=4, ms=400).status
        at = unit.position
        assert unit.wait(100).position == at + 200

    def test_r17_as_on_a_3601_the_input_must_not_be_active_at_the_start(self):
        unit = ready(changed={0: 0x8004}).input(1).command(0x80, (3, 0), modifiers=0x80)
        assert "CMD-20" in unit.rules

    def test_smd_p67_below_the_minimum_distance_the_input_does_not_count(self):
        unit = ready(changed={0: 0x8004})
        unit.command(0x80, (3, 0), modifiers=0x80, current=4, jerk=0, ms=300).input(1).input(1, on=False)
        assert "MOVING_CW" in unit.wait(2000).status
        at = unit.position
        assert unit.input(1, ms=2000).position == pytest.approx(at + 3000, abs=10)


class TestAssembled:
    def program(self, unit: Unit, *segments: tuple[int, ...]) -> Unit:
        unit.write(0x0800, ENABLE)
        for segment in segments:
            unit.write(0x1800, ENABLE, *segment)
            assert "WAITING_FOR_SEGMENT" not in unit.status
            unit.write(0x0800)
            assert unit.status >= {"ASSEMBLED_MODE", "WAITING_FOR_SEGMENT"}
        return unit.write(0, ENABLE)

    TWO = ((3, 0, 3, 0, 20, 10, 0, 0), (-4, 0, 2, 0, 20, 10, 0, 0))

    @pytest.mark.parametrize(("modifiers", "end"), [(0, 7000), (0x10, -7000), (0x200, -1000)])
    def test_smd_p38_runs(self, modifiers, end):
        unit = self.program(ready(), *self.TWO)
        unit.command(0x2000, jerk=500, modifiers=modifiers, ms=6000)
        assert unit.position == end
        assert unit.status >= {"MOVE_COMPLETE"}
        assert not unit.status & {"ASSEMBLED_MODE", "COMMAND_ERROR"}

    def test_r20_a_blend_does_not_stop_at_a_border(self):
        unit = self.program(ready(), *self.TWO).command(0x2000, ms=1150)
        # 3000 steps: 100 ms up with 200 steps, 933 ms; then 100 ms down to 2000 steps/s with 250 steps
        at = unit.position
        assert at == 3000 + 250 + 33
        assert unit.wait(200).position == at + 400

    def test_r20_dwell_pauses_with_no_motion(self):
        # the first segment: 100 ms up, 200 ms down, 600 steps on the ramps, 2400 at 3000 steps/s: 1.1 s
        unit = self.program(ready(), *self.TWO).command(0x2000, jerk=500, modifiers=0x200, ms=1101)
        assert unit.position == 3000
        assert "STOPPED" in unit.status
        assert not unit.status & {"MOVING_CW", "MOVE_COMPLETE"}
        assert "STOPPED" in unit.wait(498).status
        assert "MOVING_CCW" in unit.wait(2).status

    def test_sd_p23_hold_stops_a_blend_and_keeps_the_profile(self):
        unit = self.program(ready(), (30, 0, 3, 0, 20, 10, 0, 0)).command(0x2000, ms=1000)
        unit.write(4, ms=700)
        assert unit.status >= {"STOPPED"}
        assert not unit.status & {"MOVE_COMPLETE", "POSITION_INVALID", "COMMAND_ERROR"}
        assert "CMD-07" in unit.command(8).rules
        assert "MOVING_CW" in unit.command(0x400).command(0x2000, ms=300).status

    def test_17_p80_sixteen_segments_and_not_more(self):
        segment = (0, 500, 1, 100, 20, 10, 0, 0)
        unit = self.program(ready(), *(segment,) * 16)
        assert len(unit.drive.layer.segments) == 16
        unit.write(0x0800)
        for _ in range(16):
            unit.write(0x1800, ENABLE, *segment).write(0x0800)
        assert "CMD-11" in unit.write(0x1800).rules
        assert "ASSEMBLED_MODE" not in unit.status

    @pytest.mark.parametrize(
        "segment", [(3, 0, 0, 0, 20, 10, 0, 0), (0, 0, 3, 0, 20, 10, 0, 0), (3, 0, 3, 0, 20, 10, 0, 5001)]
    )
    def test_r30_a_bad_segment_voids_the_profile(self, segment):
        unit = ready().write(0x0800, ENABLE).write(0x1800, ENABLE, *segment)
        assert "CMD-11" in unit.rules
        assert "ASSEMBLED_MODE" not in unit.status
        assert "CMD-10" in unit.write(0, ENABLE).command(0x400).command(0x2000).rules

    def test_smd_control_server_runs_without_a_zero(self):
        unit = ready().write(0x0800, ENABLE).write(0x1800, ENABLE, 1, 0, 3, 0, 20, 10, 0, 0).write(0x0800)
        unit.write(0, at=9).write(0x2000, ms=1000)
        assert unit.position == 1000


class TestFormats:
    def test_smd_p67_binary_out_thousands_in(self):
        unit = Unit().configure({1: 0x0103}).command(0x200, (0xFFFF, 0xFEA7))
        assert unit.position == -345

    @pytest.mark.parametrize(
        ("word_1", "shown"), [(0x0203, (1, 4464)), (0x0603, (4464, 1)), (0x0003, (70, 0))]
    )
    def test_smd_p81_thousands_out(self, word_1, shown):
        unit = Unit().configure({1: word_1}).command(0x200, (70, 0))
        assert (unit.word(2), unit.word(3)) == shown

    def test_eds_a_move_in_binary(self):
        unit = Unit().configure({1: 0x0303}).command(2, (0, 1500), speed=(0, 5000), ms=1000)
        assert (unit.word(2), unit.word(3)) == (0, 1500)

    def test_r12_targets_are_limited_in_binary_too(self):
        unit = Unit().configure({1: 0x0303})
        assert "COMMAND_ERROR" not in unit.command(0x200, (0x7F, 0xFFFF)).status
        assert "COMMAND_ERROR" in unit.command(0x200, (0x80, 0)).status

    def test_smd_p59_the_starting_speed_stays_in_thousands(self):
        unit = Unit().configure({1: 0x0303, 2: 1, 3: 234})
        assert unit.drive.layer.start_sps == 1234


def test_the_words_of_a_valid_configuration_are_those_of_the_manual():
    assert VALID[4] == 2048
