"""The Modbus registers of a stack of drives, as requests and answers without transport [SMD p. 120, p. 121].

    inputs     input registers from 0, also holding registers from 0; discrete inputs from 0
    outputs    holding registers from 1024; coils from 16,384: 16 for each register, bit 0 first

Each axis has ten registers, followed by those of the next axis. The registers of one request act together,
at the instant of the request. Function 23 answers with the data from before its own write. A request is
refused as a whole: 1 for another function, 2 for an address without a register, 3 for a count or value.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import TypeVar

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu import bit_message as bits
from pymodbus.pdu import register_message as words
from scanrack.io_images.drives.models import WORDS

from ...line.modbus_pdus import (
    ILLEGAL_ADDRESS,
    ModbusRefusedError,
    answer_to,
    bits_of,
    number_of,
    request_of,
)
from .drive import DriveUnit

T = TypeVar("T")

OUTPUTS = 1024
"""The first output register."""

COILS = 16 * OUTPUTS
"""The coil of its bit 0."""

REQUESTS_KEPT = 64
"""Maximum decoded requests that are cached: clients repeat the same requests."""


class DriveRegisters:
    """The registers of the axes of a stack.

    Args:
        axes: 1 or more, all advanced to the instant of each request.
    """

    def __init__(self, axes: Sequence[DriveUnit]) -> None:
        self.axes = axes
        self._functions: dict[int, Callable[[ModbusPDU], ModbusPDU]] = {
            1: self._read_coils,
            2: self._read_discrete,
            3: self._read_holding,
            4: self._read_input,
            5: self._write_coil,
            6: self._write_register,
            15: self._write_coils,
            16: self._write_registers,
            22: self._mask_write,
            23: self._write_and_read,
        }
        self._decoded = lru_cache(REQUESTS_KEPT)(partial(request_of, functions=self._functions))

    def answer(self, request: bytes) -> bytes:
        """Carry out a request (function code and data); return the answer or exception."""
        return answer_to(self._decoded(request), self._carry_out)

    def _carry_out(self, request: ModbusPDU) -> ModbusPDU:
        return self._functions[request.function_code](request)

    # reading

    def _inputs(self) -> list[int]:
        return [word & 0xFFFF for axis in self.axes for word in axis.inputs()]

    def _outputs(self) -> list[int]:
        words: list[int] = []
        for axis in self.axes:
            words += axis.words
        return words

    def _holding(self, first: int, count: int) -> list[int]:
        return (
            _part(self._outputs(), first - OUTPUTS, count) if first >= OUTPUTS else self._input(first, count)
        )

    def _input(self, first: int, count: int) -> list[int]:
        return _part(self._inputs(), first, count)

    def _read_coils(self, request: ModbusPDU) -> ModbusPDU:
        coils = _part(_bits(self._outputs()), request.address - COILS, request.count)
        return bits.ReadCoilsResponse(bits=coils)

    def _read_discrete(self, request: ModbusPDU) -> ModbusPDU:
        return bits.ReadDiscreteInputsResponse(
            bits=_part(_bits(self._inputs()), request.address, request.count)
        )

    def _read_holding(self, request: ModbusPDU) -> ModbusPDU:
        return words.ReadHoldingRegistersResponse(registers=self._holding(request.address, request.count))

    def _read_input(self, request: ModbusPDU) -> ModbusPDU:
        return words.ReadInputRegistersResponse(registers=self._input(request.address, request.count))

    # writing

    def _write(self, first: int, values: Sequence[int]) -> None:
        outputs, at = self._outputs(), first - OUTPUTS
        if _part(outputs, at, len(values)) == list(values):
            return
        outputs[at : at + len(values)] = values
        for number, axis in enumerate(self.axes):
            axis.obey(outputs[WORDS * number : WORDS * number + WORDS])

    def _write_bits(self, first: int, values: Sequence[bool]) -> None:
        outputs, at = _bits(self._outputs()), first - COILS
        _part(outputs, at, len(values))
        outputs[at : at + len(values)] = values
        self._write(OUTPUTS, [number_of(outputs[bit : bit + 16]) for bit in range(0, len(outputs), 16)])

    def _write_coil(self, request: ModbusPDU) -> ModbusPDU:
        self._write_bits(request.address, request.bits)
        return bits.WriteSingleCoilResponse(address=request.address, bits=request.bits)

    def _write_coils(self, request: ModbusPDU) -> ModbusPDU:
        self._write_bits(request.address, request.bits)
        return bits.WriteMultipleCoilsResponse(address=request.address, count=request.count)

    def _write_register(self, request: ModbusPDU) -> ModbusPDU:
        self._write(request.address, request.registers)
        return words.WriteSingleRegisterResponse(address=request.address, registers=request.registers)

    def _write_registers(self, request: ModbusPDU) -> ModbusPDU:
        self._write(request.address, request.registers)
        return words.WriteMultipleRegistersResponse(address=request.address, count=request.count)

    def _mask_write(self, request: ModbusPDU) -> ModbusPDU:
        assert isinstance(request, words.MaskWriteRegisterRequest)
        kept, added = request.and_mask, request.or_mask
        (word,) = _part(self._outputs(), request.address - OUTPUTS, 1)
        self._write(request.address, [word & kept | added & ~kept & 0xFFFF])
        return words.MaskWriteRegisterResponse(address=request.address, and_mask=kept, or_mask=added)

    def _write_and_read(self, request: ModbusPDU) -> ModbusPDU:
        assert isinstance(request, words.ReadWriteMultipleRegistersRequest)
        before = self._holding(request.read_address, request.read_count)
        self._write(request.write_address, request.write_registers)
        return words.ReadWriteMultipleRegistersResponse(registers=before)


def _bits(registers: Sequence[int]) -> list[bool]:
    return [bit for register in registers for bit in bits_of(register, 16)]


def _part(values: Sequence[T], first: int, count: int) -> list[T]:
    """Return the values at some places; refuse places that have no value."""
    if first < 0 or first + count > len(values):
        raise ModbusRefusedError(ILLEGAL_ADDRESS)
    return list(values[first : first + count])
