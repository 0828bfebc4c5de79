"""Regions of memory as bytes, for COP and CPS.

A region is a single tag, or an array from one element on. It is read and written through its fields, so
structures, arrays and images are copied as in a controller's memory.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Sequence
from dataclasses import field, replace

from scanrack.io_images.records import record

from ..model.arithmetic import real, whole, wrap
from ..model.operands import Constant, Group, Place, Resolved
from ..model.tags import OWN, Leaf
from ..model.types import DINT, DataType, Elementary, Field, Structure, count_of, fields_of, size_of
from .memory import BytesAt, Column, Store, Value


@record
class FieldSlice:
    """A field of an element, and its leaf."""

    field: Field
    leaf: Leaf
    per_element: int  # number of the leaf's values in one element

    def indices(self, first: int, count: int) -> range:
        """Return the flat indices of its values in `count` elements of the region."""
        begin = first * self.per_element + self.field.index
        return range(begin, begin + count * self.per_element, self.per_element)


@record
class ArrayRegion:
    """A tag, or an array from one element on: the source or target of a copy."""

    type: DataType  # of an element
    size: int  # bytes per element
    parts: tuple[FieldSlice, ...]  # fields of an element
    indices: tuple[Resolved, ...]  # subscripts of the first element
    dims: tuple[int, ...]  # the dimension of each subscript
    rest: int  # elements per step of the last subscript: the product of the dimensions without one
    array: int  # number of elements of the array; 1 for a single tag
    text: str
    root: str = ""  # in an add-on instruction its `Leaf.root`; "" in a program
    whole: bool = False  # whether it is a whole InOut; only its store has the length
    fixed_first: int | None = None  # the flat index of the first element, None if it is computed
    fillings: dict[str, bytes] = field(default_factory=dict, compare=False)  # elements by text of a value

    def first(self, index_of: Callable[[Resolved, int], int], dims: tuple[int, ...] = ()) -> int:
        """Return the flat index of the first element; `index_of` evaluates a subscript, given its limit."""
        flat = 0
        for index, length in zip(self.indices, dims or self.dims, strict=True):
            flat = flat * length + index_of(index, length)
        return flat * self.rest

    def left(self, first: int, store: Store) -> int:
        """Return the number of elements from `first` to the end of the array in the store."""
        return max(0, store.left - first) if self.whole else self.fixed_left(first)

    def fixed_left(self, first: int) -> int:
        """Return the number of elements from `first` to the end, for a region other than a whole InOut."""
        return self.array - first % self.array


def region_of(resolved: Resolved, *, extent: bool = False) -> ArrayRegion:
    """Return the region that starts at an operand; with `extent`, only its first field."""
    assert isinstance(resolved, (Place, Group))
    own_dims = () if isinstance(resolved, Place) else resolved.dims
    kind: DataType = resolved.type
    fields = fields_of(kind)[:1] if extent else fields_of(kind)
    if isinstance(resolved, Place):
        path, leaves = resolved.leaf.path, [resolved.leaf]
    else:
        path = resolved.path
        leaves = [resolved.layout.leaf(f"{path}.{part.path}" if part.path else path) for part in fields]
    indexed_dims = leaves[0].dims[: len(resolved.indices)]
    elements = count_of(indexed_dims) * count_of(own_dims)
    parts = tuple(
        FieldSlice(part, leaf, leaf.size // elements) for part, leaf in zip(fields, leaves, strict=True)
    )
    array = count_of(own_dims) if own_dims else count_of(resolved.array)
    root = leaves[0].root
    is_whole = root not in ("", OWN) and path.upper() == root
    region = ArrayRegion(
        kind,
        size_of(kind),
        parts,
        indices=resolved.indices,
        dims=indexed_dims,
        rest=count_of(own_dims),
        array=array,
        text=resolved.text,
        root=root,
        whole=is_whole,
    )
    if not all(isinstance(index, Constant) for index in resolved.indices):
        return region
    return replace(region, fixed_first=region.first(lambda index, _length: int(index.value)))  # type: ignore[union-attr]


End = tuple[Store, ArrayRegion, int]
"""One side of a copy: store, region, first element."""


def copy(source: End, target: End, length: int) -> None:
    """Copy the bytes of `length` target elements, but stop at the end of either array."""
    source_store, source_region, source_first = source
    store, region, first = target
    count = min(length, region.left(first, store))
    if count <= 0:
        return
    needed = count * region.size
    source_count = min(source_region.left(source_first, source_store), -(-needed // source_region.size))
    data = take(source_store, source_region, source_first, source_count)[:needed]
    place = _bytes_of(store, region, first)
    if place is not None:
        tag, begin = place
        tag.B[begin : begin + len(data)] = data
        return
    if len(data) < needed:
        data += take(store, region, first, count)[len(data) :]
    put(store, region, first, count, data)


def fill(target: End, length: int, value: Value) -> None:
    """Set elements, up to the end of the array; convert the value for each member of a structure."""
    store, region, first = target
    count = min(length, region.left(first, store))
    place = _bytes_of(store, region, first) if count > 0 else None
    if place is not None:
        tag, begin = place
        tag.B[begin : begin + count * region.size] = filled(region, value) * count
        return
    for part in region.parts:
        _write_field(store, part, first, [converted(part.leaf.type, value)] * count)


def filled(region: ArrayRegion, value: Value) -> bytes:
    """Return an element with the same value in all members."""
    text = repr(value)  # a key that distinguishes 0.0 and -0.0
    if text in region.fillings:
        return region.fillings[text]
    data = bytearray(region.size)
    for part in fields_of(region.type):
        _pack(data, region.size, part, [converted(part.type, value)])
    if len(region.fillings) >= _MOST_FILLINGS:
        region.fillings.clear()
    region.fillings[text] = bytes(data)
    return region.fillings[text]


_MOST_FILLINGS = 8


def _bytes_of(store: Store, region: ArrayRegion, first: int) -> BytesAt | None:
    """Return the bytes of a region from an element on; None if it is not in bytes, or an array of BOOL."""
    part = region.parts[0]
    if isinstance(region.type, Elementary) and region.type.is_bool:
        return None
    place = store.bytes_at(part.leaf, first * part.per_element + part.field.index)
    return None if place is None else (place[0], place[1] - part.field.offset)


def converted(kind: Elementary, value: Value) -> Value:
    """Return a number converted to a type, without setting flags or recording faults."""
    if kind.is_bool:
        return bool(value)
    if kind.is_double:
        return float(value)
    if kind.is_real:
        return real(value)
    return wrap(whole(value) if isinstance(value, float) else int(value), kind.wraps)


def take(memory: Store, region: ArrayRegion, first: int, count: int) -> bytes:
    """Return `count` elements of a region as bytes, from element `first` on."""
    place = _bytes_of(memory, region, first)
    if place is not None:
        tag, begin = place
        return bytes(tag.B[begin : begin + count * region.size])
    data = bytearray(count * region.size)
    for part in region.parts:
        column = _column(memory, part, first, count)
        if column is not None:
            array, selected = column
            values = array[selected]
        else:
            values = [memory.read(part.leaf, index) for index in part.indices(first, count)]
        _pack(data, region.size, part.field, values)
    return bytes(data)


def put(memory: Store, region: ArrayRegion, first: int, count: int, data: bytes) -> None:
    """Set `count` elements of a region from bytes, from element `first` on."""
    data = data[: count * region.size]
    place = _bytes_of(memory, region, first)
    if place is not None:
        tag, begin = place
        tag.B[begin : begin + len(data)] = data
        return
    for part in region.parts:
        _write_field(memory, part, first, _unpack(data, region.size, part.field, count))


def _write_field(store: Store, part: FieldSlice, first: int, values: Sequence[Value]) -> None:
    """Set a field in as many elements as there are values."""
    column = _column(store, part, first, len(values))
    if column is not None:
        array, selected = column
        array[selected] = values
        return
    for index, value in zip(part.indices(first, len(values)), values, strict=True):
        store.write(part.leaf, index, value)


def _column(store: Store, part: FieldSlice, first: int, count: int) -> Column | None:
    """Return the slice of a field's values over several elements; None if accessed one by one."""
    begin = first * part.per_element + part.field.index
    return store.column(part.leaf, begin, part.per_element, count) if count > 1 else None


