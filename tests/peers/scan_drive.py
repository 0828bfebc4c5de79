"""Moves a drive at EtherNet/IP with the scanner `ethernetip`: python scan_drive.py HOST."""

from __future__ import annotations

import json
import struct
import sys
import time
from typing import Any

from ethernetip import ethernetip

SECONDS = 20
SETTINGS = struct.pack("<HHiHHHH", 0, 3, 1000, 2048, 0, 20, 28)


def main(host: str) -> None:
    """Configure, enable, preset, move to 3000."""
    network: Any = ethernetip.EtherNetIP(host)
    drive = network.explicit_conn(host)
    drive.registerSession()
    inputs = network.registerAssembly(network.ENIP_IO_TYPE_INPUT, 20, 100, drive)
    outputs = network.registerAssembly(network.ENIP_IO_TYPE_OUTPUT, 20, 150, drive)
    network.startIO(0)
    name = drive.getAttrSingle(1, 1, 7)[1]
    opened = drive.sendFwdOpenReq(
        100, 150, 110, None, 5, 20, 20, configData=SETTINGS, originator_udp_port=network.originator_udp_port
    )

    def word(at: int) -> int:
        return sum(inputs[16 * at + bit] << bit for bit in range(16))

    def put(at: int, value: int) -> None:
        for bit in range(16):
            outputs[16 * at + bit] = bool(value >> bit & 1)

    def until(at: int, mask: int, value: int) -> None:
        end = time.monotonic() + SECONDS
        while word(at) & mask != value:
            assert time.monotonic() < end, [f"{word(each):04x}" for each in range(10)]
            time.sleep(0.01)

    drive.produce()
    put(1, 0x8000)
    until(1, 0x8000, 0x8000)
    put(0, 0x0200)
    until(1, 0x2000, 0x2000)
    put(0, 0)
    until(1, 0x2000, 0)
    for at, value in ((2, 3), (4, 5), (6, 20), (7, 20)):
        put(at, value)
    time.sleep(0.2)
    put(0, 1)
    until(0, 0x88, 0x88)
    seen = {"name": name.decode()[1:], "opened": opened, "position": [word(2), word(3)]}
    drive.stopProduce()
    time.sleep(0.1)
    seen["closed"] = drive.sendFwdCloseReq(100, 150, 110)
    network.stopIO()
    sys.stdout.write(json.dumps(seen))


main(sys.argv[1])
