#!/usr/bin/env bash
# what: pycomm3 accepts the late answer to one read as the answer to the next, so each later tag has the value of the one before it
# date: 2026-11-30
# meets: programs that catch a CommError of a slow controller and continue polling
# expected: every tag its own value, or an error, since a request has a sequence count that its answer repeats
# behavior:
#   The answer to the first read comes after the timeout of 0.5 s. pycomm3 raises CommError, keeps the connection open and
#   never compares the sequence count. The late answer waits in the socket, and each later read returns the value of the
#   tag before it, without an error. pylogix opens a new connection and reads the right values. ciplink, a fork of
#   pycomm3, raises CommError for each later read. Other answers take 0.1 s, as through a gateway.
# product: After a CommError of pycomm3, close the driver and reopen it: [what surprises](hmi-clients.md#surprising-client-behavior)
# output:
#   pylogix: A Connection failure
#   pylogix: B 2, no error
#   pylogix: C 3, no error
#   pylogix: D 4, no error
#   pycomm3: A CommError
#   pycomm3: B 1, no error
#   pycomm3: C 2, no error
#   pycomm3: D 3, no error
#   ciplink: A CommError
#   ciplink: B CommError
#   ciplink: C CommError
#   ciplink: D CommError
folder=$(mktemp -d)
. "$(dirname "$0")/lib"
install pycomm3==1.2.16 pylogix==1.1.6 ciplink==0.3.4 cm-ethernetip==0.1.0
observe python - <<'PY'
import asyncio
import logging
import socket
import threading
import time

import ciplink
import pycomm3
from ethernetip.cip.identity_info import IdentityInfo
from ethernetip.logix import data_types
from ethernetip.logix.logix_dispatcher import LogixDispatcher
from ethernetip.logix.tag_database import TagDatabase
from ethernetip.protocol.eip_adapter import EipAdapter
from pylogix import PLC

logging.disable(logging.CRITICAL)
TAGS = "ABCD"
TIMEOUT_S, DELAY_S, LATENCY_S = 0.5, 1.5, 0.1
slow = threading.Event()


def pass_on(source, target, answers):
    """Pass bytes on; wait before each answer, and for long before one that shall be slow."""
    try:
        while data := source.recv(65536):
            if answers:
                time.sleep(DELAY_S if slow.is_set() else LATENCY_S)
                slow.clear()
            target.sendall(data)
        target.shutdown(socket.SHUT_WR)
    except OSError:
        pass


def relay(listener, server_port):
    while True:
        client, _ = listener.accept()
        server = socket.create_connection(("127.0.0.1", server_port))
        threading.Thread(target=pass_on, args=(client, server, False), daemon=True).start()
        threading.Thread(target=pass_on, args=(server, client, True), daemon=True).start()


def read_all(name, read):
    slow.set()
    for tag in TAGS:
        print(f"{name}: {tag}", read(tag))
        time.sleep(DELAY_S)


def with_pylogix(port):
    with PLC("127.0.0.1", port=port, timeout=TIMEOUT_S) as plc:

        def read(tag):
            answer = plc.Read(tag)
            return f"{answer.Value}, no error" if answer.Status == "Success" else answer.Status

        for number, tag in enumerate(TAGS, 1):
            assert plc.Write(tag, number).Status == "Success"
        read_all("pylogix", read)


def with_driver(package, port):
    driver = package.LogixDriver(f"127.0.0.1:{port}", init_program_tags=False)
    driver.socket_timeout = TIMEOUT_S

    def read(tag):
        try:
            answer = driver.read(tag)
        except package.CommError:
            return "CommError"
        return answer.error or f"{answer.value}, no error"

    with driver:
        read_all(package.__name__, read)


def read_with_all(server_port):
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=relay, args=(listener, server_port), daemon=True).start()
    port = listener.getsockname()[1]
    with_pylogix(port)
    with_driver(pycomm3, port)
    with_driver(ciplink, port)


async def main():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    tags, identity = TagDatabase(), IdentityInfo(product_name="Sample")
    for tag in TAGS:
        tags.add_tag(tag, data_types.DINT)
    await EipAdapter(LogixDispatcher(tags, identity), identity).listen("127.0.0.1", port)
    await asyncio.to_thread(read_with_all, port)


asyncio.run(main())
PY
