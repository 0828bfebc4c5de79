"""The OPC UA server process, built around asyncua's sessions.

A read request reads its tags in one exchange with the scan process. A subscription does so at each publishing
interval. All values from one exchange have the same timestamp. A write request is sent as one packet.
Clients can only read and write tags; `opcua_guard.py` decides which clients may.
"""

from __future__ import annotations

import asyncio
import pickle
import socket
import warnings
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from multiprocessing.connection import Connection
from typing import Any

from ..line.hosts import join_address
from ..line.ports.places import CLIENTS_MAX
from ..tag_servers.setup import TagSetup
from ..tag_servers.tag_snapshot import Operation
from .mailbox import AREA_BYTES, Mailbox
from .opcua_attributes import Attributes, BadStatusError
from .opcua_guard import UaGuard, keep_apart
from .opcua_library import service_error, ua
from .opcua_services import Service, accept_unknown_values, answer_browse_next, limit_operations
from .opcua_space import TagNode, TagSpace
from .opcua_subscriptions import KEEP_ALIVES, Subscriptions
from .opcua_views import CONTINUATIONS_MOST, Browsing, Views
from .quiet import CLIENT_LOGS, give_back_memory, quiet
from .shared_memory import SharedMemory
from .tag_server import STEP_S, ScanProcess

NAMESPACE = "urn:scanrack:tags"

INTERVAL_MS, SLOWEST_MS = 50.0, 3_600_000.0
"""Shortest and longest publishing interval, ms."""

ITEMS_MOST, SUBSCRIPTIONS_MOST, QUEUE_MOST = 20_000, 100, 100
"""Maximum monitored items and subscriptions for all clients together, and maximum queued values per item."""

MESSAGE_MOST, CHUNK_MOST = 1 << 24, 1 << 16
"""Maximum number of bytes in a message, and in one of its chunks."""

UNSENT_MOST, CLOSING_S = MESSAGE_MOST, 5.0
"""Limits for a slow client: unread bytes, and the time, s, to read them before its connection ends."""

TIDY_S = 2.0
"""Delay, s, before the memory of ended connections is released together."""

PENDING_MOST, ACTIVATION_S = 32, 10.0
"""Maximum waiting requests per client, and time limit, s, for a connected client to open a session."""

BATCH_BYTES = AREA_BYTES // 4
"""Maximum bytes that one exchange reads. A larger read needs several exchanges, one per scan."""


