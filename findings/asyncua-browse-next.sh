#!/usr/bin/env bash
# what: asyncua's server ignores the maximum of references per node and answers BrowseNext with BadUserAccessDenied
# date: 2026-11-29
# meets: anyone who tests the browser of an HMI against a folder of many tags
# expected: two references and a continuation point, then the others
# behavior:
#   A folder with more than five references is browsed with RequestedMaxReferencesPerNode 2: all come at once, without a
#   continuation point. BrowseNext is not implemented, and the status says that the user has no permission.
# product: Its OPC UA server, built on asyncua, adds continuation points and BrowseNext; see [OPC UA](hmi.md#opc-ua)
# output:
#   references: 5 continuation point: None
#   BrowseNext: BadUserAccessDenied
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
observe python - <<'PY'
import asyncio
import logging
import socket

from asyncua import Client, Server, ua

logging.disable(logging.CRITICAL)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}"


async def main():
    server = Server()
    await server.init()
    server.set_endpoint(url)
    folder = await server.nodes.objects.add_folder(2, "tags")
    for number in range(5):
        await folder.add_variable(2, f"tag{number}", number)
    async with server, Client(url) as client:
        wanted = ua.BrowseDescription()
        wanted.NodeId = folder.nodeid
        wanted.BrowseDirection = ua.BrowseDirection.Forward
        wanted.IncludeSubtypes = True
        wanted.ResultMask = ua.BrowseResultMask.All
        wanted.ReferenceTypeId = ua.NodeId(ua.ObjectIds.HierarchicalReferences)
        browse = ua.BrowseParameters()
        browse.RequestedMaxReferencesPerNode = 2
        browse.NodesToBrowse = [wanted]
        [result] = await client.uaclient.browse(browse)
        print("references:", len(result.References), "continuation point:", result.ContinuationPoint)
        following = ua.BrowseNextParameters()
        following.ReleaseContinuationPoints = False
        following.ContinuationPoints = [b"1"]
        try:
            print(await client.uaclient.browse_next(following))
        except ua.UaStatusCodeError as error:
            print("BrowseNext:", type(error).__name__)


asyncio.run(main())
PY
