"""Clients of a tag server that mean no good, over sockets: they harm only themselves."""

from __future__ import annotations

import random
import select
import socket
import struct
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import pytest
from scanrack.runtime.line.ports import places
from scanrack.runtime.live import tag_client
from scanrack.runtime.live.tag_server import TagServer
from served_tags import ServedRack, batch, frame, message, served, symbol, unconnected, write_rack

READ = message(0x4C, symbol("Scan"), b"\1\0")
NOP = 0


class Dialler:
    """A client at a port."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=120)

    def register(self) -> Dialler:
        """Begin a session."""
        self.socket.sendall(frame(0x65, b"\1\0\0\0"))
        self.handle = struct.unpack_from("<I", self.take(), 4)[0]
        return self

    def take(self) -> bytes:
        """Return a frame; b"" if the connection has ended."""
        data, length = b"", 24
        while len(data) < length:
            try:
                more = self.socket.recv(length - len(data))
            except ConnectionError:
                return b""
            if not more:
                return b""
            data += more
            if len(data) == 24:
                length += struct.unpack_from("<H", data, 2)[0]
        return data

    def packet(self, data: bytes) -> bytes:
        """Return a frame with a message."""
        return frame(0x6F, unconnected(data), self.handle)

    def status(self, data: bytes = READ) -> int:
        """Send a message; return the status of its reply."""
        self.socket.sendall(self.packet(data))
        return self.take()[42]


@contextmanager
def dialling(port: int) -> Iterator[Dialler]:
    client = Dialler(port)
    with client.socket:
        yield client.register()


@contextmanager
def stepped(tmp_path: Path) -> Iterator[tuple[TagServer, int]]:
    """A server that takes steps only when it is told."""
    with ExitStack() as ports:
        rack = ServedRack(write_rack(tmp_path), ports)
        listening = ports.enter_context(socket.create_server(("127.0.0.1", 0)))
        server = TagServer(rack.setup, listening, None, rack.exchange)
        ports.callback(server.close)
        yield server, listening.getsockname()[1]


def registered(server: TagServer, port: int) -> Dialler:
    """Return a client with a session at a server that takes steps."""
    client = Dialler(port)
    client.socket.sendall(frame(0x65, b"\1\0\0\0"))
    while not select.select([client.socket], [], [], 0)[0]:
        server.step(0.01)
    client.handle = struct.unpack_from("<I", client.take(), 4)[0]
    return client


def _is(each: tag_client.Client, client: Dialler) -> bool:
    return bool(each.socket.getpeername() == client.socket.getsockname())


def test_a_client_that_gives_way_may_send_at_that_instant(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(places, "CLIENTS_MAX", 1)
    monkeypatch.setattr(places, "SILENT_NS", 0)
    with stepped(tmp_path) as (server, port):
        first = registered(server, port)
        server.step(0)  # nothing is ready now; what is ready first is handled first
        second = Dialler(port)
        first.socket.sendall(first.packet(READ))
        while not server.dropped:
            server.step(0.01)
        assert first.take() == b""
        assert [_is(each, second) for each in server.clients.values()] == [True]
        first.socket.close()
        second.socket.close()


def test_many_packets_of_a_client_keep_no_other_one_waiting(tmp_path: Path) -> None:
    with stepped(tmp_path) as (server, port):
        greedy, modest = registered(server, port), registered(server, port)
        greedy.socket.sendall(greedy.packet(batch([READ] * 20)) * 6)
        while not any(each.waiting for each in server.clients.values()):
            server.step()
        modest.socket.sendall(modest.packet(READ))
        modest.socket.settimeout(0)
        for _ in range(3):
            server.step()
        assert modest.take()[42] == 0
        assert any(each.waiting for each in server.clients.values())
        greedy.socket.close()
        modest.socket.close()


def test_frames_without_an_answer_are_taken_in_parts(tmp_path: Path) -> None:
    with stepped(tmp_path) as (server, port):
        client = registered(server, port)
        client.socket.sendall(frame(NOP) * 1000)
        server.step()
        [there] = server.clients.values()
        assert not there.waiting
        assert len(there.session.pending) < 24
        client.socket.close()


@pytest.mark.slow
def test_the_attack(tmp_path: Path) -> None:
    chance = random.Random(7)
    with served(write_rack(tmp_path)) as (_, port), ExitStack() as opened, dialling(port) as good:
        whole = good.packet(READ)
        for _ in range(30):  # slow ones
            opened.enter_context(dialling(port)).socket.sendall(whole[:10])
        for end in range(0, len(whole), 3):
            with dialling(port) as other:
                other.socket.sendall(whole[:end])
        for length in (0, 1, 23, 4601, 65_535):
            with dialling(port) as other:
                other.socket.sendall(frame(0x6F, unconnected(READ), other.handle, length=length))
        for _ in range(100):
            with socket.create_connection(("127.0.0.1", port)) as other, suppress(ConnectionError):
                other.sendall(chance.randbytes(chance.randrange(1, 400)))
        assert good.status() == 0
        held = [opened.enter_context(socket.create_connection(("127.0.0.1", port))) for _ in range(200)]
        assert sum(map(_stays, held)) <= places.CLIENTS_MAX - 31
        assert good.status() == 0


def _stays(where: socket.socket) -> bool:
    """Whether a server has kept a connection: it answers a request."""
    try:
        where.sendall(frame(0x63))
        return where.recv(24) != b""
    except ConnectionError:
        return False


def test_a_client_that_never_reads_is_dropped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tag_client, "UNREAD_MOST", 1 << 12)
    with served(write_rack(tmp_path)) as (_, port), dialling(port) as deaf, dialling(port) as good:
        deaf.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 12)
        part = message(0x4C, symbol("Dints"), struct.pack("<H", 3000))
        many = deaf.packet(part) * 1000
        with pytest.raises(ConnectionError):
            deaf.socket.sendall(many * 100)
        assert good.status() == 0