class OpcUaServer:
    """A tag server on a listening socket.

    Args:
        process: carries out the reads and writes in requests; a call can block.
    """

    def __init__(self, listening: socket.socket, process: ScanProcess) -> None:
        self._server: Any = import_module("asyncua").Server()
        self._listening, self._process = listening, process
        self._turn = asyncio.Lock()
        self._exchanges: set[asyncio.Task[list[bytes | None] | None]] = set()
        self._release_task: asyncio.Task[None] | None = None
        self._space: TagSpace
        self._attributes: Attributes
        self._views: Views

    @property
    def _inner(self) -> Any:
        return self._server.iserver

    async def start(self, setup: TagSetup) -> None:
        """Configure asyncua's server, replace the services of its sessions, show the tags, and listen."""
        self._process.version = setup.version
        accept_unknown_values()
        server = self._server
        await server.init()
        server.set_server_name(f"scanrack {setup.name}")
        host, port = self._listening.getsockname()[:2]
        server.set_endpoint(f"opc.tcp://{join_address(host, port)}/scanrack")
        guard = UaGuard(setup.ua_security)
        await server.set_application_uri(guard.uri)
        await guard.set_up(server)
        self._set_limits()
        namespace = await server.register_namespace(NAMESPACE)
        space = self._inner.aspace
        self._space = TagSpace(space, namespace, setup.name)
        await self._space.show(setup.database)
        self._attributes, self._views = Attributes(space, self._space), Views(space)
        await self._publish_limits()
        self._hook_sessions()
        await self._listen(guard)

    def _set_limits(self) -> None:
        """Limit connections, pending requests, subscriptions, queues and messages."""
        inner_server = self._inner
        inner_server.max_connections = CLIENTS_MAX
        inner_server.max_pending_messages_per_connection = PENDING_MOST
        inner_server.max_pending_activation_seconds = ACTIVATION_S
        inner_server.max_subscriptions = SUBSCRIPTIONS_MOST
        inner_server.max_monitored_item_queue_size = inner_server.max_unacked_messages_per_subscription = (
            QUEUE_MOST
        )
        limits = self._server.limits
        limits.max_recv_buffer = limits.max_send_buffer = CHUNK_MOST
        limits.max_message_size, limits.max_chunk_count = MESSAGE_MOST, MESSAGE_MOST // CHUNK_MOST

    async def _publish_limits(self) -> None:
        """Publish the limit on continuation points; asyncua publishes the operation limits."""
        points = ua.Variant(CONTINUATIONS_MOST, ua.VariantType.UInt16)
        node = ua.NodeId(ua.ObjectIds.Server_ServerCapabilities_MaxBrowseContinuationPoints)
        await self._inner.aspace.write_attribute_value(node, ua.AttributeIds.Value, ua.DataValue(points))

    async def _listen(self, guard: UaGuard) -> None:
        """Listen on the given socket; asyncua's own `start` would open another one."""
        binary_module: Any = import_module("asyncua.server.binary_server_asyncio")
        await self._server._setup_server_nodes()
        await self._inner.start()
        binary_server = binary_module.BinaryServer(self._inner, "", 0, self._server.limits)
        binary_server.set_policies(self._server._policies)

        def make_protocol() -> Any:
            protocol = binary_server._make_protocol()
            protocol.data_received = _bounded(protocol, protocol.data_received)
            protocol.connection_made = _impatient(_guarded(protocol, protocol.connection_made, guard))
            protocol.connection_lost = self._tidying(protocol.connection_lost)
            return protocol

        await asyncio.get_running_loop().create_server(make_protocol, sock=self._listening)
        binary_server.cleanup_task = asyncio.create_task(binary_server._close_task_loop())
        self._server.bserver = binary_server

    def _tidying(self, lost: Callable[[Exception | None], None]) -> Callable[[Exception | None], None]:
        """Wrap the callback for a lost connection so that it also schedules the release of memory."""

        def tidying(error: Exception | None) -> None:
            lost(error)
            if self._release_task is None:
                self._release_task = asyncio.create_task(self._release_later())

        return tidying

    async def _release_later(self) -> None:
        """Release the memory of all connections that have ended within `TIDY_S`."""
        await asyncio.sleep(TIDY_S)
        self._release_task = None
        await self._server.bserver._close_tasks()
        give_back_memory()

    async def show(self, setup: TagSetup) -> None:
        """Show the tags of an edited program."""
        async with self._turn:
            self._process.version = setup.version
            await self._space.show(setup.database)
            self._views.edition += 1

    # --- sessions

    def _hook_sessions(self) -> None:
        """Replace asyncua's services in each new session with the services of this package."""
        create = self._inner.create_session

        def created(name: Any, *more: Any, **named: Any) -> Any:
            session = create(name, *more, **named)
            keep_apart(session, self._inner.subscription_service.subscriptions)
            client = f"{name[0]}:{name[1]}"
            Subscriptions(session, self._inner.subscription_service, self._attributes)
            browsing = Browsing(self._views, session.translate_browsepaths_to_nodeids)
            session.browse, session.browse_next = browsing.browse, browsing.browse_next
            session.translate_browsepaths_to_nodeids = browsing.translate
            session.read = self._reading(client)
            session.write = lambda params: self._write(params, session, client)
            session.create_subscription = self._subscribing(session.create_subscription, client)
            session.modify_subscription = self._changing(session.modify_subscription)
            session.create_monitored_items = self._monitoring(session.create_monitored_items, client)
            limit_operations(session)
            return session

        self._inner.create_session = created

    def _reading(self, client: str) -> Service:
        """Return a session's Read service, which reads the tags of a request together."""

        async def reading(params: Any) -> Any:
            self._attributes.check_read(params)
            await self._refresh(map(self._attributes.tag_of, params.NodesToRead), client)
            return self._attributes.read(params)

        return reading

    async def _write(self, params: Any, session: Any, client: str) -> list[Any]:
        """Write values as one packet; return the status of each."""
        codes = ua.StatusCodes
        write_values, version = params.NodesToWrite, self._process.version
        await self._refresh(
            (self._attributes.tag_of(write_value) for write_value in write_values if write_value.IndexRange),
            client,
        )
        status, operations = [codes.Good] * len(write_values), list[Operation]()
        value_indexes = list[int]()  # of each operation
        for index, node_value in enumerate(write_values):
            try:
                changes = self._attributes.changes(node_value)
            except BadStatusError as error:
                status[index] = getattr(codes, error.code)
            else:
                operations += changes
                value_indexes += [index] * len(changes)
        if operations:
            written = await self._carry_out(operations, _by_user(session.user, client), version)
            for number, index in enumerate(value_indexes):
                if written is None or written[number] is None:
                    status[index] = codes.BadInvalidState if written is None else codes.BadOutOfRange
        return [ua.StatusCode(code) for code in status]

    # --- subscriptions

    def _subscribing(self, create: Service, client: str) -> Service:
        """Wrap CreateSubscription: interval and lifetime are limited, and publishing reads the tags."""

        async def subscribing(params: Any, *more: Any, **named: Any) -> Any:
            params.RequestedPublishingInterval = interval(params.RequestedPublishingInterval)
            if params.RequestedLifetimeCount:  # 0 = the longest lifetime
                alive = KEEP_ALIVES * params.RequestedMaxKeepAliveCount
                params.RequestedLifetimeCount = max(params.RequestedLifetimeCount, alive)
            result = await create(params, *more, **named)
            subscription = self._inner.subscription_service.subscriptions[result.SubscriptionId]
            subscription.publish_results = self._publishing(
                subscription, subscription.publish_results, client
            )
            return result

        return subscribing

    def _changing(self, change: Callable[[Any], Any]) -> Callable[[Any], Any]:
        """Wrap ModifySubscription so that the publishing interval is limited."""

        def changing(params: Any) -> Any:
            params.RequestedPublishingInterval = interval(params.RequestedPublishingInterval)
            return change(params)

        return changing

    def _publishing(self, subscription: Any, publish: Service, client: str) -> Service:
        """Return a service that reads all of a subscription's tags together and then publishes."""

        async def publishing(request: Any = None) -> Any:
            if request is None:  # the interval has passed; a request only fetches queued values
                items = list(subscription.monitored_item_srv._monitored_items.values())
                await self._refresh((self._attributes.tag_of(item.read_value_id) for item in items), client)
            return await publish(request)

        return publishing

    def _monitoring(self, create: Service, client: str) -> Service:
        """Wrap CreateMonitoredItems so that the items of all clients are limited, and have values."""

        async def monitoring(params: Any) -> Any:
            services = self._inner.subscription_service.subscriptions.values()
            item_count = sum(len(service.monitored_item_srv._monitored_items) for service in services)
            if item_count + len(params.ItemsToCreate) > ITEMS_MOST:
                raise service_error("BadTooManyMonitoredItems")
            await self._refresh(
                (self._attributes.tag_of(item.ItemToMonitor) for item in params.ItemsToCreate), client
            )
            return await create(params)

        return monitoring

    # --- exchanges

    async def _refresh(self, requested: Iterable[TagNode | None], client: str) -> None:
        """Read tags together. While the program is being edited, the tags keep their values."""
        nodes, version = list(dict.fromkeys(filter(None, requested))), self._process.version
        while nodes:
            size, count = 0, 0
            while count < len(nodes) and (not count or size + nodes[count].variable.size <= BATCH_BYTES):
                size += nodes[count].variable.size
                count += 1
            batch, nodes = nodes[:count], nodes[count:]
            batch_data = await self._carry_out([node.variable.reads for node in batch], client, version)
            if batch_data is not None:
                await self._space.store(batch, batch_data)

    async def _carry_out(
        self, operations: Sequence[Operation], client: str, version: int
    ) -> list[bytes | None] | None:
        """Return a packet's results for one version of the program, or None if the program was edited.

        A client that disconnects cancels only its own wait, not the exchange. Otherwise a second exchange
        could start, and both would wait forever for one answer.
        """
        exchange_task = asyncio.create_task(self._exchange(operations, client, version))
        self._exchanges.add(exchange_task)  # the event loop itself keeps no reference to a task
        exchange_task.add_done_callback(self._exchanges.discard)
        return await asyncio.shield(exchange_task)

    async def _exchange(
        self, operations: Sequence[Operation], client: str, version: int
    ) -> list[bytes | None] | None:
        """Carry out a packet in the scan process, one at a time; see `_carry_out`."""
        async with self._turn:
            if version != self._process.version:
                return None
            exchange_future = asyncio.get_running_loop().run_in_executor(
                None, self._process, [(client, operations)]
            )
            try:
                exchange_results = await exchange_future
            except ValueError as error:  # too much for one exchange
                raise service_error("BadRequestTooLarge") from error
        return None if exchange_results is None else exchange_results.results[0]


