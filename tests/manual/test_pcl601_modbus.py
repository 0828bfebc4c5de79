"""The PCL601's tables over Modbus: addresses, ranges, exceptions, broadcast, what power loss leaves.

The manual prints no exceptions: codes are those of the Modbus standard, 1 function, 2 address, 3 value,
6 busy. Frames are given without CRC.
"""

from __future__ import annotations

import pytest
from bench601 import Bench601
from scanrack.io_images.pcl601 import MAP, Register


@pytest.fixture
def bench():
    return Bench601()


SINGLES = [row for row in MAP if row.writable and row.words == 1 and row.register is not Register.COMMAND]
PAIRS = [row for row in MAP if row.writable and row.words == 2]
READ_ONLY = [row for row in MAP if not row.writable]


def test_memory_map_has_38_registers_at_consecutive_references(bench):
    reference = 1
    for row in MAP:
        assert row.reference == reference
        reference += row.words
    assert reference == 39
    assert [row.reference for row in READ_ONLY] == [32, 34, 35, 36, 37]
    assert bench.ask("01 03 00 00 00 26").startswith("01 03 4c")


@pytest.mark.parametrize("row", SINGLES, ids=lambda row: row.register.name)
def test_range_of_a_register(bench, row):
    for value in (row.low, row.high, row.default):
        assert bench.write(row.register, value) is None
        assert bench.read(row.register) == value
        if row.register is Register.ADDRESS:
            bench.write(row.register, 1)
    for value in (row.low - 1, row.high + 1):
        if 0 <= value <= 0xFFFF:
            before = bench.read(row.register)
            assert bench.write(row.register, value) == 3
            assert bench.read(row.register) == before
            assert bench.errors() == 64
            bench.code(10)


@pytest.mark.parametrize("row", PAIRS, ids=lambda row: row.register.name)
def test_pairs_low_word_first(bench, row):
    assert bench.ask(f"01 10 00 {row.address:02x} 00 02 04 12 34 00 56").startswith("01 10")
    assert bench.read(row.register) == 0x561234
    assert bench.ask(f"01 06 00 {row.address + 1:02x} 00 57").startswith("01 06")  # the high half alone
    assert bench.read(row.register) == 0x571234
    if row.low < 0:
        bench.write(row.register, -3000)
        assert bench.ask(f"01 03 00 {row.address:02x} 00 02") == "01 03 04 f4 48 ff ff"


@pytest.mark.parametrize("row", READ_ONLY, ids=lambda row: row.register.name)
def test_read_only(bench, row):
    for address in range(row.address, row.address + row.words):
        assert bench.ask(f"01 06 00 {address:02x} 00 00") == "01 86 02"


def test_defaults_after_power_up(bench):
    for row in MAP:
        assert bench.read(row.register) == row.default
    assert bench.ask("01 03 00 24 00 02") == "01 03 04 30 30 31 2e"  # firmware 1.00 as function 0x11 has it


