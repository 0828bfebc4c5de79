"""A scanner of EtherNet/IP for a served drive, of bare sockets."""

from __future__ import annotations

import socket
import struct
from time import monotonic

from drive_served import TIMEOUT_S

SETTINGS = struct.pack("<HHiHHHH", 0, 3, 1000, 2048, 0, 20, 28)
PATH = bytes.fromhex("20 04 24 6E 2C 96 2C 64")
MANAGER = bytes.fromhex("02 20 06 24 01")
SECONDS = 20


def with_settings(settings: bytes = SETTINGS) -> bytes:
    return PATH + bytes((0x80, len(settings) // 2)) + settings


def forward_open(
    path: bytes = PATH,
    sizes: tuple[int, int] = (26, 22),
    rpi_us: int = 10_000,
    trigger: int = 1,
    multiplier: int = 0,
    serial: int = 7,
) -> bytes:
    """Return the data of a request of a class 1 connection."""
    to_target, to_originator = (0x4800 | size for size in sizes)
    head = struct.pack("<BBIIHHIB3x", 10, 5, 0, 0x1234, serial, 99, 42, multiplier)
    rates = struct.pack("<IHIHBB", rpi_us, to_target, rpi_us, to_originator, trigger, len(path) // 2)
    return head + rates + path


def class_1_packet(connection: int, count: int, words: tuple[int, ...], run: int = 1) -> bytes:
    """Return a packet to the drive; words that are missing are 0."""
    data = struct.pack("<HI10H", count & 0xFFFF, run, *words, *(0,) * (10 - len(words)))
    return struct.pack("<HHHIIHH", 2, 0x8002, 8, connection, count, 0xB1, len(data)) + data


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
        request = forward_open(path, sizes, rpi_us, trigger, multiplier, serial)
        reply = self.ask(b"\x54" + manager + request)
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
        packet = class_1_packet(self.ours, self.packets, words, run)
        self.udp.sendto(packet, self.target)

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
