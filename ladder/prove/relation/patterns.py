"""Bytes of terms, for copies between types: each byte is a known byte of a known value, or unknown.

A value that arrives whole at a place of its own type is that value. Otherwise the new value is put together
from bytes. Three kinds of bytes and bits are unknown: bytes of a float that arrive at another type, bytes in
gaps between members, and bits of a byte of BOOL members that belong to no member. An earlier copy may have
set the last two.
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
        """Return a new variable of a kind and an interval."""

    def computed(self, name: Hashable, kind: tuple[str, int, int], *operands: T, strict: bool = False) -> T:
        """Return the variable for a computation; equal operands give the same variable."""


class Byte(NamedTuple):
    """Byte `at` of a value; 0 is the low byte."""

    t: T
    at: int = 0


class Bits(NamedTuple):
    """A byte of eight Boolean terms, lowest bit first; None for a bit without a member, which is unknown."""

    truths: tuple[T | None, ...]


Pattern = list[Byte | Bits | None]
"""Bytes; None in a gap."""


def constant_bytes(data: bytes) -> Pattern:
    """Return known bytes."""
    return [Byte(const(byte)) for byte in data]


def pack(into: Pattern, offset: int, field: Field, t: T) -> None:
    """Write a value into bytes at its field."""
    if field.bit is not None:
        known = into[offset]
        truths = list(known.truths if isinstance(known, Bits) else (None,) * 8)
        truths[field.bit] = truth_of(t)
        into[offset] = Bits(tuple(truths))
        return
    for place in range(max(1, field.type.bits // 8)):
        into[offset + place] = Byte(t, place)


def unpack(cells: Sequence[Byte | Bits | None], offset: int, field: Field, unknowns: Unknowns) -> T:
    """Return the value of a field in bytes."""
    if field.bit is not None:
        return _bit_of(cells[offset], field.bit, unknowns)
    kind, count = field.type, max(1, field.type.bits // 8)
    part = cells[offset : offset + count]
    if kind.is_bool:
        return not_(eq(_number(part[0], unknowns), const(0)))
    whole = _slice_of(part)
    if kind.is_real or kind.is_double:
        return _float(part, whole, kind, unknowns)
    if whole is not None and whole.t.kind in FLOATS and (whole.at, kind.bits) == (0, _bits(whole.t)):
        return unknowns.computed("bits", kind_of(kind), whole.t, strict=True)
    if whole is not None and whole.t.kind == INT:
        return wrap(shr(whole.t, 8 * whole.at), kind.wraps)
    number = const(0)
    for place, byte in enumerate(part):
        number = add(number, mul(_number(byte, unknowns), const(1 << 8 * place)))
    return wrap(number, kind.wraps)


def _slice_of(here: Sequence[Byte | Bits | None]) -> Byte | None:
    """Return the first byte if the bytes are consecutive bytes of one value, else None."""
    first = here[0]
    if not isinstance(first, Byte) or first.t.op == "const":
        return None
    expected = [Byte(first.t, first.at + place) for place in range(len(here))]
    return first if list(here) == expected else None


def _float(here: Sequence[Byte | Bits | None], whole: Byte | None, kind: Elementary, unknowns: Unknowns) -> T:
    expected = kind_of(kind)[0]
    if whole is not None and whole.at == 0 and whole.t.kind == expected:
        return whole.t
    data = bytearray()
    for byte in here:
        if not isinstance(byte, Byte) or byte.t.op != "const":
            return _joined(here, kind, unknowns)
        data.append(_constant_byte(byte))
    return const(struct.unpack(f"<{kind.code}", data)[0], expected)


def _joined(here: Sequence[Byte | Bits | None], kind: Elementary, unknowns: Unknowns) -> T:
    """Return the float that bytes form: the same variable for the same bytes of the same values."""
    known = [byte for byte in here if isinstance(byte, Byte)]
    if len(known) < len(here):
        return unknowns.unknown(*kind_of(kind))
    name = "joined", tuple(byte.at for byte in known)
    return unknowns.computed(name, kind_of(kind), *[byte.t for byte in known], strict=True)


def _bits(t: T) -> int:
    return 32 if t.kind == F32 else 64


def _constant_byte(each: Byte) -> int:
    if each.t.kind in FLOATS:
        return struct.pack("<f" if each.t.kind == F32 else "<d", each.t.val)[each.at]
    return int(each.t.val) >> 8 * each.at & 0xFF


def _number(each: Byte | Bits | None, unknowns: Unknowns) -> T:
    """Return a byte as a number from 0 to 255."""
    if isinstance(each, Bits):
        number = const(0)
        for k, truth in enumerate(each.truths):
            number = setbit(number, k, unknowns.unknown(BOOL) if truth is None else truth, -8)
        return number
    if each is None:
        return unknowns.unknown(INT, 0, 255)
    if each.t.kind in FLOATS and each.t.op != "const":
        return unknowns.computed(("byte", each.at), (INT, 0, 255), each.t, strict=True)
    if each.t.op == "const":
        return const(_constant_byte(each))
    return bitop("band", shr(whole_of(each.t), 8 * each.at), const(0xFF))


def _bit_of(each: Byte | Bits | None, number: int, unknowns: Unknowns) -> T:
    if isinstance(each, Bits):
        truth = each.truths[number]
        return unknowns.unknown(BOOL) if truth is None else truth
    if each is None or each.t.kind in FLOATS:
        return bit(_number(each, unknowns), number) if each is not None else unknowns.unknown(BOOL)
    return bit(whole_of(each.t), 8 * each.at + number)
