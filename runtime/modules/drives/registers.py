"""The Modbus registers of a drive stack, as requests and replies without transport [SMD p. 120, p. 121].

    inputs     input registers from 0, also holding registers from 0; discrete inputs from 0
    outputs    holding registers from 1024; coils from 16,384: 16 for each register, bit 0 first

Each axis has ten registers; the registers of the next axis follow. The registers in one request act together,
at the instant of the request. Function 23 returns the data from before its own write. A request is refused
as a whole: exception 1 for an invalid function, 2 for an address, 3 for a count or value.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from typing import TypeVar

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.register_message import MaskWriteRegisterRequest, ReadWriteMultipleRegistersRequest
from scanrack.io_images.drives.models import WORDS

from ...line.modbus_pdus import (
    ILLEGAL_ADDRESS,
    ModbusRefusedError,
    answer_to,
    bits_of,
    number_of,
    reply_to_write,
    reply_with,
    request_of,
)
from .drive import DriveUnit

T = TypeVar("T")

OUTPUTS = 1024
"""The first output register."""

COILS = 16 * OUTPUTS
"""The first coil, which is bit 0 of the first output register."""

REQUESTS_KEPT = 64
"""Maximum number of decoded requests that are cached, because clients repeat the same requests."""


class DriveRegisters:
    """The registers of the axes of a stack.

    Args:
        axes: one or more axes, all advanced to the instant of each request.
    """

    def __init__(self, axes: Sequence[DriveUnit]) -> None:
        self.axes = axes
        self._decoded = lru_cache(REQUESTS_KEPT)(partial(request_of, functions=(*READS, *WRITES, 23)))

    def answer(self, request: bytes) -> bytes:
        """Carry out a request (function code and data); return the reply or exception."""
        return answer_to(self._decoded(request), self._carry_out)

    def _carry_out(self, request: ModbusPDU) -> ModbusPDU:
        """Return the reply to a request, after its writes; raise ModbusRefusedError if it is refused."""
        function = request.function_code
        if function in READS:
            return reply_with(request, READS[function](self, request.address, request.count))
        if isinstance(request, ReadWriteMultipleRegistersRequest):
            words_before = self._holding(request.read_address, request.read_count)
            self._write(request.write_address, request.write_registers)
            return reply_with(request, words_before)
        WRITES[function](self, request)
        return reply_to_write(request)

    # reading

    def _inputs(self) -> list[int]:
        return [word & 0xFFFF for axis in self.axes for word in axis.inputs()]

    def _outputs(self) -> list[int]:
        words: list[int] = []
        for axis in self.axes:
            words += axis.words
        return words

    def _coils(self, first: int, count: int) -> list[bool]:
        return _slice(_bits(self._outputs()), first - COILS, count)

    def _discrete(self, first: int, count: int) -> list[bool]:
        return _slice(_bits(self._inputs()), first, count)

    def _holding(self, first: int, count: int) -> list[int]:
        if first < OUTPUTS:
            return self._input(first, count)
        return _slice(self._outputs(), first - OUTPUTS, count)

    def _input(self, first: int, count: int) -> list[int]:
        return _slice(self._inputs(), first, count)

    # writing

    def _write(self, first: int, values: Sequence[int]) -> None:
        """Write output registers, and let all axes obey; registers that do not change have no effect."""
        outputs, offset = self._outputs(), first - OUTPUTS
        if _slice(outputs, offset, len(values)) == list(values):
            return
        outputs[offset : offset + len(values)] = values
        for number, axis in enumerate(self.axes):
            axis.obey(outputs[WORDS * number : WORDS * number + WORDS])

    def _write_bits(self, request: ModbusPDU) -> None:
        """Write coils, by writing all output registers with the changed bits."""
        outputs, offset, values = _bits(self._outputs()), request.address - COILS, request.bits
        _slice(outputs, offset, len(values))  # refuses an address without a coil
        outputs[offset : offset + len(values)] = values
        self._write(OUTPUTS, [number_of(outputs[bit : bit + 16]) for bit in range(0, len(outputs), 16)])

    def _write_registers(self, request: ModbusPDU) -> None:
        self._write(request.address, request.registers)

    def _mask_write(self, request: ModbusPDU) -> None:
        assert isinstance(request, MaskWriteRegisterRequest)
        kept_mask, added = request.and_mask, request.or_mask
        (word,) = _slice(self._outputs(), request.address - OUTPUTS, 1)
        self._write(request.address, [word & kept_mask | added & ~kept_mask & 0xFFFF])


READS: Mapping[int, Callable[[DriveRegisters, int, int], Sequence[int]]] = {
    1: DriveRegisters._coils,
    2: DriveRegisters._discrete,
    3: DriveRegisters._holding,
    4: DriveRegisters._input,
}
WRITES: Mapping[int, Callable[[DriveRegisters, ModbusPDU], None]] = {
    5: DriveRegisters._write_bits,
    6: DriveRegisters._write_registers,
    15: DriveRegisters._write_bits,
    16: DriveRegisters._write_registers,
    22: DriveRegisters._mask_write,
}
"""The functions by code; `_carry_out` handles 23, which writes and reads."""


def _bits(registers: Sequence[int]) -> list[bool]:
    return [bit for register in registers for bit in bits_of(register, 16)]


def _slice(values: Sequence[T], first: int, count: int) -> list[T]:
    """Return `count` values from index `first` on; refuse an address without a value."""
    if first < 0 or first + count > len(values):
        raise ModbusRefusedError(ILLEGAL_ADDRESS)
    return list(values[first : first + count])
