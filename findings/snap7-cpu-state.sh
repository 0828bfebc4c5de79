#!/usr/bin/env bash
# what: python-snap7's get_cpu_state reports RUN for a controller that the same client has stopped
# date: 2026-11-30
# meets: anyone who waits with this client until an S7 controller has stopped or started
# expected: STOP after plc_stop, RUN after plc_hot_start
# behavior:
#   The server's own cpu_state follows the requests. The client sends a read request without an address in place of the
#   request for the system status, and returns RUN whatever the answer is.
# product: Does not serve S7; see the protocols that it serves: [HMI](hmi.md)
# output:
#   started: the server is in RUN, the client says S7CpuStatusRun
#   plc_stop: the server is in STOP, the client says S7CpuStatusRun
#   plc_hot_start: the server is in RUN, the client says S7CpuStatusRun
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install python-snap7==3.3.0
observe python - <<'PY'
import logging
import time

from snap7 import Client, Server
from snap7.type import SrvArea

logging.disable(logging.CRITICAL)
server = Server(log=False)
server.register_area(SrvArea.DB, 1, bytearray(8))
server.start(tcp_port=18104)
time.sleep(0.5)
client = Client()
client.connect("127.0.0.1", 0, 1, 18104)


def compare(request):
    print(f"{request}: the server is in {server.cpu_state.name}, the client says {client.get_cpu_state()}")


compare("started")
client.plc_stop()
compare("plc_stop")
client.plc_hot_start()
compare("plc_hot_start")
client.disconnect()
server.stop()
PY
