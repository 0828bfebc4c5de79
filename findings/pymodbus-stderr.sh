#!/usr/bin/env bash
# what: pymodbus prints errors to stderr in a program that configures no logging
# date: 2026-11-29
# meets: anyone who calls a Modbus client in a command whose stderr is read
# expected: a library with a NullHandler prints nothing
# behavior:
#   A refused connection is logged as an error by the logger pymodbus.logging. The NullHandler of the package sits on
#   another logger, pymodbus_internal, so Python's handler of last resort prints the line to stderr.
# product: Adds a NullHandler to the logger `pymodbus`: a lost link is an event of the recording; see [Talk to a controller](clients.md)
# output:
#   Connection to (127.0.0.1, PORT) failed: [Errno 111] Connection refused
#   connected: False
#   pymodbus []
#   pymodbus.logging []
#   pymodbus_internal ['NullHandler']
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1
observe python - <<'PY'
import logging
import os
import socket

from pymodbus.client import ModbusTcpClient

os.dup2(1, 2)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
print("connected:", ModbusTcpClient("127.0.0.1", port=port, retries=0, timeout=1).connect(), flush=True)
loggers = logging.root.manager.loggerDict
for name in sorted(name for name in loggers if name.startswith("pymodbus")):
    print(name, [type(each).__name__ for each in getattr(loggers[name], "handlers", [])])
PY
sed -i 's/(127.0.0.1, [0-9]*)/(127.0.0.1, PORT)/' seen
