#!/usr/bin/env bash
# what: asyncua's server ignores an index range: a write of one element replaces the whole array, and the status is Good
# date: 2026-11-30
# meets: an HMI that reads or changes one element of an array, tested against that server
# expected: two elements, one changed element, BadIndexRangeNoData; or a status that refuses index ranges
# behavior:
#   The server never reads the field IndexRange. A read of 1:2 returns all four elements, and so does one of 7:9, which
#   the array does not have. A write of 99 to element 1 leaves an array of one element. A write of an array to a scalar
#   is accepted, too, and makes it an array.
# product: Its OPC UA server, built on asyncua, reads and writes index ranges itself: [OPC UA](hmi.md#opc-ua)
# output:
#   read 1:2 of [10, 20, 30, 40]: Good [10, 20, 30, 40]
#   read 7:9 of [10, 20, 30, 40]: Good [10, 20, 30, 40]
#   write [99] to element 1: Good, the array is [99]
#   write [1, 2] to a scalar: Good, it is [1, 2]
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
observe python - <<'PY'
import asyncio
import logging
import socket

from asyncua import Client, Server, ua

logging.disable(logging.CRITICAL)


def words(values):
    return ua.DataValue(ua.Variant(values, ua.VariantType.Int32))


async def write(client, node, values, index_range=None):
    item = ua.WriteValue(NodeId=node.nodeid, AttributeId=ua.AttributeIds.Value, Value=words(values))
    item.IndexRange = index_range
    (status,) = await client.uaclient.write(ua.WriteParameters(NodesToWrite=[item]))
    return status.name


async def main():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}"
    server = Server()
    await server.init()
    server.set_endpoint(url)
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    array = await server.nodes.objects.add_variable(2, "array", [10, 20, 30, 40], ua.VariantType.Int32)
    scalar = await server.nodes.objects.add_variable(2, "scalar", 5, ua.VariantType.Int32)
    for node in (array, scalar):
        await node.set_writable()
    async with server, Client(url) as client:
        before = await array.read_value()
        for index_range in ("1:2", "7:9"):
            item = ua.ReadValueId(NodeId=array.nodeid, AttributeId=ua.AttributeIds.Value, IndexRange=index_range)
            (value,) = await client.uaclient.read(ua.ReadParameters(NodesToRead=[item]))
            print(f"read {index_range} of {before}:", value.StatusCode.name, value.Value.Value)
        status = await write(client, array, [99], "1")
        print(f"write [99] to element 1: {status}, the array is", await array.read_value())
        status = await write(client, scalar, [1, 2])
        print(f"write [1, 2] to a scalar: {status}, it is", await scalar.read_value())


asyncio.run(main())
PY
