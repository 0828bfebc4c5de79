"""Modbus requests to a PCL601 and the form of its answers, without address and CRC.

    function  data             good answer               exception
    01 02     first, count     function, bytes, data     function + 80, code
    03 04     first, count     function, bytes, data
    05 06     address, value   the same
    10        first, count ... function, first, count
    11                         function, 5, unit, 4 more

An answer with a correct checksum may still belong to another master's request, or to an
earlier one: function, length, byte count and echo are compared, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from struct import pack

from ...io_images.pcl601 import ROWS, Code, Register
from ...io_images.pcl601.terminals import INPUT_COUNT, OUTPUT_COUNT

READ_COILS, READ_INPUTS, READ_REGISTERS, READ_INPUT_REGISTERS = 0x01, 0x02, 0x03, 0x04
WRITE_COIL, WRITE_REGISTER, WRITE_REGISTERS, REPORT_ID = 0x05, 0x06, 0x10, 0x11
BITS, WORDS = (READ_COILS, READ_INPUTS), (READ_REGISTERS, READ_INPUT_REGISTERS)
COUNTED = (*BITS, *WORDS)
EXCEPTION = 0x80
EXCEPTION_BYTES = 2
ECHO_BYTES = 5
ID_BYTES = 7


def read_outputs() -> bytes:
    """Return the request for all outputs, one bit each."""
    return pack(">BHH", READ_COILS, 0, OUTPUT_COUNT)


def read_inputs() -> bytes:
    """Return the request for all inputs, one bit each."""
    return pack(">BHH", READ_INPUTS, 0, INPUT_COUNT)


def read_input_register() -> bytes:
    """Return the request for the inputs as one word."""
    return pack(">BHH", READ_INPUT_REGISTERS, 0, 1)


def read_registers(first: Register, words: int) -> bytes:
    """Return the request for registers, beginning with the first word of a value."""
    return pack(">BHH", READ_REGISTERS, ROWS[first].address, words)


def write_output(output: int, on: bool) -> bytes:
    """Return the request that switches an output, 1 to 8."""
    return pack(">BHH", WRITE_COIL, output - 1, 0xFF00 if on else 0)


def write_register(register: Register, word: int) -> bytes:
    """Return the request that writes one unsigned word."""
    return pack(">BHH", WRITE_REGISTER, ROWS[register].address, word)


def write_registers(first: Register, words: Sequence[int]) -> bytes:
    """Return the request that writes unsigned words, beginning with the first word of a value."""
    count = len(words)
    return pack(f">BHHB{count}H", WRITE_REGISTERS, ROWS[first].address, count, 2 * count, *words)


def command(code: Code) -> bytes:
    """Return the request that carries out a command code."""
    return write_register(Register.COMMAND, code)


def report_id() -> bytes:
    """Return the request for address and firmware; its answer has no run status, as printed."""
    return bytes((REPORT_ID,))


def answer_bytes(pdu: bytes) -> int:
    """Return the length of a good answer.

    >>> answer_bytes(bytes.fromhex("03 00 0c 00 02")), answer_bytes(bytes.fromhex("06 00 00 00 01"))
    (6, 5)
    """
    if pdu[0] not in COUNTED:
        return ID_BYTES if pdu[0] == REPORT_ID else ECHO_BYTES
    count = int.from_bytes(pdu[3:5], "big")
    return 2 + (2 * count if pdu[0] in WORDS else (count + 7) // 8)


def answer_head(pdu: bytes, unit: int) -> bytes:
    """Return the first bytes of a good answer of `unit`.

    >>> answer_head(bytes.fromhex("03 00 0c 00 02"), 1).hex(" ")
    '03 04'
    """
    if pdu[0] in COUNTED:
        return bytes((pdu[0], answer_bytes(pdu) - 2))
    return bytes((REPORT_ID, ID_BYTES - 2, unit)) if pdu[0] == REPORT_ID else pdu[:ECHO_BYTES]


def low_high(value: int) -> tuple[int, int]:
    """Return a value of 32 bits as its two words, the low one first.

    >>> low_high(100_000), low_high(-1)
    ((34464, 1), (65535, 65535))
    """
    return value & 0xFFFF, value >> 16 & 0xFFFF


def signed_pair(low: int, high: int) -> int:
    """Return the signed value of two words; the inverse of `low_high`."""
    value = low | high << 16
    return value - (1 << 32) if value >> 31 else value
