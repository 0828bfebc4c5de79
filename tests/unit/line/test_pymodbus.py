"""What pymodbus does to valid input. After an update that turns a test red, what it names need not be ours.

| ours | because of |
|---|---|
| `line/rtu.py`: `Framer` | frames that are lost, unknown functions, no silence between frames |
| `line/ports/modbustcp.py`: `split_frames` | a byte taken from the next request |
| `line/ports/modbustcp.py`: `ModbusTcpPort` | lost requests, exceptions without a function, others served |
| `line/pcl601_pdus.py`: `Pcl601Identity` | a byte that the manual lacks |
"""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import pymodbus
import pytest
from modbus_standard import rtu
from pymodbus.framer import FramerRTU, FramerSocket, FramerType
from pymodbus.pdu import DecodePDU
from pymodbus.pdu.other_message import ReportDeviceIdResponse
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

READ = bytes.fromhex("03 0000 0001")
REPLY = bytes.fromhex("03 02 0007")
VERSION = tuple(map(int, pymodbus.__version__.split(".")[:2]))


def test_of_two_frames_in_one_read_the_second_is_lost() -> None:
    frame = rtu(1, READ)
    used, request = FramerRTU(DecodePDU(True)).handleFrame(frame + frame, 0, 0)
    assert request is not None
    assert used == 2 * len(frame)  # right: len(frame), and the rest is the second frame


@pytest.mark.skipif(VERSION < (3, 16), reason="since 3.16")
def test_a_frame_behind_noise_is_lost() -> None:
    data = b"\x00\x00" + rtu(1, READ)
    assert FramerRTU(DecodePDU(True)).handleFrame(data, 0, 0) == (len(data), None)


def test_request_11h_takes_a_byte_of_the_next_one() -> None:
    request = bytes.fromhex("0001 0000 0002 01 11")
    used, *_ = FramerSocket(DecodePDU(True)).decode(request + b"\x00")
    assert used == len(request) + 1  # right: len(request)


def test_the_answer_to_11h_has_a_run_status() -> None:
    assert ReportDeviceIdResponse(b"\x011.00").encode() == b"\x06\x011.00\xff"


@contextmanager
def served(framer: FramerType) -> Iterator[socket.socket]:
    """Run pymodbus's server for a block; yield a connection to it."""
    ready, ports = threading.Event(), []
    loop = asyncio.new_event_loop()
    ended = asyncio.Event()

    async def serve() -> None:
        registers = SimData(0, values=[7, 8], datatype=DataType.REGISTERS)
        server = ModbusTcpServer(SimDevice(1, simdata=[registers]), framer=framer, address=("127.0.0.1", 0))
        await server.serve_forever(background=True)
        ports.append(server.transport.sockets[0].getsockname()[1])  # type: ignore[attr-defined]
        ready.set()
        await ended.wait()
        await server.shutdown()

    thread = threading.Thread(target=loop.run_until_complete, args=(serve(),))
    thread.start()
    try:
        assert ready.wait(10)
        with socket.create_connection(("127.0.0.1", ports[0]), timeout=10) as client:
            yield client
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join()
        loop.close()


def framed(transaction: int, pdu: bytes) -> bytes:
    return transaction.to_bytes(2, "big") + b"\0\0" + (len(pdu) + 1).to_bytes(2, "big") + b"\x01" + pdu


def test_of_three_requests_in_one_packet_its_server_answers_the_first() -> None:
    with served(FramerType.SOCKET) as client:
        client.sendall(b"".join(framed(number, READ) for number in (1, 2, 3)))
        expected = framed(1, REPLY)
        assert client.recv(len(expected), socket.MSG_WAITALL) == expected
        client.sendall(framed(4, READ))
        expected = framed(4, REPLY)  # right: 2
        assert client.recv(len(expected), socket.MSG_WAITALL) == expected


def test_its_server_refuses_a_function_without_its_number_and_serves_others_unasked() -> None:
    with served(FramerType.SOCKET) as client:
        for request, reply in (
            (b"\x41", b"\x80\x01"),  # right: C1 01
            (bytes.fromhex("08 0000 1234"), bytes.fromhex("08 0000 1234")),  # right for a PCL601: 88 01
        ):
            client.sendall(framed(1, request))
            expected = framed(1, reply)
            assert client.recv(len(expected), socket.MSG_WAITALL) == expected


def test_an_unknown_function_in_rtu_is_waited_for_without_end() -> None:
    frame = rtu(1, b"\x41")
    assert FramerRTU(DecodePDU(True)).handleFrame(frame, 0, 0) == (0, None)  # right: exception C1 01
