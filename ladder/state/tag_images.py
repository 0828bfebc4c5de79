"""Reads and writes the tags of a memory as bytes in a controller's layout."""

from __future__ import annotations

import struct
from functools import cached_property

from scanrack.io_images.enip.listing import Listing, patched

from ..model.operands import Group
from ..model.tags import Leaf, Tag
from ..model.types import BOOL, Elementary, count_of, fields_of, size_of
from .listing import listing_of, string_capacities
from .memory import Memory
from .regions import ArrayRegion, region_of, take

Cell = tuple[Leaf, int, int, str, int | None]
"""A value in one element: its leaf, index within the element, byte, type letter, and bit."""


class TagImage:
    """The bytes of one tag.

    Args:
        memory: the program's memory, valid until the program is edited.

    Attributes:
        size: number of bytes.
    """

    def __init__(self, memory: Memory, tag: Tag) -> None:
        self._memory, self._tag = memory, tag
        count = count_of(tag.dims)
        self._is_bits = tag.type is BOOL and bool(tag.dims)
        self._stride = size_of(tag.type)
        # an array of BOOL has whole words of 32 bits
        self.size = -(-count // 32) * 4 if self._is_bits else self._stride * count
        self._bytes = self._bits if self._is_bits else self._elements

    def read(self, offset: int, size: int) -> bytes:
        """Return bytes of the tag; raise a ValueError if they extend beyond its end."""
        self._check(offset, size)
        return self._bytes(offset, size)

    def write(self, offset: int, data: bytes, keep: bytes = b"") -> None:
        """Set bytes, except the bits that are set in `keep`.

        Raises:
            ValueError: the bytes extend beyond the end of the tag, or a LEN would exceed its STRING; nothing
                has changed.
        """
        self._check(offset, len(data))
        if keep and len(keep) != len(data):
            raise ValueError(f"{self._tag.name}: {len(keep)} bytes of mask for {len(data)} bytes of data")
        unit = 4 if self._is_bits else self._stride
        first, last = offset // unit, -(-(offset + len(data)) // unit)
        begin, size = offset - first * unit, (last - first) * unit
        raw = bytearray(self._bytes(first * unit, size))
        kept_bits = bytearray(b"\xff" * size)
        kept_bits[begin : begin + len(data)] = keep or bytes(len(data))
        raw[begin : begin + len(data)] = patched(bytes(raw[begin : begin + len(data)]), data, keep)
        if self._is_bits:
            self._put_bits(8 * first * unit, raw, kept_bits)
            return
        self._check_strings(raw, begin, len(data))
        for number in range(first, last):
            part = slice((number - first) * unit, (number - first + 1) * unit)
            self._put_element(number, raw[part], kept_bits[part])

    def _check(self, offset: int, size: int) -> None:
        if offset < 0 or size < 1 or offset + size > self.size:
            raise ValueError(f"{self._tag.name}: no bytes {offset} to {offset + size}; it has {self.size}")

    @cached_property
    def _leaf(self) -> Leaf:
        return self._memory.layout.leaf(self._tag.name)

    @cached_property
    def _region(self) -> ArrayRegion:
        tag = self._tag
        return region_of(Group(tag.type, tag.name, (), tag.dims, self._memory.layout, tag.name))

    @cached_property
    def _cells(self) -> tuple[Cell, ...]:
        """The values of the first element, by byte."""
        kind = self._tag.type
        if isinstance(kind, Elementary):
            return ((self._leaf, 0, 0, kind.code, None),)
        name, layout = self._tag.name, self._memory.layout
        cells = [
            (layout.leaf(f"{name}.{part.path}"), part.index, part.offset, part.type.code, part.bit)
            for part in fields_of(kind)
        ]
        return tuple(sorted(cells, key=lambda cell: cell[2]))

    def _values_per_element(self, leaf: Leaf) -> int:
        """Return the number of a leaf's values in one element."""
        return leaf.size // count_of(self._tag.dims)

    # --- reading

    def _bits(self, offset: int, size: int) -> bytes:
        """Return bytes of an array of BOOL, eight elements in each."""
        leaf, read, number = self._leaf, self._memory.read, 0
        for bit in range(8 * offset, min(8 * (offset + size), leaf.size)):
            if read(leaf, bit):
                number |= 1 << bit - 8 * offset
        return number.to_bytes(size, "little")

    def _elements(self, offset: int, size: int) -> bytes:
        """Return bytes of the elements that the range touches, cut to the range."""
        stride = self._stride
        first, last = offset // stride, -(-(offset + size) // stride)
        skip = offset - first * stride
        return take(self._memory, self._region, first, last - first)[skip : skip + size]

    # --- writing

    def _put_bits(self, begin: int, raw: bytearray, kept_bits: bytearray) -> None:
        """Set elements of an array of BOOL from bit `begin` on, except those set in `kept_bits`."""
        leaf = self._leaf
        for bit in range(min(8 * len(raw), leaf.size - begin)):
            if not kept_bits[bit >> 3] >> (bit & 7) & 1:
                self._memory.write(leaf, begin + bit, bool(raw[bit >> 3] >> (bit & 7) & 1))

    def _put_element(self, number: int, raw: bytearray, kept_bits: bytearray) -> None:
        """Set the values of an element, except values with all bits set in `kept_bits`."""
        for leaf, index, offset, code, bit in self._cells:
            if bit is not None:
                if kept_bits[offset] >> bit & 1:
                    continue
                value = bool(raw[offset] >> bit & 1)
            else:
                if kept_bits[offset : offset + struct.calcsize(code)].count(255) == struct.calcsize(code):
                    continue
                value = struct.unpack_from(f"<{code}", raw, offset)[0]
            self._memory.write(leaf, number * self._values_per_element(leaf) + index, value)

    @cached_property
    def _string_capacities(self) -> tuple[tuple[int, int], ...]:
        return tuple(string_capacities(self._tag.type))

    def _check_strings(self, raw: bytearray, begin: int, size: int) -> None:
        """Raise a ValueError for a LEN above the size of DATA, so that no program reads beyond it."""
        for base in range(0, len(raw), self._stride) if self._string_capacities else ():
            for string_offset, capacity in self._string_capacities:
                offset = base + string_offset
                (length,) = struct.unpack_from("<i", raw, offset)
                if offset < begin + size and begin < offset + 4 and not 0 <= length <= capacity:
                    raise ValueError(
                        f"{self._tag.name}: LEN of a STRING is {length}; must be 0 to {capacity}"
                    )


class TagImages:
    """All tags of a program as bytes."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._images: dict[int, TagImage] = {}

    @cached_property
    def listing(self) -> Listing:
        """The tags, in the order of their numbers in `read`."""
        return listing_of(self._memory.layout)

    @cached_property
    def _tags(self) -> list[Tag]:
        return list(self._memory.layout.tags().values())

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {tag.name.upper(): number for number, tag in enumerate(self._tags)}

    def read(self, number: int, offset: int, size: int) -> bytes:
        """Return bytes of a tag by its number; raise a ValueError if the tag or the bytes do not exist."""
        return self._image(number).read(offset, size)

    def write(self, name: str, offset: int, data: bytes, keep: bytes = b"") -> None:
        """Set bytes of a tag by full name, see `TagImage.write`; raise a ValueError for an unknown tag."""
        number = self._numbers.get(name.upper())
        if number is None:
            raise ValueError(f"no tag {name}")
        self._image(number).write(offset, data, keep)

    def _image(self, number: int) -> TagImage:
        """Return the image of a tag by its number; raise a ValueError if no tag has this number."""
        image = self._images.get(number)
        if image is None:
            if number >= len(self._tags):
                raise ValueError(f"no tag number {number}; there are {len(self._tags)}")
            image = self._images[number] = TagImage(self._memory, self._tags[number])
        return image
