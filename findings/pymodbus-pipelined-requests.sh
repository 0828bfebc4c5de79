#!/usr/bin/env bash
# what: a pymodbus server answers the first of several requests that arrive in one read and drops the others
# date: 2026-11-29
# meets: a Modbus TCP client with several open transactions, which the transaction identifier is for
# expected: an answer to each, at least with Modbus TCP
# behavior:
#   Three requests in one segment, with transaction identifiers 1, 2 and 3, get one answer within a second, to the first.
#   A request after that is answered. With the RTU framer over TCP it is the same.
# product: Its Modbus server splits the frames itself and answers each; see [Modbus](hmi.md#modbus)
# output:
#   socket three at once: 00 01 00 00 00 05 01 03 02 00 0a
#   socket the third alone: 00 03 00 00 00 05 01 03 02 00 0c
#   rtu three at once: 01 03 02 00 0a 38 43
#   rtu the third alone: 01 03 02 00 0c b8 41
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pymodbus==3.16.1
observe python - <<'PY'
import asyncio

from pymodbus import FramerType
from pymodbus.framer import FramerRTU, FramerSocket
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.register_message import ReadHoldingRegistersRequest
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice


async def answers(reader):
    got = b""
    try:
        while True:
            got += await asyncio.wait_for(reader.read(100), 1)
    except TimeoutError:
        return got.hex(" ") or "nothing"


async def main():
    for framer, frames in ((FramerType.SOCKET, FramerSocket), (FramerType.RTU, FramerRTU)):
        device = SimDevice(1, [SimData(0, values=[10, 11, 12], datatype=DataType.REGISTERS)])
        server = ModbusTcpServer(device, framer=framer, address=("127.0.0.1", 0))
        await server.listen()
        reader, writer = await asyncio.open_connection(*server.transport.sockets[0].getsockname())
        build = frames(DecodePDU(True)).buildFrame
        sent = [
            build(ReadHoldingRegistersRequest(address=each, count=1, dev_id=1, transaction_id=each + 1))
            for each in (0, 1, 2)
        ]
        writer.write(b"".join(sent))
        print(framer.value, "three at once:", await answers(reader))
        writer.write(sent[2])
        print(framer.value, "the third alone:", await answers(reader))
        writer.close()
        await server.shutdown()


asyncio.run(main())
PY
