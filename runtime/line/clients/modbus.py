"""A Modbus master that accepts only possible answers to its request.

    RTU    unit, PDU, CRC                                      serial line, or its bytes over TCP
    TCP    transaction, 0, length, unit, PDU                   Modbus TCP

It checks CRC, unit, function, byte count, and in the answer to a write its address and its
value or quantity. Nothing is repeated here.
"""

from __future__ import annotations

from struct import Struct
from typing import Protocol

from typing_extensions import override

from ..pcl601_pdus import COUNTED, EXCEPTION, EXCEPTION_BYTES, answer_bytes, answer_head
from ..rtu import crc, frame
from .link import (
    ANSWER_S,
    LATE_S,
    SILENCE_S,
    BadResponseError,
    Link,
    NoAnswerError,
    RefusedError,
    checked_answer_s,
    drain,
)

EXCEPTIONS = {
    1: "it does not know the function",
    2: "no such register, or it can't be written",
    3: "the value is out of range",
    6: "a program is running, or the register is locked while the motor moves",
}

_HEADER = Struct(">HHHB")


def check_answer(pdu: bytes, answer: bytes) -> bytes:
    """Return the data of an answer, without function and byte count.

    Raises:
        BadResponseError: it does not match the request.
        RefusedError: it is an exception.
    """
    if len(answer) == EXCEPTION_BYTES and answer[0] == pdu[0] | EXCEPTION:
        meaning = EXCEPTIONS.get(answer[1], "not one of its own")
        raise RefusedError(f"function {pdu[0]:02x} is refused with exception {answer[1]}: {meaning}")
    if answer[:1] != pdu[:1] or len(answer) != answer_bytes(pdu):
        raise BadResponseError("a response to a different request", answer)
    reading = pdu[0] in COUNTED
    if not answer.startswith(answer_head(pdu, unit=0)):
        what = "an answer with a wrong byte count" if reading else "an answer to another write"
        raise BadResponseError(what, answer)
    return answer[2:] if reading else b""


class ModbusLine(Protocol):
    """Carries a request to a unit and its answer back."""

    def ask(self, unit: int, pdu: bytes) -> bytes:
        """Ask once; return the data of the answer.

        Raises:
            LinkError: no answer, one that does not match, or an exception.
        """

    def pause(self, seconds: float) -> None:
        """Wait."""


class RtuLine(ModbusLine):
    """Modbus RTU over a link.

    Args:
        answer_s: how long an answer may take, 0.01 to 60 s.
    """

    def __init__(self, link: Link, answer_s: float = ANSWER_S) -> None:
        self._link = link
        self._answer_s = checked_answer_s(answer_s)
        self._quiet_s = SILENCE_S

    @override
    def ask(self, unit: int, pdu: bytes) -> bytes:
        drain(self._link, self._quiet_s)
        self._quiet_s = self._answer_s + LATE_S
        self._link.send(frame(unit, pdu))
        answer = self._received(unit, pdu)
        if answer[0] & EXCEPTION or len(answer) == answer_bytes(pdu):
            self._quiet_s = SILENCE_S
        return check_answer(pdu, answer)

    @override
    def pause(self, seconds: float) -> None:
        self._link.pause(seconds)

    def _received(self, unit: int, pdu: bytes) -> bytes:
        least = 1 + EXCEPTION_BYTES + 2
        received = self._link.receive(least, self._answer_s)
        if len(received) == least and not received[1] & EXCEPTION:
            received += self._link.receive(1 + answer_bytes(pdu) + 2 - least, self._answer_s)
        if len(received) < least:
            raise NoAnswerError(f"unit {unit} does not answer within {self._answer_s:g} s", received)
        if crc(received[:-2]) != received[-2:]:
            raise BadResponseError(f"a damaged answer from unit {unit}", received)
        if received[0] != unit:
            raise BadResponseError(f"a response from unit {received[0]}, not {unit}", received)
        return received[1:-2]


class TcpLine(ModbusLine):
    """Modbus TCP over a link; answers to earlier requests are recognized by their transaction and dropped.

    Args:
        answer_s: how long an answer may take, 0.01 to 60 s.
    """

    def __init__(self, link: Link, answer_s: float = ANSWER_S) -> None:
        self._link = link
        self._answer_s = checked_answer_s(answer_s)
        self._transaction = 0

    @override
    def ask(self, unit: int, pdu: bytes) -> bytes:
        self._transaction = (self._transaction + 1) & 0xFFFF
        self._link.send(_HEADER.pack(self._transaction, 0, len(pdu) + 1, unit) + pdu)
        while True:
            header = self._link.receive(_HEADER.size, self._answer_s)
            if len(header) < _HEADER.size:
                raise NoAnswerError(f"unit {unit} does not answer within {self._answer_s:g} s", header)
            transaction, protocol, length, from_unit = _HEADER.unpack(header)
            answer = self._link.receive(max(0, length - 1), self._answer_s)
            if protocol != 0 or len(answer) != length - 1:
                raise BadResponseError("no Modbus TCP", header + answer)
            if (transaction, from_unit) == (self._transaction, unit):
                return check_answer(pdu, answer)

    @override
    def pause(self, seconds: float) -> None:
        self._link.pause(seconds)
