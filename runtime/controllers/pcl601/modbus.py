"""The nine Modbus functions, from request to reply [Appendix 3].

Frames as printed, less address and CRC:

    01 02 03 04   first address, quantity          byte count, data
    05 06         address, value                   the request again
    0F 10         first address, quantity,         first address, quantity
                  byte count, data
    11            -                                05, address, "1.00"

The reply to a refused request is an exception, which the manual does not print:
1 unknown function, 2 outside the map or read only, 3 quantity, byte count or
value, 6 while a program runs or motion locks the register. A request is refused
as a whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import pack, unpack

from ....io_images.pcl601 import FIRMWARE, ROWS, WORD_COUNT, WORDS, Code, Error, Register, with_word
from ....io_images.pcl601.terminals import INPUT_COUNT, OUTPUT_BITS, OUTPUT_COUNT
from .controller import Pcl601Controller

BITS_MAX = 2000
WORDS_MAX = 125
WRITE_BITS_MAX = 1968
WRITE_WORDS_MAX = 123
ON, OFF = 0xFF00, 0x0000
PLACES = tuple((row.register, 16 * word) for row, word in WORDS)
"""Register and first bit of each data word."""
EXCEPTION = 0x80
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, DEVICE_BUSY = 1, 2, 3, 6


class ModbusRefusalError(Exception):
    """A refused request, with its exception code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"exception {code}")
        self.code = code


