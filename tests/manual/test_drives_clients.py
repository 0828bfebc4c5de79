"""What the two public drivers write to a drive, register by register, and what a drive of the family does.

The orders of the registers are those of SMD_Control_Server and of EPICS's drivers for ANG1 and ANF2.
"""

from __future__ import annotations

from struct import pack, unpack
from typing import Any

import pytest
from drive_unit import ENABLE, VALID
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.models import MODELS
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.registers import DriveRegisters

MS = 1_000_000
STOPPED, MOVE_COMPLETE, COMMAND_ERROR = 0x0008, 0x0080, 0x1000


class Client:
    """A master that writes a register, or all of an axis, within a millisecond."""

    def __init__(self, model: str, **options: Any) -> None:
        self.drive = DriveUnit(MODELS[model], options=options)
        self.registers = DriveRegisters([self.drive])

    def wait(self, ms: float) -> Client:
        self.drive.advance(self.drive.now_ns + round(ms * MS))
        return self

    def each(self, *writes: tuple[int, int]) -> Client:
        """Write registers one by one, by function 6."""
        for address, value in writes:
            request = pack(">BHH", 6, address, value & 0xFFFF)
            assert self.registers.answer(request) == request
            self.wait(0.4)
        return self

    def block(self, *values: int) -> Client:
        """Write registers from 1024 on by function 16."""
        words = [value & 0xFFFF for value in values]
        head = pack(">BHHB", 16, 1024, len(words), 2 * len(words))
        assert self.registers.answer(head + pack(f">{len(words)}H", *words))[0] == 16
        return self.wait(50)

    def read(self, function: int = 4) -> tuple[int, ...]:
        """Read the ten input registers."""
        return unpack(">10H", self.registers.answer(pack(">BHH", function, 0, 10))[2:])


class TestAng1OfEpics:
    """Function 6 on one connection; motion is over when bit 3 of word 0 is on."""

    @pytest.fixture
    def record(self) -> Client:
        client = Client("ang1", stored=(0x8011, *VALID[1:]))  # both limits
        client.each((1026, 0), (1027, 0), (1024, 0x200), (1024, 0))
        return client.each((1024, 0), (1024, 0x400), (1024, 0), (1025, ENABLE))

    def move(self, record: Client, bit: int, upper: int, lower: int) -> None:
        record.each((1028, 5), (1029, 0), (1030, 20), (1031, 20), (1026, upper), (1027, lower))
        record.each((1024, 0), (1024, bit))

    def test_a_preset_and_an_absolute_move_that_ends(self, record):
        assert not record.read()[0] & 0x0400
        self.move(record, 1, 1, 500)
        assert not record.wait(50).read()[0] & STOPPED
        seen = record.wait(2000).read()
        assert seen[0] & (STOPPED | MOVE_COMPLETE) == STOPPED | MOVE_COMPLETE
        assert seen[2:4] == (1, 500)

    def test_a_jog_is_a_long_relative_move_and_hold_stops_it(self, record):
        self.move(record, 2, 1000, 0)
        record.wait(500).each((1024, 0), (1024, 4))
        assert record.wait(1000).read()[0] & (STOPPED | COMMAND_ERROR) == STOPPED

    def test_hold_at_rest_is_an_error_that_the_next_enable_clears(self, record):
        record.each((1024, 0), (1024, 4))
        assert record.read()[0] & COMMAND_ERROR
        record.each((1024, 0), (1024, 0x400), (1024, 0), (1025, ENABLE))
        assert not record.read()[0] & COMMAND_ERROR

    def test_it_continues_after_a_limit(self, record):
        self.move(record, 2, 1000, 0)
        record.wait(500).drive.operate(InputBit.HOME, True)  # wired to input 1, the CW limit
        seen = record.wait(100).read()
        assert seen[0] & STOPPED
        assert seen[1] & 1
        for _ in range(3):  # polls: reset, and preset the present position
            record.each((1024, 0), (1024, 0x400), (1024, 0), (1026, seen[2]), (1027, seen[3]))
            record.each((1024, 0x200), (1024, 0))
        self.move(record, 1, 0, 0)
        assert record.wait(100).read()[0] & 2
        record.drive.operate(InputBit.HOME, False)
        assert record.wait(2000).read()[2:4] == (0, 0)


