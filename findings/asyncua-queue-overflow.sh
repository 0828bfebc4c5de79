#!/usr/bin/env bash
# what: asyncua's server drops the oldest values of a full queue, whatever DiscardOldest says, and never sets the overflow bit
# date: 2026-11-30
# meets: a historian that trusts the bit to know whether it has every value
# expected: the last three values or, with DiscardOldest False, the first two and the last, and Overflow in a status of both
# behavior:
#   Ten values come within one publishing interval, and the queue holds three. Both items get the last three with the
#   status Good, so the seven that are lost do not show. OPC UA part 4 asks for both.
# product: Its OPC UA server sends one value per item in each publishing interval, so request a queue that outlasts a pause: [OPC UA](hmi.md#opc-ua)
# output:
#   DiscardOldest True: 18 Good 0000h, 19 Good 0000h, 20 Good 0000h
#   DiscardOldest False: 18 Good 0000h, 19 Good 0000h, 20 Good 0000h
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
observe python - <<'PY'
import asyncio
import logging
import socket

from asyncua import Client, Server, ua

logging.disable(logging.CRITICAL)
FIRST, COUNT, INTERVAL_MS = 11, 10, 500


class Received:
    def __init__(self):
        self.values = []

    def datachange_notification(self, node, value, data):
        status = data.monitored_item.Value.StatusCode
        self.values.append(f"{value} {status.name} {status.value & 0xFFFF:04x}h")


async def main():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}"
    server = Server()
    await server.init()
    server.set_endpoint(url)
    server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
    node = await server.nodes.objects.add_variable(2, "level", 0, ua.VariantType.Int32)
    async with server, Client(url) as client:
        for discard in (True, False):
            received = Received()
            subscription = await client.create_subscription(INTERVAL_MS, received)
            item = ua.MonitoredItemCreateRequest()
            item.ItemToMonitor.NodeId = node.nodeid
            item.ItemToMonitor.AttributeId = ua.AttributeIds.Value
            item.MonitoringMode = ua.MonitoringMode.Reporting
            item.RequestedParameters.ClientHandle = 201
            item.RequestedParameters.SamplingInterval = 0
            item.RequestedParameters.QueueSize = 3
            item.RequestedParameters.DiscardOldest = discard
            await subscription.create_monitored_items([item])
            await asyncio.sleep(2 * INTERVAL_MS / 1000)
            received.values.clear()
            for value in range(FIRST, FIRST + COUNT):
                await node.write_value(ua.Variant(value, ua.VariantType.Int32))
            await asyncio.sleep(2 * INTERVAL_MS / 1000)
            print(f"DiscardOldest {discard}:", ", ".join(received.values))
            await subscription.delete()


asyncio.run(main())
PY
