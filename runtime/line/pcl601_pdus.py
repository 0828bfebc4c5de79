"""Modbus requests to a PCL601, and its answer to function 11h.

An answer with a correct checksum can still belong to another master's request, or to an earlier request, so
function, length, byte count and echo are also compared.
"""

from __future__ import annotations

from collections.abc import Sequence

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu import bit_message as bits
from pymodbus.pdu import register_message as words
from pymodbus.pdu.other_message import ReportDeviceIdRequest, ReportDeviceIdResponse
from scanrack.io_images.pcl601 import ROWS, Code, Register
from scanrack.io_images.pcl601.terminals import INPUT_COUNT, OUTPUT_COUNT
from typing_extensions import override

from .modbus_pdus import GuardedDecoder, mismatch

READ_COILS, READ_INPUTS, READ_REGISTERS, READ_INPUT_REGISTERS = 0x01, 0x02, 0x03, 0x04
WRITE_REGISTERS, REPORT_ID = 0x10, 0x11
READS = (READ_COILS, READ_INPUTS, READ_REGISTERS, READ_INPUT_REGISTERS, REPORT_ID)
ID_BYTES = 7
"""Length of the PDU that answers function 11h."""


class Pcl601Identity(ReportDeviceIdResponse):
    """Address and firmware [Appendix 3, 0x11].

    This is a subclass because pymodbus adds the standard's run status at the end, which the manual does not
    show.
    """

    @override
    def encode(self) -> bytes:
        """Return the byte count, address and firmware."""
        return bytes((len(self.identifier),)) + self.identifier

    @override
    def decode(self, data: bytes) -> None:
        """Store everything after the byte count."""
        self.identifier = data[1:]


ANSWERS = GuardedDecoder(False)
"""Decodes the answers of a PCL601."""
ANSWERS.register(Pcl601Identity)


def is_answer(request: ModbusPDU, answer: ModbusPDU) -> bool:
    """Return whether a normal answer matches the request; an answer to 11h also contains the unit."""
    if isinstance(answer, Pcl601Identity) and answer.identifier[:1] != bytes((request.dev_id,)):
        return False
    return not mismatch(request, answer)


def read_outputs() -> ModbusPDU:
    """Return the request for all outputs, one bit each."""
    return bits.ReadCoilsRequest(address=0, count=OUTPUT_COUNT)


def read_inputs() -> ModbusPDU:
    """Return the request for all inputs, one bit each."""
    return bits.ReadDiscreteInputsRequest(address=0, count=INPUT_COUNT)


def read_input_register() -> ModbusPDU:
    """Return the request for the inputs as one word."""
    return words.ReadInputRegistersRequest(address=0, count=1)


def read_registers(first: Register, count: int) -> ModbusPDU:
    """Return the request that reads `count` words, starting with the first word of a register."""
    return words.ReadHoldingRegistersRequest(address=ROWS[first].address, count=count)


def write_output(output: int, is_on: bool) -> ModbusPDU:
    """Return the request that switches an output, 1 to 8, on or off."""
    return bits.WriteSingleCoilRequest(address=output - 1, bits=[is_on])


def write_register(register: Register, word: int) -> ModbusPDU:
    """Return the request that writes one unsigned word."""
    return words.WriteSingleRegisterRequest(address=ROWS[register].address, registers=[word])


def write_registers(first: Register, values: Sequence[int]) -> ModbusPDU:
    """Return the request that writes unsigned words, starting with the first word of a register."""
    return words.WriteMultipleRegistersRequest(address=ROWS[first].address, registers=list(values))


def command(code: Code) -> ModbusPDU:
    """Return the request that carries out a command code."""
    return write_register(Register.COMMAND, code)


def report_id() -> ModbusPDU:
    """Return the request for address and firmware."""
    return ReportDeviceIdRequest()


def low_high(value: int) -> tuple[int, int]:
    """Return a 32-bit value as two words, the low word first.

    >>> low_high(100_000), low_high(-1)
    ((34464, 1), (65535, 65535))
    """
    return value & 0xFFFF, value >> 16 & 0xFFFF


def signed_pair(low: int, high: int) -> int:
    """Return the signed value of two words; this is the inverse of `low_high`."""
    value = low | high << 16
    return value - (1 << 32) if value >> 31 else value
