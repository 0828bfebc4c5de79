#!/usr/bin/env bash
# what: asyncua's server answers Republish with Good and an empty message for any sequence number
# date: 2026-11-29
# meets: an HMI that lost its connection and fetches what it missed
# expected: the message, or BadMessageNotAvailable as Part 4, 5.13.6 says
# behavior:
#   Republish of number 1 twice, and of 99, which was never sent: each is answered with ServiceResult Good, sequence number 0
#   and no notification. A client takes that as received and goes on without the values of the outage.
# product: Its OPC UA server, built on asyncua, returns the message or BadMessageNotAvailable itself; see [OPC UA](hmi.md#opc-ua)
# output:
#   changed to 1.0
#   1 Good 0 []
#   1 Good 0 []
#   99 Good 0 []
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
observe python - <<'PY'
import asyncio
import logging
import socket

from asyncua import Client, Server, ua
from asyncua.ua.ua_binary import struct_from_binary

logging.disable(logging.CRITICAL)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}"


class Changes:
    def datachange_notification(self, node, value, data):
        print("changed to", value)


async def main():
    server = Server()
    await server.init()
    server.set_endpoint(url)
    level = await server.nodes.objects.add_variable(2, "level", 1.0)
    async with server, Client(url) as client:
        subscription = await client.create_subscription(50, Changes())
        await subscription.subscribe_data_change(client.get_node(level.nodeid))
        await asyncio.sleep(1)
        for number in (1, 1, 99):
            request = ua.RepublishRequest()
            request.Parameters.SubscriptionId = subscription.subscription_id
            request.Parameters.RetransmitSequenceNumber = number
            answer = struct_from_binary(ua.RepublishResponse, await client.uaclient.protocol.send_request(request))
            message = answer.NotificationMessage
            print(number, answer.ResponseHeader.ServiceResult.name, message.SequenceNumber, message.NotificationData)


asyncio.run(main())
PY
