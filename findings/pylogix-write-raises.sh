#!/usr/bin/env bash
# what: pylogix raises struct.error for a write of 1.7 to a DINT, although it returns other failures as a Status
# date: 2026-11-29
# meets: anyone who writes set points from an HMI and checks Response.Status
# expected: a Response with a Status that says so, or 1
# behavior:
#   A tag that is missing gives a Response with a Status and no exception. A value with a fraction for a DINT raises
#   struct.error: required argument is not an integer, so a loop that checks Status ends there. Nothing is written.
# product: Its EtherNet/IP server never gets that write; catch struct.error: [what surprises](hmi-clients.md#surprising-client-behavior)
# output:
#   speed 5 Status: Success
#   level 1.7 Status: Success
#   missing 5 Status: Path destination unknown
#   speed 1.7 struct.error: required argument is not an integer
#   speed is 5
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pylogix==1.1.6 cpppo==5.2.5
observe python - <<'PY'
import socket
import struct
import subprocess
import sys
import time

from pylogix import PLC

with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
words = [sys.executable, "-m", "cpppo.server.enip", "--no-udp", "-a", f"127.0.0.1:{port}", "speed=DINT", "level=REAL"]
with open("server.log", "w") as log:
    server = subprocess.Popen(words, stdout=log, stderr=log)
try:
    for _ in range(100):
        try:
            socket.create_connection(("127.0.0.1", port)).close()
            break
        except OSError:
            time.sleep(0.2)
    with PLC("127.0.0.1", port=port, timeout=10) as plc:
        for name, value in (("speed", 5), ("level", 1.7), ("missing", 5), ("speed", 1.7)):
            try:
                print(name, value, "Status:", plc.Write(name, value).Status)
            except struct.error as error:
                print(name, value, "struct.error:", error)
        print("speed is", plc.Read("speed").Value)
finally:
    server.terminate()
    server.wait()
PY
