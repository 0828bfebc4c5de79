#!/usr/bin/env bash
# what: pymodbus's server answers a function that it does not have, or a wrong count, with function 80h in place of the request's
# date: 2026-11-30
# meets: masters that probe a device for its functions or its largest block
# expected: C1 01 for function 41h and 83 03 for 126 registers, which is illegal (1 to 125)
# behavior:
#   Both are answered with 80 01, an exception of function 0 with the code of an unknown function. A master compares the
#   function code of an answer with that of its request: modbus_tk calls the answer invalid, so the exception code is lost.
#   An address that the server does not have gets 83 02, as it should.
# product: Its Modbus server answers with the function of the request, 01 and 03: [Modbus](hmi.md#modbus)
# output:
#   registers 0 and 1: 03 04 00 01 00 02
#   register 100: 83 02
#   126 registers: 80 01
#   function 41h: 80 01
#   126 registers, modbus_tk: ModbusInvalidResponseError
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1 modbus_tk==1.1.5 pyserial==3.5
observe python - <<'PY'
import asyncio
import logging
import struct

from modbus_tk.defines import READ_HOLDING_REGISTERS
from modbus_tk.exceptions import ModbusError, ModbusInvalidResponseError
from modbus_tk.modbus_tcp import TcpMaster
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

logging.disable(logging.CRITICAL)
UNIT = 1
REQUESTS = {
    "registers 0 and 1": "03 0000 0002",
    "register 100": "03 0064 0001",
    "126 registers": "03 0000 007e",
    "function 41h": "41",
}


async def ask(port, request):
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(struct.pack(">HHHB", 7, 0, len(request) + 1, UNIT) + request)
    answer = await asyncio.wait_for(reader.read(300), 5)
    writer.close()
    return answer[7:].hex(" ")


def with_modbus_tk(port):
    master = TcpMaster("127.0.0.1", port, timeout_in_sec=5)
    try:
        return master.execute(UNIT, READ_HOLDING_REGISTERS, 0, 126)
    except (ModbusError, ModbusInvalidResponseError) as error:
        return type(error).__name__
    finally:
        master.close()


async def main():
    device = SimDevice(UNIT, [SimData(0, values=[1, 2], datatype=DataType.REGISTERS)])
    server = ModbusTcpServer(device, address=("127.0.0.1", 0))
    await server.listen()
    port = server.transport.sockets[0].getsockname()[1]
    for name, request in REQUESTS.items():
        print(f"{name}:", await ask(port, bytes.fromhex(request)))
    print("126 registers, modbus_tk:", await asyncio.to_thread(with_modbus_tk, port))
    await server.shutdown()


asyncio.run(main())
PY
