#!/usr/bin/env bash
# what: a uModbus server refuses a write of three registers with exception 02 and has written two of them
# date: 2026-11-30
# meets: masters that repeat or give up a refused write, and trust that nothing has changed
# expected: exception 02 and three unchanged registers
# behavior:
#   The server calls the route of each address in turn and answers with the exception of the first one without a route,
#   after it has called those before. Coils do the same.
# product: Checks every address of a request before it writes the first one: [Modbus](hmi.md#modbus)
# output:
#   registers 7, 8, 9: written 21 22 23
#   registers 8, 9, 10: IllegalDataAddressError, written 31 32
#   coils 8, 9, 10: IllegalDataAddressError, written 1 1
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install uModbus==1.0.4 pyserial==3.5
observe python - <<'PY'
import socket
import threading
from socketserver import TCPServer

from umodbus.client import tcp
from umodbus.exceptions import ModbusError
from umodbus.server.tcp import RequestHandler, get_server

server = get_server(TCPServer, ("127.0.0.1", 0), RequestHandler)
written = []


@server.route(slave_ids=[1], function_codes=[15, 16], addresses=range(10))
def write(slave_id, function_code, address, value):
    written.append(value)


threading.Thread(target=server.serve_forever, daemon=True).start()
connection = socket.create_connection(server.server_address, 5)
for name, request in (
    ("registers 7, 8, 9", tcp.write_multiple_registers(1, 7, [21, 22, 23])),
    ("registers 8, 9, 10", tcp.write_multiple_registers(1, 8, [31, 32, 33])),
    ("coils 8, 9, 10", tcp.write_multiple_coils(1, 8, [1, 1, 1])),
):
    written.clear()
    try:
        tcp.send_message(request, connection)
        answer = ""
    except ModbusError as error:
        answer = f"{type(error).__name__}, "
    print(f"{name}: {answer}written", *written)
connection.close()
server.shutdown()
PY
