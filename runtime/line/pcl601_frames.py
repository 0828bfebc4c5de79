"""Requests to a PCL601, Modbus RTU, each with the expected form of its reply."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from struct import unpack

from ...io_images.pcl601 import Code, Register
from . import pcl601_pdus as pdus
from .master import LineRequest, Reply, Verdict
from .rtu import frame, is_frame
from .wire import LineFormat

LINE_FORMAT = LineFormat(38_400, "E")
"""Fixed; the manual's "no start bit, no stop bit" is 11 bits in its own arithmetic."""

AROUND = 3
"""Bytes of a frame around its PDU: address and CRC."""

HEAD = 3
"""Bytes of a read's reply before the data."""


def _read(data: bytes, head: bytes, size: int) -> Reply | Verdict:
    """Read a reply that must begin with `head` and have `size` bytes."""
    refusal = bytes((head[0], head[1] | pdus.EXCEPTION))
    if len(data) == pdus.EXCEPTION_BYTES + AROUND and data.startswith(refusal) and is_frame(data):
        return Reply(data, data[2])
    if len(data) < size:
        return Verdict.UNFINISHED
    if len(data) > size or not data.startswith(head) or not is_frame(data):
        return Verdict.FOREIGN
    return Reply(data)


def _request(unit: int, pdu: bytes) -> LineRequest:
    size = pdus.answer_bytes(pdu) + AROUND
    head = bytes((unit,)) + pdus.answer_head(pdu, unit)
    return LineRequest(frame(unit, pdu), size, partial(_read, head=head, size=size))


def read_registers(unit: int, first: Register, words: int) -> LineRequest:
    """Return the request for registers, beginning with the first word of a value."""
    return _request(unit, pdus.read_registers(first, words))


def read_inputs(unit: int) -> LineRequest:
    """Return the request for the input register."""
    return _request(unit, pdus.read_input_register())


def write_registers(unit: int, first: Register, words: Sequence[int]) -> LineRequest:
    """Return the request that writes unsigned words, beginning with the first word of a value."""
    return _request(unit, pdus.write_registers(first, words))


def write_command(unit: int, code: Code) -> LineRequest:
    """Return the request that carries out a command code.

    >>> write_command(1, Code.GO).frame.hex(" ")
    '01 06 00 00 00 01 48 0a'
    """
    return _request(unit, pdus.command(code))


def write_output(unit: int, output: int, on: bool) -> LineRequest:
    """Return the request that switches an output, 1 to 8."""
    return _request(unit, pdus.write_output(output, on))


def report_id(unit: int) -> LineRequest:
    """Return the request for address and firmware."""
    return _request(unit, pdus.report_id())


def words_of(reply: Reply) -> tuple[int, ...]:
    """Return the words of a read's reply."""
    data = reply.data[HEAD:-2]
    return unpack(f">{len(data) // 2}H", data)
