"""Every row of the PMC006x3s' instruction summary, over the line [4.2]."""

from __future__ import annotations

import pytest
from bench006 import Bench006
from scanrack.io_images.pmc006.instructions import INSTRUCTIONS, PARAMETERS, Kind, ParameterStorage
from scanrack.io_images.pmc006.status import Level, Status1, Status2

# character: (values taken, values refused with 6, read by, kept by t and power cycle), transcribed from 4.2
ROWS = {
    "4": ([1, 50, 100, 0], [-1, 101], None, False),
    "9": ([1, 256_000], [-1, 256_001], "9", False),
    "F": ([1, 0], [-1, 2], None, True),
    "J": ([1, 2, 3, 0], [-1, 4], "K", True),
    "L": ([65, 30_000], [64, 30_001], "L", True),
    "M": ([200, 400, 500, 600, 800, 1000, 1024, 1200, 1600], [201, 1700], "M", True),
    "Q": ([0, 1, 2, 3], [-1, 4], None, True),
    "S": ([65, 30_000], [64, 30_001], "S", True),
    "a": ([1, 0], [-1, 2], None, True),
    "d": ([1, 0], [-1, 2], None, False),
    "e": ([400, 3000], [399, 3001], "e", True),
    "f": ([1, 2, 3, 0], [-1, 4], None, False),
    "g": ([1, 0], [-1, 2], None, False),
    "m": ([2, 4, 8, 16, 32, 64, 128, 0], [1, 3, 256, -2], "k", True),
    "o": ([1, 5, 8, 0], [-1, 9], "h", True),
    "u": ([1, 5, 8, 0], [-1, 9], None, True),
    "v": ([1, 256_000], [-1, 256_001], "v", False),
    ":": ([1, 7, 0], [-1, 8], ";", False),
}


@pytest.mark.parametrize("char", ROWS)
def test_4_2_values_in_range_are_taken_and_others_refused_with_6(char: str) -> None:
    taken, refused, read_by, _ = ROWS[char]
    bench = Bench006()
    for value in taken:
        assert bench.ask(char, value) == value
        if read_by is not None:
            assert bench.ask(read_by, 0) == value
    for value in refused:
        assert bench.ask(char, value) == 6
        if read_by is not None:
            assert bench.ask(read_by, 0) == taken[-1]


@pytest.mark.parametrize("char", [char for char, row in ROWS.items() if row[2] is not None])
def test_4_3_17_what_t_keeps_survives_power_off_and_the_rest_has_its_default(char: str) -> None:
    taken, _, read_by, kept = ROWS[char]
    assert read_by is not None
    bench = Bench006()
    factory = bench.ask(read_by, 0)
    bench.ask(char, taken[0])
    bench.power_cycle()
    assert bench.ask(read_by, 0) == factory
    bench.ask(char, taken[0])
    assert bench.ask("t") == 0
    bench.power_cycle()
    assert bench.ask(read_by, 0) == (taken[0] if kept else factory)


def test_4_2_the_position_is_set_and_6_and_7_are_no_refusals() -> None:
    bench = Bench006()
    for position in (1, 6, 7, 0x7FFFFFFF, 0):
        assert (bench.ask("i", position), bench.position) == (0, position)
    assert (bench.ask("i", -1), bench.position) == (6, 0)


def test_4_2_user_data_are_kept_at_once() -> None:
    bench = Bench006()
    bench.ask("7", 0x1234)
    bench.power_cycle()
    assert bench.ask("6") == 0x1234


def test_4_3_17_a_new_address_counts_at_once_and_is_kept_by_t_only() -> None:
    bench = Bench006(0xFF)
    assert bench.text("a5 ff 77 07 00 00 00 22") == "a5 7a 07 07 00 00 00 2d"
    assert bench.text("a5 ff 6b 00 00 00 00 0f") == ""
    bench.address = 7
    assert bench.ask("w", 0) == 7  # 0 asks
    assert [bench.ask("w", bad) for bad in (-1, 121, 255)] == [6, 6, 6]
    bench.power_cycle()
    assert bench.address == 0xFF
    bench.ask("w", 120)
    bench.address = 120
    bench.ask("t")
    bench.power_cycle()
    assert bench.ask("w", 0) == 120


