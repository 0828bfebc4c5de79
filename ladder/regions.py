"""Stretches of memory as bytes, for COP and CPS.

A region is the elements of an array from one on, or a single tag. It is read and
written through its fields, so that structures, arrays and images copy into each
other as they would in a controller's memory.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from .memory import Memory, Value
from .operands import Constant, Group, Place, Resolved
from .tags import Layout, Leaf
from .types import DataType, Elementary, Field, count_of, fields_of, size_of


@dataclass(frozen=True, slots=True)
class Part:
    """A field of an element, and where its values are."""

    field: Field
    leaf: Leaf
    per_element: int


@dataclass(frozen=True, slots=True)
class Region:
    """Where copying starts, and how far it may go.

    Attributes:
        type: type of an element.
        size: bytes of an element.
        parts: its fields.
        indices: subscripts that lead to the first element.
        dims: the dimension of each of them.
        rest: dimensions that are left open.
        array: number of elements of the array; 1 for a single tag.
        text: the address.
    """

    type: DataType
    size: int
    parts: tuple[Part, ...]
    indices: tuple[Resolved, ...]
    dims: tuple[int, ...]
    rest: int
    array: int
    text: str

    def first(self, index_of: Callable[[Resolved, int], int]) -> int:
        """Return the number of the first element, all arrays around it counted."""
        flat = 0
        for index, length in zip(self.indices, self.dims, strict=True):
            flat = flat * length + index_of(index, length)
        return flat * self.rest

    @property
    def fixed_first(self) -> int | None:
        """The number of the first element, None if it is computed."""
        if not all(isinstance(index, Constant) for index in self.indices):
            return None
        return self.first(lambda index, _: int(index.value) if isinstance(index, Constant) else 0)

    def left(self, first: int) -> int:
        """Return how many elements there are from that one to the end of its array."""
        return self.array - first % self.array


def region_of(resolved: Resolved, layout: Layout) -> Region:
    """Return the region that starts at an operand."""
    assert isinstance(resolved, (Place, Group))
    path = resolved.leaf.path if isinstance(resolved, Place) else resolved.path
    rest = () if isinstance(resolved, Place) else resolved.dims
    kind: DataType = resolved.type
    fields = fields_of(kind)
    leaves = [layout.leaf(f"{path}.{each.path}" if each.path else path) for each in fields]
    settled = leaves[0].dims[: len(resolved.indices)]
    elements = count_of(settled) * count_of(rest)
    parts = tuple(Part(each, leaf, leaf.size // elements) for each, leaf in zip(fields, leaves, strict=True))
    array = count_of(rest) if rest else count_of(resolved.array)
    return Region(kind, size_of(kind), parts, resolved.indices, settled, count_of(rest), array, resolved.text)


def copy(memory: Memory, source: Region, first: int, target: Region, at: int, length: int) -> None:
    """Copy bytes; stop at the end of either array.

    Args:
        memory: where both are.
        source: from where.
        first: its first element.
        target: to where.
        at: its first element.
        length: elements of the target.
    """
    count = min(length, target.left(at))
    if count <= 0:
        return
    wanted = count * target.size
    taken = min(source.left(first), -(-wanted // source.size))
    data = take(memory, source, first, taken)[:wanted]
    if len(data) < wanted:
        data += take(memory, target, at, count)[len(data) :]
    put(memory, target, at, count, data)


def take(memory: Memory, region: Region, first: int, count: int) -> bytes:
    """Return elements as bytes."""
    data = bytearray(count * region.size)
    for number in range(count):
        for part in region.parts:
            value = memory.read(part.leaf, (first + number) * part.per_element + part.field.index)
            _pack(data, number * region.size + part.field.offset, part.field, value)
    return bytes(data)


def put(memory: Memory, region: Region, first: int, count: int, data: bytes) -> None:
    """Set elements from bytes."""
    for number in range(count):
        for part in region.parts:
            value = _unpack(data, number * region.size + part.field.offset, part.field)
            memory.write(part.leaf, (first + number) * part.per_element + part.field.index, value)


def _pack(data: bytearray, offset: int, field: Field, value: Value) -> None:
    if field.bit is None:
        struct.pack_into(f"<{field.type.code}", data, offset, value)
    elif value:
        data[offset] |= 1 << field.bit


def _unpack(data: bytes, offset: int, field: Field) -> Value:
    if field.bit is not None:
        return bool(data[offset] >> field.bit & 1)
    value: Value = struct.unpack_from(f"<{field.type.code}", data, offset)[0]
    return value


def plain(region: Region) -> Elementary | None:
    """Return the elementary type of a region that is a list of numbers, None if it is another."""
    if isinstance(region.type, Elementary) and region.parts[0].leaf.dims:
        return region.type
    return None
