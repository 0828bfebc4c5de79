"""Bytes of terms, for copies between types. Each byte is either a known byte of a known value or unknown.

A value that is copied as a whole to a place of the same type stays the same term. Otherwise the new value is
composed of bytes. Three kinds of bytes and bits are unknown: bytes of a float that are copied to another
type, bytes in gaps between members, and bits without a member in a byte of BOOL members. The last two kinds
are unknown because an earlier copy can have set them.
"""

from __future__ import annotations

import struct
from collections.abc import Hashable, Sequence
from typing import NamedTuple, Protocol

from ...model.types import Elementary, Field
from ..algebra.meaning import BOOL, F32, INT
from ..algebra.numbers import add, bit, bitop, eq, mul, setbit, shr, wrap
from ..algebra.terms import T, const, not_
from .places import kind_of
from .symbols import FLOATS, truth_of, whole_of


class Unknowns(Protocol):
    """Makes variables for bytes that have no terms."""

    def unknown(self, kind: str, lo: int = 0, hi: int = 0) -> T:
        """Return a variable with an unknown value from `lo` to `hi`; a BOOL or a float has no interval."""

    def computed(self, name: Hashable, kind: tuple[str, int, int], *operands: T, strict: bool = False) -> T:
        """Return the variable for a computation. Equal operands have the same variable."""


class Byte(NamedTuple):
    """Byte `at` of a value; 0 is the low byte."""

    t: T
    at: int = 0


class Bits(NamedTuple):
    """A byte of eight Boolean terms, lowest bit first; None for a bit without a member, which is unknown."""

    truths: tuple[T | None, ...]


Pattern = list[Byte | Bits | None]
"""Bytes; None for a gap."""


def constant_bytes(data: bytes) -> Pattern:
    """Return known bytes."""
    return [Byte(const(byte)) for byte in data]


def pack(into: Pattern, offset: int, field: Field, t: T) -> None:
    """Write a field's value into bytes."""
    if field.bit is not None:
        known = into[offset]
        truths = list(known.truths if isinstance(known, Bits) else (None,) * 8)
        truths[field.bit] = truth_of(t)
        into[offset] = Bits(tuple(truths))
        return
    for position in range(max(1, field.type.bits // 8)):
        into[offset + position] = Byte(t, position)


def unpack(cells: Sequence[Byte | Bits | None], offset: int, field: Field, unknowns: Unknowns) -> T:
    """Return the value of a field, read from bytes."""
    if field.bit is not None:
        return _bit_of(cells[offset], field.bit, unknowns)
    kind, count = field.type, max(1, field.type.bits // 8)
    field_cells = cells[offset : offset + count]
    if kind.is_bool:
        return not_(eq(_number(field_cells[0], unknowns), const(0)))
    whole = _slice_of(field_cells)
    if kind.is_real or kind.is_double:
        return _float(field_cells, whole, kind, unknowns)
    if whole is not None and whole.t.kind in FLOATS and (whole.at, kind.bits) == (0, _bits(whole.t)):
        return unknowns.computed("bits", kind_of(kind), whole.t, strict=True)
    if whole is not None and whole.t.kind == INT:
        return wrap(shr(whole.t, 8 * whole.at), kind.wraps)
    number = const(0)
    for position, byte in enumerate(field_cells):
        number = add(number, mul(_number(byte, unknowns), const(1 << 8 * position)))
    return wrap(number, kind.wraps)


def _slice_of(cells: Sequence[Byte | Bits | None]) -> Byte | None:
    """Return the first byte if all bytes are consecutive bytes of one value, else None."""
    first = cells[0]
    if not isinstance(first, Byte) or first.t.op == "const":
        return None
    expected = [Byte(first.t, first.at + place) for place in range(len(cells))]
    return first if list(cells) == expected else None


def _float(
    cells: Sequence[Byte | Bits | None], whole: Byte | None, kind: Elementary, unknowns: Unknowns
) -> T:
    """Return the float in bytes: a value copied as a whole, a constant, or the value of joined bytes."""
    expected = kind_of(kind)[0]
    if whole is not None and whole.at == 0 and whole.t.kind == expected:
        return whole.t
    data = bytearray()
    for byte in cells:
        if not isinstance(byte, Byte) or byte.t.op != "const":
            return _joined(cells, kind, unknowns)
        data.append(_constant_byte(byte))
    return const(struct.unpack(f"<{kind.code}", data)[0], expected)


def _joined(cells: Sequence[Byte | Bits | None], kind: Elementary, unknowns: Unknowns) -> T:
    """Return the variable for the float formed by bytes. Equal bytes have the same variable."""
    known_bytes = [byte for byte in cells if isinstance(byte, Byte)]
    if len(known_bytes) < len(cells):
        return unknowns.unknown(*kind_of(kind))
    name = "joined", tuple(byte.at for byte in known_bytes)
    return unknowns.computed(name, kind_of(kind), *[byte.t for byte in known_bytes], strict=True)


def _bits(t: T) -> int:
    """Return the size in bits of a float term."""
    return 32 if t.kind == F32 else 64


def _constant_byte(byte: Byte) -> int:
    """Return a byte of a constant as a number from 0 to 255."""
    if byte.t.kind in FLOATS:
        return struct.pack("<f" if byte.t.kind == F32 else "<d", byte.t.val)[byte.at]
    return int(byte.t.val) >> 8 * byte.at & 0xFF


def _number(cell: Byte | Bits | None, unknowns: Unknowns) -> T:
    """Return a byte as a number from 0 to 255."""
    if isinstance(cell, Bits):
        number = const(0)
        for k, truth in enumerate(cell.truths):
            number = setbit(number, k, unknowns.unknown(BOOL) if truth is None else truth, -8)
        return number
    if cell is None:
        return unknowns.unknown(INT, 0, 255)
    if cell.t.kind in FLOATS and cell.t.op != "const":
        return unknowns.computed(("byte", cell.at), (INT, 0, 255), cell.t, strict=True)
    if cell.t.op == "const":
        return const(_constant_byte(cell))
    return bitop("band", shr(whole_of(cell.t), 8 * cell.at), const(0xFF))


def _bit_of(cell: Byte | Bits | None, number: int, unknowns: Unknowns) -> T:
    """Return a bit of a byte; a new variable if the bit is unknown."""
    if isinstance(cell, Bits):
        truth = cell.truths[number]
        return unknowns.unknown(BOOL) if truth is None else truth
    if cell is None:
        return unknowns.unknown(BOOL)
    if cell.t.kind in FLOATS:
        return bit(_number(cell, unknowns), number)
    return bit(whole_of(cell.t), 8 * cell.at + number)
