"""Requests to a PCL601 over Modbus RTU, each with a function that reads its reply."""

from __future__ import annotations

from functools import partial

from pymodbus.pdu import ModbusPDU

from . import pcl601_pdus as pdus
from .master import LineRequest, Reply, Verdict
from .modbus_pdus import EXCEPTION_BYTES, answer_bytes, encoded, refusal
from .rtu import frame, is_frame
from .wire import LineFormat

LINE_FORMAT = LineFormat(38_400, "E")
"""The fixed line format; the manual says "no start bit, no stop bit", but calculates with 11 bits."""

FRAME_OVERHEAD = 3


def _read(data: bytes, request: ModbusPDU, size: int) -> Reply | Verdict:
    """Read a reply: an exception, or an answer with `size` bytes."""
    if len(data) in (EXCEPTION_BYTES + FRAME_OVERHEAD, size) and data[0] == request.dev_id and is_frame(data):
        answer = pdus.ANSWERS.decode(data[1:-2])
        if (code := refusal(request, answer)) is not None:
            return Reply(data, code)
        if answer is not None and pdus.is_answer(request, answer):
            return Reply(data, words=tuple(answer.registers))
    return Verdict.UNFINISHED if len(data) < size else Verdict.FOREIGN


def request(unit: int, pdu: ModbusPDU) -> LineRequest:
    """Return a request from `pcl601_pdus` to a unit with the size and the reader of its reply.

    The unit is also set in `pdu`.

    >>> from scanrack.io_images.pcl601 import Code
    >>> request(1, pdus.command(Code.GO)).frame.hex(" ")
    '01 06 00 00 00 01 48 0a'
    """
    pdu.dev_id = unit
    reply_bytes = pdus.ID_BYTES if pdu.function_code == pdus.REPORT_ID else answer_bytes(pdu)
    reply_size = FRAME_OVERHEAD + reply_bytes
    return LineRequest(frame(unit, encoded(pdu)), reply_size, partial(_read, request=pdu, size=reply_size))
