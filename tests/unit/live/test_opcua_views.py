"""Browsing while a program is edited, and values that enumerations of OPC UA do not have."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from scanrack.runtime.live.opcua_services import accept_unknown_values
from scanrack.runtime.live.opcua_views import Browsing, Views

pytestmark = pytest.mark.extra("opcua")


@pytest.mark.slow
def test_a_continuation_point_ends_with_the_edition_of_the_program() -> None:
    from asyncua import Server, ua

    async def work() -> None:
        server: Any = Server()
        await server.init()
        views = Views(server.iserver.aspace)
        browsing = Browsing(views, server.iserver.isession.translate_browsepaths_to_nodeids)
        start = ua.BrowseDescription(ua.NodeId(ua.ObjectIds.RootFolder), ResultMask=ua.BrowseResultMask.All)
        asked = ua.BrowseParameters(RequestedMaxReferencesPerNode=1, NodesToBrowse=[start] * 2)
        first, second = await browsing.browse(asked)
        assert [each.BrowseName.Name for each in first.References] == ["FolderType"]

        async def following(point: bytes) -> Any:
            return (await browsing.browse_next(ua.BrowseNextParameters(False, [point])))[0]

        more = await following(first.ContinuationPoint)
        assert [each.BrowseName.Name for each in more.References] == ["Objects"]
        views.edition += 1
        assert (await following(second.ContinuationPoint)).StatusCode.name == "BadContinuationPointInvalid"
        again, _ = await browsing.browse(asked)
        assert again.StatusCode.is_good()

    asyncio.run(work())


def test_unknown_values_are_invalid_ones() -> None:
    from asyncua import ua

    accept_unknown_values()
    assert [ua.TimestampsToReturn(each) for each in (-1, 5, 9)] == [ua.TimestampsToReturn.Invalid] * 3
    assert ua.BrowseDirection(99) is ua.BrowseDirection.Invalid
    assert ua.TimestampsToReturn(2) is ua.TimestampsToReturn.Both
