"""A tag in the map of coils and registers: its values as words and bits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from struct import Struct

from scanrack.io_images.enip.listing import BOOL, DWORD, SINT, PlainKind

from ..config.server_table import HIGH_FIRST, MapRow
from ..line.modbus_pdus import ILLEGAL_VALUE, ModbusRefusedError, number_of
from .database import Database, Target
from .tag_paths import target_of
from .tag_snapshot import ReadBytes, TagSnapshot, WriteBytes

COILS, DISCRETE_INPUTS, INPUT_REGISTERS, HOLDING_REGISTERS = (
    "coils",
    "discrete_inputs",
    "input_registers",
    "holding_registers",
)
BITS = (COILS, DISCRETE_INPUTS)
TABLES = (*BITS, INPUT_REGISTERS, HOLDING_REGISTERS)


@dataclass(frozen=True)
class MappedTag:
    """A tag in the map."""

    target: Target
    writable: bool
    high_first: bool

    @property
    def size(self) -> int:
        """Size of a value, bytes."""
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
        """Number of coils that it occupies."""
        return 32 * self.target.count if self.target.kind == DWORD else 1

    def values_at(self, first: int, count: int) -> tuple[int, int]:
        """Return offset and size of the values to which a run of its registers belongs."""
        begin, end = first // self.words, -(-(first + count) // self.words)
        return self.target.offset + begin * self.size, (end - begin) * self.size

    def to_words(self, data: bytes) -> list[int]:
        """Return values as registers."""
        if self.size == 1:
            signed = self.target.kind == SINT
            return [
                int.from_bytes(data[i : i + 1], "little", signed=signed) & 0xFFFF for i in range(len(data))
            ]
        return self._turned(Struct(f"<{len(data) // 2}H").unpack(data))

    def to_bytes(self, words: Sequence[int]) -> bytes:
        """Return registers as values; refused if a value does not fit."""
        if self.size > 1:
            return Struct(f"<{len(words)}H").pack(*self._turned(words))
        signed = self.target.kind == SINT
        try:
            return b"".join(
                (word - (word >> 15 << 16 if signed else 0)).to_bytes(1, "little", signed=signed)
                for word in words
            )
        except OverflowError:
            raise ModbusRefusedError(ILLEGAL_VALUE) from None

    def _turned(self, words: Sequence[int]) -> list[int]:
        """Reverse the words of each value if it begins with the high word."""
        step = self.words
        if not self.high_first or step == 1:
            return list(words)
        return [word for at in range(0, len(words), step) for word in reversed(words[at : at + step])]

    def byte_of(self, place: int) -> int:
        """Return the offset of the register at a place."""
        value, word = divmod(place, self.words)
        return self.target.offset + 2 * (
            value * self.words + (self.words - 1 - word if self.high_first else word)
        )

    def read_words(self, place: int, count: int, snapshot: TagSnapshot) -> list[int]:
        """Read registers."""
        offset, size = self.values_at(place, count)
        found = self.to_words(snapshot.read(ReadBytes(self.target.symbol.index, offset, size)))
        begin = place % self.words
        return found[begin : begin + count]

    # --- coils

    def read_bits(self, place: int, count: int, snapshot: TagSnapshot) -> list[bool]:
        """Read coils."""
        offset, size, shift = self._span(place, count)
        data = (
            int.from_bytes(snapshot.read(ReadBytes(self.target.symbol.index, offset, size)), "little")
            >> shift
        )
        return [bool(data >> at & 1) for at in range(count)]

    def change(self, place: int, bits: Sequence[bool]) -> WriteBytes:
        """Return the write of coils; other bits of their bytes stay as they are."""
        offset, size, shift = self._span(place, len(bits))
        on = number_of(bits) << shift
        if self.target.kind == BOOL and self.target.bit is None:
            return WriteBytes(self.target.symbol.index, offset, on.to_bytes(1, "little"))
        others = ((1 << 8 * size) - 1) & ~(((1 << len(bits)) - 1) << shift)
        masks = (each.to_bytes(size, "little") for each in (on, others))
        return WriteBytes(self.target.symbol.index, offset, *masks)

    def _span(self, place: int, count: int) -> tuple[int, int, int]:
        """Return the first byte of coils, the number of bytes, and the first bit in them."""
        first = self.first_bit + place
        return first // 8, -(-(first % 8 + count) // 8), first % 8


class Gap:
    """Addresses without a tag that read as 0."""

    def read_words(self, _place: int, count: int, _snapshot: TagSnapshot) -> list[int]:
        """Read registers."""
        return [0] * count

    def read_bits(self, _place: int, count: int, _snapshot: TagSnapshot) -> list[bool]:
        """Read coils."""
        return [False] * count


def mapped(table: str, database: Database, row: MapRow, order: str) -> MappedTag:
    """Return the tag of a table's row; ValueError if there is no such tag, or it can't be in that table."""
    target = target_of(database, row.tag)
    kind = target.kind
    if (kind in (BOOL, DWORD)) != (table in BITS):
        expected = "BOOL" if table in BITS else "an integer or a REAL"
        raise ValueError(f"its type is {'BOOL' if kind == DWORD else kind.name}: {table} take {expected}")
    if not isinstance(kind, PlainKind):
        raise ValueError(f"its type is {kind.name}: give a member of it")
    return MappedTag(
        target, database.may_write(target.tag, target.name, kind), (row.order or order) == HIGH_FIRST
    )
