"""The Modbus registers of a stack of drives, as requests and answers without transport [SMD p. 120, p. 121].

    inputs     input registers from 0, also holding registers from 0; discrete inputs from 0
    outputs    holding registers from 1024; coils from 16,384, bit 0 of register n at 16,384 + 16 * (n - 1024)

Each axis has ten registers, the next one after the other. A write acts at once, register by register of one
request together. Function 23 answers with the data from before its own write.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from struct import Struct, error, pack

from ....io_images.drives.models import WORDS
from .drive import Drive

OUTPUTS = 1024
"""The first output register."""

COILS = 16_384
"""The coil of its bit 0."""

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
EXCEPTION = 0x80
READ_BITS_MOST, WRITE_BITS_MOST = 2000, 1968
READ_WORDS_MOST, WRITE_WORDS_MOST, WRITE_AND_READ_MOST = 125, 123, 121
COIL_VALUES: Mapping[int, int] = {0x0000: 0, 0xFF00: 1}

_PAIR, _SEVERAL, _MASK, _BOTH = Struct(">HH"), Struct(">HHB"), Struct(">HHH"), Struct(">HHHHB")


class RefusedError(Exception):
    """A request is answered with an exception."""

    def __init__(self, code: int) -> None:
        super().__init__(f"exception {code}")
        self.code = code


class DriveRegisters:
    """The registers of the axes of a stack, all advanced to the present instant.

    Args:
        axes: 1 or more.
    """

    def __init__(self, axes: Sequence[Drive]) -> None:
        self.axes = axes

    def answer(self, pdu: bytes) -> bytes:
        """Carry out a request; return the answer or exception.

        Args:
            pdu: function code and data, at least one byte.
        """
        function = _FUNCTIONS.get(pdu[0])
        try:
            if function is None:
                raise RefusedError(ILLEGAL_FUNCTION)
            return pdu[:1] + function(self, pdu[1:])
        except RefusedError as refused:
            return bytes((pdu[0] | EXCEPTION, refused.code))
        except error:  # the data are too short or too long
            return bytes((pdu[0] | EXCEPTION, ILLEGAL_VALUE))

    # -- registers ----------------------------------------------------------------------------

    def _inputs(self) -> list[int]:
        return [word & 0xFFFF for axis in self.axes for word in axis.inputs()]

    def _outputs(self) -> list[int]:
        return [word for axis in self.axes for word in axis.words]

    def _read(self, first: int, count: int, *, holding: bool) -> list[int]:
        if holding and first >= OUTPUTS:
            return _part(self._outputs(), first - OUTPUTS, count)
        return _part(self._inputs(), first, count)

    def _write(self, first: int, values: Sequence[int]) -> None:
        words = self._outputs()
        _part(words, first - OUTPUTS, len(values))
        words[first - OUTPUTS : first - OUTPUTS + len(values)] = values
        for at, axis in enumerate(self.axes):
            axis.obey(words[WORDS * at : WORDS * at + WORDS])

    # -- functions ----------------------------------------------------------------------------

    def read_coils(self, data: bytes) -> bytes:
        """Read bits of the outputs."""
        return self._read_bits(data, self._outputs(), COILS)

    def read_discrete(self, data: bytes) -> bytes:
        """Read bits of the inputs."""
        return self._read_bits(data, self._inputs(), 0)

    @staticmethod
    def _read_bits(data: bytes, words: Sequence[int], base: int) -> bytes:
        first, count = _PAIR.unpack(data)
        _check(count, READ_BITS_MOST)
        bits = _part([word >> bit & 1 for word in words for bit in range(16)], first - base, count)
        size = (count + 7) // 8
        return bytes((size,)) + sum(bit << at for at, bit in enumerate(bits)).to_bytes(size, "little")

    def read_holding(self, data: bytes) -> bytes:
        """Read inputs or outputs."""
        return self._read_words(data, holding=True)

    def read_input(self, data: bytes) -> bytes:
        """Read inputs."""
        return self._read_words(data, holding=False)

    def _read_words(self, data: bytes, *, holding: bool) -> bytes:
        first, count = _PAIR.unpack(data)
        _check(count, READ_WORDS_MOST)
        return _counted(self._read(first, count, holding=holding))

    def write_coil(self, data: bytes) -> bytes:
        """Write a bit of the outputs."""
        address, value = _PAIR.unpack(data)
        if value not in COIL_VALUES:
            raise RefusedError(ILLEGAL_VALUE)
        self._write_bits(address, (COIL_VALUES[value],))
        return data

    def write_coils(self, data: bytes) -> bytes:
        """Write bits of the outputs."""
        first, count, size = _SEVERAL.unpack(data[: _SEVERAL.size])
        _check(count, WRITE_BITS_MOST)
        _check_size(data[_SEVERAL.size :], size, (count + 7) // 8)
        values = int.from_bytes(data[_SEVERAL.size :], "little")
        self._write_bits(first, [values >> at & 1 for at in range(count)])
        return data[: _PAIR.size]

    def _write_bits(self, first: int, values: Sequence[int]) -> None:
        words = self._outputs()
        _part(range(16 * len(words)), first - COILS, len(values))
        for at, value in enumerate(values, start=first - COILS):
            words[at // 16] = words[at // 16] & ~(1 << at % 16) | value << at % 16
        self._write(OUTPUTS, words)

    def write_register(self, data: bytes) -> bytes:
        """Write an output."""
        address, value = _PAIR.unpack(data)
        self._write(address, (value,))
        return data

    def write_registers(self, data: bytes) -> bytes:
        """Write outputs."""
        first, count, size = _SEVERAL.unpack(data[: _SEVERAL.size])
        _check(count, WRITE_WORDS_MOST)
        self._write(first, _words(data[_SEVERAL.size :], size, count))
        return data[: _PAIR.size]

    def mask_write(self, data: bytes) -> bytes:
        """Clear and set bits of an output."""
        address, keep, set_bits = _MASK.unpack(data)
        (word,) = _part(self._outputs(), address - OUTPUTS, 1)
        self._write(address, (word & keep | set_bits & ~keep & 0xFFFF,))
        return data

    def write_and_read(self, data: bytes) -> bytes:
        """Write outputs; answer with what was there before."""
        read_at, reads, write_at, writes, size = _BOTH.unpack(data[: _BOTH.size])
        _check(reads, READ_WORDS_MOST)
        _check(writes, WRITE_AND_READ_MOST)
        values = _words(data[_BOTH.size :], size, writes)
        answer = _counted(self._read(read_at, reads, holding=True))
        self._write(write_at, values)
        return answer


def _part(values: Sequence[int], first: int, count: int) -> list[int]:
    """Return values by their place; an exception if there are none at one of them."""
    if first < 0 or first + count > len(values):
        raise RefusedError(ILLEGAL_ADDRESS)
    return list(values[first : first + count])


def _check(count: int, most: int) -> None:
    if not 1 <= count <= most:
        raise RefusedError(ILLEGAL_VALUE)


def _check_size(data: bytes, size: int, needed: int) -> None:
    if not size == needed == len(data):
        raise RefusedError(ILLEGAL_VALUE)


def _words(data: bytes, size: int, count: int) -> tuple[int, ...]:
    _check_size(data, size, 2 * count)
    return Struct(f">{count}H").unpack(data)


def _counted(words: Sequence[int]) -> bytes:
    return bytes((2 * len(words),)) + pack(f">{len(words)}H", *words)


_FUNCTIONS: Mapping[int, Callable[[DriveRegisters, bytes], bytes]] = {
    1: DriveRegisters.read_coils,
    2: DriveRegisters.read_discrete,
    3: DriveRegisters.read_holding,
    4: DriveRegisters.read_input,
    5: DriveRegisters.write_coil,
    6: DriveRegisters.write_register,
    15: DriveRegisters.write_coils,
    16: DriveRegisters.write_registers,
    22: DriveRegisters.mask_write,
    23: DriveRegisters.write_and_read,
}
