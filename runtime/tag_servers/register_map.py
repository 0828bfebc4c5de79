"""Tags as Modbus coils and registers, according to the map in a rack file [Modbus V1.1b3, chapter 6].

| function | effect |
|---|---|
| 01, 02 | read coils, discrete inputs |
| 03, 04 | read holding registers, input registers |
| 05, 0F | write one coil, several |
| 06, 10 | write one register, several |
| 16 | set and clear bits of a register |
| 17 | write registers, then read some |

A request is carried out at one instant, or refused as a whole:

| exception | reason |
|---|---|
| 01h | an unsupported function |
| 02h | an address without a tag, a write of half a value, or a write to a read-only tag |
| 03h | a count or a value that is not allowed |
| 04h | the program rejects the value |

With `fill`, addresses without a tag read as 0 if they are below the last address in their table.
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
    index: int  # of the coil or register in the row
    addresses_left: int  # number of the row's addresses from this one on


_GAP = _Cell(Gap(), 0, 1)


class RegisterMap:
    """The coils and registers of a rack.

    Args:
        table: the map in the rack file.

    Attributes:
        problems: a sentence for each row that is skipped because its tag is unknown or can't be in the table,
            or because one of its addresses already has a tag.
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
        self._filled_to = {  # by table: addresses below this one have a tag or read as 0
            name: max(cells, default=0) if table.fill else 0 for name, cells in self._cells.items()
        }

    def _add(self, table: str, row: MappedTag, address: int) -> None:
        """Put a tag's coils or registers at its addresses; raise ValueError if one is taken or too high."""
        cells = self._cells[table]
        size = row.bits if table in BITS else row.words * row.target.count
        if address + size > ADDRESSES:
            raise ValueError(
                f"it needs {size} addresses from {address} on; the last valid address is {ADDRESSES - 1}"
            )
        for taken_address in range(address, address + size):
            cell = cells.get(taken_address)
            if cell is not None and isinstance(cell.row, MappedTag):
                raise ValueError(f"{cell.row.target.name} already has an address from {address} on")
        for index in range(size):
            cells[address + index] = _Cell(row, index, size - index)

    def answer(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        """Carry out a request; return the reply or exception.

        Args:
            request: a request from `decoded`.
        """
        return carried_out(request, lambda valid_request: self._carry_out(valid_request, snapshot))

    def _carry_out(self, request: ModbusPDU, snapshot: TagSnapshot) -> ModbusPDU:
        try:
            return _FUNCTIONS[request.function_code](self, request, snapshot)
        except CipRefusedError:  # the program rejects the value
            raise ModbusRefusedError(FAILURE) from None

    def read_bits(self, table: str, request: ModbusPDU, snapshot: TagSnapshot) -> list[bool]:
        """Read coils or discrete inputs."""
        runs = self._rows_at(table, request.address, request.count)
        return [
            bit for row, offset, item_count in runs for bit in row.read_bits(offset, item_count, snapshot)
        ]

    def read_words(self, table: str, first: int, count: int, snapshot: TagSnapshot) -> list[int]:
        """Read holding or input registers."""
        runs = self._rows_at(table, first, count)
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
        ((row, offset, _),) = self._writable_rows_at(HOLDING_REGISTERS, request.address, 1)
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
        """Write registers, and then read registers."""
        span = request.read_address, request.read_count
        self._rows_at(HOLDING_REGISTERS, *span)  # an invalid read must refuse the request before the write
        self._write(HOLDING_REGISTERS, request.write_address, request.write_registers, snapshot)
        registers = self.read_words(HOLDING_REGISTERS, *span, snapshot)
        return words.ReadWriteMultipleRegistersResponse(registers=registers)

    def _write(self, table: str, first: int, values: Sequence[Any], snapshot: TagSnapshot) -> None:
        """Write coils or registers; if clients may not write one of them, refuse before the first write."""
        changes, index = [], 0
        for row, offset, item_count in self._writable_rows_at(table, first, len(values)):
            row_values, index = values[index : index + item_count], index + item_count
            changes.append(
                row.write_of_bits(offset, row_values)
                if table in BITS
                else row.write_of_words(offset, row_values)
            )
        for change in changes:
            snapshot.write(change)

    def _writable_rows_at(self, table: str, first: int, count: int) -> list[tuple[MappedTag, int, int]]:
        """Return the rows at addresses (see `_rows_at`); refuse if clients may not write one of them."""
        rows = []
        for row, offset, item_count in self._rows_at(table, first, count):
            if isinstance(row, Gap) or not row.writable:
                raise ModbusRefusedError(ILLEGAL_ADDRESS)
            rows.append((row, offset, item_count))
        return rows

    def _rows_at(self, table: str, first: int, count: int) -> list[tuple[MappedTag | Gap, int, int]]:
        """Return the rows at addresses, each with its first coil or register and their count."""
        cells, filled_to, rows = self._cells[table], self._filled_to[table], []
        address, end_address = first, first + count
        while address < end_address:
            cell = cells.get(address) or (_GAP if address < filled_to else None)
            if cell is None:
                raise ModbusRefusedError(ILLEGAL_ADDRESS)
            item_count = min(cell.addresses_left, end_address - address)
            rows.append((cell.row, cell.index, item_count))
            address += item_count
        return rows


def _confirmation(request: ModbusPDU) -> ModbusPDU:
    """Return the reply to a write: the request for one value, or address and count for several values."""
    replies = {0x0F: bits.WriteMultipleCoilsResponse, 0x10: words.WriteMultipleRegistersResponse}
    make_reply = replies.get(request.function_code)
    return request if make_reply is None else make_reply(address=request.address, count=request.count)


_FUNCTIONS: Mapping[int, Callable[[RegisterMap, Any, TagSnapshot], ModbusPDU]] = {
    0x01: lambda registers, request, snapshot: bits.ReadCoilsResponse(
        bits=registers.read_bits(COILS, request, snapshot)
    ),
    0x02: lambda registers, request, snapshot: bits.ReadDiscreteInputsResponse(
        bits=registers.read_bits(DISCRETE_INPUTS, request, snapshot)
    ),
    0x03: lambda registers, request, snapshot: words.ReadHoldingRegistersResponse(
        registers=registers.read_words(HOLDING_REGISTERS, request.address, request.count, snapshot)
    ),
    0x04: lambda registers, request, snapshot: words.ReadInputRegistersResponse(
        registers=registers.read_words(INPUT_REGISTERS, request.address, request.count, snapshot)
    ),
    0x05: RegisterMap.write_bits,
    0x06: RegisterMap.write_words,
    0x0F: RegisterMap.write_bits,
    0x10: RegisterMap.write_words,
    0x16: RegisterMap.mask_word,
    0x17: RegisterMap.write_and_read,
}


def decoded(pdu: bytes) -> ModbusPDU:
    """Return a decoded request, or the exception to reply with.

    Args:
        pdu: function code and data, at least one byte.
    """
    return request_of(pdu, _FUNCTIONS)
