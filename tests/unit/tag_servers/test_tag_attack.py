"""Nonsense of all kinds: each packet gets an answer, or ends its own connection, and nothing else happens."""

from __future__ import annotations

import random
import struct
from contextlib import ExitStack
from pathlib import Path

import pytest
from amounts import amount
from scanrack.runtime.tag_servers.tag_snapshot import BrokenClientError
from served_tags import Client, ServedRack, batch, frame, message, symbol, unconnected, write_rack

ONE = struct.pack("<H", 1)
READ = message(0x4C, symbol("Scan"), ONE)
REQUEST = b"\x07\0\0\0\0\0\0"
MESSAGES = (
    READ,
    message(0x55, b"\x20\x6b\x24\x00", struct.pack("<5H", 4, 1, 2, 8, 10)),
    batch([READ, READ]),
    message(0x52, b"\x20\x06\x24\x01", struct.pack("<BBH", 5, 10, len(READ)) + READ + b"\1\0\1\0"),
    message(0x03, b"\x20\x6c\x25\0\0\1", struct.pack("<5H", 4, 4, 5, 2, 1)),
    message(0x4C, b"\x20\x6c\x25\0\xce\x0f", struct.pack("<IH", 0, 400)),
    message(0x4D, symbol("aDint"), struct.pack("<HHi", 0xC4, 1, 5)),
    message(0x53, symbol("Many", 1), struct.pack("<HHHI", 0x2A0, 1, 1, 0) + bytes(40)),
    message(0x4E, symbol("aDint"), struct.pack("<HII", 4, 8, 0xFFFFFFFF)),
    message(0x54, b"\x20\x06\x24\x01", bytes(35) + b"\x02\x20\x02\x24\x01"),
    message(0x03, b"\x20\x8b\x24\x01", struct.pack("<2H", 1, 6)),
    message(0x4B, b"\x20\x67\x24\x01", REQUEST + b"\x0f\0\1\0\xa2\x02\x07\x89\0\0"),
    message(0x4B, b"\x20\x67\x24\x01", REQUEST + b"\x0f\0\1\0\xab\x54\x09\x8d\0\0\xff\xff" + bytes(84)),
)


def mutated(chance: random.Random) -> bytes:
    """Return a message with some bytes changed, cut, put in or added."""
    data = bytearray(chance.choice(MESSAGES))
    for _ in range(chance.randrange(5)):
        how, at = chance.randrange(4), chance.randrange(len(data) + 1)
        if how == 0 and at < len(data):
            data[at] = chance.randrange(256)
        elif how == 1:
            del data[at:]
        elif how == 2:
            data.insert(at, chance.choice((0, 1, 0x7F, 0x80, 0xFF, 0x91, 0x28)))
        else:
            data += chance.randbytes(chance.randrange(1, 40))
    return bytes(data)


@pytest.mark.parametrize("files", [False, True], ids=["tags", "files"])
def test_nonsense_gets_an_answer_and_changes_nothing_else(tmp_path: Path, files: bool) -> None:
    chance = random.Random(7)
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path, files=files), ports)
        client = Client(rack)
        for _ in range(amount(400)):
            body = unconnected(mutated(chance))
            if chance.random() < 0.05:
                body = chance.randbytes(chance.randrange(64))
            command = 0x6F if chance.random() < 0.9 else 0x70
            reply = client.send(frame(command, body, client.handle))
            assert command == 0x70 or 24 <= len(reply) <= 24 + 16 + 504
        before = rack.run.cpu.scan
        assert client.ask(message(0x01, b"\x20\x01\x24\x01"))[0] == 0
        assert rack.run.cpu.scan == before + 1
        if not files:
            assert rack.debugger.tags["Locked"] == 7


def test_every_service_of_every_object_is_answered(tmp_path: Path) -> None:
    paths = [symbol("Scan"), b"", b"\x20\x6b\x24\x05", b"\x20\x6b\x24\xff", *(
        bytes((0x20, kind, 0x24, 1)) for kind in (1, 2, 6, 0x64, 0x67, 0x6C, 0x8B, 0xAC, 0xF5)
    )]  # fmt: skip
    with ExitStack() as ports:
        client = Client(ServedRack(write_rack(tmp_path), ports))
        for service in range(0, 128, 1):
            for path in paths[service % 2 :: 2]:
                body = unconnected(message(service, path, b"\1\0\0\0\0\0"))
                assert len(client.send(frame(0x6F, body, client.handle))) >= 44


def test_every_prefix_and_noise_ends_its_own_session_at_most(tmp_path: Path) -> None:
    chance = random.Random(11)
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path), ports)
        whole = frame(0x6F, unconnected(READ), 0)
        for end in range(len(whole)):
            assert Client(rack).session.receive(whole[:end]) == []
        for _ in range(200):
            session = Client(rack).session
            try:
                for packet in session.receive(chance.randbytes(chance.randrange(1, 200))):
                    session.plan(packet, 1)
            except BrokenClientError:
                pass
        assert Client(rack).ask(READ)[0] == 0
