#!/usr/bin/env bash
# what: pyserial's in_waiting is 1 for eight received bytes if the port is a socket:// of a serial device server
# date: 2026-11-30
# meets: programs with read(in_waiting) whose controller moves from a COM port to a serial device server
# expected: 8, "the number of bytes currently in the input buffer"
# behavior:
#   With socket:// the property is the number of readable sockets, 0 or 1. read(in_waiting) returns one byte of an
#   answer, and a loop until in_waiting stands still ends after the first byte. loop:// of the same package says 8.
# product: Its clients request a number of bytes and wait: [line clients](line-clients.md#from-python)
# output:
#   loop://: in_waiting 8, read(in_waiting) 0103040001000200
#   socket://: in_waiting 1, read(in_waiting) 01
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pyserial==3.5
observe python - <<'PY'
import socket
import time

import serial

ANSWER = bytes.fromhex("0103040001000200")


def show(name, port):
    time.sleep(0.5)
    waiting = port.in_waiting
    print(f"{name}: in_waiting {waiting}, read(in_waiting)", port.read(waiting).hex())


loop = serial.serial_for_url("loop://", timeout=1)
loop.write(ANSWER)
show("loop://", loop)
listener = socket.create_server(("127.0.0.1", 0))
port = serial.serial_for_url(f"socket://127.0.0.1:{listener.getsockname()[1]}", timeout=1)
device, _ = listener.accept()
device.sendall(ANSWER)
show("socket://", port)
port.close()
PY
