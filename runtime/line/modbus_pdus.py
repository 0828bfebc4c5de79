"""Encodes and decodes Modbus PDUs with pymodbus, and checks all decoded PDUs.

    request   bytes -> request_of -> carry out -> reply -> bytes
    answer    bytes -> GuardedDecoder(False) -> mismatch, with the request -> values

pymodbus 3.15 and 3.16 decode more than the standard allows, for example extra bytes after the data, and wrong
byte counts. The guard encodes the decoded PDU again and compares the bytes [Modbus V1.1b3, chapter 6].
pymodbus's `datastore_update` is not used, since it answers functions 05 and 06 by reading the value back.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from struct import error
from typing import Any

from pymodbus.exceptions import ModbusException
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU
from pymodbus.pdu.bit_message import WriteMultipleCoilsRequest
from pymodbus.pdu.register_message import ReadWriteMultipleRegistersRequest, WriteMultipleRegistersRequest
from typing_extensions import override

EXCEPTION = 0x80
EXCEPTION_BYTES = 2
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, FAILURE, DEVICE_BUSY = 1, 2, 3, 4, 6
"""Exception codes [Modbus V1.1b3, chapter 7]."""

WRITE_BITS_MAX, WRITE_WORDS_MAX, WRITE_AND_READ_MAX = 1968, 123, 121
"""Maximum coils for 0Fh, registers for 10h, and registers written by 17h; pymodbus allows more."""


class ModbusRefusedError(ValueError):
    """A refused request, with the exception code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"exception {code:02x}h")
        self.code = code


class GuardedDecoder(DecodePDU):
    """Decodes only what the standard allows.

    Args:
        is_server: whether to decode requests instead of answers.
    """

    @override
    def decode(self, frame: bytes) -> ModbusPDU | None:
        """Decode a PDU; return None if the bytes are not one complete and valid PDU."""
        try:
            kind = self.lookupPduClass(b"\0" + frame)  # in an RTU frame the function is the second byte
            if kind is None:
                return None
            pdu = ExceptionResponse(frame[0]) if kind is ExceptionResponse else kind()
            pdu.decode(frame[1:])
            return pdu if _is_whole(pdu, frame) else None
        except (ModbusException, ValueError, IndexError, error):
            return None


