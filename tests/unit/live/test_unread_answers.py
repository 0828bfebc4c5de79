"""A client that does not take what is sent is cut off: at a number of bytes, and some time after the end."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable

import pytest
from scanrack.runtime.live import opcua_server
from scanrack.runtime.live.opcua_server import _impatient

BLOCK = bytes(1 << 20)
BLOCKS_MOST = 64


class Answering(asyncio.Protocol):
    """Notes what happens to its connection."""

    def __init__(self) -> None:
        self.ended = asyncio.Event()
        self.unsent = [0]
        self.transport: asyncio.Transport

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport

    def connection_lost(self, error: Exception | None) -> None:
        self.ended.set()

    def write(self) -> None:
        self.transport.write(BLOCK)
        self.unsent.append(self.transport.get_write_buffer_size())


def served(work: Callable[[Answering], None]) -> Answering:
    """Return a protocol after work for a client that reads nothing, and the end of its connection."""

    async def session() -> Answering:
        made = Answering()
        made.connection_made = _impatient(made.connection_made)  # type: ignore[assignment, method-assign]
        server = await asyncio.get_running_loop().create_server(lambda: made, "127.0.0.1", 0)
        async with server:
            with socket.create_connection(server.sockets[0].getsockname()) as client:
                client.settimeout(0)
                while not hasattr(made, "transport"):
                    await asyncio.sleep(0)
                work(made)
                await asyncio.wait_for(made.ended.wait(), 30)
        return made

    return asyncio.run(session())


def test_unsent_bytes_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opcua_server, "UNSENT_MOST", 4 * len(BLOCK))

    def work(made: Answering) -> None:
        for _ in range(BLOCKS_MOST):
            made.write()

    made = served(work)
    assert 4 * len(BLOCK) - len(BLOCK) < max(made.unsent) <= 4 * len(BLOCK)


def test_a_connection_that_is_closed_waits_for_its_client_for_a_while_only(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(opcua_server, "CLOSING_S", 0.01)

    def work(made: Answering) -> None:
        while not made.unsent[-1]:
            made.write()
        made.transport.close()

    assert served(work).unsent[-1] <= len(BLOCK)
