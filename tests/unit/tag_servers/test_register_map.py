"""Tags as coils and registers: values by arithmetic, refusals by Modbus V1.1b3, chapter 6."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack.runtime.config.server_table import ModbusTable
from scanrack.runtime.live.actions import Store
from scanrack.runtime.tag_servers.database import Database
from scanrack.runtime.tag_servers.modbus_session import ModbusSession
from scanrack.runtime.tag_servers.register_map import RegisterMap
from scanrack.runtime.tag_servers.tag_snapshot import BrokenClientError, Instant
from served_tags import ServedRack, write_rack

MAP = {
    "coils": (
        {"address": 0, "tag": "aBool"},
        {"address": 1, "tag": "Hosts.Go"},
        {"address": 2, "tag": "Hosts.Stop"},
        {"address": 3, "tag": "anInt.15"},
        {"address": 8, "tag": "Flags"},
        {"address": 100, "tag": "Locked.0"},
    ),
    "discrete_inputs": ({"address": 7, "tag": "Flags[35]"}, {"address": 8, "tag": "Locked.2"}),
    "input_registers": ({"address": 30, "tag": "Locked"}, {"address": 32, "tag": "Local:1:I.Data"}),
    "holding_registers": (
        {"address": 0, "tag": "aDint"},
        {"address": 2, "tag": "aReal"},
        {"address": 4, "tag": "anInt"},
        {"address": 5, "tag": "aSint"},
        {"address": 6, "tag": "Program:Main.Step.Time", "order": "low first"},
        {"address": 8, "tag": "aLint"},
        {"address": 12, "tag": "Grid[1,0]"},
        {"address": 40, "tag": "Locked"},
        {"address": 50, "tag": "Many[2].Steps[1].Speed"},
        {"address": 60, "tag": "aUsint"},
        {"address": 200, "tag": "Dints"},
    ),
}


class Bench:
    """A served rack with a map of its tags."""

    def __init__(self, rack: ServedRack, *, fill: bool = False) -> None:
        self.rack, self.tags = rack, rack.debugger.tags
        table = ModbusTable.model_validate({**MAP, "fill": fill})
        self.map = RegisterMap(Database(rack.desk.listing, rack.setup.writable), table)
        assert self.map.problems == []
        self._session = ModbusSession(self.map)

    def ask(self, pdu: bytes) -> bytes:
        """Send a request as a frame; return the PDU of the reply."""
        (packet,) = self._session.receive(struct.pack(">HHHB", 9, 0, len(pdu) + 1, 255) + pdu)
        plan = self._session.plan(packet, 1)
        now_ns, version, results = self.rack.exchange([("127.0.0.1:5000", plan.operations)])
        reply = self._session.reply(packet, Instant(results[0], now_ns, version))
        assert struct.unpack_from(">HHHB", reply) == (9, 0, len(reply) - 6, 255)
        return reply[7:]

    def words(self, function: int, first: int, count: int) -> tuple[int, ...]:
        """Return registers."""
        reply = self.ask(struct.pack(">BHH", function, first, count))
        assert reply[:2] == bytes((function, 2 * count)), reply.hex(" ")
        return struct.unpack(f">{count}H", reply[2:])

    def write(self, first: int, *words: int) -> bytes:
        """Write registers; return the reply."""
        head = struct.pack(">BHHB", 0x10, first, len(words), 2 * len(words))
        return self.ask(head + struct.pack(f">{len(words)}H", *words))


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with ExitStack() as ports:
        yield Bench(ServedRack(write_rack(tmp_path), ports))


def test_values_take_registers_in_the_order_of_their_row(bench: Bench) -> None:
    assert bench.words(3, 0, 2) == (0x0001, 0xE240)  # 123,456
    assert bench.words(3, 2, 2) == (0x3FC0, 0)  # 1.5
    assert bench.words(3, 4, 2) == (-1234 & 0xFFFF, -5 & 0xFFFF)
    bench.tags["\\Main.Step.Time"] = 0x10002
    assert bench.words(3, 6, 2) == (2, 1)
    assert bench.words(3, 8, 4) == struct.unpack(">4H", struct.pack(">q", -5_000_000_000))
    assert bench.words(3, 1, 3) == (0xE240, 0x3FC0, 0)  # also from the middle of a value
    assert bench.words(3, 12, 1) == (5,)
    assert bench.words(4, 30, 2) == (0, 7)
    inputs = bytes(bench.rack.run.rack.slots[1].inputs.raw)
    assert bench.words(4, 32, 8) == struct.unpack("<8H", inputs)


@pytest.fixture
def filled(tmp_path: Path) -> Iterator[Bench]:
    with ExitStack() as ports:
        yield Bench(ServedRack(write_rack(tmp_path), ports), fill=True)


def test_filled_gaps_read_as_zero_and_take_no_writes(filled: Bench) -> None:
    filled.tags["Flags[0]"] = True
    assert filled.words(3, 12, 4) == (5, 0, 0, 0)
    assert filled.words(4, 0, 32)[-3:] == (0, 0, 7)  # from before the first one
    assert filled.ask(struct.pack(">BHH", 1, 4, 8)) == bytes((1, 1, 0b0001_0000))
    for refused in (
        struct.pack(">BHHB", 0x10, 12, 2, 4) + bytes(4),  # a tag and a gap
        struct.pack(">BHH", 6, 13, 0),
        struct.pack(">BHHH", 0x16, 13, 0, 0),
        struct.pack(">BHH", 5, 4, 0),
        struct.pack(">BHH", 4, 30, 11),  # beyond the last one: Local:1:I.Data ends at 39
        struct.pack(">BHH", 2, 9, 1),
    ):
        assert filled.ask(refused) == bytes((refused[0] | 0x80, 2)), refused.hex(" ")


def test_a_request_writes_whole_values_at_one_instant(bench: Bench) -> None:
    assert bench.write(0, 0xFFFF, 0xFFFE, 0x4010, 0) == struct.pack(">BHH", 0x10, 0, 4)
    assert (bench.tags["aDint"], bench.tags["aReal"]) == (-2, 2.25)
    assert bench.write(6, 4, 3)[0] == 0x10
    assert bench.tags["\\Main.Step.Time"] == 0x30004
    assert bench.ask(struct.pack(">BHH", 6, 4, 0x8000)) == struct.pack(">BHH", 6, 4, 0x8000)
    assert bench.tags["anInt"] == -0x8000
    assert bench.write(202, 0, 11, 0, 12)[0] == 0x10
    assert [bench.tags[f"Dints[{at}]"] for at in range(4)] == [0, 11, 12, 0]
    both = struct.pack(">BHHHHB2H", 0x17, 0, 3, 50, 2, 4, 0x4108, 0)
    assert struct.unpack(">BB3H", bench.ask(both)) == (0x17, 6, 0xFFFF, 0xFFFE, 0x4010)
    assert bench.tags["Many[2].Steps[1].Speed"] == 8.5


def test_a_mask_sets_and_clears_bits_of_a_register(bench: Bench) -> None:
    bench.tags["anInt"], bench.tags["aDint"] = 0x0012, 0x12_0012
    for address in (4, 0):  # the specification's example: 12h, F2h, 25h gives 17h
        assert bench.ask(struct.pack(">BHHH", 0x16, address, 0xF2, 0x25))[0] == 0x16
    assert (bench.tags["anInt"], bench.tags["aDint"]) == (0x17, 0x17_0012)
    assert bench.ask(struct.pack(">BHHH", 0x16, 2, 0xF2, 0x25)) == b"\x96\x02"  # a REAL has no bits


def test_coils_are_bools_bits_and_arrays_of_bools(bench: Bench) -> None:
    bench.tags["Hosts.Stop"] = bench.tags["Flags[3]"] = bench.tags["Flags[35]"] = True
    assert bench.ask(struct.pack(">BHH", 1, 0, 4)) == bytes((1, 1, 0b1100))  # anInt is negative
    assert bench.ask(struct.pack(">BHH", 1, 8, 64)) == bytes((1, 8, 8, 0, 0, 0, 8, 0, 0, 0))
    assert bench.ask(struct.pack(">BHH", 2, 7, 2)) == bytes((2, 1, 0b11))
    assert bench.ask(struct.pack(">BHHB", 15, 0, 3, 1) + b"\x03") == struct.pack(">BHH", 15, 0, 3)
    assert [bench.tags[name] for name in ("aBool", "Hosts.Go", "Hosts.Stop")] == [True, True, False]
    assert bench.ask(struct.pack(">BHH", 5, 1, 0)) == struct.pack(">BHH", 5, 1, 0)
    assert bench.ask(struct.pack(">BHH", 5, 3, 0))[0] == 5
    assert (bench.tags["Hosts.Go"], bench.tags["anInt"]) == (False, -1234 & 0x7FFF)
    assert bench.ask(struct.pack(">BHHB", 15, 38, 10, 2) + b"\xff\x03")[0] == 15
    assert [bench.tags[f"Flags[{at}]"] for at in (29, 30, 39, 40)] == [False, True, True, False]
    assert bench.tags["Flags[3]"]


@pytest.mark.parametrize(
    ("pdu", "reply"),
    [
        ("03 00 12 00 01", "83 02"),  # no tag
        ("03 00 0c 00 02", "83 02"),  # the second one has none
        ("01 00 04 00 01", "81 02"),
        ("03 00 00 00 00", "83 03"),  # no registers
        ("03 00 00 00 7e", "83 03"),  # 126
        ("01 00 00 07 d1", "81 03"),  # 2,001 coils
        ("03 00 00", "83 03"),
        ("03 00 00 00 01 00", "83 03"),
        ("06 00 28 00 01", "86 02"),  # clients only read it
        ("05 00 64 ff 00", "85 02"),
        ("06 00 00 00 01", "86 02"),  # half a DINT
        ("10 00 01 00 02 04 00 00 00 00", "90 02"),  # two halves
        ("10 00 04 00 02 04 00 07 00 80", "90 03"),  # 128 does not fit a SINT, and 7 is not written
        ("06 00 3c ff ff", "86 03"),  # nor -1 a USINT
        ("10 00 04 00 02 03 00 00 00", "90 03"),
        ("05 00 00 00 01", "85 03"),
        ("0f 00 00 00 03 02 00 00", "8f 03"),
        ("17 00 12 00 01 00 04 00 01 02 00 05", "97 02"),  # the read is refused, and so is the write
        ("2b 0e 01 00", "ab 01"),
        ("07", "87 01"),
    ],
)
def test_what_is_refused_changes_nothing(bench: Bench, pdu: str, reply: str) -> None:
    assert bench.ask(bytes.fromhex(pdu)) == bytes.fromhex(reply)
    assert (bench.tags["aDint"], bench.tags["anInt"], bench.tags["Locked"]) == (123_456, -1234, 7)


def test_a_write_is_an_order_of_its_client(bench: Bench) -> None:
    bench.write(4, 5)
    (given,) = [each.order for each in bench.rack.hands.applied]
    assert given == Store("anInt", 0, "0500", "", "127.0.0.1:5000")


def test_a_row_without_a_place_is_named(bench: Bench) -> None:
    table = {
        "coils": ({"address": 0, "tag": "aDint"}, {"address": 65_500, "tag": "Flags"}),
        "holding_registers": (
            {"address": 0, "tag": "Missing"},
            {"address": 1, "tag": "aBool"},
            {"address": 2, "tag": "Fill"},
            {"address": 3, "tag": "Text[ "},
            {"address": 4, "tag": "aDint"},
            {"address": 5, "tag": "anInt"},
        ),
    }
    made = RegisterMap(Database(bench.rack.desk.listing), ModbusTable.model_validate(table))
    assert made.problems == [
        "[server.modbus] coils[0], tag aDint: its type is DINT; coils accept BOOL",
        "[server.modbus] coils[1], tag Flags: it needs 64 addresses from 65500 on; "
        "the last valid address is 65535",
        "[server.modbus] holding_registers[0], tag Missing: no tag 'Missing'",
        "[server.modbus] holding_registers[1], tag aBool: its type is BOOL; holding_registers accept an "
        "integer or a REAL",
        "[server.modbus] holding_registers[2], tag Fill: its type is TIMER; map one of its members",
        "[server.modbus] holding_registers[3], tag Text[ : 'Text[ ' is not a name of a tag, such as "
        "Recipe.Steps[2].Time",
        "[server.modbus] holding_registers[5], tag anInt: aDint already has an address from 5 on",
    ]


def test_data_files_are_mapped_by_their_addresses(tmp_path: Path) -> None:
    table = {
        "coils": ({"address": 0, "tag": "B3:1/2"},),
        "holding_registers": ({"address": 0, "tag": "N7:3"}, {"address": 1, "tag": "T4:0.PRE"}),
        "input_registers": ({"address": 0, "tag": "I:1.0"}, {"address": 1, "tag": "F8:1"}),
    }
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path, files=True), ports)
        made = RegisterMap(Database(rack.desk.listing, ("*",)), ModbusTable.model_validate(table))
        assert made.problems == []
        session = ModbusSession(made)
        found = []
        for pdu in ("01 00 00 00 01", "03 00 00 00 02", "04 00 01 00 02"):
            request = bytes.fromhex(pdu)
            (packet,) = session.receive(struct.pack(">HHHB", 1, 0, len(request) + 1, 1) + request)
            results = rack.exchange([("here", session.plan(packet, 1).operations)])[2][0]
            found.append(session.reply(packet, Instant(results, 0, 1))[9:])
    assert found == [b"\1", struct.pack(">hh", -4, 500), struct.pack(">f", -2.25)]


def test_other_bytes_end_the_client(bench: Bench) -> None:
    with pytest.raises(BrokenClientError):
        ModbusSession(bench.map).receive(b"GET / HTTP/1.1\r\n")


def test_a_mask_reaches_the_second_register_of_a_value(bench: Bench) -> None:
    """Register 1 has the low word of aDint, which is 123,456 = 1 E240h."""
    assert bench.ask(struct.pack(">BHHH", 0x16, 1, 0, 5)) == struct.pack(">BHHH", 0x16, 1, 0, 5)
    assert (bench.words(3, 0, 2), bench.tags["aDint"]) == ((1, 5), 0x10005)
