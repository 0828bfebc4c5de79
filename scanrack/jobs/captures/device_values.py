"""Named values in exchanges with a controller: registers, inputs and outputs, parameters of a PMC006."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from scanrack.io_images.pcl601 import WORD_COUNT, WORDS
from scanrack.io_images.pmc006.frame import STATE_ERROR, UNKNOWN_ERROR
from scanrack.io_images.pmc006.instructions import BY_CODE, Kind
from scanrack.runtime.line import pcl601_pdus as pdus
from scanrack.runtime.line.modbus_pdus import number_of
from scanrack.traces.format.tagplan import Tag

from .pairing import PairedExchange, decoded

Values = dict[str, int]


def pcl601_values(exchange: PairedExchange, words: dict[int, int]) -> Values:
    """Return the values of a PCL601 that an exchange shows.

    Args:
        words: the known register words, by address; this call updates them.
    """
    pair = decoded(exchange)
    if pair is None:
        return {}
    request, reply = pair
    function, first = request.function_code, request.address
    if function in (pdus.READ_COILS, pdus.READ_INPUTS):
        name = "outputs" if function == pdus.READ_COILS else "inputs"
        return {name: number_of(reply.bits)} if first == 0 else {}
    if function == pdus.READ_INPUT_REGISTERS:
        return {"inputs": reply.registers[0]}
    message = reply if function == pdus.READ_REGISTERS else request
    read_words = {
        address: word for address, word in enumerate(message.registers, first) if address < WORD_COUNT
    }
    words.update(read_words)
    return _register_values(read_words, words)


def _register_values(addresses: Iterable[int], words: Mapping[int, int]) -> Values:
    """Return the values of the registers at the given word addresses, by name."""
    values: Values = {}
    for address in addresses:
        row, high = WORDS[address]
        offset = address - high
        value = words.get(offset, 0)
        if row.words == 2:
            value = pdus.signed_pair(value, words.get(offset + 1, 0))
        values[row.register.name.lower()] = value
    return values


def pmc006_values(exchange: PairedExchange, _words: dict[int, int]) -> Values:
    """Return the value of a PMC006 that an instruction sets or reads."""
    row = BY_CODE.get(exchange.request[0])
    if row is None or exchange.reply is None or row.kind is Kind.ACTION:
        return {}
    requested = int.from_bytes(exchange.request[1:5], "little", signed=True)
    value = int.from_bytes(exchange.reply, "little", signed=True)
    if row.kind is Kind.SET and value in (STATE_ERROR, UNKNOWN_ERROR) and value != requested:
        return {}  # the instruction was refused
    return {row.name: value}


VALUES: Mapping[str, Callable[[PairedExchange, dict[int, int]], Values]] = {
    "pcl601": pcl601_values,
    "pmc006": pmc006_values,
}
"""Functions that extract values, by controller."""

ALWAYS = (
    Tag("reply_ms", "LREAL"),
    Tag("function", "USINT"),
    Tag("exception", "USINT"),
    Tag("answered", "BOOL"),
)
"""Tags of each exchange: time to the reply, Modbus function or instruction, Modbus exception."""
