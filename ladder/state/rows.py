"""Rows of numbers in the compiled program. A row is a list, a view of bytes, or the words of an image."""

from __future__ import annotations

import struct
from array import array
from typing import Any

from .fault_log import FaultLog
from .memory import Value

_BITS = 32  # of a DINT


def copy_row(target: Any, target_first: int, source: Any, source_first: int, count: int) -> None:
    """Copy numbers of one type."""
    if count <= 0:
        return
    row = source[source_first : source_first + count]
    if isinstance(row, list) and not isinstance(target, list):
        row = array(target.format, row)
    target[target_first : target_first + count] = row


def move_down(
    faults: FaultLog,
    site: int,
    tag: str,
    row: Any,
    first: int,
    count: int,
    remaining: int,
    zero: Value | bytes,
) -> None:
    """Move elements of a queue down by one and clear the last one; fault at the end of the array.

    Args:
        row: numbers, or the bytes of structures.
        first: the first element, or its first byte.
        count: number of elements, including the first one, which is overwritten.
        remaining: number of elements to the end of the array.
        zero: the new value of the last element; for a structure, its bytes.
    """
    size = len(zero) if isinstance(zero, bytes) else 1
    end = first + min(count, remaining) * size
    if count > 0:
        row[first : end - size] = row[first + size : end]
    if not 0 < count <= remaining:
        faults.subscript(site, tag, min(count - 1, remaining), remaining)
    row[slice(end - size, end) if isinstance(zero, bytes) else end - 1] = zero


def shift_bits(row: Any, first: int, length: int, new: bool, left: bool) -> bool:
    """Shift the bits of DINTs by one, with a new bit shifted in; return the bit that is shifted out."""
    words = -(-length // _BITS)
    bits = int.from_bytes(array("i", row[first : first + words]).tobytes(), "little")
    last = length - 1
    if left:
        unloaded, bits = bits >> last & 1, bits << 1 | new
    else:
        unloaded, bits = bits & 1, bits >> 1 & ~(1 << last) | new << last
    moved = array("i", (bits & (1 << _BITS * words) - 1).to_bytes(_BITS // 8 * words, "little"))
    row[first : first + words] = moved.tolist() if isinstance(row, list) else moved
    return bool(unloaded)


def store_bytes(row: Any, first: int, remaining: int, code: str, size: int, data: bytes) -> None:
    """Set integers of a type from bytes, up to the end of the array.

    Args:
        remaining: number of elements to the end of the array.
        code: the type's letter in the `struct` module.
        size: the type's size, bytes.
    """
    count = min(remaining, -(-len(data) // size))
    missing = count * size - len(data)
    if missing > 0:  # the last element keeps its remaining bytes
        data += struct.pack(f"<{code}", row[first + count - 1])[-missing:]
    if isinstance(row, list):
        row[first : first + count] = struct.unpack_from(f"<{count}{code}", data)
    else:
        row[first : first + count] = array(code, data[: count * size])


def first_of(data: bytes, code: str, size: int, old_value: int) -> int:
    """Return the first integer in bytes; missing bytes come from `old_value`."""
    if len(data) < size:
        data += struct.pack(f"<{code}", old_value)[len(data) :]
    first: int = struct.unpack_from(f"<{code}", data)[0]
    return first