def _by_user(user: Any, client: str) -> str:
    """Return a client's address, preceded by the user's name if a user has logged in."""
    return f"{user.name} ({client})" if user.name else client


def interval(requested_ms: float) -> float:
    """Return the publishing interval to use, ms, when a client requests an interval.

    >>> interval(0.0), interval(float("nan")), interval(250.0)
    (50.0, 50.0, 250.0)
    """
    return min(requested_ms, SLOWEST_MS) if requested_ms >= INTERVAL_MS else INTERVAL_MS


def _bounded(protocol: Any, receive: Callable[[bytes], None]) -> Callable[[bytes], None]:
    """Wrap a connection's receiver so that it aborts the connection at a chunk longer than `CHUNK_MOST`."""

    def received(data: bytes) -> None:
        receive(data)
        if len(protocol._buffer) > CHUNK_MOST and protocol.transport is not None:
            protocol._buffer = b""
            protocol.transport.abort()

    return received


def _guarded(protocol: Any, connect: Callable[[Any], None], guard: UaGuard) -> Callable[[Any], None]:
    """Wrap the callback for a new connection so that the guard checks its requests."""

    def connected(transport: Any) -> None:
        connect(transport)
        if protocol.processor is not None:  # None if too many clients are connected
            answer_browse_next(protocol.processor)
            guard.watch(protocol)

    return connected