class TestSmdControlServer:
    """Function 6 with a connection for each operation; reads by function 3."""

    @pytest.fixture
    def client(self) -> Client:
        client = Client("smd23e2")
        client.each((1025, VALID[1]), (1024, VALID[0]))
        client.each(*((1024 + at, VALID[at]) for at in (2, 3, 4, 6, 7, 8)))
        client.each((1024, 0), (1024, 0x400), (1025, ENABLE))
        return client

    def test_it_configures_word_by_word_and_leaves_the_reset_bit_on(self, client):
        status = client.read(3)
        assert status[0] == 0x4408
        assert status[1] & 0xA000 == 0xA000

    def test_relative_move(self, client):
        client.each((1024, 0), (1025, ENABLE), (1026, 1), (1027, 500), (1028, 5), (1029, 0), (1030, 20))
        client.each((1031, 10), (1033, 0), (1024, 2))
        assert client.wait(1000).read(3)[2:4] == (1, 500)

    def test_jogs_follow_each_other(self, client):
        values = (1026, 0), (1027, 0), (1028, 5), (1029, 0), (1030, 20), (1031, 10), (1032, 0), (1033, 0)
        jog = ((1024, 0), (1025, ENABLE), *values, (1024, 0x80))
        for _ in range(20):
            client.each(*jog).wait(3)
        assert client.read(3)[0] & (1 | COMMAND_ERROR) == 1
        client.each((1024, 0), (1025, ENABLE), (1024, 4))
        assert client.wait(1000).read(3)[0] & STOPPED

    def test_immediate_stop_in_one_write(self, client):
        self.test_relative_move(client)
        client.each((1024, 0), (1026, 99), (1024, 2)).wait(300).each((1025, ENABLE), (1024, 0x10))
        assert client.read(3)[0] & (0x0400 | STOPPED | COMMAND_ERROR) == 0x0400 | STOPPED

    def test_assembled_move_that_is_never_ended(self, client):
        client.each((1025, ENABLE), (1024, 0x0800))
        assert client.wait(1000).read(3)[0] & 0x0300 == 0x0300
        for upper in (3, 4):
            client.each((1025, ENABLE), (1026, upper), (1027, 0), (1028, 3), (1029, 0), (1030, 20))
            client.each((1031, 10), (1033, 0), (1024, 0x1800))
            assert client.wait(1000).read(3)[0] & 0x0300 == 0x0100
            client.each((1025, ENABLE), (1024, 0x0800)).wait(1000)
        client.each((1025, ENABLE), (1033, 0), (1024, 0x2000))
        assert client.wait(6000).read(3)[2:4] == (7, 0)

    def test_it_reads_the_configuration(self, client):
        client.each((1025, 0x8800), (1024, 0x8000), *((1026 + at, 0) for at in range(8)))
        assert client.read(3) == VALID
        client.each((1024, 0), (1024, 0x400), (1025, ENABLE))
        assert client.read(3)[0] == 0x4408


class TestAnf2OfEpics:
    """Function 16 with ten registers, 32-bit values with the high word first."""

    ZEROS = (0,) * 10

    @pytest.fixture
    def record(self) -> Client:
        client = Client("anf2").block(0x8428, 0, 0, 100, 0, 0, 0, 0, 0, 0)
        client.drive.operate(InputBit.CW_LIMIT, True)  # active low
        client.drive.operate(InputBit.CCW_LIMIT, True)
        return client.block(*self.ZEROS).wait(100).block(0x0200, *(0,) * 9).wait(200)

    def test_the_configuration_is_taken_and_the_position_valid(self, record):
        assert record.read()[0] == 0x4000 | STOPPED

    def test_an_absolute_move_ends(self, record):
        record.block(*self.ZEROS).block(1, 0, 0, 1500, 0, 1000, 20, 20, 0, 0)
        assert not record.read()[0] & STOPPED
        seen = record.wait(3000).read()
        assert seen[0] & STOPPED
        assert seen[2:4] == (0, 1500)

    def test_a_jog_ends_with_two_zero_words(self, record):
        record.block(*self.ZEROS).block(0x100, 0, 0, 0, 0, 1000, 20, 20, 0, 0).wait(500)
        assert record.read()[0] & 2
        assert record.block(0, 0).wait(500).read()[0] & (STOPPED | COMMAND_ERROR) == STOPPED

    def test_a_stop_is_zeros_and_a_hold_at_once(self, record):
        record.block(*self.ZEROS).block(2, 0, 1, 0, 0, 1000, 20, 20, 0, 0).wait(500)
        record.each((1024, 0), (1025, 0), (1024, 4))
        assert record.wait(500).read()[0] & (STOPPED | COMMAND_ERROR) == STOPPED

    def test_a_hold_in_a_jog_is_an_error_and_ends_nothing(self, record):
        record.block(*self.ZEROS).block(0x80, 0, 0, 0, 0, 1000, 20, 20, 0, 0).wait(500).each((1024, 0x84))
        assert record.read()[0] & (1 | COMMAND_ERROR) == 1 | COMMAND_ERROR
        record.block(0x0880, *(0,) * 3, 0, 1000, 20, 20, 0, 0)
        assert record.read()[0] & (1 | COMMAND_ERROR) == 1
