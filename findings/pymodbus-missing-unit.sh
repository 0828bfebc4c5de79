#!/usr/bin/env bash
# what: pymodbus answers for a unit that it does not have, with exception 4, even with ignore_missing_devices=True
# date: 2026-11-29
# meets: anyone who tests how a master handles a missing unit, on a line with several
# expected: exception 0Bh, and no answer with ignore_missing_devices=True, as the option's documentation says
# behavior:
#   A server with SimDevice(1) gets a request for unit 7. The lookup falls back to unit 0, which is missing, too; the
#   KeyError becomes exception 4, and the option is never read. Its documentation: True to not send errors on a missing device.
# product: Its Modbus server answers any unit number; see [Modbus](hmi.md#modbus)
# output:
#   ignore_missing_devices=False, unit 1: [1, 2]
#   ignore_missing_devices=False, unit 7: exception 4
#   ignore_missing_devices=True, unit 1: [1, 2]
#   ignore_missing_devices=True, unit 7: exception 4
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1
observe python - <<'PY'
import asyncio
import logging

from pymodbus.client import AsyncModbusTcpClient
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

logging.disable(logging.CRITICAL)


async def main():
    for ignore in (False, True):
        device = SimDevice(1, [SimData(0, values=[1, 2], datatype=DataType.REGISTERS)])
        server = ModbusTcpServer(device, address=("127.0.0.1", 0), ignore_missing_devices=ignore)
        await server.listen()
        port = server.transport.sockets[0].getsockname()[1]
        client = AsyncModbusTcpClient("127.0.0.1", port=port, timeout=2, retries=0)
        await client.connect()
        for unit in (1, 7):
            answer = await client.read_holding_registers(0, count=2, device_id=unit)
            print(f"ignore_missing_devices={ignore}, unit {unit}:", answer.registers or f"exception {answer.exception_code}")
        client.close()
        await server.shutdown()


asyncio.run(main())
PY
