"""Requests to a PCL601, Modbus RTU, each with what its reply has to look like.

A reply that passes the checksum may still be to somebody else's request, or a
late one to an earlier one: address, function, count and echo are compared, too.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from functools import partial

from pymodbus.framer import FramerRTU

from ...io_images.pcl601 import ROWS, Code, Register
from .master import Reply, Request, Verdict
from .wire import LineFormat

LINE_FORMAT = LineFormat(38_400, "E")
"""Fixed; the manual's "no start bit, no stop bit" is 11 bits in its own arithmetic."""

READ_REGISTERS, READ_INPUTS, WRITE_COIL, WRITE_REGISTER = 0x03, 0x04, 0x05, 0x06
WRITE_REGISTERS, REPORT_ID = 0x10, 0x11
EXCEPTION = 0x80
EXCEPTION_SIZE = 5
ECHO_SIZE = 8
ID_SIZE = 10
HEAD = 3
"""Bytes of a read's reply before the data."""


def _with_checksum(body: bytes) -> bytes:
    return body + struct.pack(">H", FramerRTU.compute_CRC(body))


def _is_whole(frame: bytes) -> bool:
    return _with_checksum(frame[:-2]) == frame


def _read(data: bytes, head: bytes, size: int) -> Reply | Verdict:
    """Read a reply that has to begin with `head` and to be `size` long."""
    refusal = bytes((head[0], head[1] | EXCEPTION))
    if len(data) == EXCEPTION_SIZE and data.startswith(refusal) and _is_whole(data):
        return Reply(data, data[2])
    if len(data) < size:
        return Verdict.UNFINISHED
    if len(data) > size or not data.startswith(head) or not _is_whole(data):
        return Verdict.FOREIGN
    return Reply(data)


def _request(body: bytes, head: bytes, size: int) -> Request:
    return Request(_with_checksum(body), size, partial(_read, head=head, size=size))


def read_registers(unit: int, first: Register, words: int) -> Request:
    """Return the request for registers from the first of a value on."""
    body = struct.pack(">BBHH", unit, READ_REGISTERS, ROWS[first].address, words)
    return _request(body, bytes((unit, READ_REGISTERS, 2 * words)), HEAD + 2 * words + 2)


def read_inputs(unit: int) -> Request:
    """Return the request for the input register."""
    body = struct.pack(">BBHH", unit, READ_INPUTS, 0, 1)
    return _request(body, bytes((unit, READ_INPUTS, 2)), HEAD + 4)


def write_registers(unit: int, first: Register, words: Sequence[int]) -> Request:
    """Return the request that writes words, unsigned, from the first of a value on."""
    address, count = ROWS[first].address, len(words)
    head = struct.pack(">BBHH", unit, WRITE_REGISTERS, address, count)
    return _request(head + struct.pack(f">B{count}H", 2 * count, *words), head, ECHO_SIZE)


def write_command(unit: int, code: Code) -> Request:
    """Return the request that has a command code carried out.

    >>> write_command(1, Code.GO).frame.hex(" ")
    '01 06 00 00 00 01 48 0a'
    """
    body = struct.pack(">BBHH", unit, WRITE_REGISTER, ROWS[Register.COMMAND].address, code)
    return _request(body, body, ECHO_SIZE)


def write_output(unit: int, output: int, on: bool) -> Request:
    """Return the request that switches an output, 1 to 8."""
    body = struct.pack(">BBHH", unit, WRITE_COIL, output - 1, 0xFF00 if on else 0)
    return _request(body, body, ECHO_SIZE)


def report_id(unit: int) -> Request:
    """Return the request for address and firmware; its reply has no run status, as printed."""
    return _request(bytes((unit, REPORT_ID)), bytes((unit, REPORT_ID, 5, unit)), ID_SIZE)


def low_high(value: int) -> tuple[int, int]:
    """Return a value of 32 bits as its two words, the low one first.

    >>> low_high(100_000), low_high(-1)
    ((34464, 1), (65535, 65535))
    """
    return value & 0xFFFF, value >> 16 & 0xFFFF


def words_of(reply: Reply) -> tuple[int, ...]:
    """Return the words of a read's reply."""
    data = reply.data[HEAD:-2]
    return struct.unpack(f">{len(data) // 2}H", data)


def signed_pair(low: int, high: int) -> int:
    """Return what two words hold, as `low_high` splits it."""
    value = low | high << 16
    return value - (1 << 32) if value >> 31 else value
