"""Nonsense over Modbus TCP: each whole frame is answered, or ends its own connection, and that is all.

Broken on purpose: tags written that the rack does not list: a test turns red.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from amounts import amount
from scanrack.runtime.config.server_table import ModbusTable
from scanrack.runtime.tag_servers.setup import MODBUS_TCP, SESSIONS
from scanrack.runtime.tag_servers.tag_snapshot import BrokenClientError, Instant
from served_tags import ServedRack, write_rack

MAP = ModbusTable.model_validate(
    {
        "coils": ({"address": 0, "tag": "aBool"}, {"address": 8, "tag": "Flags"}),
        "discrete_inputs": ({"address": 0, "tag": "Locked.0"},),
        "input_registers": ({"address": 0, "tag": "Locked"},),
        "holding_registers": ({"address": 0, "tag": "aDint"}, {"address": 6, "tag": "Locked"}),
    }
)
PDUS = tuple(
    bytes.fromhex(text)
    for text in (
        "01 0000 0001", "02 0000 0001", "03 0000 0002", "04 0000 0002", "05 0000 ff00", "06 0000 0007",
        "0f 0008 0003 01 05", "10 0000 0002 04 00000005", "16 0000 00ff 0100",
        "17 0000 0002 0000 0002 04 00000007",
        "10 0006 0002 04 00000005", "2b 0e 01 00", "08 0000 1234", "14 07 06 0001 0000 0002",
    )
)  # fmt: skip


class Attacked:
    """A rack whose coils and registers are asked without sockets."""

    def __init__(self, rack: ServedRack) -> None:
        self.rack = rack
        self.sessions = SESSIONS[MODBUS_TCP](replace(rack.setup, protocol=MODBUS_TCP, modbus=MAP))

    def answers(self, data: bytes) -> list[bytes]:
        """Send bytes as a client of their own; BrokenClientError if they end it."""
        session = self.sessions.open()
        found = []
        for packet in session.receive(data):
            plan = session.plan(packet, 1)
            now_ns, version, results = self.rack.exchange([("127.0.0.1:5000", plan.operations)])
            found.append(session.reply(packet, Instant(results[0], now_ns, version)))
        return found


def framed(pdu: bytes, length: int | None = None) -> bytes:
    return struct.pack(">HHHB", 0x1234, 0, len(pdu) + 1 if length is None else length, 1) + pdu


@pytest.fixture
def attacked(tmp_path: Path) -> Iterator[Attacked]:
    with ExitStack() as ports:
        yield Attacked(ServedRack(write_rack(tmp_path), ports))


def check_alive(attacked: Attacked) -> None:
    (reply,) = attacked.answers(framed(bytes.fromhex("04 0000 0002")))
    assert reply == bytes.fromhex("1234 0000 0007 01 04 04 00000007")  # Locked is 7


def mutated(chance: random.Random) -> bytes:
    data = bytearray(chance.choice(PDUS))
    for _ in range(chance.randrange(5)):
        how, at = chance.randrange(4), chance.randrange(len(data) + 1)
        if how == 0 and at < len(data):
            data[at] = chance.randrange(256)
        elif how == 1 and at:
            del data[at:]
        elif how == 2:
            data.insert(at, chance.choice((0, 1, 0x7F, 0x80, 0xFF)))
        else:
            data += chance.randbytes(chance.randrange(1, 40))
    return bytes(data)


def test_each_request_is_answered_by_its_function_or_an_exception(attacked: Attacked) -> None:
    """An exception is the function with bit 7, and a code of 1 to 4 [Modbus application protocol, 7]."""
    chance = random.Random(3)
    for _ in range(amount(600)):
        pdu = mutated(chance)
        (reply,) = attacked.answers(framed(pdu))
        assert reply[:4] == b"\x12\x34\0\0"
        assert struct.unpack_from(">H", reply, 4)[0] == len(reply) - 6 <= 254
        assert reply[7] in (pdu[0], pdu[0] | 0x80)
        if reply[7] & 0x80:
            assert len(reply) == 9
            assert reply[8] in (1, 2, 3, 4)
    check_alive(attacked)


def test_every_function_with_every_length_is_answered(attacked: Attacked) -> None:
    for function in range(256):
        for length in (0, 1, 3, 4, 5, 9):
            (reply,) = attacked.answers(framed(bytes((function,)) + bytes(length)))
            assert reply[7] in (function, function | 0x80)
    check_alive(attacked)


def test_prefixes_wait_and_noise_ends_its_own_session_at_most(attacked: Attacked) -> None:
    whole = framed(PDUS[2])
    for end in range(len(whole)):
        assert attacked.answers(whole[:end]) == []
    chance, ended = random.Random(5), 0
    for _ in range(300):
        try:
            attacked.answers(chance.randbytes(chance.randrange(1, 300)))
        except BrokenClientError:
            ended += 1
    assert ended > 200  # a protocol other than 0 in 65,535 of 65,536 heads
    check_alive(attacked)


@pytest.mark.parametrize("length", [0, 1, 255, 65_535])
def test_a_length_that_there_is_not_ends_the_session(attacked: Attacked, length: int) -> None:
    with pytest.raises(BrokenClientError):
        attacked.answers(framed(PDUS[2], length) + bytes(300))
    check_alive(attacked)
