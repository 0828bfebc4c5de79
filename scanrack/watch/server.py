"""The server of a monitor, with files and a socket per page. No other module imports `websockets`."""

from __future__ import annotations

import asyncio
import json
import socket
import traceback
from contextlib import suppress
from http import HTTPStatus
from multiprocessing.connection import Connection
from typing import Any

from scanrack.runtime.live.actions import parsed
from scanrack.runtime.live.quiet import CLIENT_LOGS, quiet
from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from .gate import Gate
from .monitors.monitor import Monitor
from .monitors.page import Page
from .monitors.questions import handle_message

HZ, IDLE_HZ = 30, 10
"""Frames per second with and without open pages."""

BUSY_S = 0.025
"""Maximum time for which a monitor works between two frames, s."""

MESSAGE_MOST = 1 << 16
OUTBOX_MOST = 200
"""Maximum number of waiting messages for a page. If a page does not read its messages, its requests are
dropped."""

PAGES_MOST = 8
STRANGERS_MOST = 16
"""Maximum number of sockets that have not sent the key yet."""

KEY_S = 5
"""Time within which a socket must send the key, s."""

WRONG_KEY, FAILED, TOO_MANY = 1008, 1011, 1013
"""Status codes for closing a socket [RFC 6455, section 7.4.1, and IANA's registry]."""


class Server:
    """The server of a monitor."""

    def __init__(self, monitor: Monitor, gate: Gate, pipe: Connection | None = None) -> None:
        self._monitor, self._gate, self._pipe = monitor, gate, pipe
        self._strangers = 0

    def run(self, listening: socket.socket) -> None:
        """Serve until the scan process ends or a trace continues as a session."""
        quiet(*CLIENT_LOGS)
        # Windows' default loop keeps a listening socket to itself, so that the next monitor could not use it
        with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
            runner.run(self._run(listening))

    async def _run(self, listening: socket.socket) -> None:
        """Serve pages until the session is over, then end the processes of their questions."""
        async with serve(
            self._socket,
            sock=listening,
            process_request=self._request,
            max_size=MESSAGE_MOST,
            compression="deflate",
            server_header=None,
        ):
            try:
                await self._pump()
                await self._flush()
            finally:
                self._monitor.processes.close()

    async def _pump(self) -> None:
        """Call the monitor's `tick` at regular intervals."""
        loop = asyncio.get_running_loop()
        due = loop.time()
        while not self._ended():
            due = max(due + 1 / (HZ if self._monitor.pages else IDLE_HZ), loop.time())
            await asyncio.sleep(due - loop.time())
            self._monitor.processes.tick()
            while (self._monitor.tick() | self._monitor.tick_compared()) and loop.time() < due + BUSY_S:
                await asyncio.sleep(0)

    async def _flush(self) -> None:
        """Wait until pages have got their messages, at most about one second."""
        for _ in range(HZ):
            if any(page.outbox for page in self._monitor.pages):
                await asyncio.sleep(1 / HZ)

    def _ended(self) -> bool:
        """Return whether the session is over: the monitor has ended, or the scan process closed the pipe."""
        if self._monitor.over:
            return True
        if self._pipe is None:
            return False
        try:
            return self._pipe.poll(0) and not self._pipe.recv_bytes()
        except (EOFError, OSError):
            return True

    def _request(self, _connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request for a file; return None for an allowed request to open a socket."""
        headers = request.headers
        hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
        host = hosts[0] if len(hosts) == 1 else None
        answer = self._gate.respond(
            request.path,
            host,
            ",".join(origins) if origins else None,
            accepts=",".join(headers.get_all("Accept-Encoding")),
            cached=",".join(headers.get_all("If-None-Match")),
        )
        if answer is None:
            return None
        reason = HTTPStatus(answer.status).phrase
        return Response(answer.status, reason, Headers(answer.headers.items()), answer.body)

    async def _socket(self, connection: ServerConnection) -> None:
        """Serve a page if it sends the key in time and few pages are open; otherwise close its socket."""
        if self._strangers >= STRANGERS_MOST:
            await connection.close(TOO_MANY, "too many connections")
            return
        self._strangers += 1
        try:
            has_key = await self._sends_key(connection)
        finally:
            self._strangers -= 1
        if not has_key:
            await connection.close(WRONG_KEY, "the link has no key or a wrong one; open the printed link")
        elif len(self._monitor.pages) >= PAGES_MOST:
            await connection.close(TOO_MANY, f"{PAGES_MOST} pages are open; close one")
        else:
            await self._serve(connection)

    async def _sends_key(self, connection: ServerConnection) -> bool:
        """Return whether the first message of a socket has the key and arrives within `KEY_S`."""
        try:
            message = parsed(await asyncio.wait_for(connection.recv(), KEY_S))
        except (ValueError, TimeoutError, ConnectionClosed):
            return False
        return isinstance(message, dict) and self._gate.is_key(message.get("key"))

    async def _serve(self, connection: ServerConnection) -> None:
        """Add a page, exchange messages with it until its socket is closed, and remove it."""
        page = Page()
        self._monitor.join(page)
        sending = asyncio.create_task(self._send(connection, page))
        try:
            async for text in connection:
                self._take(page, text)
        except ConnectionClosed:
            pass
        finally:
            self._monitor.leave(page)
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending

    def _take(self, page: Page, text: str | bytes) -> None:
        """Handle a message; refuse it if there are too many, or drop it if the page reads no answers."""
        if len(page.outbox) >= OUTBOX_MOST:
            return
        if not page.may_send():
            page.send({"answer": {"id": None, "refused": "more than 100 messages a second"}})
            return
        try:
            message = parsed(text)
        except ValueError as error:
            page.send({"answer": {"id": None, "refused": f"this is not JSON: {error}"}})
            return
        handle_message(self._monitor, page, message)

    async def _send(self, connection: ServerConnection, page: Page) -> None:
        """Send messages and frames to a page. A slow page gets fewer frames, and does not delay others."""
        while True:
            await page.due.wait()
            page.due.clear()
            while page.outbox:
                await connection.send(_json(page.outbox.popleft()))
            frame = self._frame(page)
            if frame is None:
                await connection.close(FAILED, "this picture can't be made; see the error in the terminal")
                return
            if frame:
                await connection.send(_json({"frame": frame}))

    def _frame(self, page: Page) -> dict[str, Any] | None:
        """Return the changes for a page; None after an internal error, which closes only this page."""
        try:
            return self._monitor.frame(page)
        except Exception:  # printed in the terminal in which the command runs
            traceback.print_exc()
            return None


def _json(message: object) -> str:
    return json.dumps(message, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
