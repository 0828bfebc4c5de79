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
value that is not allowed, 04h if the program rejects the value; 02h for an address without a tag, for a
write of half a value, and for a write to a tag that clients may only read. With `fill`, addresses without a
tag below the last one of their table read as 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pymodbus.pdu import ModbusPDU
from pymodbus.pdu import bit_message as bits
from pymodbus.pdu import register_message as words
from scanrack.io_images.enip.codes import CipRefusedError
from scanrack.io_images.enip.listing import PlainKind

from ..config.server_table import ModbusTable
from ..line.modbus_pdus import FAILURE, ILLEGAL_ADDRESS, ModbusRefusedError, carried_out, request_of
from .database import Database
from .mapped_tags import (
    ADDRESSES,
    BITS,
    COILS,
    DISCRETE_INPUTS,
    HOLDING_REGISTERS,
    INPUT_REGISTERS,
    TABLES,
    Gap,
    MappedTag,
    mapped,
)
from .tag_snapshot import TagSnapshot, WriteBytes


@dataclass(frozen=True)
class _Cell:
    """The tag or gap at an address."""

    row: MappedTag | Gap
    place: int  # of the row's coils or registers
    rest: int  # of the row's addresses, this one included


_GAP = _Cell(Gap(), 0, 1)


class RegisterMap:
    """The coils and registers of a rack.

    Args:
        table: the map in the rack file.

    Attributes:
        problems: a sentence for each row with an unknown tag, a tag that can't be in its table, or a taken
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
        self._filled = {  # by table: the address at which gaps end
            name: max(cells, default=0) if table.fill else 0 for name, cells in self._cells.items()
        }

    def _add(self, table: str, row: MappedTag, address: int) -> None:
        cells = self._cells[table]
        size = row.bits if table in BITS else row.words * row.target.count
        if address + size > ADDRESSES:
            raise ValueError(
                f"it needs {size} addresses from {address} on: the last address is {ADDRESSES - 1}"
            )
        cell_row = next(
            (existing.row for place in range(size) if (existing := cells.get(address + place))), None
        )
        if isinstance(cell_row, MappedTag):
            raise ValueError(f"an address from {address} on is that of {cell_row.target.name}")
        for index in range(size):
            cells[address + index] = _Cell(row, index, size - index)

    def answer(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        """Carry out a request; return the reply or exception.

        Args:
            request: a request from `decoded`.
        """
        return carried_out(request, lambda each: self._carry_out(each, snapshot))

    def _carry_out(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        try:
            return _FUNCTIONS[request.function_code](self, request, snapshot)
        except CipRefusedError:  # the program rejects the value
            raise ModbusRefusedError(FAILURE) from None

    def read_bits(self, table: str, request: ModbusPDU, snapshot: TagSnapshot) -> list[bool]:
        """Read coils or discrete inputs."""
        runs = self._runs(table, request.address, request.count)
        return [
            bit for row, offset, item_count in runs for bit in row.read_bits(offset, item_count, snapshot)
        ]

    def read_words(self, table: str, first: int, count: int, snapshot: TagSnapshot) -> list[int]:
        """Read holding or input registers."""
        runs = self._runs(table, first, count)
        return [
            word for row, offset, item_count in runs for word in row.read_words(offset, item_count, snapshot)
        ]

    def write_bits(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        """Write coils."""
        self._write(COILS, request.address, request.bits, snapshot)
        return _confirmation(request)

    def write_words(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        """Write registers."""
        self._write(HOLDING_REGISTERS, request.address, request.registers, snapshot)
        return _confirmation(request)

    def mask_word(self, request: words.MaskWriteRegisterRequest, snapshot: TagSnapshot) -> ModbusPDU:
        """Set and clear bits of a register: (old AND and-mask) OR (or-mask AND NOT and-mask)."""
        ((row, offset, _),) = self._writable(HOLDING_REGISTERS, request.address, 1)
        kind = row.target.kind
        if row.size == 1 or not isinstance(kind, PlainKind) or not kind.bits:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        and_mask, on_mask = request.and_mask, request.or_mask & ~request.and_mask & 0xFFFF
        masks = (mask.to_bytes(2, "little") for mask in (on_mask, and_mask))
        snapshot.write(WriteBytes(row.target.symbol.index, row.byte_of(offset), *masks))
        return request

    def write_and_read(
        self, request: words.ReadWriteMultipleRegistersRequest, snapshot: TagSnapshot
    ) -> ModbusPDU:
        """Write registers, then read some."""
        span = request.read_address, request.read_count
        self._runs(HOLDING_REGISTERS, *span)  # refused as a whole, or not at all
        self._write(HOLDING_REGISTERS, request.write_address, request.write_registers, snapshot)
        registers = self.read_words(HOLDING_REGISTERS, *span, snapshot)
        return words.ReadWriteMultipleRegistersResponse(registers=registers)

    def _write(self, table: str, first: int, values: Sequence[Any], snapshot: TagSnapshot) -> None:
        """Write coils or registers; refused before the first write if one of them can't be written."""
        changes, index = [], 0
        for row, offset, item_count in self._writable(table, first, len(values)):
            row_values, index = values[index : index + item_count], index + item_count
            changes.append(
                row.write_of_bits(offset, row_values)
                if table in BITS
                else row.write_of_words(offset, row_values)
            )
        for change in changes:
            snapshot.write(change)

    def _writable(self, table: str, first: int, count: int) -> list[tuple[MappedTag, int, int]]:
        """Return the rows at addresses as `_runs` does; refused if clients can't write one of them."""
        runs = []
        for row, offset, item_count in self._runs(table, first, count):
            if isinstance(row, Gap) or not row.writable:
                raise ModbusRefusedError(ILLEGAL_ADDRESS)
            runs.append((row, offset, item_count))
        return runs

    def _runs(self, table: str, first: int, count: int) -> list[tuple[MappedTag | Gap, int, int]]:
        """Return the rows at addresses, each with its first place and the number of places."""
        cells, end, runs, end_address = self._cells[table], self._filled[table], [], first + count
        while first < end_address:
            cell = cells.get(first) or (_GAP if first < end else None)
            if cell is None:
                raise ModbusRefusedError(ILLEGAL_ADDRESS)
            item_count = min(cell.rest, end_address - first)
            runs.append((cell.row, cell.place, item_count))
            first += item_count
        return runs