def _impatient(connect: Callable[[Any], None]) -> Callable[[Any], None]:
    """Wrap the callback for a new connection so that a client that doesn't read is disconnected."""

    def connected(transport: Any) -> None:
        write, close_transport = transport.write, transport.close

        def writing(data: bytes) -> None:
            write(data)
            if transport.get_write_buffer_size() > UNSENT_MOST:
                transport.abort()

        def closing() -> None:
            close_transport()
            if transport.get_write_buffer_size():
                asyncio.get_running_loop().call_later(CLOSING_S, transport.abort)

        transport.write, transport.close = writing, closing
        connect(transport)

    return connected


async def _serve(pipe: Connection, process: ScanProcess, listening: socket.socket) -> None:
    """Serve until the scan process ends."""
    loop = asyncio.get_running_loop()
    connection_ended: asyncio.Future[None] = loop.create_future()
    setup: TagSetup = pickle.loads(pipe.recv_bytes())  # trusted: it comes from our own scan process
    server = OpcUaServer(listening, process)
    await server.start(setup)
    changes: set[asyncio.Task[None]] = set()

    def renew() -> None:
        """Show the tags of an edited program; if the scan process has ended, end the server."""
        try:
            setup: TagSetup = pickle.loads(pipe.recv_bytes())
        except (EOFError, OSError):
            loop.remove_reader(pipe.fileno())
            if not connection_ended.done():
                connection_ended.set_result(None)
            return
        task = asyncio.create_task(server.show(setup))
        changes.add(task)  # the event loop itself keeps no reference to a task
        task.add_done_callback(changes.discard)

    loop.add_reader(pipe.fileno(), renew)
    while not connection_ended.done():
        process.beat()
        await asyncio.wait([connection_ended], timeout=STEP_S)


def main(
    setups: socket.socket, waker: socket.socket, mailbox: SharedMemory, listening: socket.socket
) -> None:
    """Run a server process; see `tag_server.main`."""
    quiet(*CLIENT_LOGS)
    warnings.simplefilter("ignore")  # warnings about clients' certificates
    process = ScanProcess(Mailbox(mailbox), waker)
    try:
        # Windows' default loop can't watch a pipe, and keeps a listening socket to itself
        with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
            runner.run(_serve(Connection(setups.detach()), process, listening))
    except (EOFError, OSError, KeyboardInterrupt):
        return
