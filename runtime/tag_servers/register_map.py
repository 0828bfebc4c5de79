"""Tags as Modbus coils and registers, by the map of a rack file [Modbus V1.1b3, chapter 6].

| function | does |
|---|---|
| 01, 02 | read coils, discrete inputs |
| 03, 04 | read holding registers, input registers |
| 05, 0F | write one coil, several |
| 06, 10 | write one register, several |
| 16 | set and clear bits of a register |
| 17 | write registers, then read some |

A request is carried out at one instant, or refused as a whole: 01h for another function, 03h for a count or a
value that is not allowed, 04h if the program does not take the value; 02h for an address without a tag, for a
write of half a value, and for one of a tag that clients only read.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from struct import Struct, error

from ...io_images.enip.codes import CipRefusedError
from ...io_images.enip.listing import PlainKind
from ..config.server_table import ModbusTable
from .database import Database
from .mapped_tags import (
    BITS,
    COILS,
    DISCRETE_INPUTS,
    FAILURE,
    HOLDING_REGISTERS,
    ILLEGAL_ADDRESS,
    ILLEGAL_FUNCTION,
    ILLEGAL_VALUE,
    INPUT_REGISTERS,
    TABLES,
    MappedTag,
    ModbusRefusedError,
    mapped,
    packed,
)
from .tag_snapshot import ReadBytes, TagSnapshot, WriteBytes

ADDRESSES = 1 << 16

EXCEPTION = 0x80
READ_BITS_MOST, WRITE_BITS_MOST = 2000, 1968
READ_WORDS_MOST, WRITE_WORDS_MOST, WRITE_AND_READ_MOST = 125, 123, 121
COIL_VALUES: Mapping[int, bool] = {0x0000: False, 0xFF00: True}

_PAIR, _SEVERAL, _MASK, _BOTH = Struct(">HH"), Struct(">HHB"), Struct(">HHH"), Struct(">HHHHB")


@dataclass(frozen=True)
class _Cell:
    """What is at an address."""

    row: MappedTag
    place: int  # of the row's coils or registers


class RegisterMap:
    """The coils and registers of a rack.

    Args:
        table: of the rack file.

    Attributes:
        problems: a sentence for each row that names no tag, one that has no place in its table, or a taken
            address; the addresses of such a row have no tag.
    """

    def __init__(self, database: Database, table: ModbusTable) -> None:
        self._cells: dict[str, dict[int, _Cell]] = {name: {} for name in TABLES}
        self.problems: list[str] = []
        for name in TABLES:
            for number, row in enumerate(getattr(table, name)):
                try:
                    self._add(name, mapped(name, database, row, table.order), row.address)
                except ValueError as error:
                    self.problems.append(f"[server.modbus] {name}[{number}], tag {row.tag}: {error}")

    def _add(self, table: str, row: MappedTag, address: int) -> None:
        cells = self._cells[table]
        size = row.bits if table in BITS else row.words * row.target.count
        if address + size > ADDRESSES:
            raise ValueError(
                f"it needs {size} addresses from {address} on: the last address is {ADDRESSES - 1}"
            )
        if taken := next(filter(None, (cells.get(address + place) for place in range(size))), None):
            raise ValueError(f"an address from {address} on is that of {taken.row.target.name}")
        for place in range(size):
            cells[address + place] = _Cell(row, place)

    def answer(self, pdu: bytes, snapshot: TagSnapshot) -> bytes:
        """Carry out a request; return the reply or exception.

        Args:
            pdu: function code and data, at least one byte.
        """
        function = _FUNCTIONS.get(pdu[0])
        try:
            if function is None:
                raise ModbusRefusedError(ILLEGAL_FUNCTION)
            return pdu[:1] + function(self, pdu[1:], snapshot)
        except ModbusRefusedError as refused:
            return bytes((pdu[0] | EXCEPTION, refused.code))
        except error:  # the data are too short or too long
            return bytes((pdu[0] | EXCEPTION, ILLEGAL_VALUE))
        except CipRefusedError:  # the program does not take the value
            return bytes((pdu[0] | EXCEPTION, FAILURE))

    # --- bits

    def read_bits(self, table: str, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Read coils or discrete inputs."""
        first, count = _PAIR.unpack(data)
        _check(count, READ_BITS_MOST)
        runs = self._runs(table, first, count)
        bits = [bit for row, place, many in runs for bit in row.to_bits(place, many, snapshot)]
        return bytes((-(-count // 8),)) + packed(bits)

    def write_bit(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Write one coil."""
        address, value = _PAIR.unpack(data)
        if value not in COIL_VALUES:
            raise ModbusRefusedError(ILLEGAL_VALUE)
        self._write_bits(address, [COIL_VALUES[value]], snapshot)
        return data

    def write_bits(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Write several coils."""
        first, count, size = _SEVERAL.unpack_from(data)
        packed = data[_SEVERAL.size :]
        _check(count, WRITE_BITS_MOST)
        if size != -(-count // 8) or len(packed) != size:
            raise ModbusRefusedError(ILLEGAL_VALUE)
        self._write_bits(first, [bool(packed[at // 8] >> at % 8 & 1) for at in range(count)], snapshot)
        return data[: _PAIR.size]

    def _write_bits(self, first: int, bits: Sequence[bool], snapshot: TagSnapshot) -> None:
        changes, at = [], 0
        for row, place, many in self._runs(COILS, first, len(bits)):
            _check_access(row)
            changes += [row.change(place, bits[at : at + many])]
            at += many
        for each in changes:
            snapshot.write(each)

    # --- registers

    def read_words(self, table: str, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Read holding or input registers."""
        first, count = _PAIR.unpack(data)
        _check(count, READ_WORDS_MOST)
        words: list[int] = []
        for row, place, many in list(self._runs(table, first, count)):
            offset, size = row.values_at(place, many)
            found = row.to_words(snapshot.read(ReadBytes(row.target.symbol.index, offset, size)))
            begin = place % row.words
            words += found[begin : begin + many]
        return bytes((2 * count,)) + Struct(f">{count}H").pack(*words)

    def write_word(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Write one register."""
        address, word = _PAIR.unpack(data)
        self._write_words(address, (word,), snapshot)
        return data

    def write_words(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Write several registers."""
        first, count, size = _SEVERAL.unpack_from(data)
        self._write_words(first, _words(data[_SEVERAL.size :], count, size, WRITE_WORDS_MOST), snapshot)
        return data[: _PAIR.size]

    def mask_word(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Set and clear bits of a register: (old AND and-mask) OR (or-mask AND NOT and-mask)."""
        address, keep, on = _MASK.unpack(data)
        ((row, place, _),) = self._runs(HOLDING_REGISTERS, address, 1)
        _check_access(row)
        kind = row.target.kind
        if row.size == 1 or not isinstance(kind, PlainKind) or not kind.bits:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        masks = (each.to_bytes(2, "little") for each in (on & ~keep & 0xFFFF, keep))
        snapshot.write(WriteBytes(row.target.symbol.index, row.byte_of(place), *masks))
        return data

    def write_and_read(self, data: bytes, snapshot: TagSnapshot) -> bytes:
        """Write registers, then read some."""
        read_at, read_count, first, count, size = _BOTH.unpack_from(data)
        _check(read_count, READ_WORDS_MOST)
        words = _words(data[_BOTH.size :], count, size, WRITE_AND_READ_MOST)
        list(self._runs(HOLDING_REGISTERS, read_at, read_count))  # refused as a whole, or not at all
        self._write_words(first, words, snapshot)
        return self.read_words(HOLDING_REGISTERS, _PAIR.pack(read_at, read_count), snapshot)

    def _write_words(self, first: int, words: Sequence[int], snapshot: TagSnapshot) -> None:
        changes, at = [], 0
        for row, place, many in self._runs(HOLDING_REGISTERS, first, len(words)):
            _check_access(row)
            if place % row.words or many % row.words:
                raise ModbusRefusedError(ILLEGAL_ADDRESS)
            offset, _ = row.values_at(place, many)
            changes += [WriteBytes(row.target.symbol.index, offset, row.to_bytes(words[at : at + many]))]
            at += many
        for each in changes:
            snapshot.write(each)

    def _runs(self, table: str, first: int, count: int) -> Iterator[tuple[MappedTag, int, int]]:
        """Yield the rows at addresses, each with its first place and the number of places."""
        cells = [self._cells[table].get(address) for address in range(first, first + count)]
        if None in cells:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        for _, group in groupby(filter(None, cells), key=lambda each: id(each.row)):
            found = list(group)
            yield found[0].row, found[0].place, len(found)


Function = Callable[[RegisterMap, bytes, TagSnapshot], bytes]

_FUNCTIONS: Mapping[int, Function] = {
    0x01: lambda registers, data, snapshot: registers.read_bits(COILS, data, snapshot),
    0x02: lambda registers, data, snapshot: registers.read_bits(DISCRETE_INPUTS, data, snapshot),
    0x03: lambda registers, data, snapshot: registers.read_words(HOLDING_REGISTERS, data, snapshot),
    0x04: lambda registers, data, snapshot: registers.read_words(INPUT_REGISTERS, data, snapshot),
    0x05: RegisterMap.write_bit,
    0x06: RegisterMap.write_word,
    0x0F: RegisterMap.write_bits,
    0x10: RegisterMap.write_words,
    0x16: RegisterMap.mask_word,
    0x17: RegisterMap.write_and_read,
}


def _check(count: int, most: int) -> None:
    if not 1 <= count <= most:
        raise ModbusRefusedError(ILLEGAL_VALUE)


def _check_access(row: MappedTag) -> None:
    if not row.writable:
        raise ModbusRefusedError(ILLEGAL_ADDRESS)


def _words(data: bytes, count: int, size: int, most: int) -> tuple[int, ...]:
    _check(count, most)
    if size != 2 * count or len(data) != size:
        raise ModbusRefusedError(ILLEGAL_VALUE)
    return Struct(f">{count}H").unpack(data)
