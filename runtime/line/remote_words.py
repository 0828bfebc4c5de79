"""A module's eight output and eight input words as Modbus registers, for a PLC that has it as remote I/O.

    holding registers   0-7  output words, which the PLC writes      8-15  input words
                       16-18 exchanges, torn writes, age of the output words in ms
    input registers     0-7  input words                             8-10  the same three

    03, 04   reads        06, 10  writes        17  writes, then reads: both in one request

A write of all eight words is an exchange: they change together. One of fewer is *torn*: the module may see
half a command. It is carried out and counted, or refused with exception 02h.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct, error

WORDS = 8
FACTS = 3
COUNT_LIMIT = 0xFFFF
READ_MAX = 125
READ_HOLDING, READ_INPUTS, WRITE_ONE, WRITE_SEVERAL, WRITE_AND_READ = 0x03, 0x04, 0x06, 0x10, 0x17
ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
EXCEPTION = 0x80

_PAIR = Struct(">HH")
_SEVERAL = Struct(">HHB")
_BOTH = Struct(">HHHHB")


class _RefusedError(ValueError):
    """A request that gets an exception."""

    def __init__(self, code: int) -> None:
        super().__init__(f"exception {code:02x}h")
        self.code = code


class RemoteWords:
    """The words of one module, between a PLC and the module's backplane.

    Attributes:
        outputs: the words that the PLC wrote last, 0 to 65,535.
        exchanges: writes carried out, the torn ones included.
        torn: writes of fewer than eight words, carried out or refused.
        heard_ns: instant of the latest write that was carried out; None before the first.

    Args:
        inputs: returns the module's input words at present, 0 to 65,535.
        whole: refuse torn writes.
    """

    def __init__(self, inputs: Callable[[], Sequence[int]], *, whole: bool = False) -> None:
        self._inputs = inputs
        self._whole = whole
        self.outputs = [0] * WORDS
        self.exchanges = self.torn = 0
        self.heard_ns: int | None = None

    def answer(self, now_ns: int, pdu: bytes) -> bytes:
        """Carry out a request; return the reply or exception.

        Args:
            pdu: function code and data, at least one byte.
        """
        try:
            return self._carry_out(now_ns, pdu[0], pdu[1:])
        except _RefusedError as refused:
            return bytes((pdu[0] | EXCEPTION, refused.code))
        except error:  # the data are too short or too long
            return bytes((pdu[0] | EXCEPTION, ILLEGAL_VALUE))

    def _carry_out(self, now_ns: int, function: int, data: bytes) -> bytes:
        if function in (READ_HOLDING, READ_INPUTS):
            return self._read(now_ns, function, *_PAIR.unpack(data))
        if function == WRITE_ONE:
            first, word = _PAIR.unpack(data)
            self._write(now_ns, first, (word,))
            return bytes((function,)) + data
        if function == WRITE_SEVERAL:
            first, count, size = _SEVERAL.unpack_from(data)
            self._write(now_ns, first, _words(data[_SEVERAL.size :], count, size))
            return bytes((function,)) + data[: _PAIR.size]
        if function == WRITE_AND_READ:
            read_at, read_count, first, count, size = _BOTH.unpack_from(data)
            self._check(read_at, read_count, 2 * WORDS + FACTS)  # refused as a whole, or not at all
            self._write(now_ns, first, _words(data[_BOTH.size :], count, size))
            return self._read(now_ns, function, read_at, read_count)
        raise _RefusedError(ILLEGAL_FUNCTION)

    def _write(self, now_ns: int, first: int, words: Sequence[int]) -> None:
        if first + len(words) > WORDS:
            raise _RefusedError(ILLEGAL_ADDRESS)
        torn = len(words) < WORDS
        self.torn += torn
        if torn and self._whole:
            raise _RefusedError(ILLEGAL_ADDRESS)
        self.outputs[first : first + len(words)] = words
        self.exchanges += 1
        self.heard_ns = now_ns

    def _read(self, now_ns: int, function: int, first: int, count: int) -> bytes:
        own = [] if function == READ_INPUTS else self.outputs
        block = [*own, *self._inputs(), *self._facts(now_ns)]
        self._check(first, count, len(block))
        return Struct(f">BB{count}H").pack(function, 2 * count, *block[first : first + count])

    def _facts(self, now_ns: int) -> tuple[int, int, int]:
        age_ms = COUNT_LIMIT if self.heard_ns is None else (now_ns - self.heard_ns) // 1_000_000
        return self.exchanges & COUNT_LIMIT, self.torn & COUNT_LIMIT, min(age_ms, COUNT_LIMIT)

    @staticmethod
    def _check(first: int, count: int, there: int) -> None:
        if not 1 <= count <= READ_MAX:
            raise _RefusedError(ILLEGAL_VALUE)
        if first + count > there:
            raise _RefusedError(ILLEGAL_ADDRESS)


def _words(data: bytes, count: int, size: int) -> tuple[int, ...]:
    if not 1 <= count <= READ_MAX or size != 2 * count or len(data) != size:
        raise _RefusedError(ILLEGAL_VALUE)
    return Struct(f">{count}H").unpack(data)