REFUSED = [
    ("01 07", "01 87 01"),  # read exception status: not among the nine
    ("01 08 00 00 12 34", "01 88 01"),
    ("01 16 00 00 00 00 00 00", "01 96 01"),
    ("01 2b 0e 01 00", "01 ab 01"),
    ("01 03 00 26 00 01", "01 83 02"),
    ("01 03 00 25 00 02", "01 83 02"),
    ("01 03 00 00 00 00", "01 83 03"),
    ("01 03 00 00 00 7e", "01 83 03"),
    ("01 03 00 00 00 7d", "01 83 02"),
    ("01 04 00 01 00 01", "01 84 02"),
    ("01 04 00 00 00 02", "01 84 02"),
    ("01 01 00 10 00 01", "01 81 02"),
    ("01 01 00 00 07 d1", "01 81 03"),
    ("01 02 00 08 00 01", "01 82 02"),
    ("01 02 00 00 00 09", "01 82 02"),
    ("01 02 00 00 00 00", "01 82 03"),
    ("01 05 00 08 ff 00", "01 85 02"),
    ("01 05 00 00 12 34", "01 85 03"),
    ("01 05 00 00 00 01", "01 85 03"),
    ("01 06 00 26 00 01", "01 86 02"),
    ("01 06 00 00 00 10", "01 86 03"),  # command code above 15
    ("01 0f 00 00 00 09 02 ff 01", "01 8f 02"),
    ("01 0f 00 00 00 08 02 ff 01", "01 8f 03"),
    ("01 0f 00 00 00 00 00", "01 8f 03"),
    ("01 10 00 05 00 02 03 00 01 02", "01 90 03"),
    ("01 10 00 05 00 02 06 00 01 02 03 04 05", "01 90 03"),
    ("01 10 00 25 00 02 04 00 00 00 00", "01 90 02"),
    ("01 10 00 1e 00 02 04 00 01 00 00", "01 90 02"),  # 4x31 may be written, 4x32 not
    ("01 10 00 05 00 00 00", "01 90 03"),
    # Address and byte count are wrong: the count is checked first [Modbus V1.1b3, figures 21 and 22].
    ("01 0f 00 08 00 01 02 01 00", "01 8f 03"),  # no ninth output; two bytes for one output
    ("01 0f 00 13 00 01 02 13 e2", "01 8f 03"),
    ("01 0f 00 02 00 64 0d 65", "01 8f 03"),  # a hundred outputs; one byte of 13
    ("01 0f 00 00 07 b1 f7" + 247 * " 00", "01 8f 03"),  # 1,969 outputs
    ("01 10 00 26 00 01 04 00 00 00 00", "01 90 03"),  # no register 4x39; four bytes for one register
    ("01 10 00 08 00 2c 02 00 01", "01 90 03"),  # beyond the map; two bytes for 44 registers
    ("01 10 00 6f 34 00 01", "01 90 03"),
    ("01 10 00 1f 00 01 01 00", "01 90 03"),  # read only; one byte
]


@pytest.mark.parametrize(("request_", "reply"), REFUSED, ids=[row[0] for row in REFUSED])
def test_refused(bench, request_, reply):
    before = bench.ask("01 03 00 00 00 22")
    assert bench.ask(request_) == reply
    assert bench.ask("01 03 00 00 00 22") == before


def test_all_or_nothing(bench):
    # base 600 and max 3000 are fine, jog 50001 is not
    assert bench.ask("01 10 00 05 00 03 06 02 58 0b b8 c3 51") == "01 90 03"
    assert (bench.read(Register.BASE_SPEED), bench.read(Register.MAX_SPEED)) == (500, 5000)


def test_unknown_command_code_sets_the_command_error(bench):
    assert bench.code(16) == 3
    assert bench.errors() == 8


def test_code_0_is_echoed_and_does_nothing(bench):
    assert bench.ask("01 06 00 00 00 00") == "01 06 00 00 00 00"
    assert bench.errors() == 0


def test_the_command_register_reads_0_once_the_command_is_executed(bench):
    bench.set_up()
    bench.code(4)
    assert bench.busy()
    assert bench.read(Register.COMMAND) == 0


def test_outputs_read_as_sixteen_bits(bench):
    bench.ask("01 0f 00 00 00 08 01 a5")
    assert bench.ask("01 01 00 00 00 10") == "01 01 02 a5 00"
    assert bench.ask("01 01 00 05 00 03") == "01 01 01 05"  # outputs 6 to 8 of 1010 0101


def test_all_outputs_can_be_off(bench):
    bench.ask("01 0f 00 00 00 08 01 ff")
    assert bench.ask("01 0f 00 00 00 08 01 00").startswith("01 0f")
    assert bench.controller.outputs == 0


def test_input_register_and_inputs_agree(bench):
    for number, name in enumerate(("in1", "in2", "in3", "in4", "in5", "in6", "hard_minus", "soft_plus")):
        bench.pin(name)
        assert bench.ask("01 04 00 00 00 01") == f"01 04 02 00 {1 << number:02x}"
        assert bench.ask("01 02 00 00 00 08") == f"01 02 01 {1 << number:02x}"
        assert bench.ask(f"01 02 00 {number:02x} 00 01") == "01 02 01 01"
        bench.pin(name, "open")


