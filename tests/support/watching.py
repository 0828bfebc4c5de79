"""`scanrack watch` in a process of its own, and pages that are sockets."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
import subprocess
import sys
import time
from contextlib import asynccontextmanager, contextmanager
from pathlib import Path

import scanrack.watch.command
import scanrack.watch.server  # noqa: F401  # each process would import it
from forked import start
from websockets.asyncio.client import connect

FEEDER = Path(__file__).parents[2] / "examples" / "feeder" / "feeder.toml"
PATIENCE_S = 120


class Watched:
    """A session that runs: its link, and its process."""

    def __init__(self, process, link):
        self.process, self.link = process, link
        base, self.key = link.split("/#key=")
        self.host = base.removeprefix("http://")
        self.port = int(self.host.rpartition(":")[2])

    @property
    def monitor(self):
        """Number of the process that serves the pages: the child of the scan process, on Linux."""
        threads = Path(f"/proc/{self.process.pid}/task").glob("*/children")  # one of them starts it again
        return next(int(child) for each in threads for child in each.read_text(encoding="utf-8").split())

    def raw(self, text):
        """Send bytes to the port; return the status of the answer and all of it."""
        with socket.create_connection(("127.0.0.1", self.port), PATIENCE_S) as connection:
            connection.sendall(text.replace("\n", "\r\n").encode())
            answer = b""
            while part := connection.recv(65536):
                answer += part
                if b"101 Switching" in answer:
                    break
        return int(answer.split()[1]), answer.decode("utf-8", "replace")

    def end(self):
        """End it as Ctrl-C does; return the exit status."""
        self.process.send_signal(signal.SIGINT)
        return self.process.wait(PATIENCE_S)


@contextmanager
def watched(*options, rack=FEEDER, cwd=None):
    """Start a session, and end it."""
    command = [sys.executable, "-c", "from scanrack.commands import main; main()", "watch", str(rack)]
    process = start(
        [*command, *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        encoding="utf-8",
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        if not line:
            raise AssertionError(process.communicate()[1])
        yield Watched(process, line.split()[0])
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            try:
                process.wait(PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
        process.communicate()


class Page:
    """A page: its socket, and what it was told, put together."""

    def __init__(self, socket):
        self.socket = socket
        self.hello = {}
        self.frame = {}
        self.frames = 0
        self.edges = {}
        self.error = {}  # the error bit that was told last
        self._number = 0
        self._answers = {}

    async def hear(self):
        """Take one message."""
        message = json.loads(await asyncio.wait_for(self.socket.recv(), PATIENCE_S))
        if "hello" in message:
            self.hello, self.frame = message["hello"], {}
        elif "frame" in message:
            self.frames += 1
            for key, value in message["frame"].items():
                if key in ("words", "values", "machine", "power", "tags"):
                    self.frame.setdefault(key, {}).update(value)
                elif key == "strip":
                    for name, edges in value["bits"].items():
                        self.edges.setdefault(name, []).extend(edges)
                elif key == "events":
                    self.frame.setdefault("events", []).extend(value)
                else:
                    self.frame[key] = value
        elif "error" in message:
            self.error = message["error"]
        elif "answer" in message:
            self._answers[message["answer"]["id"]] = message["answer"]
        return message

    async def ask(self, do, **fields):
        """Ask or order; return the answer."""
        self._number += 1
        await self.socket.send(json.dumps({"id": self._number, "do": do, **fields}))
        return await self.answer(self._number)

    async def answer(self, number):
        """Wait for an answer."""
        while number not in self._answers:
            await self.hear()
        return self._answers.pop(number)

    async def until(self, holds):
        """Wait until a condition on this page holds."""
        end = time.monotonic() + PATIENCE_S
        while not holds(self):
            assert time.monotonic() < end, f"it does not come: { ({**self.frame, 'events': '...'}) }"
            await self.hear()


@asynccontextmanager
async def page_of(session, key=None):
    """Open a page."""
    uri = f"ws://{session.host}/socket"
    async with connect(
        uri, max_size=None, compression=None, close_timeout=0.5, open_timeout=PATIENCE_S
    ) as opened:
        await opened.send(json.dumps({"key": session.key if key is None else key}))
        page = Page(opened)
        yield page
