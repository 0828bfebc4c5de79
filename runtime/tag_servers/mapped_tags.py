"""A tag in the map of coils and registers; its values are words and bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from struct import error, pack, unpack

from scanrack.io_images.enip.listing import BOOL, DWORD, SINT, PlainKind

from ..config.server_table import HIGH_FIRST, MapRow
from ..line.modbus_pdus import ILLEGAL_ADDRESS, ILLEGAL_VALUE, ModbusRefusedError
from .database import Database, Target
from .tag_paths import target_of
from .tag_snapshot import ReadBytes, TagSnapshot, WriteBytes, bits_to_write

COILS, DISCRETE_INPUTS, INPUT_REGISTERS, HOLDING_REGISTERS = (
    "coils",
    "discrete_inputs",
    "input_registers",
    "holding_registers",
)
BITS = (COILS, DISCRETE_INPUTS)
TABLES = (*BITS, INPUT_REGISTERS, HOLDING_REGISTERS)

ADDRESSES = 1 << 16
"""Number of addresses in a table."""


@dataclass(frozen=True)
class MappedTag:
    """A tag in the map.

    Registers and coils are numbered from 0 at the first address of the tag.
    """

    target: Target
    writable: bool
    high_first: bool

    @property
    def size(self) -> int:
        """Number of bytes of a value."""
        return self.target.kind.size

    @property
    def words(self) -> int:
        """Number of registers of a value."""
        return max(1, self.size // 2)

    @property
    def first_bit(self) -> int:
        """The bit of the tag at which the mapped value begins."""
        return 8 * self.target.offset + (self.target.bit or 0)

    @property
    def bits(self) -> int:
        """Number of coils of the tag."""
        return 32 * self.target.count if self.target.kind == DWORD else 1

    def values_at(self, first: int, count: int) -> tuple[int, int]:
        """Return offset and size, in bytes, of the values in a run of registers."""
        begin, end = first // self.words, -(-(first + count) // self.words)
        return self.target.offset + begin * self.size, (end - begin) * self.size

    def to_words(self, data: bytes) -> list[int]:
        """Return the registers for the bytes of values."""
        if self.size == 1:
            return [value & 0xFFFF for value in unpack(self._bytes_form(len(data)), data)]
        return self._in_word_order(unpack(f"<{len(data) // 2}H", data))

    def to_bytes(self, words: Sequence[int]) -> bytes:
        """Return the bytes of the values in registers; refuse a value that does not fit."""
        if self.size > 1:
            return pack(f"<{len(words)}H", *self._in_word_order(words))
        signed = self.target.kind == SINT
        try:
            return pack(
                self._bytes_form(len(words)), *(word - (signed and word >> 15 << 16) for word in words)
            )
        except error:
            raise ModbusRefusedError(ILLEGAL_VALUE) from None

    def _bytes_form(self, count: int) -> str:
        """Return the `struct` format of one-byte values."""
        return f"{count}{'b' if self.target.kind == SINT else 'B'}"

    def _in_word_order(self, words: Sequence[int]) -> list[int]:
        """Return words with each value reversed if the high word comes first."""
        step = self.words
        if not self.high_first or step == 1:
            return list(words)
        return [
            word for index in range(0, len(words), step) for word in reversed(words[index : index + step])
        ]

    def byte_of(self, register: int) -> int:
        """Return the byte of the tag at which a register begins."""
        value_number, word_number = divmod(register, self.words)
        return self.target.offset + 2 * (
            value_number * self.words + (self.words - 1 - word_number if self.high_first else word_number)
        )

    def read_words(self, register: int, count: int, snapshot: TagSnapshot) -> list[int]:
        """Read registers."""
        offset, size = self.values_at(register, count)
        words = self.to_words(snapshot.read(ReadBytes(self.target.symbol.index, offset, size)))
        begin = register % self.words
        return words[begin : begin + count]

    def write_of_words(self, register: int, words: Sequence[int]) -> WriteBytes:
        """Return the operation that writes registers; refuse to write part of a value."""
        if register % self.words or len(words) % self.words:
            raise ModbusRefusedError(ILLEGAL_ADDRESS)
        offset, _ = self.values_at(register, len(words))
        return WriteBytes(self.target.symbol.index, offset, self.to_bytes(words))

    # --- coils

    def read_bits(self, coil: int, count: int, snapshot: TagSnapshot) -> list[bool]:
        """Read coils."""
        offset, shift = divmod(self.first_bit + coil, 8)
        byte_range = ReadBytes(self.target.symbol.index, offset, -(-(shift + count) // 8))
        data = int.from_bytes(snapshot.read(byte_range), "little") >> shift
        return [bool(data >> index & 1) for index in range(count)]

    def write_of_bits(self, coil: int, bits: Sequence[bool]) -> WriteBytes:
        """Return the operation that writes coils."""
        if self.target.kind == BOOL and self.target.bit is None:  # the bit has a byte of its own
            return WriteBytes(self.target.symbol.index, self.target.offset, bytes(bits))
        return bits_to_write(self.target.symbol.index, self.first_bit + coil, bits)


class Gap:
    """Addresses without a tag that read as 0."""

    def read_words(self, _register: int, count: int, _snapshot: TagSnapshot) -> list[int]:
        """Read registers."""
        return [0] * count

    def read_bits(self, _coil: int, count: int, _snapshot: TagSnapshot) -> list[bool]:
        """Read coils."""
        return [False] * count


def mapped(table: str, database: Database, row: MapRow, order: str) -> MappedTag:
    """Return the tag of a row; raise ValueError for an unknown tag or a tag that can't be in the table."""
    target = target_of(database, row.tag)
    kind = target.kind
    if (kind in (BOOL, DWORD)) != (table in BITS):
        allowed_types = "BOOL" if table in BITS else "an integer or a REAL"
        type_name = "BOOL" if kind == DWORD else kind.name
        raise ValueError(f"its type is {type_name}; {table} accept {allowed_types}")
    if not isinstance(kind, PlainKind):
        raise ValueError(f"its type is {kind.name}; map one of its members")
    return MappedTag(
        target, database.may_write(target.tag, target.name, kind), (row.order or order) == HIGH_FIRST
    )
