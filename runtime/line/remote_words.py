"""A module's output and input words as Modbus registers, for a PLC that uses it as remote I/O.

For a 3601:

    holding registers   0-7  output words, which the PLC writes      8-15  input words
                       16-18 exchanges, torn writes, age of the output words in ms
    input registers     0-7  input words                             8-10  the same three numbers

    03, 04   reads        06, 10  writes        17  writes and then reads

A write of all output words is an exchange, in which they change together. A write of fewer words is *torn*,
since the module might see half a command. A torn write is carried out and counted, or refused with exception
02h. Counts are checked before addresses, with exception 03h [Modbus V1.1b3, 6.3, 6.4, 6.12 and 6.17].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu.register_message import ReadWriteMultipleRegistersRequest
from scanrack.io_images.image import WORDS

from . import modbus_pdus as pdus

COUNT_LIMIT = 0xFFFF
READ_HOLDING, READ_INPUTS, WRITE_ONE, WRITE_SEVERAL, WRITE_AND_READ = 0x03, 0x04, 0x06, 0x10, 0x17
FUNCTIONS = (READ_HOLDING, READ_INPUTS, WRITE_ONE, WRITE_SEVERAL, WRITE_AND_READ)


class RemoteWords:
    """The words of one module, between a PLC and the module's backplane.

    Attributes:
        outputs: the words that the PLC wrote last, 0 to 65,535.
        exchanges: number of writes that were carried out, including torn writes.
        torn: number of torn writes, carried out or refused.
        heard_ns: instant of the latest write that was carried out, or None before the first one.

    Args:
        inputs: function that returns the module's current input words, 0 to 65,535.
        size: number of output words.
        whole: whether to refuse torn writes.
    """

    def __init__(
        self, inputs: Callable[[], Sequence[int]], size: int = WORDS, *, whole: bool = False
    ) -> None:
        self._inputs = inputs
        self._refuses_torn = whole
        self.outputs = [0] * size
        self.exchanges = self.torn = 0
        self.heard_ns: int | None = None

    def answer(self, now_ns: int, pdu: bytes) -> bytes:
        """Carry out a request; return the reply or exception.

        Args:
            pdu: function code and data, at least one byte.
        """
        request = pdus.request_of(pdu, FUNCTIONS)
        return pdus.answer_to(request, lambda command: self._carry_out(now_ns, command))

    def _carry_out(self, now_ns: int, request: ModbusPDU) -> ModbusPDU:
        """Carry out a request; return its reply, or raise a ModbusRefusedError."""
        if isinstance(request, ReadWriteMultipleRegistersRequest):
            span = request.read_address, request.read_count
            self._read(now_ns, self.outputs, *span)  # refuse an invalid read before the write
            self._write(now_ns, request.write_address, request.write_registers)
            return pdus.reply_with(request, self._read(now_ns, self.outputs, *span))
        if request.function_code in (READ_HOLDING, READ_INPUTS):
            outputs = self.outputs if request.function_code == READ_HOLDING else []
            return pdus.reply_with(request, self._read(now_ns, outputs, request.address, request.count))
        self._write(now_ns, request.address, request.registers)
        return pdus.reply_to_write(request)

    def _write(self, now_ns: int, first: int, values: Sequence[int]) -> None:
        """Write output words, and count the exchange; count or refuse a torn write."""
        if first + len(values) > len(self.outputs):
            raise pdus.ModbusRefusedError(pdus.ILLEGAL_ADDRESS)
        is_torn = len(values) < len(self.outputs)
        self.torn += is_torn
        if is_torn and self._refuses_torn:
            raise pdus.ModbusRefusedError(pdus.ILLEGAL_ADDRESS)
        self.outputs[first : first + len(values)] = values
        self.exchanges += 1
        self.heard_ns = now_ns

    def _read(self, now_ns: int, outputs: Sequence[int], first: int, count: int) -> Sequence[int]:
        """Return registers from a block of output words, input words, counts and age."""
        block = [*outputs, *self._inputs(), *self._counts_and_age(now_ns)]
        if first + count > len(block):
            raise pdus.ModbusRefusedError(pdus.ILLEGAL_ADDRESS)
        return block[first : first + count]

    def _counts_and_age(self, now_ns: int) -> tuple[int, int, int]:
        """Return exchanges, torn writes and age of the outputs in ms, each of 16 bits."""
        age_ms = COUNT_LIMIT if self.heard_ns is None else (now_ns - self.heard_ns) // 1_000_000
        return self.exchanges & COUNT_LIMIT, self.torn & COUNT_LIMIT, min(age_ms, COUNT_LIMIT)