def _confirmation(request: ModbusPDU) -> ModbusPDU:
    """Return the reply to a write: the request again for one value, its address and count for several."""
    reply = {0x0F: bits.WriteMultipleCoilsResponse, 0x10: words.WriteMultipleRegistersResponse}
    make_reply = reply.get(request.function_code)
    return request if make_reply is None else make_reply(address=request.address, count=request.count)


_FUNCTIONS: Mapping[int, Callable[[RegisterMap, Any, TagSnapshot], ModbusPDU]] = {
    0x01: lambda own, request, now: bits.ReadCoilsResponse(bits=own.read_bits(COILS, request, now)),
    0x02: lambda own, request, now: bits.ReadDiscreteInputsResponse(
        bits=own.read_bits(DISCRETE_INPUTS, request, now)
    ),
    0x03: lambda own, request, now: words.ReadHoldingRegistersResponse(
        registers=own.read_words(HOLDING_REGISTERS, request.address, request.count, now)
    ),
    0x04: lambda own, request, now: words.ReadInputRegistersResponse(
        registers=own.read_words(INPUT_REGISTERS, request.address, request.count, now)
    ),
    0x05: RegisterMap.write_bits,
    0x06: RegisterMap.write_words,
    0x0F: RegisterMap.write_bits,
    0x10: RegisterMap.write_words,
    0x16: RegisterMap.mask_word,
    0x17: RegisterMap.write_and_read,
}


def decoded(pdu: bytes) -> ModbusPDU:
    """Return a request, or the exception that answers it.

    Args:
        pdu: function code and data, at least one byte.
    """
    return request_of(pdu, _FUNCTIONS)