def test_factory_defaults() -> None:
    bench = Bench006(0xFF)
    asked = {char: bench.ask(char) for char in "9LMSevwPRKhk;6c"}
    assert asked == {
        "9": 600,
        "L": 600,
        "M": 1000,
        "S": 600,
        "e": 1000,
        "v": 6000,
        "w": 255,
        "P": 0,
        "R": 0x10000,
        "K": 0,
        "h": 5,
        "k": 16,
        ";": 0,
        "6": 0,
        "c": 0,
    }
    assert bench.status1 == Status1(0)
    assert bench.status2 == Status2.DIR
    assert Level(bench.ask("x")) == Level.EXT1 | Level.EXT2 | Level.FSET | Level.GPIO8


def test_4_1_1_six_and_seven_as_values_are_values() -> None:
    bench = Bench006()
    assert [bench.ask("o", value) for value in (6, 7)] == [6, 7]
    assert bench.ask("h") == 7


@pytest.mark.parametrize(
    ("char", "value", "register", "bit"),
    [
        ("a", 1, "j", Status1.AUTO_DEC),
        ("g", 1, "O", Status2.FREE_RUN),
        ("f", 1, "O", Status2.EXT1_EN),
        ("f", 2, "O", Status2.EXT2_EN),
        ("f", 3, "O", Status2.EXT1_EN | Status2.EXT2_EN),
        ("4", 1, "O", Status2.COIL),
        ("N", 1, "O", Status2.SPEED_MODE),
        ("F", 1, "O", Status2.OFFLINE_AUTO),
    ],
)
def test_4_3_16_status_bits_of_settings(char: str, value: int, register: str, bit: int) -> None:
    bench = Bench006()
    before = bench.ask(register)
    bench.ask(char, value)
    assert bench.ask(register) == before | bit
    bench.ask(char, 0)
    assert bench.ask(register) == before


def test_4_3_16_direction_supply_and_temperature() -> None:
    bench = Bench006()
    bench.ask("d", 0)
    assert bench.status2 == Status2(0)
    bench.controller.supply_v, bench.controller.overheated = 8.9, True
    assert (bench.status1, bench.status2) == (Status1.UVL, Status2.OTS)


def test_4_3_11_the_solenoid_is_driven_with_its_duty() -> None:
    bench = Bench006()
    duties = [(bench.ask("4", value), bench.controller.coil_percent) for value in (100, 30, 0)]
    assert duties == [(100, 100), (30, 30), (0, 0)]


def test_4_3_14_of_the_gpio_word_only_three_bits_do_anything() -> None:
    bench = Bench006()
    assert bench.ask("y", 0xFFF) == 0
    assert bench.controller.gpio == 0b1_1010  # AN_PUD, AN_EN, GPIO8
    assert bench.ask("y", 0x1000) == 6
    assert bench.ask("y", 0) == 0
    assert Level.GPIO8 not in Level(bench.ask("x"))


def test_switches_of_the_model() -> None:
    bench = Bench006(i_signed=True, max_microstep=256, device_id=77, firmware=0x20000)
    assert (bench.ask("i", -5), bench.position) == (0, -5)
    assert (bench.ask("m", 256), bench.ask("P"), bench.ask("R")) == (256, 77, 0x20000)
    with pytest.raises(ValueError, match="option max_microstep: 100 is not allowed: 128, 256"):
        Bench006(max_microstep=100)
    with pytest.raises(ValueError, match="address 121"):
        Bench006(121)


def test_the_table_has_every_row_once_and_its_parameters_allow_their_defaults() -> None:
    assert len({row.code for row in INSTRUCTIONS}) == len({row.name for row in INSTRUCTIONS}) == 41
    for row in PARAMETERS:
        assert row.allows(row.default) or row.name == "device_address"
        assert row.kind is Kind.SET
    kept = "".join(sorted(row.char for row in INSTRUCTIONS if row.keeping is ParameterStorage.SAVED))
    assert kept == "FJLMQSaemouw"  # "Can be saved after power-down" in 4.2
