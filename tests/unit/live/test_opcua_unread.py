"""A client of OPC UA that does not take what is sent is cut off at our limit: of a stub transport."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from scanrack.runtime.live import opcua_server
from scanrack.runtime.live.opcua_server import CHUNK_MOST, _bounded, _impatient

LIMIT = 100


class StubTransport:
    """A transport whose client reads nothing: what is written stays in its buffer."""

    def __init__(self) -> None:
        self.unsent = 0
        self.aborted = self.closed = False

    def write(self, data: bytes) -> None:
        self.unsent += len(data)

    def get_write_buffer_size(self) -> int:
        return self.unsent

    def close(self) -> None:
        self.closed = True

    def abort(self) -> None:
        self.aborted = True


@pytest.fixture
def transport(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr(opcua_server, "UNSENT_MOST", LIMIT)
    monkeypatch.setattr(opcua_server, "CLOSING_S", 0)
    found: Any = StubTransport()
    _impatient(lambda _transport: None)(found)
    return found


def test_a_client_that_reads_nothing_is_cut_off_at_the_limit(transport: Any) -> None:
    transport.write(bytes(LIMIT))
    assert not transport.aborted
    transport.write(b"x")
    assert transport.aborted


@pytest.mark.parametrize("unsent", [0, 1])
def test_what_is_left_when_a_client_is_closed_waits_for_a_while_only(transport: Any, unsent: int) -> None:
    async def close() -> None:
        transport.write(bytes(unsent))
        transport.close()
        assert not transport.aborted
        await asyncio.sleep(0.01)

    asyncio.run(close())
    assert (transport.closed, transport.aborted) == (True, bool(unsent))


def test_a_part_of_a_message_that_is_longer_than_the_limit_ends_its_client() -> None:
    class Received:
        _buffer = b""
        transport: Any = StubTransport()

    made = Received()

    def receive(data: bytes) -> None:
        made._buffer += data

    received = _bounded(made, receive)
    received(bytes(CHUNK_MOST))
    assert not made.transport.aborted
    received(b"x")
    assert made.transport.aborted
    assert made._buffer == b""