def _pack(data: bytearray, size: int, field: Field, values: list[Value]) -> None:
    """Pack the values of a field into the bytes of elements of this size."""
    if field.bit is not None:
        for number, value in enumerate(values):
            if value:
                data[number * size + field.offset] |= 1 << field.bit
        return
    if len(values) == 1:
        struct.pack_into(f"<{field.type.code}", data, field.offset, values[0])
        return
    packed = struct.pack(f"<{len(values)}{field.type.code}", *values)
    width = len(packed) // len(values)
    if width == size:
        data[:] = packed
        return
    for byte in range(width):
        data[field.offset + byte :: size] = packed[byte::width]


def _unpack(data: bytes, size: int, field: Field, count: int) -> list[Value]:
    """Return the values of a field in elements of this size."""
    if field.bit is not None:
        return [bool(byte >> field.bit & 1) for byte in data[field.offset :: size]]
    if count == 1:
        return list(struct.unpack_from(f"<{field.type.code}", data, field.offset))
    width = struct.calcsize(f"<{field.type.code}")
    if width == size:
        return list(struct.unpack(f"<{count}{field.type.code}", data))
    packed = bytearray(count * width)
    for byte in range(width):
        packed[byte::width] = data[field.offset + byte :: size]
    return list(struct.unpack(f"<{count}{field.type.code}", packed))


MOST_COPIED_SINGLY = 40
"""Maximum number of values in a structure that is copied variable by variable."""


def copied_singly(operands: Sequence[object]) -> bool:
    """Return whether a copy with these operands copies one structure value by value."""
    if len(operands) != 3:
        return False
    source, target, length = operands
    if not isinstance(source, Group) or not isinstance(target, Group) or not isinstance(length, Constant):
        return False
    is_array = bool(target.array or target.dims or target.frame)  # any length copies a structure outside one
    return (
        isinstance(source.type, Structure)
        and (source.type is target.type or source.type == target.type)
        and all(isinstance(index, Constant) for index in (*source.indices, *target.indices))
        and (length == Constant(1, DINT) if is_array else length.value >= 1)
        and len(fields_of(source.type)) <= MOST_COPIED_SINGLY
    )


def plain(region: ArrayRegion) -> Elementary | None:
    """Return the elementary type of a region that is a list of numbers; None for other regions."""
    if isinstance(region.type, Elementary) and (region.parts[0].leaf.dims or region.whole):
        return region.type
    return None
