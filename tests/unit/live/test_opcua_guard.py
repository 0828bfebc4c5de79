"""What a connection of the OPC UA server may keep: one session, and nothing after its end."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any

import pytest
from scanrack.runtime.live.opcua_guard import UaGuard

pytestmark = pytest.mark.extra("opcua")


def creating() -> Any:
    """Return the kind of a request for a session."""
    from asyncua import ua

    return ua.NodeId(ua.ObjectIds.CreateSessionRequest_Encoding_DefaultBinary)


def body(server_uri: str | None = None) -> Any:
    """Return the rest of a request for a session."""
    from asyncua import ua
    from asyncua.common.utils import Buffer
    from asyncua.ua.ua_binary import struct_to_binary

    return Buffer(struct_to_binary(ua.CreateSessionParameters(ServerUri=server_uri)))


def connection_of(server: Any) -> Any:
    """Return what stands for a connection's processor: it makes sessions as asyncua does."""
    processor = SimpleNamespace(
        session=None, _session_watchdog_task=None, _connection=SimpleNamespace(security_policy=None)
    )

    async def process(_kind: Any, _body: Any) -> None:
        processor.session = server.iserver.create_session("peer", external=True)
        processor._session_watchdog_task = asyncio.create_task(asyncio.sleep(60))

    processor._process_message = process
    return processor


def test_a_connection_has_one_session_at_a_time_and_the_server_keeps_none() -> None:
    from asyncua import Server
    from asyncua.common.utils import ServiceError
    from asyncua.ua import StatusCodes

    async def work() -> None:
        server: Any = Server()
        guard = UaGuard(None)
        await guard.set_up(server)
        processor = connection_of(server)
        create = guard._checked(processor, processor._process_message)
        await create(creating(), body())
        first, watchdog = processor.session, processor._session_watchdog_task
        with pytest.raises(ServiceError) as caught:
            await create(creating(), body())
        assert caught.value.code == StatusCodes.BadTooManySessions
        assert processor.session is first
        assert server.iserver._external_sessions == {}
        await first.close_session(True)
        with pytest.raises(ServiceError) as caught:
            await create(creating(), body("urn:another:server"))
        assert caught.value.code == StatusCodes.BadServerUriInvalid
        await create(creating(), body(guard.uri))
        assert processor.session is not first
        await asyncio.sleep(0)
        assert watchdog.cancelled()
        processor._session_watchdog_task.cancel()

    asyncio.run(work())