def test_home_and_jog_are_seen_nowhere(bench):
    for register in (Register.BASE_SPEED, Register.JOG_SPEED):
        bench.controller.values[register] = 5000  # equal: a jog does not begin
    for name in ("home", "jog_plus", "jog_minus", "fast_jog"):
        bench.pin(name)
    assert bench.ask("01 04 00 00 00 01") == "01 04 02 00 00"


def test_broadcast_is_executed_and_never_answered(bench):
    assert bench.ask("00 06 00 06 0b b8") is None
    assert bench.read(Register.MAX_SPEED) == 3000
    assert bench.ask("00 05 00 02 ff 00") is None
    assert bench.ask("00 0f 00 03 00 01 01 01") is None
    assert bench.controller.outputs == 0b1100
    assert bench.ask("00 10 00 05 00 01 02 00 07") is None
    assert bench.read(Register.BASE_SPEED) == 7
    assert bench.ask("00 03 00 00 00 01") is None
    assert bench.ask("00 06 00 06 00 00") is None  # out of range: the error bit tells
    assert bench.errors() == 64


def test_other_addresses_pass_by(bench):
    assert bench.ask("02 06 00 06 0b b8") is None
    assert bench.read(Register.MAX_SPEED) == 5000


def test_address_is_answered_from_the_old_one_and_kept_through_power_loss(bench):
    assert bench.ask("01 06 00 09 00 2a") == "01 06 00 09 00 2a"
    assert bench.ask("01 03 00 09 00 01") is None
    assert bench.ask("2a 03 00 09 00 01") == "2a 03 02 00 2a"
    assert bench.ask("2a 11") == "2a 11 05 2a 31 2e 30 30"
    bench.unit.power_cycle(bench.bus.now_ns)
    assert bench.ask("2a 03 00 09 00 01") == "2a 03 02 00 2a"


def test_power_loss_forgets_the_rest(bench):
    bench.set_up(accel=7777, base=333, top=4444, jog=2222, direction=0)
    bench.write(Register.POSITION, -77)
    bench.ask("01 05 00 04 ff 00")
    bench.code(16)
    bench.unit.power_cycle(bench.bus.now_ns)
    for row in MAP:
        assert bench.read(row.register) == row.default
    assert bench.controller.outputs == 0


def test_in_motion_speeds_direction_and_position_are_locked(bench):
    bench.set_up()
    bench.code(4)
    for row in MAP:
        if row.writable and row.register is not Register.COMMAND:
            value = 1 if row.register is Register.ADDRESS else row.default
            assert bench.write(row.register, value) == (6 if row.locked else None), row.register
    assert bench.errors() == 1024
    assert [row.reference for row in MAP if row.locked] == [4, 6, 7, 8, 9, 13]


def test_codes_that_need_an_idle_axis(bench):
    bench.set_up()
    bench.code(4)
    for code in (1, 2, 3, 4, 7, 8, 9, 12):
        assert bench.code(code) is None
        assert bench.errors() == 1024, code
        bench.code(10)
    for code in (6, 10, 13, 14, 15):
        assert bench.code(code) is None
        assert bench.errors() == 0, code


def test_reading_the_error_register_does_not_clear_it(bench):
    bench.code(16)
    assert (bench.errors(), bench.errors()) == (8, 8)
    bench.code(10)
    assert bench.errors() == 0


def test_analog_enable_writes_both_and_reads_either(bench):
    values = bench.controller.values
    assert bench.write(Register.ANALOG_ENABLE, 1) is None
    assert (values.analog_speed, values.analog_position) == (True, True)
    values.set_analog(speed=False)
    assert bench.read(Register.ANALOG_ENABLE) == 1
    bench.write(Register.ANALOG_ENABLE, 0)
    assert (values.analog_speed, values.analog_position) == (False, False)
