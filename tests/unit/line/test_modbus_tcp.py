"""The client of a Modbus TCP device against peers with right answers and with faults.

Requests and answers are bytes as the tables of Modbus V1.1b3, chapter 6, have them.
"""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import pytest
from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.register_message import (
    MaskWriteRegisterRequest,
    ReadHoldingRegistersRequest,
    ReadInputRegistersRequest,
    ReadWriteMultipleRegistersRequest,
    WriteMultipleRegistersRequest,
    WriteSingleRegisterRequest,
)
from scanrack.runtime.line.clients.link import BadResponseError, LinkError, NoAnswerError
from scanrack.runtime.line.clients.modbus import ModbusExceptionError
from scanrack.runtime.line.clients.modbus_tcp import ModbusTcpLine

HEADER = struct.Struct(">HHHB")
Answers = Callable[[int, bytes], list[bytes]]
"""From the transaction of a request and its PDU to what the peer sends; a part b"" closes the connection."""


class Peer:
    """A listening device. Attributes: PDUs received, and the number of connections."""

    def __init__(self, answers: Answers) -> None:
        self._answers = answers
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._listening.getsockname()[1]
        self.heard: list[bytes] = []
        self.connections = 0
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listening.accept()
                self.connections += 1
                with client, suppress(OSError):
                    client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    self._talk(client)

    def _talk(self, client: socket.socket) -> None:
        while header := client.recv(HEADER.size, socket.MSG_WAITALL):
            transaction, _, length, _ = HEADER.unpack(header)
            pdu = client.recv(length - 1, socket.MSG_WAITALL)
            self.heard.append(pdu)
            for part in self._answers(transaction, pdu):
                if not part:
                    return
                client.sendall(part)

    def close(self) -> None:
        """Stop listening."""
        self._listening.shutdown(socket.SHUT_RDWR)
        self._listening.close()
        self._thread.join()


@contextmanager
def line_to(answers: Answers, answer_s: float = 5.0) -> Iterator[tuple[ModbusTcpLine, Peer]]:
    peer = Peer(answers)
    line = ModbusTcpLine("127.0.0.1", peer.port, answer_s)
    try:
        yield line, peer
    finally:
        line.close()
        peer.close()


def framed(
    transaction: int, pdu: str, *, unit: int = 7, protocol: int = 0, length: int | None = None
) -> bytes:
    data = bytes.fromhex(pdu)
    return HEADER.pack(transaction, protocol, (len(data) if length is None else length) + 1, unit) + data


EXAMPLES: list[tuple[ModbusPDU, str, str, dict[str, object]]] = [
    # as printed in V1.1b3, 6.3, 6.4, 6.6, 6.12, 6.16 and 6.17
    (
        ReadHoldingRegistersRequest(address=107, count=3),
        "03 00 6b 00 03",
        "03 06 02 2b 00 00 00 64",
        {"registers": [555, 0, 100]},
    ),
    (ReadInputRegistersRequest(address=8, count=1), "04 00 08 00 01", "04 02 00 0a", {"registers": [10]}),
    (
        WriteSingleRegisterRequest(address=1, registers=[3]),
        "06 00 01 00 03",
        "06 00 01 00 03",
        {"address": 1, "registers": [3]},
    ),
    (
        WriteMultipleRegistersRequest(address=1, registers=[10, 258]),
        "10 00 01 00 02 04 00 0a 01 02",
        "10 00 01 00 02",
        {"address": 1, "count": 2},
    ),
    (
        MaskWriteRegisterRequest(address=4, and_mask=0xF2, or_mask=0x25),
        "16 00 04 00 f2 00 25",
        "16 00 04 00 f2 00 25",
        {"and_mask": 0xF2, "or_mask": 0x25},
    ),
    (
        ReadWriteMultipleRegistersRequest(
            read_address=3, read_count=6, write_address=14, write_registers=[255, 255, 255]
        ),
        "17 00 03 00 06 00 0e 00 03 06 00 ff 00 ff 00 ff",
        "17 0c 00 fe 0a cd 00 01 00 03 00 0d 00 ff",
        {"registers": [0xFE, 0xACD, 1, 3, 13, 255]},
    ),
]


@pytest.mark.parametrize(
    ("request_", "sent", "reply", "values"), EXAMPLES, ids=[row[1][:2] for row in EXAMPLES]
)
def test_each_function_by_the_standards_example(
    request_: ModbusPDU, sent: str, reply: str, values: dict[str, object]
) -> None:
    with line_to(lambda number, _: [framed(number, reply)]) as (line, peer):
        answer = line.ask(7, request_)
        assert {name: getattr(answer, name) for name in values} == values
        line.ask(7, request_)
    assert peer.heard == [bytes.fromhex(sent)] * 2
    assert peer.connections == 1


def read() -> ModbusPDU:
    return ReadHoldingRegistersRequest(address=0, count=2)


