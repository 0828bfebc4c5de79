"""`scanrack serve smd23e2 --ethernet-ip`: identity, assemblies, the class 1 connection."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from time import monotonic

import pytest
from drive_served import TIMEOUT_S, serving
from drive_unit import VALID

SETTINGS = struct.pack("<HHiHHHH", 0, 3, 1000, 2048, 0, 20, 28)
PATH = bytes.fromhex("20 04 24 6E 2C 96 2C 64")
MANAGER = bytes.fromhex("02 20 06 24 01")
SECONDS = 20


class Scanner:
    """One TCP session and one UDP socket."""

    def __init__(self, port: int, io_port: int) -> None:
        self.tcp = socket.create_connection(("127.0.0.1", port), timeout=TIMEOUT_S)
        self.udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.udp.bind(("127.0.0.1", 0))
        self.udp.settimeout(TIMEOUT_S)
        self.target = ("127.0.0.1", io_port)
        self.session, self.packets, self.serial = 0, 0, 0
        self.session = struct.unpack_from("<I", self.frame(0x65, b"\1\0\0\0"), 4)[0]

    def close(self) -> None:
        self.tcp.close()
        self.udp.close()

    def frame(self, command: int, body: bytes) -> bytes:
        self.tcp.sendall(struct.pack("<HHII8sI", command, len(body), self.session, 0, b"8 bytes.", 0) + body)
        data = b""
        while len(data) < 24 or len(data) < 24 + struct.unpack_from("<H", data, 2)[0]:
            more = self.tcp.recv(4096)
            assert more
            data += more
        return data

    def ask(self, request: bytes) -> bytes:
        """Return the reply to an unconnected request."""
        origin = struct.pack("<HH", 0x8001, 16) + struct.pack(">HH12x", 2, self.udp.getsockname()[1])
        body = struct.pack("<IHHHHHH", 0, 0, 3, 0, 0, 0xB2, len(request)) + request + origin
        reply = self.frame(0x6F, body)
        size = struct.unpack_from("<H", reply, 24 + 14)[0]
        return reply[40 : 40 + size]

    def get(self, kind: int, instance: int, attribute: int) -> bytes:
        reply = self.ask(bytes((0x0E, 3, 0x20, kind, 0x24, instance, 0x30, attribute)))
        assert reply[:4] == b"\x8e\0\0\0", reply.hex(" ")
        return reply[4:]

    def open(
        self,
        path: bytes = PATH,
        manager: bytes = MANAGER,
        sizes: tuple[int, int] = (26, 22),
        rpi_us: int = 10_000,
        trigger: int = 1,
        multiplier: int = 0,
        serial: int = 7,
    ) -> bytes:
        to_target, to_originator = (0x4800 | size for size in sizes)
        head = struct.pack("<BBIIHHIB3x", 10, 5, 0, 0x1234, serial, 99, 42, multiplier)
        rates = struct.pack("<IHIHBB", rpi_us, to_target, rpi_us, to_originator, trigger, len(path) // 2)
        reply = self.ask(b"\x54" + manager + head + rates + path)
        if reply[2] == 0:
            self.serial = serial
            self.ours = struct.unpack_from("<I", reply, 4)[0]
        return reply

    def shut(self) -> bytes:
        path = struct.pack("<BBHHIBB", 10, 5, self.serial, 99, 42, len(PATH) // 2, 0) + PATH
        return self.ask(b"\x4e" + MANAGER + path)

    def send(self, *words: int, run: int = 1) -> None:
        """Send a packet of words; the others are 0."""
        self.packets += 1
        data = struct.pack("<HI10H", self.packets & 0xFFFF, run, *words, *(0,) * (10 - len(words)))
        head = struct.pack("<HHHIIHH", 2, 0x8002, 8, self.ours, self.packets, 0xB1, len(data))
        self.udp.sendto(head + data, self.target)

    def receive(self) -> tuple[int, int, tuple[int, ...]]:
        """Return count of packets, sequence count and words of the next packet."""
        data = self.udp.recv(2048)
        assert data[:6] + data[6:10] == struct.pack("<HHHI", 2, 0x8002, 8, 0x1234)
        number, kind, size, sequence = struct.unpack_from("<IHHH", data, 10)
        assert (kind, size, len(data)) == (0xB1, 22, 40)
        return number, sequence, struct.unpack_from("<10H", data, 20)

    def until(self, word: int, mask: int, value: int, *words: int, run: int = 1) -> tuple[int, ...]:
        """Send words with each packet until bits are as they have to be."""
        end = monotonic() + SECONDS
        while True:
            self.send(*words, run=run)
            seen = self.receive()[2]
            if seen[word] & mask == value:
                return seen
            assert monotonic() < end, [f"{each:04x}" for each in seen]


@pytest.fixture
def scanner() -> Iterator[Scanner]:
    words = ("smd23e2", "--ethernet-ip", "0", "--io-port", "0", "--time-scale", "10")
    with serving(*words) as served:
        place = served.line.split()
        opened = Scanner(int(place[0].rpartition(":")[2]), int(place[place.index("UDP") + 1]))
        yield opened
        opened.close()


def with_settings(settings: bytes = SETTINGS) -> bytes:
    return PATH + bytes((0x80, len(settings) // 2)) + settings


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
