"""`scanrack serve smd23e2 --ethernet-ip`: identity, assemblies, the class 1 connection."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from time import monotonic

import pytest
from drive_scanner import PATH, SETTINGS, Scanner, class_1_packet, with_settings
from drive_served import serving
from drive_unit import VALID
from mcap.reader import make_reader

SECONDS = 20


@pytest.fixture
def scanner() -> Iterator[Scanner]:
    words = ("smd23e2", "--ethernet-ip", "0", "--io-port", "0", "--time-scale", "10")
    with serving(*words) as served:
        place = served.line.split()
        opened = Scanner(int(place[0].rpartition(":")[2]), int(place[place.index("UDP") + 1]))
        yield opened
        opened.close()


def test_identity_and_assemblies_by_explicit_reads(scanner: Scanner) -> None:
    """Vendor 10, device type 12, product code 29, revision 1.6 [EDS]."""
    assert scanner.ask(b"\1\2\x20\1\x24\1")[4:12] == struct.pack("<HHHBB", 10, 12, 29, 1, 6)
    assert scanner.get(1, 1, 7) == b"\7SMD23E2"
    listed = scanner.frame(0x63, b"")
    assert b"SMD23E2" in listed
    assert struct.unpack("<10H", scanner.get(4, 100, 3))[0] == 0x6408
    assert scanner.get(4, 150, 3) == bytes(20)
    assert scanner.get(4, 110, 4) == struct.pack("<H", 16)
    assert scanner.ask(bytes((0x0E, 3, 0x20, 4, 0x24, 101, 0x30, 3)))[2] == 5


def test_the_network_interface_has_the_address_of_the_server(scanner: Scanner) -> None:
    assert scanner.get(0xF5, 1, 5)[:4] == bytes((1, 0, 0, 127))
    assert scanner.get(0xF6, 1, 1) == struct.pack("<I", 1000)


def test_a_connection_with_a_configuration_moves_the_drive(scanner: Scanner) -> None:
    assert scanner.open(with_settings())[:4] == b"\xd4\0\0\0"
    assert scanner.get(4, 110, 3) == SETTINGS
    scanner.until(1, 0x8000, 0x8000, 0, 0x8000)
    scanner.until(1, 0x2000, 0x2000, 0x0200, 0x8000)
    scanner.until(1, 0x2000, 0, 0, 0x8000)
    seen = scanner.until(0, 0x0088, 0x0088, 1, 0x8000, 3, 0, 5, 0, 20, 20)
    assert seen[2:4] == (3, 0)
    assert scanner.shut()[:4] == b"\xce\0\0\0"


def test_a_path_of_16_bit_segments_opens_too(scanner: Scanner) -> None:
    assert scanner.open(manager=bytes.fromhex("04 21000600 25000100"))[:4] == b"\xd4\0\0\0"


def test_counts_of_packets_go_up(scanner: Scanner) -> None:
    scanner.open()
    counts = [scanner.receive()[:2] for _ in range(5)]
    first = counts[0][0]
    assert counts == [(first + at, first + at) for at in range(5)]


def test_an_idle_scanner_shows_as_a_plc_in_program_mode(scanner: Scanner) -> None:
    scanner.open(with_settings())
    scanner.until(1, 0x8000, 0x8000, 0, 0x8000)
    assert not scanner.until(1, 0x0020, 0x0020, 0, 0x8000, run=0)[1] & 0x8000
    scanner.until(1, 0x8020, 0x8000, 0, 0x8000)


def test_a_silent_scanner_loses_its_connection_and_the_driver_its_current(scanner: Scanner) -> None:
    """Time-out: 4 x 10 ms after a first packet."""
    scanner.open(with_settings())
    scanner.until(1, 0x8000, 0x8000, 0, 0x8000)
    end = monotonic() + SECONDS
    while scanner.open(serial=8)[2]:
        assert monotonic() < end
    assert not struct.unpack("<10H", scanner.get(4, 100, 3))[1] & 0x8000


@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"sizes": (24, 22)}, 0x0127),
        ({"sizes": (26, 20)}, 0x0128),
        ({"path": with_settings(bytes(14))}, 0x0126),
        ({"path": bytes.fromhex("20 04 24 6F 2C 96 2C 64")}, 0x0129),
        ({"path": bytes.fromhex("20 04 24 6E 2C 97 2C 64")}, 0x012A),
        ({"path": bytes.fromhex("20 04 24 6E 2C 96 2C 65")}, 0x012B),
        ({"path": bytes.fromhex("20 04 24 6E 2C 96")}, 0x012B),
        ({"path": bytes.fromhex("34 04 0B 00 0C 00 1D 00 01 06") + PATH}, 0x0114),
        ({"path": bytes.fromhex("34 04 0A 00 0C 00 1D 00 02 06") + PATH}, 0x0116),
        ({"rpi_us": 999}, 0x0111),
        ({"trigger": 3}, 0x0103),
    ],
)
def test_a_refused_connection_says_why(scanner: Scanner, changed: dict[str, object], status: int) -> None:
    reply = scanner.open(**changed)  # type: ignore[arg-type]
    assert reply[2:6] == bytes((1, 1)) + struct.pack("<H", status)
    assert scanner.open()[2] == 0


def test_a_second_owner_is_refused_and_costs_the_first_nothing(scanner: Scanner) -> None:
    scanner.open()
    assert scanner.open(serial=8)[2:6] == b"\1\1\x06\1"
    assert scanner.open()[2:6] == b"\1\1\0\1"
    scanner.send()
    scanner.receive()


def test_an_invalid_configuration_is_the_drives_own_bit(scanner: Scanner) -> None:
    assert scanner.open(with_settings(struct.pack("<HHiHHHH", 0, 3, 0, 2048, 0, 20, 28)))[2] == 0
    assert scanner.receive()[2][0] & 0x2000


def test_packets_that_are_none_cost_nothing(scanner: Scanner) -> None:
    scanner.packets = 1000
    scanner.open(with_settings())
    for noise in (b"", b"\2\0", bytes(100), b"\xff" * 40):
        scanner.udp.sendto(noise, scanner.target)
    scanner.until(1, 0x8000, 0x8000, 0, 0x8000)
    scanner.packets -= 100
    scanner.send()  # an old packet
    scanner.packets += 100
    assert scanner.until(1, 0x8000, 0x8000, 0, 0x8000)


def test_the_words_of_the_configuration_are_those_of_modbus(scanner: Scanner) -> None:
    scanner.open(with_settings())
    first, second, start, steps, *_ = struct.unpack("<HHiHHHH", scanner.get(4, 110, 3))
    assert (first | 0x8000, second, divmod(start, 1000), steps) == (VALID[0], VALID[1], (1, 0), VALID[4])


def test_packets_of_class_1_are_recorded(tmp_path: Path) -> None:
    """Each is on /line as it was on the network, and the counts of late ones are values of the axis."""
    words = ("smd23e2", "--ethernet-ip", "0", "--io-port", "0", "--record", "line.mcap")
    with serving(*words, cwd=tmp_path) as served:
        place = served.line.split()
        with closing(Scanner(int(place[0].rpartition(":")[2]), int(place[place.index("UDP") + 1]))) as owner:
            owner.open(with_settings())
            sent, received = [], []
            for word in (0, 1 << 15, 0):
                sent.append(class_1_packet(owner.ours, owner.packets + 1, (0, word)).hex(" "))
                owner.send(0, word)
                received.append(owner.udp.recv(2048).hex(" "))
            owner.shut()
    with (tmp_path / "line.mcap").open("rb") as stream:
        messages = [
            (channel.topic, json.loads(message.data))
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages()
        ]
    line = [(each["direction"], each["hex"]) for topic, each in messages if topic == "/line"]
    assert [data for way, data in line if way == "received" and data in sent] == sent
    assert [data for way, data in line if way == "sent" and data in received] == received
    units = [each for topic, each in messages if topic == "/unit1"]
    assert {"late_received", "late_sent"} <= units[-1].keys()
    assert units[-1]["out.command_1"] == 0