def write() -> ModbusPDU:
    return WriteSingleRegisterRequest(address=5, registers=[7])


READ, OTHER, WRITE = "03 04 00 01 00 02", "03 04 00 01 00 09", "06 00 05 00 07"
BAD: dict[str, tuple[Callable[[], ModbusPDU], Answers]] = {
    "another function": (read, lambda number, _: [framed(number, "04 04 00 01 00 02")]),
    "fewer registers": (read, lambda number, _: [framed(number, "03 02 00 01")]),
    "more registers": (read, lambda number, _: [framed(number, "03 06 00 01 00 02 00 03")]),
    "a byte behind the data": (read, lambda number, _: [framed(number, READ + " 00")]),
    "half a register": (read, lambda number, _: [framed(number, "03 03 00 01 00")]),
    "a byte count beyond the frame": (read, lambda number, _: [framed(number, "03 08 00 01 00 02")]),
    "the echo of another address": (write, lambda number, _: [framed(number, "06 00 06 00 07")]),
    "the echo of another value": (write, lambda number, _: [framed(number, "06 00 05 00 08")]),
    "an echo with a byte behind it": (write, lambda number, _: [framed(number, WRITE + " 00")]),
    "another function's exception": (read, lambda number, _: [framed(number, "86 02")]),
    "an exception with a byte behind it": (read, lambda number, _: [framed(number, "83 02 00")]),
    "an exception without a code": (read, lambda number, _: [framed(number, "83")]),
    "transaction 0": (read, lambda _, __: [framed(0, READ)]),
}


@pytest.mark.parametrize("fault", BAD)
def test_what_is_no_answer_to_the_request_is_not_taken_for_it(fault: str) -> None:
    request, answers = BAD[fault]
    with line_to(answers) as (line, peer):
        for _ in range(2):  # each on a connection of its own: nothing of the first is left
            with pytest.raises(BadResponseError) as bad:
                line.ask(7, request())
            assert bad.value.received
    assert (len(peer.heard), peer.connections) == (2, 2)


MISSING: dict[str, Answers] = {
    "silence": lambda _, __: [],
    "another unit": lambda number, _: [framed(number, READ, unit=8)],
    "another protocol": lambda number, _: [framed(number, READ, protocol=1)],
    "a byte short": lambda number, _: [framed(number, READ)[:-1]],
    "an older transaction": lambda number, _: [framed(number + 1, READ)],
}


@pytest.mark.parametrize("fault", MISSING)
def test_a_missing_answer_is_awaited_once(fault: str) -> None:
    with line_to(MISSING[fault], 0.05) as (line, peer):
        with pytest.raises(NoAnswerError, match=r"unit 7 does not answer within 0\.05 s"):
            line.ask(7, read())
        assert peer.heard == [bytes.fromhex("03 00 00 00 02")]


RIGHT: dict[str, Answers] = {
    "in pieces": lambda number, _: [framed(number, READ)[at : at + 5] for at in range(0, 13, 5)],
    "after a stale one": lambda number, _: [framed(number + 9, OTHER), framed(number, READ)],
    "after another unit's": lambda number, _: [
        framed(number, READ[:-2] + "09", unit=8) + framed(number, READ)
    ],
}


@pytest.mark.parametrize("case", RIGHT)
def test_the_right_answer_is_found(case: str) -> None:
    with line_to(RIGHT[case]) as (line, _):
        for _ in range(3):
            assert line.ask(7, read()).registers == [1, 2]


def test_an_exception_keeps_the_connection() -> None:
    with line_to(lambda number, pdu: [framed(number, "83 02" if pdu[0] == 3 else WRITE)]) as (line, peer):
        with pytest.raises(
            ModbusExceptionError, match=r"function 03 is refused .* 2: illegal data addr"
        ) as told:
            line.ask(7, read())
        assert told.value.code == 2
        line.ask(7, write())
    assert peer.connections == 1


def test_a_closed_connection_is_opened_again_by_the_next_request() -> None:
    first = iter([True])
    with line_to(lambda number, _: [b"" if next(first, False) else framed(number, READ)]) as (line, peer):
        with pytest.raises(LinkError, match="has closed the connection"):
            line.ask(7, read())
        assert line.ask(7, read()).registers == [1, 2]
    assert peer.connections == 2


def test_a_host_without_a_listener_is_named(capfd: Any) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    with pytest.raises(LinkError, match=rf"127\.0\.0\.1:{port} can't be reached: "):
        ModbusTcpLine("127.0.0.1", port).ask(1, read())
    assert capfd.readouterr() == ("", "")  # pymodbus prints nothing


def test_a_time_out_of_range_is_a_mistake() -> None:
    with pytest.raises(ValueError, match=r"timeout 61 s: must be 0\.01 to 60"):
        ModbusTcpLine("127.0.0.1", 502, 61)
