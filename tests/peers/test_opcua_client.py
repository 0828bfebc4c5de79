"""Tags over OPC UA, with asyncua's client: the server in its own process, scans where a request waits."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterator
from datetime import datetime
from typing import Any

import pytest
from ua_bench import TIMEOUT_S, Bench, channel, named, served, status_of

pytestmark = [pytest.mark.extra("opcua"), pytest.mark.peer("asyncua"), pytest.mark.slow]


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    with served(tmp_path_factory.mktemp("opcua")) as bench:
        yield bench


def test_elements_of_short_arrays_have_nodes(bench: Bench) -> None:
    """Grid has 12 elements, Flags 64; Dints has 3,000, which are beyond the limit."""

    async def work(client: Any) -> None:
        from asyncua import ua

        (grid, dints) = named(client, "Grid", "Dints")
        shown = [(await each.read_browse_name()).Name for each in await grid.get_children()]
        assert shown == [f"[{row},{column}]" for row in range(3) for column in range(4)]
        assert await dints.get_children() == []
        bench.tags["Grid[1,2]"], bench.tags["Flags[35]"] = 77, True
        paths = ("Grid[1,2]", "Flags[35]", "Flags[36]", "Texts[1]")
        assert await client.read_values(named(client, *paths)) == [77, True, False, ""]
        kinds = ua.VariantType
        await client.write_values(
            named(client, "Grid[2,0]", "Flags[36]"),
            [ua.Variant(-3, kinds.Int16), ua.Variant(True, kinds.Boolean)],
        )
        assert [bench.tags[each] for each in ("Grid[2,0]", "Flags[35]", "Flags[36]", "Flags[37]")] == [
            -3,
            True,
            True,
            False,
        ]
        await client.write_values(named(client, "Grid[2,0]"), [ua.Variant(9, kinds.Int16)])
        bench.tags["Grid[1,2]"], bench.tags["Flags[35]"], bench.tags["Flags[36]"] = 7, False, False

    bench.ask(work)


def test_an_open_server_has_the_uri_of_this_machine(bench: Bench) -> None:
    async def work(client: Any) -> None:
        uri = f"urn:{socket.gethostname()}:scanrack"
        (endpoint,) = await client.get_endpoints()
        assert endpoint.Server.ApplicationUri == uri
        assert (await client.get_namespace_array())[1] == uri
        assert await client.get_node("i=2254").read_value() == [uri]  # ServerArray

    bench.ask(work)


def test_tags_are_browsed_read_and_written(bench: Bench) -> None:
    async def work(client: Any) -> None:
        from asyncua import ua

        root = client.get_node("ns=2;s=Tags")
        names = [(await each.read_browse_name()).Name for each in await root.get_children()]
        listed = bench.service.desk.listing.tags if bench.service.desk is not None else ()
        assert names == [each.name for each in listed if not each.program] + ["Program:Main"]
        (many,) = named(client, "Many[2]")
        shown = [(await each.read_browse_name()).Name for each in await many.get_children()]
        assert shown == ["Id", "Flag", "Steps", "Name", "Bits", "Total"]
        paths = ("aBool", "aSint", "aLint", "aUlint", "aReal", "aLreal", "Text", "Grid", "One.Steps[1].Time")
        values = await client.read_values(named(client, *paths))
        grid = [[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12]]
        assert values == [False, -5, -5_000_000_000, 10_000_000_000, 1.5, 2.25, "hello", grid, 0]
        kinds = ua.VariantType
        written = {
            "aBool": (True, kinds.Boolean),
            "aSint": (-7, kinds.SByte),
            "aUdint": (2**32 - 1, kinds.UInt32),
            "aReal": (0.25, kinds.Float),
            "Text": ("from outside", kinds.String),
            "Hosts.Stop": (True, kinds.Boolean),
            "Program:Main.Step.Speed": (8.5, kinds.Float),
            "Many[3].Name": ("abc", kinds.String),
        }
        nodes = named(client, *written)
        made = [ua.DataValue(ua.Variant(*each)) for each in written.values()]
        bench.orders.given.clear()
        results = await client.uaclient.write_attributes([each.nodeid for each in nodes], made)
        assert all(each.is_good() for each in results), results
        assert await client.read_values(nodes) == [value for value, _ in written.values()]
        assert len(bench.orders.given) == len(written)
        assert len({scan for scan, _ in bench.orders.given}) == 1  # one request, one instant
        assert bench.tags["\\Main.Step.Speed"] == 8.5
        assert not bench.tags["Hosts.Go"]
        flags, rows = [at % 3 == 0 for at in range(64)], [[7, 8, 9, 10]] * 3
        await named(client, "Flags")[0].write_value(flags)
        await named(client, "Grid")[0].write_value(ua.Variant(rows, kinds.Int16, [3, 4]))
        assert await client.read_values(named(client, "Flags", "Grid")) == [flags, rows]
        assert [bench.tags["Flags[63]"], bench.tags["Grid[2,3]"]] == [True, 10]

    bench.ask(work)
    assert "127.0.0.1:" in bench.orders.given[0][1]


def test_what_is_not_allowed_is_refused(bench: Bench) -> None:
    async def work(client: Any) -> None:
        from asyncua import ua

        async def refusal(path: str, value: Any, kind: Any) -> str:
            with pytest.raises(ua.UaStatusCodeError) as caught:
                await named(client, path)[0].write_value(ua.Variant(value, kind))
            return type(caught.value).__name__

        kinds = ua.VariantType
        assert await refusal("Locked", 5, kinds.Int32) == "BadNotWritable"
        assert await refusal("Local:1:I.Fault", 5, kinds.Int32) == "BadNotWritable"
        assert await refusal("Missing", 5, kinds.Int32) == "BadNodeIdUnknown"
        assert await refusal("aDint", 5.0, kinds.Double) == "BadTypeMismatch"
        assert await refusal("aDint", [5], kinds.Int32) == "BadTypeMismatch"
        assert await refusal("Text", "x" * 83, kinds.String) == "BadOutOfRange"
        assert await refusal("Dints", [1, 2], kinds.Int32) == "BadOutOfRange"
        server = client.get_node(ua.ObjectIds.Server_ServiceLevel)
        with pytest.raises(ua.UaStatusCodeError):
            await server.write_value(ua.Variant(1, kinds.Byte))
        with pytest.raises(ua.UaStatusCodeError):
            await client.nodes.objects.add_object(2, "more")
        (locked,) = named(client, "Locked")
        with pytest.raises(ua.UaStatusCodeError):
            await client.delete_nodes([locked])
        assert await locked.read_value() == bench.tags["Locked"] == 7

    bench.ask(work)


def test_what_a_subscription_brings_together_is_of_one_instant(bench: Bench) -> None:
    """Each exchange is a scan, and each scan counts: three counters agree, and so do their times."""

    async def work(client: Any) -> None:
        heard: list[tuple[str, int, datetime]] = []
        enough = asyncio.Event()

        class Handler:
            def datachange_notification(self, node: Any, value: int, data: Any) -> None:
                stamp = data.monitored_item.Value.SourceTimestamp
                heard.append((node.nodeid.Identifier, value, stamp))
                if len(heard) >= 30:
                    enough.set()

        subscription = await client.create_subscription(0, Handler())
        await subscription.subscribe_data_change(named(client, "Scan", "C1", "C2"))
        await asyncio.wait_for(enough.wait(), TIMEOUT_S)
        await subscription.delete()
        by_time: dict[datetime, set[int]] = {}
        for _, value, stamp in heard:
            by_time.setdefault(stamp, set()).add(value)
        assert all(len(values) == 1 for values in by_time.values())
        assert len(by_time) >= 9

    bench.ask(work)


def test_events_of_the_server_are_subscribed_and_those_of_a_tag_are_not(bench: Bench) -> None:
    async def work(client: Any) -> None:
        from asyncua import ua

        class Handler:
            def event_notification(self, event: Any) -> None:
                pass

        subscription = await client.create_subscription(100, Handler())
        assert await subscription.subscribe_events() is not None
        refused = subscription.subscribe_events(named(client, "aDint")[0])
        with pytest.raises(ua.UaStatusCodeError, match="BadAttributeIdInvalid"):
            await refused
        await subscription.delete()

    bench.ask(work)


SUBSCRIPTIONS = 100
"""Those that a server allows, of all clients."""


def slow_subscription() -> Any:
    """Return what asks for a subscription that publishes once an hour."""
    from asyncua import ua

    return ua.CreateSubscriptionParameters(
        RequestedPublishingInterval=3_600_000.0, RequestedLifetimeCount=1_000, RequestedMaxKeepAliveCount=10
    )


async def subscribed(client: Any) -> int:
    """Return the identifier of a new subscription."""
    made = await client.uaclient.create_subscription(slow_subscription(), lambda _: None)
    return int(made.SubscriptionId)


def test_a_connection_opens_one_session_at_a_time(bench: Bench) -> None:
    async def work() -> None:
        async with channel(bench.connection()) as client:
            await client.create_session()
            assert await status_of(client.create_session()) == "BadTooManySessions"

    asyncio.run(work())


@pytest.mark.parametrize("end", ["a lost connection", "a closed session"])
def test_subscriptions_end_with_their_client(bench: Bench, end: str) -> None:
    """Nobody could use them again, and they would count against the limits."""

    async def lost() -> None:
        client = bench.connection()
        await client.connect()
        for _ in range(SUBSCRIPTIONS):
            await subscribed(client)
        assert await status_of(subscribed(client)) == "BadTooManySubscriptions"
        if end == "a closed session":
            await client.uaclient.close_session(False)  # False keeps subscriptions
        client.disconnect_socket()

    async def work(client: Any) -> None:
        from asyncua import ua

        for _ in range(50):
            try:
                await subscribed(client)
            except ua.uaerrors.BadTooManySubscriptions:
                await asyncio.sleep(0.1)
            else:
                return
        pytest.fail("the subscriptions of a client that has gone are still there")

    asyncio.run(lost())
    bench.ask(work)


def test_a_client_uses_its_own_subscriptions_only(bench: Bench) -> None:
    async def work(owner: Any) -> None:
        from asyncua import ua

        number = await subscribed(owner)
        wanted = ua.ReadValueId(named(owner, "aDint")[0].nodeid, ua.AttributeIds.Value)
        items = ua.CreateMonitoredItemsParameters(
            number, ItemsToCreate=[ua.MonitoredItemCreateRequest(wanted, ua.MonitoringMode.Reporting)]
        )
        gone = "BadSubscriptionIdInvalid"
        async with bench.client() as other:
            asked = other.uaclient
            transfer = ua.TransferSubscriptionsParameters([number])
            assert await status_of(asked.transfer_subscriptions(transfer)) == "BadServiceUnsupported"
            assert await status_of(asked.create_monitored_items(items)) == gone
            changed = ua.ModifySubscriptionParameters(number, 1_000.0)
            assert await status_of(asked.modify_subscription(changed)) == gone
            mode = ua.SetPublishingModeParameters(False, [number])
            assert [each.name for each in await asked.set_publishing_mode(mode)] == [gone]
            own = await subscribed(other)
            results = await asked.delete_subscriptions([number, own])
            assert [each.name for each in results] == [gone, "Good"]
        (made,) = await owner.uaclient.create_monitored_items(items)
        assert made.StatusCode.is_good()
        assert [each.name for each in await owner.uaclient.delete_subscriptions([number])] == ["Good"]

    bench.ask(work)
