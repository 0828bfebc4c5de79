#!/usr/bin/env bash
# what: python-snap7 3 shares a registered bytearray with its server, but silently copies a registered ctypes array
# date: 2026-11-30
# meets: anyone who runs a server script from snap7 1 or 2, whose examples register ctypes arrays
# expected: one memory in both cases, since register_area takes both and returns 0 for both
# behavior:
#   A client's write reaches the bytearray. The array keeps its old value, and what the script writes to the array is
#   never read by a client.
# product: Does not serve S7; see the protocols that it serves: [HMI](hmi.md)
# output:
#   bytearray: a client writes 22h, the script reads 22h; the script writes 33h, a client reads 33h
#   c_ubyte_Array_1: a client writes 22h, the script reads 11h; the script writes 33h, a client reads 22h
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install python-snap7==3.3.0
observe python - <<'PY'
import ctypes
import time

from snap7 import Client, Server
from snap7.type import SrvArea

memories = [bytearray([0x11]), (ctypes.c_ubyte * 1)(0x11)]
server = Server(log=False)
for number, memory in enumerate(memories, 1):
    assert server.register_area(SrvArea.DB, number, memory) == 0
server.start(tcp_port=18103)
time.sleep(0.5)
client = Client()
client.connect("127.0.0.1", 0, 1, 18103)
for number, memory in enumerate(memories, 1):
    client.db_write(number, 0, bytearray([0x22]))
    written = memory[0]
    memory[0] = 0x33
    read = client.db_read(number, 0, 1)[0]
    print(
        f"{type(memory).__name__}: a client writes 22h, the script reads {written:02x}h;"
        f" the script writes 33h, a client reads {read:02x}h"
    )
client.disconnect()
server.stop()
PY
