"""What a 3601 and a drive do with the same word: each row of the differences, on both simulations."""

from __future__ import annotations

import pytest
from drive_unit import ENABLE, MS, Unit, ready
from scanrack.io_images.amci3601 import WORDS_3601, CommandMsw, Configuration, InputBit, StatusMsw
from scanrack.io_images.drives.differences import DIFFERENCES, MOVES
from scanrack.io_images.drives.models import MODELS, Layout
from scanrack.io_images.image import Image
from scanrack.runtime.modules.amci3601 import Amci3601

BY_ID = {row.id: row for row in DIFFERENCES}
MOVE = (0, 500, 5, 0, 20, 10)  # target, speed, rates
SMD, ANF2 = (next(model for model in MODELS.values() if model.layout is each) for each in Layout)


class Plain3601:
    """A configured 3601 at position 0, written word by word."""

    def __init__(self) -> None:
        self.module, self.now_ns = Amci3601(), 0
        used = InputBit.HOME | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
        self.write(*Configuration(inputs_used=used, active_high=used, starting_speed=500).to_image().words)
        self.write().write(CommandMsw.PRESET_POSITION).write()

    def write(self, *words: int, ms: float = 2) -> Plain3601:
        self.now_ns += round(ms * MS)
        self.inputs = self.module.update(self.now_ns, Image([*words, *(0,) * (8 - len(words))]))
        return self.wait(ms, *words)

    def wait(self, ms: float, *words: int) -> Plain3601:
        self.now_ns += round(ms * MS)
        self.inputs = self.module.update(self.now_ns, Image([*words, *(0,) * (8 - len(words))]))
        return self

    @property
    def status(self) -> set[str]:
        return {str(bit.name) for bit in StatusMsw if self.inputs[0] & bit}


def names(words, image: str, word: int, mask: int) -> set[str]:
    return {name for name, bit in words.bits(image, word) if mask >> bit & 1}


@pytest.mark.parametrize("row", DIFFERENCES, ids=lambda row: row.id)
def test_the_bits_of_a_row_have_its_names_on_a_3601(row):
    assert set(row.names(0xFFFF).split(", ")) <= names(WORDS_3601, *row.place, row.bits)


SAME_NAME = {"D-01", "D-06", "D-07", "D-20", "D-23", "D-24"}
"""Rows of bits with the same name, whose behavior differs."""


@pytest.mark.parametrize(
    "row", [row for row in DIFFERENCES if row.id not in SAME_NAME], ids=lambda row: row.id
)
def test_the_bits_of_a_row_have_another_name_on_the_drive_or_none(row):
    for layout in row.layouts:
        model = SMD if layout is Layout.SMD else ANF2
        ours = names(model.words, *row.place, row.bits)
        assert not ours & set(row.names(0xFFFF).split(", ")), model.name
        named = [name for name in ours if name in row.on_drive or name in row.write]
        assert named == list(ours) or row.place != ("I", 0), ours


def test_a_move_without_the_enable_bit_moves_a_3601_only():  # D-01
    assert CommandMsw.ABSOLUTE_MOVE in MOVES
    assert "MOVING_CW" in Plain3601().write(1, 0, *MOVE).status
    unit = ready().write(0, 0).write(1, 0, *MOVE)
    assert "COMMAND_ERROR" in unit.status
    assert unit.position == 0


def test_0800h_resets_the_errors_of_a_3601_and_programs_a_blend_on_a_drive():  # D-02
    plain = Plain3601().write(5)
    assert "COMMAND_ERROR" in plain.status
    assert "COMMAND_ERROR" not in plain.write().write(0x0800).status
    unit = ready().write(0, ENABLE).write(0x0800, ENABLE)
    assert {"ASSEMBLED_MODE", "WAITING_FOR_SEGMENT"} <= unit.status  # D-21, D-22


def test_0400h_presets_the_encoder_of_a_3601_and_resets_the_errors_of_a_drive():  # D-03
    unit = ready().write(0x0003, ENABLE)
    assert "COMMAND_ERROR" in unit.status
    assert "COMMAND_ERROR" not in unit.write(0, ENABLE).write(0x0400, ENABLE).status
    assert "COMMAND_ERROR" in Plain3601().write(0x0400).status  # it has no encoder


