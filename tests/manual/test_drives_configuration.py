"""Configuration mode of AMCI's networked drives, power-up and flash, row by row with the page."""

from __future__ import annotations

import pytest
from drive_unit import ENABLE, VALID, Unit, ready
from scanrack.io_images.drives.configuration import RULES as CONFIGURATION_RULES
from scanrack.io_images.drives.rules import RULES
from scanrack.runtime.machine import Machine
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.nonvolatile import DriveMemory

pytestmark = pytest.mark.rules

INVALID = [
    pytest.param("CFG-01", {0: 0x8040}, id="SD p. 55 rule 1, bit 6"),
    pytest.param("CFG-01", {0: 0x8200}, id="SD p. 55 rule 1, bit 9"),
    pytest.param("CFG-01", {0: 0x9000}, id="SD p. 55 rule 1, bit 12"),
    pytest.param("CFG-02", {2: 0, 3: 0}, id="EDS Param3, 0"),
    pytest.param("CFG-02", {2: 2000, 3: 0}, id="EDS Param3, 2,000,000"),
    pytest.param("CFG-02", {2: 1, 3: 1000}, id="SD p. 55, lower word 1000"),
    pytest.param("CFG-02", {2: 0xFFFF, 3: 0}, id="SD p. 55, negative"),
    pytest.param("CFG-02", {2: 1, 3: 0xFFFF}, id="SD p. 55, opposite signs"),
    pytest.param("CFG-03", {0: 0x8009}, id="SD p. 55 rule 3, two CW limits"),
    pytest.param("CFG-03", {0: 0x803F}, id="SD p. 55 rule 3, two homes"),
    pytest.param("CFG-04", {4: 199}, id="EDS Param4, 199"),
    pytest.param("CFG-04", {4: 32_768}, id="EDS Param4, 32,768"),
    pytest.param("CFG-05", {0: 0xA000}, id="SD p. 55 rule 5"),
    pytest.param("CFG-07", {6: 4097}, id="EDS Param5, 4,097"),
    pytest.param("CFG-08", {7: 101}, id="EDS Param6, 101"),
    pytest.param("CFG-09", {8: 9}, id="EDS Param7, 9"),
    pytest.param("CFG-09", {8: 35}, id="EDS Param7, 35"),
    pytest.param("CFG-10", {5: 1}, id="EDS Assem110, word 5"),
    pytest.param("CFG-10", {9: 1}, id="EDS Assem110, word 9"),
]
VALID_ENDS = [
    pytest.param({2: 1999, 3: 999}, id="EDS Param3, 1,999,999"),
    pytest.param({2: 0, 3: 1}, id="EDS Param3, 1"),
    pytest.param({4: 200}, id="EDS Param4, 200"),
    pytest.param({4: 32_767}, id="EDS Param4, 32,767"),
    pytest.param({0: 0xA400, 6: 4096}, id="EDS Param5, 4,096 with stall detection"),
    pytest.param({7: 0}, id="EDS Param6, 0"),
    pytest.param({7: 100}, id="EDS Param6, 100"),
    pytest.param({8: 10}, id="EDS Param7, 10"),
    pytest.param({8: 34}, id="EDS Param7, 34"),
    pytest.param({0: 0x8000}, id="reading R-07, two general purpose inputs"),
    pytest.param({0: 0x8011}, id="SD p. 55 rule 3, both limits"),
    pytest.param({0: 0xC000}, id="EDS bit 14, no anti-resonance"),
    pytest.param({1: 0x0303}, id="EDS word 1 by default"),
]


@pytest.mark.parametrize(("rule", "changed"), INVALID)
def test_an_invalid_configuration(rule, changed):
    unit = Unit().configure(changed)
    assert "CONFIG_ERROR" in unit.status
    assert "DRIVE_ENABLED" not in unit.status
    assert rule in unit.rules


@pytest.mark.parametrize("changed", VALID_ENDS)
def test_a_valid_configuration(changed):
    unit = Unit().configure(changed)
    assert not unit.status & {"CONFIG_ERROR", "MODE_CONFIG", "COMMAND_ERROR"}
    assert "DRIVE_ENABLED" in unit.status


def test_each_row_of_the_list_of_invalid_configurations_is_tested():
    tested = {param.values[0] for param in INVALID} | {"CFG-06", "CFG-11"}
    assert tested == {row.id for row in CONFIGURATION_RULES}


def test_cfg_06_the_encoder_of_a_unit_without_one():
    assert "CFG-06" in Unit(encoder_fitted=False).configure({0: 0x8400, 6: 1024}).rules
    assert "CONFIG_ERROR" not in Unit(encoder_fitted=False).configure().status


def test_cfg_11_the_homing_time_out_of_an_anf2():
    unit = Unit("anf2").write(0x8400, 0, 0, 100, 301, 0, 0, 0, 0, 0)
    assert unit.rules[-1] == "CFG-11"
    assert unit.write(0x8400, 0, 0, 100, 300).status == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}


