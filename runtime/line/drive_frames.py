"""Requests to a networked drive over Modbus TCP, each with a function that reads its reply.

A reply is matched to its request by transaction, unit and function, so a late reply is never matched to
another request.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu import register_message as registers

from .clients.link import LinkError
from .clients.modbus import AnswerDecoder, ModbusExceptionError, check
from .master import LineRequest, Reply, Verdict
from .modbus_pdus import answer_bytes, encoded
from .ports.modbustcp import HEADER, NotModbusError, split_frames

WORDS = 10
OUTPUTS = 1024
"""The first output register."""

RESPONSES = AnswerDecoder()


def _read(data: bytes, request: ModbusPDU) -> Reply | Verdict:
    """Find the reply to a request in the received frames."""
    try:
        frames, _ = split_frames(data)
    except NotModbusError:
        return Verdict.FOREIGN
    for frame in frames:
        transaction, _, _, unit = HEADER.unpack_from(frame)
        if transaction != request.transaction_id:
            continue
        try:
            response = RESPONSES.decode(frame[HEADER.size :])
            response.transaction_id, response.dev_id = transaction, unit
            return Reply(frame, words=tuple(check(request, response).registers))
        except ModbusExceptionError as error:
            return Reply(frame, error.code)
        except LinkError:
            return Verdict.FOREIGN
    return Verdict.UNFINISHED


def _request(unit: int, transaction: int, pdu: ModbusPDU) -> LineRequest:
    pdu.dev_id, pdu.transaction_id = unit, transaction
    data = encoded(pdu)
    frame = HEADER.pack(transaction, 0, len(data) + 1, unit) + data
    return LineRequest(frame, HEADER.size + answer_bytes(pdu), partial(_read, request=pdu))


def exchange(unit: int, transaction: int, axis: int, words: Sequence[int]) -> LineRequest:
    """Return the request that reads ten words and then writes ten words (function 23).

    >>> exchange(1, 2, 1, [0] * 10).frame[:13].hex(" ")
    '00 02 00 00 00 1f 01 17 00 00 00 0a 04'

    Args:
        axis: number of the axis in the stack, from 1.
        words: the ten words to write, unsigned.
    """
    first_word = WORDS * (axis - 1)
    pdu = registers.ReadWriteMultipleRegistersRequest(
        read_address=first_word,
        read_count=WORDS,
        write_address=OUTPUTS + first_word,
        write_registers=list(words),
    )
    return _request(unit, transaction, pdu)


def read(unit: int, transaction: int, axis: int) -> LineRequest:
    """Return the request that reads ten words (function 4)."""
    pdu = registers.ReadInputRegistersRequest(address=WORDS * (axis - 1), count=WORDS)
    return _request(unit, transaction, pdu)