class Modbus:
    """Answers Modbus requests from the controller's tables."""

    def __init__(self, controller: Pcl601Controller) -> None:
        self._controller = controller
        self._functions: dict[int, Callable[[bytes], bytes]] = {
            0x01: self._read_outputs,
            0x02: self._read_inputs,
            0x03: self._read_registers,
            0x04: self._read_input_register,
            0x05: self._write_output,
            0x06: self._write_register,
            0x0F: self._write_outputs,
            0x10: self._write_registers,
            0x11: self._report_id,
        }

    def answer(self, request: bytes) -> bytes:
        """Carry out a request (function code and data); return the reply."""
        function, data = request[0], request[1:]
        try:
            if function not in self._functions:
                raise ModbusRefusalError(ILLEGAL_FUNCTION)
            return bytes((function,)) + self._functions[function](data)
        except ModbusRefusalError as refused:
            return bytes((function & 0x7F | EXCEPTION, refused.code))

    # reading

    def _read_outputs(self, data: bytes) -> bytes:
        first, count = _span(data, BITS_MAX, OUTPUT_BITS)
        return _bits(self._controller.output_pins, first, count)

    def _read_inputs(self, data: bytes) -> bytes:
        first, count = _span(data, BITS_MAX, INPUT_COUNT)
        return _bits(self._controller.inputs.active(), first, count)

    def _read_registers(self, data: bytes) -> bytes:
        first, count = _span(data, WORDS_MAX, WORD_COUNT)
        values = self._controller.read()
        places = PLACES[first : first + count]
        return _words([values[register] >> shift & 0xFFFF for register, shift in places])

    def _read_input_register(self, data: bytes) -> bytes:
        _span(data, WORDS_MAX, 1)
        return _words([self._controller.inputs.active()])

    def _report_id(self, data: bytes) -> bytes:
        if data:
            raise ModbusRefusalError(ILLEGAL_VALUE)
        text = bytes((self._controller.values[Register.ADDRESS],)) + FIRMWARE.encode()
        return bytes((len(text),)) + text

    # writing

    def _write_output(self, data: bytes) -> bytes:
        address, value = _pair(data)
        if value not in (ON, OFF):
            raise ModbusRefusalError(ILLEGAL_VALUE)
        if address >= OUTPUT_COUNT:
            raise ModbusRefusalError(ILLEGAL_ADDRESS)
        self._not_while_program_runs()
        self._controller.set_outputs(0xFF if value == ON else 0, 1 << address)
        return data

    def _write_outputs(self, data: bytes) -> bytes:
        first, count = _span(data[:4], WRITE_BITS_MAX, OUTPUT_COUNT)
        if data[4:5] != bytes(((count + 7) // 8,)) or len(data) != 5 + data[4]:
            raise ModbusRefusalError(ILLEGAL_VALUE)
        self._not_while_program_runs()
        values = int.from_bytes(data[5:], "little")
        self._controller.set_outputs(values << first, (1 << count) - 1 << first)
        return data[:4]

    def _write_register(self, data: bytes) -> bytes:
        address, value = _pair(data)
        self._write_words(address, (value,))
        return data

    def _write_registers(self, data: bytes) -> bytes:
        first, count = _span(data[:4], WRITE_WORDS_MAX, WORD_COUNT)
        if data[4:5] != bytes((2 * count,)) or len(data) != 5 + 2 * count:
            raise ModbusRefusalError(ILLEGAL_VALUE)
        self._write_words(first, unpack(f">{count}H", data[5:]))
        return data[:4]

    def _write_words(self, first: int, words: Sequence[int]) -> None:
        """Check all values, then store all; carry out a command last."""
        if first + len(words) > WORD_COUNT:
            raise ModbusRefusalError(ILLEGAL_ADDRESS)
        targets = WORDS[first : first + len(words)]
        if not all(row.writable for row, _ in targets):
            raise ModbusRefusalError(ILLEGAL_ADDRESS)
        is_stop = first == 0 and tuple(words) == (Code.STOP_MOTION,)
        if not is_stop:
            self._not_while_program_runs()
        for (row, _), value in zip(targets, words, strict=True):
            if row.locked and self._controller.busy:
                self._refuse(DEVICE_BUSY, Error.BUSY)
            if row.words == 1 and not row.allows(value):
                is_command = row.register is Register.COMMAND
                self._refuse(ILLEGAL_VALUE, Error.COMMAND if is_command else Error.RANGE)
        if not self._position_fits(first, words):
            self._refuse(ILLEGAL_VALUE, Error.RANGE)
        for (row, word), value in zip(targets, words, strict=True):
            if row.register is not Register.COMMAND:
                self._controller.values.set_word(row, word, value)
                self._controller.written(row.register)
        if first == 0:
            self._controller.do(words[0])

    def _position_fits(self, first: int, words: Sequence[int]) -> bool:
        """Whether a position of which both words are written is in range; its write is its use."""
        at = PLACES.index((Register.POSITION, 0)) - first
        if not 0 <= at < len(words) - 1:
            return True
        row, position = ROWS[Register.POSITION], 0
        for word in (0, 1):
            position = with_word(row, position, word, words[at + word])
        return row.allows(position)

    def _not_while_program_runs(self) -> None:
        if self._controller.program_running:
            self._refuse(DEVICE_BUSY, Error.MODE)

    def _refuse(self, code: int, error: Error) -> None:
        self._controller.report(error)
        raise ModbusRefusalError(code)


def _pair(data: bytes) -> tuple[int, int]:
    if len(data) != 4:
        raise ModbusRefusalError(ILLEGAL_VALUE)
    first, second = unpack(">HH", data)
    return first, second


def _span(data: bytes, limit: int, size: int) -> tuple[int, int]:
    """Return first address and quantity, both checked."""
    first, count = _pair(data)
    if not 1 <= count <= limit:
        raise ModbusRefusalError(ILLEGAL_VALUE)
    if first + count > size:
        raise ModbusRefusalError(ILLEGAL_ADDRESS)
    return first, count


def _bits(bits: int, first: int, count: int) -> bytes:
    size = (count + 7) // 8
    return bytes((size,)) + (bits >> first & (1 << count) - 1).to_bytes(size, "little")


def _words(words: Sequence[int]) -> bytes:
    return pack(f">B{len(words)}H", 2 * len(words), *words)
