#!/usr/bin/env bash
# what: pymodbus reads the coils of a shared register from bit `address modulo 16` on, against its own documentation
# date: 2026-11-29
# meets: anyone who reads inputs as coils from a simulated device
# expected: use_bit_addressing=False, so an address names a register, and its coils begin at bit 0
# behavior:
#   The comment in SimDevice says: with use_bit_addressing=False the register is addressed, single bits cannot be.
#   Register 16 and register 21 both are 0001h. Reading 4 coils at 16 gives the first bit as 1, at 21 bits 5 to 8, so 0.
# product: In its Modbus server each BOOL is a coil with one address; see [Modbus](hmi.md#modbus)
# output:
#   16 0001h [1, 0, 0, 0]
#   17 0001h [0, 0, 0, 0]
#   21 0001h [0, 0, 0, 0]
#   29 0001h [0, 0, 0, 1]
#   30 0001h [0, 0, 1, 0]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1
observe python - <<'PY'
import asyncio

from pymodbus.client import AsyncModbusTcpClient
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice


async def main():
    block = SimData(16, values=[0x0001] * 16, datatype=DataType.REGISTERS)
    server = ModbusTcpServer(SimDevice(1, [block], use_bit_addressing=False), address=("127.0.0.1", 0))
    await server.listen()
    port = server.transport.sockets[0].getsockname()[1]
    client = AsyncModbusTcpClient("127.0.0.1", port=port, timeout=2, retries=0)
    await client.connect()
    for address in (16, 17, 21, 29, 30):
        found = await client.read_coils(address, count=4, device_id=1)
        register = await client.read_holding_registers(address, device_id=1)
        print(address, f"{register.registers[0]:04x}h", [int(bit) for bit in found.bits[:4]])
    client.close()
    await server.shutdown()


asyncio.run(main())
PY
