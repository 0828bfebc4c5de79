"""A subscription of node-opcua's client, which FUXA and Node-RED have, continues after a restart and a cut.

Until a server says that it has no more lost messages, the client asks for the next one, without end.
"""

from __future__ import annotations

import json
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from queue import Empty, Queue
from typing import Any

import pytest
from peers import PEERS_FOLDER, TIMEOUT_S, node_program
from ua_bench import served

pytestmark = [
    pytest.mark.extra("opcua"),
    pytest.mark.peer("node-opcua-client"),
    pytest.mark.slow,
]

CUT_S = 3.0
ASKED_MOST = 20
"""Republish requests of one reconnection: one for each lost message, and the last one."""


class Subscriber:
    """A client that prints the values of a subscription."""

    def __init__(self, port: int) -> None:
        program = node_program("node-opcua-client")
        words = [
            program,
            str(PEERS_FOLDER / "resubscribe_ua.cjs"),
            f"opc.tcp://127.0.0.1:{port}/scanrack",
            "Scan",
        ]
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(words, stdin=pipe, stdout=pipe, encoding="utf-8")
        self._lines: Queue[dict[str, Any]] = Queue()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            with suppress(json.JSONDecodeError):  # it also prints warnings
                self._lines.put(json.loads(line))

    def hear(self, count: int) -> list[int]:
        """Wait for values that come from now on."""
        with suppress(Empty):
            while True:
                self._lines.get_nowait()
        return [self._lines.get(timeout=TIMEOUT_S)["value"] for _ in range(count)]

    def end(self) -> dict[str, int]:
        """End it; return the number of its requests by their kind."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._reader.join(TIMEOUT_S)
        assert self._process.wait(TIMEOUT_S) == 0
        while "asked" not in (line := self._lines.get_nowait()):
            pass
        return dict(line["asked"])

    def close(self) -> None:
        """End it, whatever has happened."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
        for each in (self._process.stdin, self._process.stdout):
            if each is not None:
                each.close()


@contextmanager
def subscriber(port: int) -> Iterator[Subscriber]:
    client = Subscriber(port)
    try:
        yield client
    finally:
        client.close()


class Cable:
    """A way to a port that can be cut."""

    def __init__(self, port: int) -> None:
        self._target = port
        self._ends: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self.connect(0)

    def connect(self, port: int) -> None:
        """Let clients connect, at a port that is free or given."""
        self._listening = socket.create_server(("127.0.0.1", port))
        self.port = self._listening.getsockname()[1]
        self._run(self._accept)

    def cut(self) -> None:
        """End all connections, and take none."""
        with suppress(OSError):
            self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        for each in self._ends:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
        for thread in self._threads:
            thread.join(TIMEOUT_S)
        for each in self._ends:
            each.close()
        self._ends, self._threads = [], []

    def _run(self, work: Any, *words: Any) -> None:
        thread = threading.Thread(target=work, args=words)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._listening.accept()
                far = socket.create_connection(("127.0.0.1", self._target), TIMEOUT_S)
                self._ends += [near, far]
                self._run(self._pump, near, far)
                self._run(self._pump, far, near)

    @staticmethod
    def _pump(source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while data := source.recv(1 << 16):
                sink.sendall(data)
            sink.shutdown(socket.SHUT_RDWR)


def test_values_go_on_after_a_restart(tmp_path: Path) -> None:
    with ExitStack() as clients:
        with served(tmp_path) as bench:
            port = bench.service.port
            client = clients.enter_context(subscriber(port))
            assert client.hear(5)
        time.sleep(1.0)
        with served(tmp_path, port=port):
            values = client.hear(5)
            assert values == sorted(set(values))
            asked = client.end()
    assert asked["RepublishRequest"] <= ASKED_MOST


def test_values_go_on_after_a_cut(tmp_path: Path) -> None:
    with served(tmp_path) as bench:
        cable = Cable(bench.service.port)
        try:
            with subscriber(cable.port) as client:
                assert client.hear(5)
                cable.cut()
                time.sleep(CUT_S)
                cable.connect(cable.port)
                values = client.hear(5)
                assert values == sorted(set(values))
                asked = client.end()
        finally:
            cable.cut()
    assert asked["RepublishRequest"] <= ASKED_MOST
