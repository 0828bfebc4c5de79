"""What exchanges say of a controller, by name: registers and terminals, parameters of a PMC006."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ...io_images.pcl601 import WORD_COUNT, WORDS
from ...io_images.pmc006.frame import STATE_ERROR, UNKNOWN_ERROR
from ...io_images.pmc006.instructions import BY_CODE, Kind
from ...runtime.line import pcl601_pdus as pdus
from ...traces.format.tagplan import Tag
from .pairing import PairedExchange

Values = dict[str, int]


def pcl601_says(exchange: PairedExchange, words: dict[int, int]) -> Values:
    """Return what an exchange says of a PCL601.

    Args:
        words: the register words said so far, by address; it is brought up to date.
    """
    request, reply = exchange.request, exchange.reply
    if reply is None or not reply or reply[0] & pdus.EXCEPTION or reply[0] != request[0] or len(request) < 5:
        return {}
    first, second = int.from_bytes(request[1:3], "big"), int.from_bytes(request[3:5], "big")
    if reply[0] in (pdus.READ_COILS, pdus.READ_INPUTS):
        return _bits(reply, first)
    if reply[0] == pdus.READ_INPUT_REGISTERS and len(reply) >= 4:
        return {"inputs": int.from_bytes(reply[2:4], "big")}
    written: Mapping[int, int] = {}
    if reply[0] == pdus.READ_REGISTERS:
        written = _numbered(first, reply[2:])
    elif reply[0] == pdus.WRITE_REGISTER:
        written = {first: second}
    elif reply[0] == pdus.WRITE_REGISTERS:
        written = _numbered(first, request[6:])
    known = {address: word for address, word in written.items() if address < WORD_COUNT}
    words.update(known)
    return _registers(known, words)


def _numbered(first: int, data: bytes) -> Mapping[int, int]:
    return {first + at // 2: int.from_bytes(data[at : at + 2], "big") for at in range(0, len(data) - 1, 2)}


def _bits(reply: bytes, first: int) -> Values:
    name = "outputs" if reply[0] == pdus.READ_COILS else "inputs"
    return {name: int.from_bytes(reply[2:], "little")} if first == 0 else {}


def _registers(known: Mapping[int, int], words: Mapping[int, int]) -> Values:
    values: Values = {}
    for address in known:
        row, high = WORDS[address]
        at = address - high
        value = words.get(at, 0)
        if row.words == 2:
            value = pdus.signed_pair(value, words.get(at + 1, 0))
        values[row.register.name.lower()] = value
    return values


def pmc006_says(exchange: PairedExchange, _words: dict[int, int]) -> Values:
    """Return what an exchange says of a PMC006: the value that an instruction sets or reads."""
    row = BY_CODE.get(exchange.request[0])
    if row is None or exchange.reply is None or row.kind is Kind.ACTION:
        return {}
    asked = int.from_bytes(exchange.request[1:5], "little", signed=True)
    value = int.from_bytes(exchange.reply, "little", signed=True)
    if row.kind is Kind.SET and value in (STATE_ERROR, UNKNOWN_ERROR) and value != asked:
        return {}  # refused
    return {row.name: value}


SAYS: Mapping[str, Callable[[PairedExchange, dict[int, int]], Values]] = {
    "pcl601": pcl601_says,
    "pmc006": pmc006_says,
}
"""By controller."""

ALWAYS = (
    Tag("reply_ms", "LREAL"),
    Tag("function", "USINT"),
    Tag("exception", "USINT"),
    Tag("answered", "BOOL"),
)
"""Tags of each exchange: Modbus function or instruction, exception of Modbus, time to the reply."""


def tag_of(name: str) -> Tag:
    """Return the tag of a value, 32 bits: all of them fit."""
    return Tag(name, "DINT")
