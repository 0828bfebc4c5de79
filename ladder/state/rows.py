"""Rows of numbers in the compiled program: a list, a view of bytes or the words of an image."""

from __future__ import annotations

import struct
from array import array
from typing import Any

from .fault_log import FaultLog
from .memory import Value

_BITS = 32  # of a DINT


def copy_row(goal: Any, at: int, origin: Any, first: int, count: int) -> None:
    """Copy numbers of one type."""
    if count <= 0:
        return
    row = origin[first : first + count]
    if isinstance(row, list) and not isinstance(goal, list):
        row = array(goal.format, row)
    goal[at : at + count] = row


def move_down(
    faults: FaultLog, site: int, tag: str, row: Any, at: int, count: int, left: int, zero: Value | bytes
) -> None:
    """Move elements of a queue down by one place and clear the last one; fault at the end of the array.

    Args:
        row: numbers, or the bytes of structures.
        at: the first element, or its first byte.
        count: number of elements, including the first one, which is overwritten.
        left: number of elements to the end of the array.
        zero: the new value of the last one; for a structure, its bytes.
    """
    size = len(zero) if isinstance(zero, bytes) else 1
    end = at + min(count, left) * size
    if count > 0:
        row[at : end - size] = row[at + size : end]
    if not 0 < count <= left:
        faults.subscript(site, tag, min(count - 1, left), left)
    row[slice(end - size, end) if isinstance(zero, bytes) else end - 1] = zero


def shift_bits(row: Any, at: int, length: int, new: bool, left: bool) -> bool:
    """Shift the bits of DINTs by one, with a new bit shifted in; return the bit that is shifted out."""
    words = -(-length // _BITS)
    whole = int.from_bytes(array("i", row[at : at + words]).tobytes(), "little")
    last = length - 1
    if left:
        unloaded, whole = whole >> last & 1, whole << 1 | new
    else:
        unloaded, whole = whole & 1, whole >> 1 & ~(1 << last) | new << last
    moved = array("i", (whole & (1 << _BITS * words) - 1).to_bytes(_BITS // 8 * words, "little"))
    row[at : at + words] = moved.tolist() if isinstance(row, list) else moved
    return bool(unloaded)


def store_bytes(row: Any, at: int, left: int, code: str, size: int, data: bytes) -> None:
    """Set integers of a type from all the bytes, up to the end of the array.

    Args:
        left: number of elements to the end of the array.
        code: the type's letter in the `struct` module.
        size: the type's size, bytes.
    """
    count = min(left, -(-len(data) // size))
    missing = count * size - len(data)
    if missing > 0:  # the last element keeps its remaining bytes
        data += struct.pack(f"<{code}", row[at + count - 1])[-missing:]
    if isinstance(row, list):
        row[at : at + count] = struct.unpack_from(f"<{count}{code}", data)
    else:
        row[at : at + count] = array(code, data[: count * size])


def first_of(data: bytes, code: str, size: int, before: int) -> int:
    """Return the first integer of bytes; missing bytes are taken from `before`."""
    if len(data) < size:
        data += struct.pack(f"<{code}", before)[len(data) :]
    first: int = struct.unpack_from(f"<{code}", data)[0]
    return first
