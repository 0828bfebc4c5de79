#!/usr/bin/env bash
# what: uModbus's client accepts the answer to an earlier request as the answer to this one, so values belong to other registers
# date: 2026-11-30
# meets: pollers that catch a timeout of a slow device and continue with the same socket
# expected: every register its own value, or an error, since each request has a transaction identifier that its answer repeats
# behavior:
#   The answer to the first request comes after the timeout of 0.5 s and waits in the socket. uModbus never looks at
#   the transaction identifier, so each later request returns the value of the register before it. modbus_tk, with the same
#   device, reads the right values. The device's registers hold their own addresses.
# product: Its client compares transaction, unit, function, count, address and value: [line clients](line-clients.md#from-python)
# output:
#   uModbus: register 100 TimeoutError
#   uModbus: register 200 reads 100
#   uModbus: register 300 reads 200
#   uModbus: register 400 reads 300
#   modbus_tk: register 100 TimeoutError
#   modbus_tk: register 200 reads 200
#   modbus_tk: register 300 reads 300
#   modbus_tk: register 400 reads 400
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install uModbus==1.0.4 modbus_tk==1.1.5 pyserial==3.5
observe python - <<'PY'
import socket
import struct
import threading
import time

from modbus_tk.defines import READ_HOLDING_REGISTERS
from modbus_tk.modbus_tcp import TcpMaster
from umodbus.client import tcp

TIMEOUT_S, DELAY_S = 0.5, 1.5
slow = threading.Event()


def answer(connection):
    """Answer reads of one register with its address; wait before one answer where it shall be slow."""
    with connection, connection.makefile("rb") as requests:
        while len(request := requests.read(12)) == 12:
            transaction, unit, address = struct.unpack(">H4xBxH2x", request)
            if slow.is_set():
                slow.clear()
                time.sleep(DELAY_S)
            connection.sendall(struct.pack(">HHHBBBH", transaction, 0, 5, unit, 3, 2, address))


def serve(listener):
    while True:
        threading.Thread(target=answer, args=(listener.accept()[0],), daemon=True).start()


def read_all(name, read):
    slow.set()
    for address in (100, 200, 300, 400):
        try:
            print(f"{name}: register {address} reads", *read(address))
        except TimeoutError:
            print(f"{name}: register {address} TimeoutError")
        time.sleep(DELAY_S)


listener = socket.create_server(("127.0.0.1", 0))
port = listener.getsockname()[1]
threading.Thread(target=serve, args=(listener,), daemon=True).start()
connection = socket.create_connection(("127.0.0.1", port), TIMEOUT_S)
read_all("uModbus", lambda address: tcp.send_message(tcp.read_holding_registers(1, address, 1), connection))
master = TcpMaster("127.0.0.1", port, timeout_in_sec=TIMEOUT_S)
read_all("modbus_tk", lambda address: master.execute(1, READ_HOLDING_REGISTERS, address, 1))
PY