@pytest.mark.parametrize(("bit", "moves"), [(0x1000, False), (0x2000, True)])  # D-04, D-05
def test_a_stored_blend_runs_with_bit_13_in_the_direction_of_word_1(bit, moves):
    for reverse, moving in ((0, "MOVING_CW"), (0x10, "MOVING_CCW")):
        unit = ready().write(0x0800, ENABLE).write(0x1800, ENABLE, 4, *MOVE[1:]).write(0x0800, ENABLE)
        unit.write(0, ENABLE).write(bit, ENABLE | reverse, ms=20)
        assert (moving in unit.status) is moves


def test_a_home_search_needs_an_input_with_that_function():  # D-06
    unit = ready().write(0, ENABLE).write(0x0020, ENABLE, *MOVE, ms=10)
    assert "COMMAND_ERROR" in unit.status
    assert "MOVING_CW" in Plain3601().write(0x0020, 0, 0, 0, 5, 0, 20, 10).status


def test_an_anf2_ends_a_search_after_its_time_out():  # D-07
    unit = Unit("anf2").write(0x842C, 4, 0, 100, 1, 0, ms=60)
    for limit in (InputBit.CW_LIMIT, InputBit.CCW_LIMIT):
        unit.drive.operate(limit, True)  # active low
    unit.write(0, 0, ms=60).write(0x0020, 0, 0, 0, 0, 1000, 100, 100, ms=60)
    assert "MOVING_CW" in unit.status
    unit.wait(2000)
    assert "MOVING_CW" not in unit.status
    assert unit.status & {"INPUT_ERROR", "COMMAND_ERROR"}
    plain = Plain3601().write(0x0020, 0, 0, 0, 5, 0, 20, 10)
    assert "MOVING_CW" in plain.wait(60_000, 0x0020, 0, 0, 0, 5, 0, 20, 10).status


def test_stopped_stands_beside_move_complete_on_a_drive_only():  # D-20
    plain = Plain3601().write(1, 0, *MOVE).wait(500, 1, 0, *MOVE)
    assert plain.status & {"STOPPED", "MOVE_COMPLETE"} == {"MOVE_COMPLETE"}
    unit = ready().command(1, target=(0, 500), ms=500)
    assert unit.status & {"STOPPED", "MOVE_COMPLETE"} == {"STOPPED", "MOVE_COMPLETE"}


def test_an_input_error_stays_on_a_drive_until_reset_errors():  # D-23
    plain = Plain3601()
    plain.module.operate(InputBit.ESTOP, True)
    assert "INPUT_ERROR" in plain.wait(2).status
    plain.module.operate(InputBit.ESTOP, False)
    assert "INPUT_ERROR" not in plain.wait(2).write(2, 0, *MOVE).status
    unit = ready(changed={0: 0x8006}).input(1, True)  # an emergency stop
    assert "INPUT_ERROR" in unit.status
    unit.input(1, False).write(0, ENABLE).write(2, ENABLE, *MOVE)
    assert "INPUT_ERROR" in unit.status
    assert "INPUT_ERROR" not in unit.write(0, ENABLE).write(0x0400, ENABLE).status


def test_an_immediate_stop_works_on_a_drive_with_a_command_error():  # D-24
    unit = ready().command(1, target=(9, 0), ms=50)
    unit.write(0, ENABLE).write(2, ENABLE, *MOVE)
    assert {"COMMAND_ERROR", "MOVING_CW"} <= unit.status
    assert "MOVING_CW" not in unit.write(0, ENABLE).write(0x0010, ENABLE).status
    plain = Plain3601().write(1, 0, 9, 0, 5, 0, 20, 10)
    plain.write(0, ms=20).write(2, 0, *MOVE)
    assert {"COMMAND_ERROR", "MOVING_CW"} <= plain.status
    assert "MOVING_CW" in plain.write().write(0x0010).status


@pytest.mark.parametrize(("bits", "refused"), [(1, True), (1 << 10, True), (0, False)])  # D-10, D-15
def test_reserved_bits_of_word_1_are_refused(bits, refused):
    unit = ready().command(1, target=(0, 500), modifiers=bits, ms=5)
    assert ("COMMAND_ERROR" in unit.status) is refused


def test_the_levels_of_the_inputs_are_elsewhere():  # D-30 to D-33
    assert ready().input(1, True).word(1) & 0x3F == 1
    assert ready().input(2, True).word(1) & 0x3F == 2
    unit = ready()
    unit.drive.set_temperature(95)
    assert unit.wait(1).word(1) & 0x3F == 0x10  # the CW limit of a 3601


def test_every_row_is_tested_or_said_by_its_names():
    assert len(BY_ID) == len(DIFFERENCES)
