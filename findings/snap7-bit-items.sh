#!/usr/bin/env bash
# what: python-snap7's own server answers a read of one bit with its whole byte, and a write of one bit replaces the byte
# date: 2026-11-30
# meets: anyone who tests an S7 client or HMI against that server before a PLC is there
# expected: 00 or 01 for a bit, and a write that leaves the other seven bits alone, as an S7 controller answers
# behavior:
#   The server divides the bit address by eight and then handles one byte. Each of the eight bits of 55h reads 55h, so
#   that bits that are 0 look set. Writing 1 to bit 1 of 55h leaves 01h.
# product: Does not serve S7; see the protocols that it serves: [HMI](hmi.md)
# output:
#   bits 0 to 7 of 55h: 55 55 55 55 55 55 55 55
#   bit 1 of 55h set: 01
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install python-snap7==3.3.0
observe python - <<'PY'
import time

from snap7 import Client, Server
from snap7.type import Area, SrvArea, WordLen

memory = bytearray([0x55, 0x55])
server = Server(log=False)
server.register_area(SrvArea.DB, 1, memory)
server.start(tcp_port=18102)
time.sleep(0.5)
client = Client()
client.connect("127.0.0.1", 0, 1, 18102)
bits = [client.read_area(Area.DB, 1, bit, 1, WordLen.Bit).hex() for bit in range(8)]
print("bits 0 to 7 of 55h:", *bits)
client.write_area(Area.DB, 1, 8 + 1, bytearray([1]), WordLen.Bit)
print("bit 1 of 55h set:", f"{memory[1]:02x}")
client.disconnect()
server.stop()
PY
