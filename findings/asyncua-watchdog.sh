#!/usr/bin/env bash
# what: asyncua's client drops a connection after one second without an answer, whatever its timeout says
# date: 2026-11-29
# meets: anyone who polls a PLC that is busy for a moment
# expected: with timeout=10 a pause of three seconds goes unnoticed
# behavior:
#   The server's process pauses its loop for three seconds. The client's watchdog reads the server's state every
#   watchdog_intervall, 1 s, with that same interval as limit, or half of the session's timeout if that is less; then it calls
#   the connection lost. A timeout of 10 s and a session of one hour do not count.
# product: Pass `watchdog_intervall` to your asyncua client if the rack can pause, for example in a debugger; see [OPC UA](hmi.md#opc-ua)
# output:
#   timeout=10: ['TimeoutError']
#   timeout=10, watchdog_intervall=10: []
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install asyncua==2.1.0
cat >server.py <<'PY'
import asyncio
import sys
import time

from asyncua import Server


async def main():
    server = Server()
    await server.init()
    server.set_endpoint(sys.argv[1])
    async with server:
        print("ready", flush=True)
        await asyncio.to_thread(sys.stdin.readline)
        time.sleep(3)  # the loop stands, as that of a busy controller
        await asyncio.to_thread(sys.stdin.readline)


asyncio.run(main())
PY
observe python - <<'PY'
import asyncio
import logging
import socket
import subprocess
import sys

from asyncua import Client

logging.disable(logging.CRITICAL)


async def lost(watchdog):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        url = f"opc.tcp://127.0.0.1:{free.getsockname()[1]}"
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
    server = subprocess.Popen([sys.executable, "server.py", url], text=True, **pipes)
    try:
        await asyncio.to_thread(server.stdout.readline)
        seen = []

        async def callback(error):
            seen.append(type(error).__name__)

        client = Client(url, timeout=10, **watchdog)
        client.connection_lost_callback = callback
        async with client:
            server.stdin.write("pause\n")
            server.stdin.flush()
            await asyncio.sleep(6)
        return seen[:1]
    finally:
        server.kill()
        server.wait()


async def main():
    print("timeout=10:", await lost({}))
    print("timeout=10, watchdog_intervall=10:", await lost({"watchdog_intervall": 10}))


asyncio.run(main())
PY
