"""A rack behind an OPC UA server in its own process; scans where a request waits."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterator, Mapping
from contextlib import ExitStack, asynccontextmanager, contextmanager
from pathlib import Path
from typing import Any

import pytest
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.run.servers.kinds import addresses
from scanrack.jobs.run.servers.tag_service import TagService
from scanrack.runtime.loop.listeners import QuietListener
from served_tags import write_rack

TIMEOUT_S = 120


class Orders(QuietListener):
    """Notes orders, each with its scan."""

    def __init__(self) -> None:
        self.given: list[tuple[int, str]] = []

    def event(self, scan: int, now_ns: int, topic: str, fields: Mapping[str, Any]) -> None:
        if topic == "/orders":
            self.given.append((scan, str(fields)))


class Bench:
    """A rack behind an OPC UA server."""

    def __init__(self, run: JobRun, service: TagService, folder: Path) -> None:
        debugger = run.program.debugger
        assert debugger is not None
        self.run, self.service, self.tags = run, service, debugger.tags
        self.folder, self.orders = folder, Orders()
        # What clients log in this process is no output of the server, which has a process of its own by now.
        logging.getLogger("asyncua").addHandler(logging.NullHandler())
        run.cpu.add_listener(self.orders)

    def ask(self, work: Callable[[Any], Coroutine[Any, Any, None]]) -> None:
        """Run a client's work."""

        async def session() -> None:
            async with self.client() as client:
                await work(client)

        asyncio.run(session())

    @asynccontextmanager
    async def client(self) -> AsyncIterator[Any]:
        async with self.connection() as client:
            yield client

    def connection(self) -> Any:
        """Return a client that is not connected yet."""
        from asyncua import Client

        url = f"opc.tcp://127.0.0.1:{self.service.port}/scanrack"
        # its own watchdog gives a connection up if the server does not answer within a second
        return Client(url, timeout=TIMEOUT_S, watchdog_intervall=TIMEOUT_S)


@contextmanager
def served(
    folder: Path, security: str | None = None, users: Path | None = None, port: int = 0, tags: str = ""
) -> Iterator[Bench]:
    """Serve the bench of `served_tags`; security, users and port are those of the command line."""
    job = load_job(str(write_rack(folder, tags=tags)))
    ending = threading.Event()
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(handled=True))
        (where,) = addresses([f"opc-ua:{port}"], security, users)
        service = TagService(job, where, print, writes=True)
        ports.callback(service.end)
        desk = service.serve(run)

        def scan() -> None:
            while not ending.wait(0.0005):
                if desk.has_request:
                    run.cpu.run(1)

        with run.cpu:
            thread = threading.Thread(target=scan)
            thread.start()
            try:
                yield Bench(run, service, folder)
            finally:
                ending.set()
                thread.join()


def named(client: Any, *paths: str) -> list[Any]:
    return [client.get_node(f"ns=2;s={path}") for path in paths]


@asynccontextmanager
async def channel(client: Any) -> AsyncIterator[Any]:
    """Open a channel without a session."""
    await client.connect_sessionless()
    try:
        yield client
    finally:
        client.disconnect_socket()


async def status_of(work: Awaitable[object]) -> str:
    """Return the name of the status with which a request is refused."""
    from asyncua import ua

    with pytest.raises(ua.UaStatusCodeError) as caught:
        await work
    return type(caught.value).__name__
