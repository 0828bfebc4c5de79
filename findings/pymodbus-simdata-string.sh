#!/usr/bin/env bash
# what: pymodbus applies `count` of a STRING twice: count=3 makes nine copies of the text
# date: 2026-11-29
# meets: anyone who simulates a device with text in registers
# expected: two copies, as count=2 of INT32 makes two numbers
# behavior:
#   SimData(0, values="AB", count=3, datatype=STRING) takes nine registers, count=2 four; INT32 with count=3 takes six
#   registers, three numbers. So a text with count covers registers that are meant for what comes after it.
# product: Its Modbus server maps tags to registers without SimData; see [Modbus](hmi.md#modbus)
# output:
#   STRING 'AB' count=1: 1 registers
#   STRING 'AB' count=2: 4 registers
#   STRING 'AB' count=3: 9 registers
#   INT32 3 count=1: 2 registers
#   INT32 3 count=2: 4 registers
#   INT32 3 count=3: 6 registers
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1
observe python - <<'PY'
import asyncio

from pymodbus.client import AsyncModbusTcpClient
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice


async def main():
    for datatype, value in ((DataType.STRING, "AB"), (DataType.INT32, 3)):
        for count in (1, 2, 3):
            device = SimDevice(1, [SimData(0, values=value, count=count, datatype=datatype)])
            server = ModbusTcpServer(device, address=("127.0.0.1", 0))
            await server.listen()
            port = server.transport.sockets[0].getsockname()[1]
            client = AsyncModbusTcpClient("127.0.0.1", port=port, timeout=2, retries=0)
            await client.connect()
            registers = 0
            while not (await client.read_holding_registers(0, count=registers + 1, device_id=1)).isError():
                registers += 1
            print(f"{datatype.name} {value!r} count={count}: {registers} registers")
            client.close()
            await server.shutdown()


asyncio.run(main())
PY
