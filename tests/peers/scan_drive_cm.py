"""Moves a drive at EtherNet/IP with the scanner `cm-ethernetip`: python scan_drive_cm.py HOST PORT WORDS.

It sends no configuration with the connection: the ten words of WORDS, JSON, configure the drive. Its sizes of
a connection leave the sequence count out, so it opens with 22 bytes and then sends and takes 20. It names no
port for its packets, which therefore come to 2222, and listens at another one: here at 2222.
"""

from __future__ import annotations

import asyncio
import json
import struct
import sys
from typing import Any

from ethernetip.protocol import eip_scanner
from ethernetip.protocol.forward_open_config import ForwardOpenConfig

SECONDS = 20
IO_PORT = 2222
GET_ATTRIBUTE = 0x0E
PRODUCT_NAME, INPUTS = bytes.fromhex("20 01 24 01 30 07"), bytes.fromhex("20 04 24 64 30 03")
ENABLE = 0x8000


def packed(*words: int) -> bytes:
    """Return ten words; missing ones are 0."""
    return struct.pack("<10H", *words, *(0,) * (10 - len(words)))


async def until(connection: Any, at: int, mask: int, value: int) -> tuple[int, ...]:
    """Wait for bits of an input word; return the words."""
    end = asyncio.get_running_loop().time() + SECONDS
    while True:
        words = struct.unpack("<10H", connection.produced_data[:20])
        if words[at] & mask == value:
            return words
        assert asyncio.get_running_loop().time() < end, [f"{word:04x}" for word in words]
        await asyncio.sleep(0.005)


async def main(host: str, port: int, configuration: list[int]) -> None:
    """Configure, enable, preset, move to 3000."""
    transport = eip_scanner.EipUdpTransport
    eip_scanner.EipUdpTransport = lambda bind_address, **_: transport(bind_address, bind_port=IO_PORT)
    scanner: Any = eip_scanner.EipScanner()
    await scanner.connect(host, port)
    name = (await scanner.send_explicit(GET_ATTRIBUTE, PRODUCT_NAME)).data
    status = (await scanner.send_explicit(GET_ATTRIBUTE, INPUTS)).data[:2]
    asked = ForwardOpenConfig(150, 100, 110, consumed_size=22, produced_size=22, rpi=10_000)
    connection = await scanner.forward_open(asked)
    connection._consumed_data = bytearray(20)

    async def put(words: bytes, at: int, mask: int, value: int) -> tuple[int, ...]:
        connection.set_consumed_data(words)
        return await until(connection, at, mask, value)

    await put(packed(*configuration), 0, 0xA000, 0x8000)
    await put(packed(0, ENABLE), 1, 0x8000, 0x8000)
    await put(packed(0x0200, ENABLE), 1, 0x2000, 0x2000)
    await put(packed(0, ENABLE), 1, 0x2000, 0)
    seen = await put(packed(1, ENABLE, 3, 0, 5, 0, 20, 20), 0, 0x88, 0x88)
    await connection.close()
    await scanner.close()
    said = {"name": name.decode()[1:], "status": list(status), "position": list(seen[2:4])}
    sys.stdout.write(json.dumps(said))


asyncio.run(main(sys.argv[1], int(sys.argv[2]), json.loads(sys.argv[3])))