def _is_whole(pdu: ModbusPDU, data: bytes) -> bool:
    """Return whether the bytes encode exactly this PDU, with correct counts."""
    if isinstance(pdu, WriteMultipleCoilsRequest):  # the last byte may contain unused bits
        size = -(-pdu.count // 8)
        return pdu.count <= WRITE_BITS_MAX and pdu.byte_count == size == pdu.data_byte_count
    # Count the registers: encoding repeats the received counts, even if they are wrong.
    if isinstance(pdu, WriteMultipleRegistersRequest):
        pdu.count = len(pdu.registers)
        in_range = 1 <= pdu.count <= WRITE_WORDS_MAX
    elif isinstance(pdu, ReadWriteMultipleRegistersRequest):
        pdu.write_count = len(pdu.write_registers)
        pdu.write_byte_count = 2 * pdu.write_count
        in_range = 1 <= pdu.write_count <= WRITE_AND_READ_MAX
    else:
        in_range = True
    return in_range and encoded(pdu) == data


def encoded(pdu: ModbusPDU) -> bytes:
    """Return a PDU as bytes.

    >>> from pymodbus.pdu import ReadHoldingRegistersRequest
    >>> encoded(ReadHoldingRegistersRequest(address=107, count=3)).hex(" ")
    '03 00 6b 00 03'
    """
    return bytes((pdu.function_code,)) + pdu.encode()


def bits_of(number: int, count: int) -> list[bool]:
    """Return the lowest bits of a number, bit 0 first; this is the inverse of `number_of`."""
    return [bool(number >> index & 1) for index in range(count)]


def number_of(bits: Sequence[bool]) -> int:
    """Return the number that consists of the bits, bit 0 first.

    >>> number_of([True, False, True])
    5
    """
    return sum(bit << index for index, bit in enumerate(bits))


# --- requests

REQUESTS, _REPLIES = GuardedDecoder(True), GuardedDecoder(False)


def request_of(data: bytes, functions: Container[int]) -> ModbusPDU:
    """Decode a request.

    >>> request_of(bytes.fromhex("03 00 6b 00 03"), {3}).count
    3
    >>> encoded(request_of(bytes.fromhex("03 00 6b 00 00"), {3})).hex(" ")
    '83 03'

    Args:
        data: function code and data, at least one byte.
        functions: function codes that the device supports.

    Returns:
        The request, or exception 01h or 03h.
    """
    if data[0] not in functions:
        return ExceptionResponse(data[0], ILLEGAL_FUNCTION)
    return REQUESTS.decode(data) or ExceptionResponse(data[0], ILLEGAL_VALUE)


def carried_out(request: ModbusPDU, carry_out: Callable[[Any], ModbusPDU]) -> ModbusPDU:
    """Carry out a request from `request_of`; return the reply or exception.

    Args:
        carry_out: function that carries out a request and returns its reply; it may raise
            `ModbusRefusedError`.
    """
    if isinstance(request, ExceptionResponse):
        return request
    try:
        return carry_out(request)
    except ModbusRefusedError as refused:
        return ExceptionResponse(request.function_code, refused.code)


def answer_to(request: ModbusPDU, carry_out: Callable[[Any], ModbusPDU]) -> bytes:
    """Carry out a request; return the reply or exception as bytes; see `carried_out`."""
    return encoded(carried_out(request, carry_out))


def reply_with(request: ModbusPDU, values: Sequence[Any]) -> ModbusPDU:
    """Return the reply to a read, with the bits or registers that were read."""
    name = "bits" if request.function_code in _BITS_READ else "registers"
    return _reply_class(request)(**{name: values})


def reply_to_write(request: ModbusPDU) -> ModbusPDU:
    """Return the reply to a write: address and count for several values, otherwise the request itself."""
    if request.function_code in _SEVERAL_WRITTEN:
        return _reply_class(request)(address=request.address, count=request.count)
    return request


def _reply_class(request: ModbusPDU) -> Callable[..., ModbusPDU]:
    kind = _REPLIES.lookupPduClass(bytes((0, request.function_code)))
    assert kind is not None
    return kind


# --- answers

_BITS_READ = (0x01, 0x02)
_SEVERAL_WRITTEN = (0x0F, 0x10)
_WRITES = (0x05, 0x06, *_SEVERAL_WRITTEN, 0x16)
"""Functions whose answer repeats the request, or its address and count."""

_REGISTERS_READ: Mapping[int, str] = {0x03: "count", 0x04: "count", 0x17: "read_count"}
"""The attribute that contains a request's number of registers, by function."""


def answer_bytes(request: ModbusPDU) -> int:
    """Return the length of the PDU of a normal answer.

    >>> from pymodbus.pdu import ReadCoilsRequest, ReadHoldingRegistersRequest
    >>> answer_bytes(ReadHoldingRegistersRequest(count=2)), answer_bytes(ReadCoilsRequest(count=9))
    (6, 4)
    """
    function = request.function_code
    if function in _REGISTERS_READ:
        return 2 + 2 * int(getattr(request, _REGISTERS_READ[function]))
    if function in _BITS_READ:
        return 2 + -(-request.count // 8)
    return 5 if function in _SEVERAL_WRITTEN else len(encoded(request))


def refusal(request: ModbusPDU, answer: ModbusPDU | None) -> int | None:
    """Return the exception code if the answer is an exception for the request, else None."""
    if isinstance(answer, ExceptionResponse) and answer.function_code == request.function_code | EXCEPTION:
        return answer.exception_code
    return None


def mismatch(request: ModbusPDU, answer: ModbusPDU) -> str:
    """Return the reason why a normal answer does not match the request, or "" if it matches."""
    function = request.function_code
    if answer.function_code != function:
        return "a response to a different request"
    if function in _REGISTERS_READ:
        is_wrong = len(answer.registers) != getattr(request, _REGISTERS_READ[function])
    else:
        is_wrong = function in _BITS_READ and len(answer.bits) != -(-request.count // 8) * 8
    if is_wrong:
        return "an answer with a wrong byte count"
    if function in _WRITES and not request.encode().startswith(answer.encode()):
        return "an answer to another write"
    return ""
