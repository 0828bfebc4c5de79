"""A Modbus master that accepts only the answer to its own request.

    RTU    unit, PDU, CRC                                      serial line, or its bytes over TCP
    TCP    transaction, 0, length, unit, PDU                   Modbus TCP, in `modbus_tcp`

It checks the CRC, unit, function and byte count; in the answer to a write, it also checks the address and the
value or quantity. It never repeats a request.
"""

from __future__ import annotations

from threading import Event
from typing import Protocol

from pymodbus.pdu import ModbusPDU
from typing_extensions import override

from ..modbus_pdus import EXCEPTION, EXCEPTION_BYTES, GuardedDecoder, answer_bytes, encoded, mismatch, refusal
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

MEANINGS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "server device failure",
    5: "acknowledge",
    6: "server device busy",
    8: "memory parity error",
    10: "gateway path unavailable",
    11: "gateway target device failed to respond",
}
"""Names of exceptions by code [Modbus V1.1b3, chapter 7]."""


class ModbusExceptionError(RefusedError):
    """The device answered with an exception.

    Attributes:
        function: function code of the request.
        code: exception code.
    """

    def __init__(self, function: int, code: int, meaning: str | None = None) -> None:
        meaning = meaning or MEANINGS.get(code, "not in the standard")
        super().__init__(f"function {function:02x} is refused with exception {code}: {meaning}")
        self.function, self.code = function, code


class AnswerDecoder(GuardedDecoder):
    """Decodes answers; raises BadResponseError for bytes that are not an answer."""

    def __init__(self) -> None:
        super().__init__(is_server=False)

    @override
    def decode(self, frame: bytes) -> ModbusPDU:
        """Decode a PDU."""
        pdu = super().decode(frame)
        if pdu is None:
            raise BadResponseError("a damaged answer", frame)
        return pdu


def check(request: ModbusPDU, answer: ModbusPDU) -> ModbusPDU:
    """Return the answer if it matches its request in transaction, unit, function, count, address and value.

    Raises:
        BadResponseError: the answer does not match the request.
        ModbusExceptionError: the answer is an exception.
    """
    if (answer.transaction_id, answer.dev_id) != (request.transaction_id, request.dev_id):
        raise BadResponseError("a response to a different request", encoded(answer))
    if (code := refusal(request, answer)) is not None:
        raise ModbusExceptionError(request.function_code, code)
    if difference := mismatch(request, answer):
        raise BadResponseError(difference, encoded(answer))
    return answer


class ModbusLine(Protocol):
    """Carries a request to a unit and its answer back."""

    def ask(self, unit: int, request: ModbusPDU) -> ModbusPDU:
        """Send the request once; return the answer.

        Raises:
            LinkError: the answer is missing, belongs to another request, or is an exception.
        """

    def pause(self, seconds: float) -> None:
        """Wait."""
        Event().wait(seconds)

    def close(self) -> None:
        """Release the line."""


class RtuLine(ModbusLine):
    """Modbus RTU over a link.

    Args:
        answer_s: longest wait for an answer, 0.01 to 60 s.
    """

    def __init__(self, link: Link, answer_s: float = ANSWER_S) -> None:
        self._decoder = AnswerDecoder()
        self._link = link
        self._answer_s = checked_answer_s(answer_s)
        self._quiet_s = SILENCE_S  # silence before the next request, longer after a missing answer

    @override
    def ask(self, unit: int, request: ModbusPDU) -> ModbusPDU:
        """Send the request after a silence; return the answer.

        After a missing or damaged answer, the next request waits longer, since the answer may be late.
        """
        request.dev_id = unit
        size = answer_bytes(request)
        drain(self._link, self._quiet_s)
        self._quiet_s = self._answer_s + LATE_S
        self._link.send(frame(unit, encoded(request)))
        pdu = self._receive(unit, size)
        is_complete = pdu[0] & EXCEPTION or len(pdu) == size
        if is_complete:
            self._quiet_s = SILENCE_S
        answer = self._decoder.decode(pdu)
        answer.dev_id = unit
        return check(request, answer)

    @override
    def pause(self, seconds: float) -> None:
        self._link.pause(seconds)

    @override
    def close(self) -> None:
        self._link.close()

    def _receive(self, unit: int, size: int) -> bytes:
        """Return the PDU of an answer, which is `size` bytes or as long as an exception."""
        bytes_minimum = 1 + EXCEPTION_BYTES + 2
        pdu = self._link.receive(bytes_minimum, self._answer_s)
        if len(pdu) == bytes_minimum and not pdu[1] & EXCEPTION:
            pdu += self._link.receive(1 + size + 2 - bytes_minimum, self._answer_s)
        if len(pdu) < bytes_minimum:
            raise NoAnswerError(f"unit {unit} does not answer within {self._answer_s:g} s", pdu)
        if crc(pdu[:-2]) != pdu[-2:]:
            raise BadResponseError(f"a damaged answer from unit {unit}", pdu)
        if pdu[0] != unit:
            raise BadResponseError(f"a response from unit {pdu[0]}, not {unit}", pdu)
        return pdu[1:-2]
