"""Exchanges of the OPC UA server come one after the other, whoever is cut off meanwhile."""

import asyncio
import socket
import threading

import pytest
from scanrack.runtime.live.opcua_server import OpcUaServer
from scanrack.runtime.live.tag_server import ExchangeResults, ScanProcess

pytestmark = pytest.mark.extra("opcua")


class SlowProcess(ScanProcess):
    """A scan process that answers when it is told to, and notes how many exchanges run at once."""

    def __init__(self):
        self.version = 1
        self.begun, self.ends = threading.Semaphore(0), threading.Semaphore(0)
        self.running = self.most = 0

    def __call__(self, packets):
        self.running += 1
        self.most = max(self.most, self.running)
        self.begun.release()
        self.ends.acquire(timeout=5)  # else a failure would never end
        self.running -= 1
        return ExchangeResults(0, 1, [[b"result"] for _ in packets])


def test_an_exchange_of_a_client_that_is_cut_off_ends_before_the_next_one():
    process = SlowProcess()

    async def session():
        server = OpcUaServer(listening, process)
        first = asyncio.create_task(server._carry_out([], "first", 1))
        await asyncio.to_thread(process.begun.acquire)
        first.cancel()
        with pytest.raises(asyncio.CancelledError):
            await first
        second = asyncio.create_task(server._carry_out([], "second", 1))
        await asyncio.sleep(0.05)
        assert process.most == 1
        process.ends.release(2)
        assert await second == [b"result"]
        assert process.most == 1

    with socket.socket() as listening:
        asyncio.run(session())
