"""Ports: bytes between a client's end and a device without I/O, one step of the server at a time."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import pytest
import serial
from bench601 import PORT_TIMING
from scanrack.runtime import Clock, LineFormat
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.line.ports import (
    BusSegment,
    LineServer,
    ModbusTcpPort,
    PduServer,
    PortError,
    PtyPort,
    RawTcpPort,
    SerialPort,
    Stop,
    serve_until_interrupted,
)
from scanrack.runtime.line.ports.modbustcp import NotModbusError, split_frames

FORMAT = LineFormat(38_400, "E")
MS = 1_000_000


@dataclass
class Parrot:
    """A device that says back, in capitals and after a delay, what it has heard."""

    delay_ns: int = 0
    name: str = ""
    line_format: LineFormat = FORMAT
    next_wake_ns: int | None = None
    heard: list[tuple[int, bytes]] = field(default_factory=list)

    def receive(self, now_ns: int, data: bytes) -> None:
        self.heard.append((now_ns, data))
        if self.name.encode() in data:
            self.next_wake_ns = now_ns + self.delay_ns

    def advance(self, now_ns: int) -> bytes:
        if self.next_wake_ns is None or now_ns < self.next_wake_ns:
            return b""
        self.next_wake_ns = None
        return self.heard[-1][1].upper()


def until(step: Callable[[float], None], done: Callable[[], bool]) -> None:
    for _ in range(100):
        if done():
            return
        step(0.05)
    raise AssertionError("nothing came")


def test_a_pseudo_terminal_carries_every_byte_and_survives_its_client() -> None:
    server = LineServer(Parrot(), port := PtyPort(), Clock())
    with closing(server):
        for _ in range(2):
            client = os.open(port.name, os.O_RDWR | os.O_NOCTTY)
            os.write(client, b"\x00\r\n\x11\x13abc\xff")
            server.step(1.0)
            assert os.read(client, 100) == b"\x00\r\n\x11\x13ABC\xff"
            os.close(client)
    assert (port.traffic.received, port.traffic.sent) == (18, 18)


def test_a_full_pseudo_terminal_loses_bytes_and_does_not_stop_the_device() -> None:
    with closing(PtyPort()) as port:
        for _ in range(20):
            port.send(b"x" * 4096)
        assert port.traffic.lost > 0


@pytest.fixture
def raw() -> Iterator[tuple[LineServer, RawTcpPort]]:
    port = RawTcpPort("127.0.0.1", 0)
    with closing(LineServer(Parrot(), port, Clock())) as server:
        yield server, port


def has_received(port: ModbusTcpPort, count: int) -> bool:
    return port.traffic.received == count


def connect(name: str) -> socket.socket:
    host, port = name.rsplit(":", 1)
    client = socket.create_connection((host, int(port)))
    client.settimeout(5)
    return client


def test_raw_tcp_answers_whoever_was_heard_last(raw: tuple[LineServer, RawTcpPort]) -> None:
    server, port = raw
    with connect(port.name) as one, connect(port.name) as two:
        one.sendall(b"one")
        until(server.step, lambda: port.traffic.sent == 3)
        two.sendall(b"two")
        until(server.step, lambda: port.traffic.sent == 6)
        assert (one.recv(10), two.recv(10)) == (b"ONE", b"TWO")


def test_raw_tcp_goes_on_when_its_client_has_gone(raw: tuple[LineServer, RawTcpPort]) -> None:
    server, port = raw
    with connect(port.name) as one:
        one.sendall(b"one")
        until(server.step, lambda: port.traffic.received == 3)
    with connect(port.name) as two:
        two.sendall(b"two")
        until(server.step, lambda: port.traffic.received == 6)
        assert two.recv(10) == b"TWO"


def test_raw_tcp_answers_a_frame_that_comes_in_two_pieces() -> None:
    """Four times the silence of `--gap-ms` passes between them, at any place of the frame."""
    port = RawTcpPort("127.0.0.1", 0)
    request = bytes.fromhex("01 03 00 05 00 01 94 0b")
    with (
        closing(LineServer(Pcl601(timing=PORT_TIMING), port, Clock())) as server,
        connect(port.name) as client,
    ):
        for cut in range(1, len(request)):
            heard = port.traffic.received
            client.sendall(request[:cut])
            until(server.step, lambda due=heard + cut: port.traffic.received == due)  # type: ignore[misc]
            end_s = time.monotonic() + 4 * PORT_TIMING.gap_ns / 1e9
            until(server.step, lambda due=end_s: time.monotonic() >= due)  # type: ignore[misc]
            client.sendall(request[cut:])
            until(server.step, lambda due=7 * cut: port.traffic.sent == due)  # type: ignore[misc]
            assert client.recv(100) == bytes.fromhex("01 03 02 01 f4 b8 53")


def tcp(transaction: int, unit: int, pdu: bytes, protocol: int = 0) -> bytes:
    return b"".join(n.to_bytes(2) for n in (transaction, protocol, len(pdu) + 1)) + bytes([unit]) + pdu


@pytest.fixture
def modbus() -> Iterator[tuple[PduServer, ModbusTcpPort]]:
    """Units 1 to 9 answer with the request turned round, the others not at all."""
    port = ModbusTcpPort("127.0.0.1", 0)
    answer = lambda unit, pdu: pdu[::-1] if unit < 10 else None  # noqa: E731
    with closing(PduServer(Parrot(), answer, port, Clock())) as server:
        yield server, port


def test_pipelined_and_split_requests_are_each_answered_in_order(
    modbus: tuple[PduServer, ModbusTcpPort],
) -> None:
    server, port = modbus
    stream = tcp(1, 1, b"abc") + tcp(0xFFFF, 9, b"de") + tcp(3, 10, b"none") + tcp(4, 2, b"f")
    with connect(port.name) as client:
        for at in range(0, len(stream), 5):
            client.sendall(stream[at : at + 5])
            until(server.step, partial(has_received, port, min(at + 5, len(stream))))
        expected = tcp(1, 1, b"cba") + tcp(0xFFFF, 9, b"ed") + tcp(4, 2, b"f")
        received = b""
        while len(received) < len(expected):
            received += client.recv(100)
        assert received == expected


def test_a_connection_that_speaks_something_else_is_ended(modbus: tuple[PduServer, ModbusTcpPort]) -> None:
    server, port = modbus
    with connect(port.name) as client:
        client.sendall(b"GET / HTTP/1.1\r\n\r\n")
        until(server.step, lambda: port.traffic.received > 0)
        assert client.recv(10) == b""
        assert port.connections == 0


@pytest.mark.parametrize("data", [tcp(1, 1, b"", 0), tcp(1, 1, b"a", 1), tcp(1, 1, b"x" * 254)])
def test_what_is_no_frame(data: bytes) -> None:
    """A PDU is 1 to 253 bytes, the protocol 0."""
    with pytest.raises(NotModbusError):
        split_frames(data)


def test_listening_where_somebody_listens_is_an_error_that_names_it() -> None:
    with closing(RawTcpPort("127.0.0.1", 0)) as port:
        host, number = port.name.split(":")
        with pytest.raises(PortError, match=f"can't listen at {port.name}"):
            ModbusTcpPort(host, int(number))


# -- a real serial port ------------------------------------------------------------------------------


class Plug:
    """Opens a pseudo-terminal in place of a serial port, unless it is pulled."""

    def __init__(self, path: str) -> None:
        self.path, self.pulled = path, False
        self.ports: list[serial.Serial] = []

    def __call__(self, path: str, line_format: LineFormat) -> serial.Serial:
        if self.pulled:
            raise OSError(f"{path} is not there")
        self.ports.append(serial.Serial(self.path, timeout=0))
        return self.ports[-1]


def test_a_serial_port_is_opened_again_when_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    with closing(PtyPort()) as line:
        plug = Plug(line.name)
        port = SerialPort("/dev/ttyX", FORMAT, opened=plug)
        server = LineServer(Parrot(), port, Clock())
        line.send(b"a")
        server.step(1.0)
        assert line.wait(120) == b"A"
        plug.pulled = True
        plug.ports[-1].close()
        server.step(0.01)
        assert not port.is_open
        server.step(0.01)
        plug.pulled = False
        until(server.step, lambda: port.is_open)
        line.send(b"b")
        server.step(1.0)
        assert line.wait(120) == b"B"
        assert port.traffic.lost == 1
        server.close()


def test_a_serial_port_follows_the_format_of_the_device() -> None:
    with closing(PtyPort()) as line:
        plug = Plug(line.name)
        device = Parrot()
        server = LineServer(device, SerialPort("/dev/ttyX", FORMAT, opened=plug), Clock())
        device.line_format = LineFormat(9600, "N", 2)
        server.step(0.0)
        assert (plug.ports[0].baudrate, plug.ports[0].stopbits) == (9600, 2)
        server.close()


def test_a_real_serial_port_object_speaks_over_a_pseudo_terminal() -> None:
    """A pseudo-terminal has no parity; asked for 8E1, it is opened with none instead of failing."""
    with closing(PtyPort()) as line:
        server = LineServer(Parrot(), SerialPort(line.name, FORMAT), Clock())
        line.send(b"hello")
        until(server.step, lambda: line.wait(0.0) == b"HELLO")
        server.close()


def test_a_port_that_is_not_there_is_an_error_that_names_it() -> None:
    with pytest.raises(PortError, match="/dev/nothing-here can't be opened"):
        SerialPort("/dev/nothing-here", FORMAT)


# -- several units on a line -------------------------------------------------------------------------


def test_all_units_hear_the_master_and_each_other() -> None:
    one, two = Parrot(name="one"), Parrot(name="two")
    line = BusSegment(one, two)
    line.receive(0, b"one?")
    assert line.advance(0) == b"ONE?"
    assert one.heard == [(0, b"one?")]
    assert two.heard == [(0, b"one?"), (0, b"ONE?")]


def test_what_comes_while_a_unit_speaks_is_heard_when_the_line_is_quiet() -> None:
    one, two = Parrot(name="one"), Parrot(name="two", delay_ns=3 * MS)
    line = BusSegment(one, two, quiet_ns=2 * MS)
    line.receive(0, b"one?")
    line.advance(0)
    line.receive(1 * MS, b"two?")
    assert line.advance(1 * MS) == b""
    assert line.next_wake_ns == 2 * MS
    assert line.advance(2 * MS) == b""
    assert line.next_wake_ns == 5 * MS
    assert line.advance(9 * MS) == b"TWO?"
    assert two.heard[-1] == (2 * MS, b"two?")


# -- time, and the end -------------------------------------------------------------------------------


def test_a_clock_runs_as_fast_as_it_is_told() -> None:
    clock = Clock(1000.0)
    assert clock.seconds_until(None, 0.5) == 0.5
    assert clock.seconds_until(0, 0.5) == 0.0
    assert 0 <= clock.seconds_until(clock.now_ns() + 10**12, 2.0) <= 1.0


@pytest.mark.parametrize("speed", [0, -1, float("inf"), float("nan")])
def test_a_speed_that_is_none(speed: float) -> None:
    with pytest.raises(ValueError, match="must be above 0"):
        Clock(speed)


def test_serving_ends_when_it_is_asked_to_and_closes_the_port() -> None:
    stop = Stop()
    steps: list[Any] = []

    class Server:
        closed = False

        def step(self, longest_s: float) -> None:
            steps.append(longest_s)

        def close(self) -> None:
            self.closed = True

    server = Server()
    serve_until_interrupted(server, lambda: stop.request() if len(steps) == 3 else None, stop)
    assert (len(steps), server.closed) == (3, True)
