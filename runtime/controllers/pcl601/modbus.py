"""The nine Modbus functions, from request to reply [Appendix 3].

Frames as printed in the manual, without address and CRC:

    01 02 03 04   first address, quantity          byte count, data
    05 06         address, value                   the request again
    0F 10         first address, quantity,         first address, quantity
                  byte count, data
    11            -                                05, address, "1.00"

The reply to a refused request is an exception; the manual does not list the codes: 1 unknown function, 2
outside the map or read only, 3 quantity, byte count or value, 6 while a program runs or a motion locks the
register. A request is refused as a whole. Quantity and byte count are checked before the address [Modbus
V1.1b3, 6.11 and 6.12].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pymodbus.pdu import ModbusPDU
from scanrack.io_images.pcl601 import FIRMWARE, ROWS, WORD_COUNT, WORDS, Code, Error, Register, Row, with_word
from scanrack.io_images.pcl601.terminals import INPUT_COUNT, OUTPUT_BITS, OUTPUT_COUNT

from ...line.modbus_pdus import (
    DEVICE_BUSY,
    ILLEGAL_ADDRESS,
    ILLEGAL_VALUE,
    ModbusRefusedError,
    answer_to,
    bits_of,
    number_of,
    reply_to_write,
    reply_with,
    request_of,
)
from ...line.pcl601_pdus import Pcl601Identity
from .controller import Pcl601Controller

WORD_PLACES = tuple((row.register, 16 * word) for row, word in WORDS)
"""Register of each data word, and the bit at which the word begins in that register."""


class Modbus:
    """Carries out Modbus requests for a controller."""

    def __init__(self, controller: Pcl601Controller) -> None:
        self._controller = controller
        self._functions: dict[int, Callable[[ModbusPDU], ModbusPDU]] = {
            0x01: self._read_outputs,
            0x02: self._read_inputs,
            0x03: self._read_registers,
            0x04: self._read_input_register,
            0x05: self._write_outputs,
            0x06: self._write_registers,
            0x0F: self._write_outputs,
            0x10: self._write_registers,
            0x11: self._report_id,
        }

    def answer(self, request: bytes) -> bytes:
        """Carry out a request (function code and data); return the reply."""
        return answer_to(request_of(request, self._functions), self._carry_out)

    def _carry_out(self, request: ModbusPDU) -> ModbusPDU:
        return self._functions[request.function_code](request)

    # reading

    def _read_outputs(self, request: ModbusPDU) -> ModbusPDU:
        _check_span(request, OUTPUT_BITS)
        return _bits_reply(request, self._controller.output_pins)

    def _read_inputs(self, request: ModbusPDU) -> ModbusPDU:
        _check_span(request, INPUT_COUNT)
        return _bits_reply(request, self._controller.inputs.active())

    def _read_registers(self, request: ModbusPDU) -> ModbusPDU:
        _check_span(request, WORD_COUNT)
        values = self._controller.read()
        word_places = WORD_PLACES[request.address : request.address + request.count]
        return reply_with(request, [values[register] >> shift & 0xFFFF for register, shift in word_places])

    def _read_input_register(self, request: ModbusPDU) -> ModbusPDU:
        _check_span(request, 1)
        return reply_with(request, [self._controller.inputs.active()])

    def _report_id(self, _request: ModbusPDU) -> ModbusPDU:
        return Pcl601Identity(bytes((self._controller.values[Register.ADDRESS],)) + FIRMWARE.encode())

    # writing

    def _write_outputs(self, request: ModbusPDU) -> ModbusPDU:
        """Set the outputs; bit 0 of the request is the output at its address."""
        first, bits = request.address, request.bits
        if first + len(bits) > OUTPUT_COUNT:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        self._refuse_while_program_runs()
        self._controller.set_outputs(number_of(bits) << first, (1 << len(bits)) - 1 << first)
        return reply_to_write(request)

    def _write_registers(self, request: ModbusPDU) -> ModbusPDU:
        """Check all values, then store them; carry out a command last."""
        first, values = request.address, request.registers
        if first + len(values) > WORD_COUNT:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        targets = WORDS[first : first + len(values)]
        if not all(row.writable for row, _ in targets):
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        is_stop = first == 0 and tuple(values) == (Code.STOP_MOTION,)
        if not is_stop:
            self._refuse_while_program_runs()
        for (row, _), value in zip(targets, values, strict=True):
            self._check_value(row, value)
        if not self._position_fits(first, values):
            self._refuse(ILLEGAL_VALUE, Error.RANGE)
        for (row, word), value in zip(targets, values, strict=True):
            if row.register is not Register.COMMAND:
                self._controller.values.set_word(row, word, value)
                self._controller.written(row.register)
        if first == 0:
            self._controller.do(values[0])
        return reply_to_write(request)

    def _check_value(self, row: Row, value: int) -> None:
        """Refuse to write a locked register during a motion, or a value out of its range.

        A value of two words is not checked, since a request can write only one of them.
        """
        if row.locked and self._controller.busy:
            self._refuse(DEVICE_BUSY, Error.BUSY)
        if row.words == 1 and not row.allows(value):
            is_command = row.register is Register.COMMAND
            self._refuse(ILLEGAL_VALUE, Error.COMMAND if is_command else Error.RANGE)

    def _position_fits(self, first: int, values: Sequence[int]) -> bool:
        """Return whether a position with both words written is in range; other writes are not checked."""
        index = WORD_PLACES.index((Register.POSITION, 0)) - first
        if not 0 <= index < len(values) - 1:
            return True
        row = ROWS[Register.POSITION]
        with_low_word = with_word(row, 0, 0, values[index])
        return row.allows(with_word(row, with_low_word, 1, values[index + 1]))

    def _refuse_while_program_runs(self) -> None:
        """Refuse a write with the mode error while the stored program runs."""
        if self._controller.program_running:
            self._refuse(DEVICE_BUSY, Error.MODE)

    def _refuse(self, code: int, error: Error) -> None:
        """Set an error bit, and raise a Modbus exception with the given code."""
        self._controller.report(error)
        raise ModbusRefusedError(code)


def _check_span(request: ModbusPDU, size: int) -> None:
    if request.address + request.count > size:
        raise ModbusRefusedError(ILLEGAL_ADDRESS)


def _bits_reply(request: ModbusPDU, number: int) -> ModbusPDU:
    """Return the reply that contains the requested bits of a number."""
    return reply_with(request, bits_of(number >> request.address, request.count))
