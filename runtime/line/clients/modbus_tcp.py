"""A client for a Modbus TCP device: pymodbus's client, plus a check of every answer against its request.

pymodbus 3.15 to 3.16 accepts an answer with the wrong function, number of registers, echoed address or echoed
value, and repeats a request three times. This client never repeats a request, so a write that starts a motion
is sent once.
"""

from __future__ import annotations

import logging
import socket
from queue import Empty, SimpleQueue

from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ConnectionException, ModbusException
from pymodbus.pdu import ModbusPDU
from typing_extensions import override

from ..hosts import join_address
from ..modbus_pdus import EXCEPTION, REQUESTS, encoded
from ..ports.modbustcp import HEADER, reply_frame, split_frames
from ..wire import LineFormat
from .link import ANSWER_S, Link, LinkError, NoAnswerError, checked_answer_s
from .modbus import AnswerDecoder, ModbusExceptionError, ModbusLine, check

CONNECT_S = 3.0
"""Longest wait for a connection, s."""

logging.getLogger("pymodbus").addHandler(logging.NullHandler())  # this client raises failures instead


class ModbusTcpLine(ModbusLine):
    """A connection to a Modbus TCP device, for one request at a time.

    It connects at the first request, and again at the first request after a failure, so that it never
    mistakes bytes of a failed exchange for an answer.

    Args:
        answer_s: longest wait for an answer, 0.01 to 60 s.

    Raises:
        ValueError: the time is out of range.
    """

    def __init__(self, host: str, port: int = 502, answer_s: float = ANSWER_S) -> None:
        self._answer_s = checked_answer_s(answer_s)
        self._request = ModbusPDU()
        self._client = _Client(host, port=port, timeout=answer_s, retries=0, trace_pdu=self._check_received)
        self._client.framer.decoder = AnswerDecoder()

    @override
    def ask(self, unit: int, request: ModbusPDU) -> ModbusPDU:
        """Send the request once; return the answer.

        >>> from pymodbus.pdu import ReadHoldingRegistersRequest
        >>> line = ModbusTcpLine("192.168.0.50")
        >>> line.ask(1, ReadHoldingRegistersRequest(address=0, count=2)).registers  # doctest: +SKIP
        [0, 8192]

        Args:
            unit: 0 to 255.
            request: a request from `pymodbus.pdu`.

        Raises:
            ModbusExceptionError: the device refused the request; the connection stays open.
            LinkError: there is no connection, no answer in time, or a wrong answer; the connection is closed.
        """
        self._request, request.dev_id = request, unit
        try:
            return self._client.execute(False, request)
        except ModbusExceptionError:
            raise
        except LinkError:
            self.close()
            raise
        except (ConnectionException, OSError) as error:
            self.close()
            raise LinkError(f"{self._client.name} has closed the connection") from error
        except ModbusException as error:
            self.close()
            raise NoAnswerError(f"unit {unit} does not answer within {self._answer_s:g} s") from error

    def connect(self) -> None:
        """Connect now; raise LinkError if the connection fails."""
        self._client.connect()

    @override
    def close(self) -> None:
        """Close the connection."""
        self._client.close()  # type: ignore[no-untyped-call]

    def _check_received(self, sending: bool, pdu: ModbusPDU) -> ModbusPDU:
        return pdu if sending else check(self._request, pdu)


class ModbusTcpLink(Link):
    """A connection to a Modbus TCP device that acts as a link, for a master that builds its own frames.

    `send` carries out the requests in its frames one after another; `receive` returns the reply frames.

    Raises:
        LinkError: the connection fails.
    """

    def __init__(self, host: str, port: int = 502, answer_s: float = ANSWER_S) -> None:
        self._line = ModbusTcpLine(host, port, answer_s)
        self._line.connect()
        self._reply_frames: SimpleQueue[bytes] = SimpleQueue()

    @override
    def follow(self, line_format: LineFormat) -> None:
        """Do nothing, since a network has no character format."""

    @override
    def send(self, data: bytes) -> None:
        """Send the request, and wait for the answer."""
        frames, _ = split_frames(data)
        for frame in frames:
            unit, pdu = frame[HEADER.size - 1], frame[HEADER.size :]
            request = REQUESTS.decode(pdu)
            assert request is not None
            try:
                answer = encoded(self._line.ask(unit, request))
            except ModbusExceptionError as error:
                answer = bytes((pdu[0] | EXCEPTION, error.code))
            self._reply_frames.put(reply_frame(frame, answer))

    @override
    def receive(self, count: int, seconds: float) -> bytes:
        """Return a complete reply frame as soon as there is one, or b"" after `seconds`."""
        try:
            return self._reply_frames.get(timeout=seconds)
        except Empty:
            return b""

    @override
    def close(self) -> None:
        self._line.close()


class _Client(ModbusTcpClient):
    """A pymodbus client that raises the reason for a failed connection, which pymodbus only logs."""

    @property
    def name(self) -> str:
        """Host and port."""
        return join_address(self.comm_params.host, self.comm_params.port)

    @override
    def connect(self) -> bool:
        """Connect unless the connection exists; return True, or raise a LinkError."""
        if self.socket is None:
            address = self.comm_params.host, self.comm_params.port
            try:
                self.socket = socket.create_connection(address, CONNECT_S)
            except OSError as error:
                raise LinkError(f"{self.name} can't be reached: {error.strerror or error}") from error
            self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return True
