"""Requests to a PMC006x3s; a reply is one frame and does not identify its instruction."""

from __future__ import annotations

from functools import partial

from scanrack.io_images.pmc006.frame import (
    BAUD,
    FRAME_BYTES,
    REPLY,
    STATE_ERROR,
    UNKNOWN_ERROR,
    command,
    decode,
)
from scanrack.io_images.pmc006.instructions import BY_NAME, Kind

from .master import LineRequest, Reply, Verdict
from .wire import LineFormat

LINE_FORMAT = LineFormat(BAUD)


def _read(data: bytes, unit: int, value: int | None) -> Reply | Verdict:
    """Read a unit's reply; the reply to an instruction that sets a value contains the value."""
    if len(data) < FRAME_BYTES:
        return Verdict.UNFINISHED
    frame = decode(data)
    if frame is None or (frame.second, frame.third) != (REPLY, unit):
        return Verdict.FOREIGN
    errors = (STATE_ERROR, UNKNOWN_ERROR)
    error_code = frame.data if frame.data in errors and frame.data != value else None
    return Reply(data, error_code)


def instruction(unit: int, name: str, value: int = 0) -> LineRequest:
    """Return the request for an instruction, given its name in the summary table.

    >>> instruction(1, "step", 2500).frame.hex(" ")
    'a5 01 73 c4 09 00 00 e6'
    """
    row = BY_NAME[name]
    response = value if row.kind is Kind.SET else None
    return LineRequest(command(unit, row.code, value), FRAME_BYTES, partial(_read, unit=unit, value=response))


def reading(unit: int, name: str) -> LineRequest:
    """Return the request that reads a value; it accepts a reply with any value."""
    row = BY_NAME[name]
    return LineRequest(command(unit, row.code), FRAME_BYTES, partial(_read_value, unit=unit))


def _read_value(data: bytes, unit: int) -> Reply | Verdict:
    reply = _read(data, unit, None)
    return Reply(reply.data) if isinstance(reply, Reply) else reply


def value_of(reply: Reply) -> int:
    """Return a reply's data as a signed 32-bit number."""
    frame = decode(reply.data)
    assert frame is not None
    return frame.data