class TestPowerUp:
    def test_r09_status(self):
        assert Unit().wait(100).word(0) == 0x6408

    def test_smd_p59_a_stored_configuration_is_used(self):
        assert Unit(stored=VALID).word(0) == 0x4408

    def test_smd_p59_the_driver_waits_for_its_enable_bit(self):
        unit = Unit(stored=VALID)
        assert "DRIVE_ENABLED" not in unit.wait(100).status
        assert "DRIVE_ENABLED" in unit.write(0, ENABLE).status

    def test_a_configuration_in_ram_is_lost_with_the_power(self):
        unit = ready()
        unit.drive.power_cycle()
        assert unit.word(0) == 0x6408

    def test_an_impossible_stored_configuration_is_refused(self):
        with pytest.raises(ValueError, match=r"option stored: .* \[CFG-09, EDS Param7\]"):
            Unit(stored=(*VALID[:8], 99, 0))


class TestConfigurationMode:
    def test_smd_p59_mirror(self):
        words = (0xA401, 0x0103, 1, 234, 2000, 0, 512, 20, 28, 0)
        unit = Unit().write(*words)
        assert tuple(unit.word(at) for at in range(10)) == words

    def test_17_p82_bit_13_is_stall_detection_not_configuration_error(self):
        assert Unit().write(*VALID).word(0) == 0x8000

    def test_17_p82_each_configuration_makes_the_position_invalid(self):
        unit = ready()
        assert "POSITION_INVALID" in unit.configure().status

    def test_17_p82_a_valid_one_clears_the_error(self):
        unit = Unit().configure({8: 99})
        assert "CONFIG_ERROR" in unit.status
        assert "CONFIG_ERROR" not in unit.configure().status

    def test_smd_control_server_writes_word_by_word(self):
        unit = Unit().write(VALID[1], at=1).write(VALID[0])
        for at in (2, 3, 4, 6, 7, 8):
            unit.write(VALID[at], at=at)
        assert "CONFIG_ERROR" not in unit.write(0).status

    def test_r06_read_back_takes_no_new_values(self):
        unit = ready().write(0x8800, at=1).write(0x8000)
        for at in range(2, 10):
            unit.write(0, at=at)
        shown = tuple(unit.word(at) for at in range(10))
        assert shown == VALID
        unit.write(0, ENABLE)
        assert not unit.status & {"CONFIG_ERROR", "POSITION_INVALID"}

    def test_r21_entered_in_a_motion(self):
        unit = ready().command(2, (20, 0), ms=500)
        unit.write(*VALID).write(0, ENABLE, *(0,) * 8)
        assert unit.status >= {"STOPPED", "POSITION_INVALID"}
        assert 0 < unit.position < 20_000
        assert "CFG-22" in unit.rules

    def test_smd_p68_bits_of_the_configuration_word_are_no_edges(self):
        unit = Unit().write(0x8002, *VALID[1:]).write(2, ENABLE, 0, 500, 5, 0, 20, 10, ms=500)
        assert unit.position == 0
        unit.write(0, ENABLE).write(2, ms=500)
        assert unit.position == 500


class TestFlash:
    def test_r06_saved_configuration_survives(self):
        unit = ready(changed={1: 0x4003})
        unit.drive.power_cycle()
        assert unit.word(0) == 0x4408
        assert unit.drive.memory.writes == 1
        assert unit.drive.memory.configuration == VALID

    def test_an_invalid_configuration_is_not_saved(self):
        unit = Unit().configure({1: 0x4003, 8: 99})
        assert unit.drive.memory == DriveMemory()

    def test_smd_p72_a_saved_profile_leaves_the_unit_deaf_until_power_is_cycled(self):
        unit = ready(changed={1: 0x4003})
        unit.write(0x0800, ENABLE).write(0x1800, ENABLE, 1, 0, 3, 0, 20, 10, 0, 0).write(0x0800)
        unit.write(0, ENABLE | 0x20)
        unit.preset(77)
        assert unit.position == 0
        unit.drive.power_cycle()
        unit.write(0, ENABLE).write(0x2000, ms=2000)
        assert unit.position == 1000
        assert unit.drive.memory.writes == 2

    def test_a_memory_goes_to_another_unit(self):
        memory = DriveMemory(configuration=VALID, writes=7)
        drive = DriveUnit(
            Unit().drive.model, Machine(), memory=DriveMemory.model_validate(memory.model_dump())
        )
        assert drive.inputs()[0] == 0x4408

    def test_smd_p72_preset_encoder_saves_its_offset(self):
        unit = ready(changed={0: 0x8400, 1: 0x4003, 6: 2048}).command(0x4000, (0, 123), modifiers=0x20)
        assert unit.drive.memory.writes == 2
        unit.command(2, (1, 0), ms=900)
        unit.drive.power_cycle()
        assert (unit.word(4), unit.word(5)) == (1, 123)


def test_every_rule_has_a_page_and_a_sentence():
    for row in RULES.values():
        assert row.section
        assert row.text.endswith(".")
