#!/usr/bin/env bash
# what: modbus_tk's server reads before it writes in function 23, so its answer is older than the request
# date: 2026-11-30
# meets: masters that send new words and read the result in one request, tested against a simulated device
# expected: the written values, since "the write operation is performed before the read" (Modbus specification, 6.17)
# behavior:
#   A request reads registers 0 to 3 and writes 170 and 187 into registers 1 and 2. modbus_tk answers with the values
#   from before the write; pymodbus and pyModbusTCP answer with the written ones. A second read shows them in all three.
# product: Its tag server writes first; AMCI's drives read first, and so do the simulated ones: [drives](drives.md#modbus)
# output:
#   modbus_tk: the request reads 1 2 3 4, then 1 170 187 4
#   pyModbusTCP: the request reads 1 170 187 4, then 1 170 187 4
#   pymodbus: the request reads 1 170 187 4, then 1 170 187 4
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install modbus_tk==1.1.5 pyserial==3.5 pyModbusTCP==0.3.1 pymodbus==3.16.1
observe python - <<'PY'
import asyncio
import logging
import os
import socket
import threading
import time

from modbus_tk.defines import HOLDING_REGISTERS
from modbus_tk.modbus_tcp import TcpServer
from pyModbusTCP.client import ModbusClient
from pyModbusTCP.server import DataBank, ModbusServer
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

logging.disable(logging.CRITICAL)
VALUES = [1, 2, 3, 4]


def modbus_tk(port):
    server = TcpServer(port=port, address="127.0.0.1")
    server.start()
    device = server.add_slave(1)
    device.add_block("registers", HOLDING_REGISTERS, 0, len(VALUES))
    device.set_values("registers", 0, VALUES)


def py_modbus_tcp(port):
    bank = DataBank(h_regs_size=len(VALUES))
    bank.set_holding_registers(0, VALUES)
    ModbusServer("127.0.0.1", port, no_block=True, data_bank=bank).start()


def pymodbus(port):
    async def serve():
        device = SimDevice(1, [SimData(0, values=VALUES, datatype=DataType.REGISTERS)])
        await ModbusTcpServer(device, address=("127.0.0.1", port)).serve_forever()

    threading.Thread(target=asyncio.run, args=(serve(),), daemon=True).start()


for name, start in (("modbus_tk", modbus_tk), ("pyModbusTCP", py_modbus_tcp), ("pymodbus", pymodbus)):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    start(port)
    client = ModbusClient("127.0.0.1", port, unit_id=1, timeout=5)
    for _ in range(100):
        if client.open():
            break
        time.sleep(0.1)
    answer = client.write_read_multiple_registers(1, [170, 187], 0, 4)
    print(f"{name}: the request reads", *answer, end=", then ")
    print(*client.read_holding_registers(0, 4), flush=True)
    client.close()
os._exit(0)  # the servers have threads that do not end
PY
