"""Reads the forces in a document: the forced addresses and their values [1756-RM084, forced tag data].

| form | example |
|---|---|
| beside a value | `ForceValue="1"` for a BOOL; `2#...._0..._...1`, where a dot is a bit without a force |
| bytes of the tag | `<ForceData>00 00 00 00 01 00 FF FF 01 00 B8 22</ForceData>` |
| bytes as a list | `<ForceData Format="L5K"><![CDATA[[0,0,1,0,3,0]]]></ForceData>` |

The bytes are three blocks, each as large as the tag's memory: its image, the mask of forced bits, and the
forced values. The import only lists forces; `run --forces` applies them.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from scanrack.ladder.model.types import BOOL, REAL, DataType, Elementary, Structure, count_of
from scanrack.ladder.state.memory import element_text

from ..xml.data import Data
from ..xml.records import Element
from .datatypes import Types
from .layouts import Layouts
from .raw import RawReader, bytes_in, fits
from .value_texts import ValueTextError

Force = tuple[str, bool | int | float]
"""The part of an address after the tag's name, and the forced value."""


class _Place(NamedTuple):
    """The place of a value in a tag's memory."""

    path: str  # the end of its address, after the tag's name
    type: Elementary
    offset: int  # byte
    bit: int | None  # of a BOOL in the byte; None for other types


_LIST = re.compile(r"\s*\[\s*(-?\d{1,3}(?:\s*,\s*-?\d{1,3})*+)\s*\]\s*")
_PATTERN = re.compile(r"2#([01.]{1,64})")
_INDEX = re.compile(r"\[\d{1,9}(?:,\d{1,9})*+\]")


def forces_of(forced: Sequence[Data], kind: DataType, dims: tuple[int, ...], types: Types) -> Iterator[Force]:
    """Yield the forces of a tag, from `Data` elements that show forces or otherwise from its `ForceData`.

    Raises:
        ValueTextError: the force data can't be read.
    """
    elements = [data.element for data in forced]
    force_data = [element for element in elements if element.tag == "ForceData"]
    forces: list[Force] = []
    for element in elements:
        if element.tag != "ForceData":
            for child in element.iterchildren("*"):
                forces += _decorated_forces(child)
    if forces or not force_data:
        yield from forces
    else:
        yield from _forces_in_bytes(_bytes(force_data[0]), kind, dims, types)


def _forces_in_bytes(data: bytes, kind: DataType, dims: tuple[int, ...], types: Types) -> Iterator[Force]:
    """Yield the forces in force data, which has the image, the mask and the values of a tag."""
    size, remainder = divmod(len(data), 3)
    mask, values = data[size : 2 * size], data[2 * size :]
    if not any(data if remainder else mask):
        return
    if remainder or not fits(mask, kind, dims, types.layouts):
        raise ValueTextError(f"its force data have {len(data)} bytes, which are not three times its memory")
    if not (isinstance(kind, Elementary) or types.layouts.is_known(kind)):
        raise ValueTextError(f"the order of the bytes of a {kind.name} is not known")
    for path, value_kind, offset, bit in _ForceMask(mask, types.layouts).places(kind, dims, 0):
        if bit is None:
            width = max(8, value_kind.bits)
            mask_bits, value_bits = (
                int.from_bytes(block[offset : offset + width // 8], "little") for block in (mask, values)
            )
            yield from _forces_of_bits(path, value_kind, mask_bits, value_bits, width)
        elif mask[offset] >> bit & 1:
            yield path, bool(values[offset] >> bit & 1)


def image_of(forced: Sequence[Data], kind: DataType, layouts: Layouts) -> Any:
    """Return the value of a tag that has only force data, from the image in that data; None for zeros."""
    for record in forced:
        if record.element.tag == "ForceData":
            data = _bytes(record.element)
            image = data[: len(data) // 3]
            if layouts.is_known(kind) and fits(image, kind, (), layouts):
                return RawReader(image, layouts, keep_zeros=False).read(kind, ())
    return None


def _bytes(element: Element) -> bytes:
    """Return the bytes of a ForceData element, from hexadecimal text or from a list."""
    text = "".join(element.itertext())
    match = _LIST.fullmatch(text)
    if match:
        return bytes(int(byte) & 0xFF for byte in match[1].split(","))
    data = bytes_in(element)
    if data is None:
        raise ValueTextError(f"its force data {text.strip()[:20]!r} are not bytes")
    return data


def _forces_of_bits(path: str, kind: Elementary | None, mask: int, value: int, width: int) -> Iterator[Force]:
    """Yield the force of a whole value, or of its bits if only some are forced.

    Args:
        kind: the type of the value; None for a signed integer of `width` bits.
    """
    if mask == (1 << width) - 1:
        yield path, _number(kind, value, width)
        return
    for bit in range(width):
        if mask >> bit & 1:
            yield f"{path}.{bit}", bool(value >> bit & 1)


def _number(kind: Elementary | None, pattern: int, width: int) -> int | float:
    """Return the value of a bit pattern."""
    if kind is not None and (kind.is_real or kind.is_double):
        value: float = struct.unpack(f"<{kind.code}", pattern.to_bytes(width // 8, "little"))[0]
        return value
    is_negative = (kind is None or kind.is_signed) and bool(pattern >> (width - 1))
    return pattern - (1 << width) if is_negative else pattern


# --- beside values


def _decorated_forces(element: Element) -> Iterator[Force]:
    """Yield the forces of a decorated value and of the values in it, in document order."""
    todo = [(element, "")]
    while todo:
        node, path = todo.pop()
        forced = node.get("ForceValue")
        if forced is not None:
            yield from _forces_in_text(path, forced, node.get("DataType", ""))
        children = []
        for child in node.iterchildren("*"):
            index = child.get("Index", "")
            if child.tag == "Structure":
                children.append((child, path))
            elif child.tag == "Element" and _INDEX.fullmatch(index):
                children.append((child, path + index))
            elif child.get("Name"):
                children.append((child, f"{path}.{child.get('Name')}"))
        todo += reversed(children)


def _forces_in_text(path: str, text: str, type_name: str) -> Iterator[Force]:
    """Yield the forces in a `ForceValue`: 0, 1 or a pattern of bits."""
    if text in ("0", "1"):
        yield path, text == "1"
        return
    match = _PATTERN.fullmatch(text.replace("_", ""))
    if match is None:
        raise ValueTextError(f"its force {text[:40]!r} is not a pattern of bits")
    bits = match[1]
    mask = int(re.sub("[01]", "1", bits).replace(".", "0"), 2)
    value = int(bits.replace(".", "0"), 2)
    yield from _forces_of_bits(path, REAL if type_name.upper() == "REAL" else None, mask, value, len(bits))


# --- in bytes


class _ForceMask:
    """Finds the places of a tag's values; elements of arrays without forced bits are skipped."""

    def __init__(self, mask: bytes, layouts: Layouts) -> None:
        self._mask, self._layouts = mask, layouts

    def places(self, kind: DataType, dims: tuple[int, ...], begin: int) -> Iterator[_Place]:
        """Yield the places of the elementary values in a value that begins at a byte."""
        if dims:
            yield from self._elements(kind, dims, begin)
        elif isinstance(kind, Structure):
            yield from self._members(kind, begin)
        else:
            yield _Place("", kind, begin, 0 if kind is BOOL else None)

    def _elements(self, kind: DataType, dims: tuple[int, ...], begin: int) -> Iterator[_Place]:
        """Yield the places of the values in an array, by element; BOOLs are packed, eight in a byte."""
        size = self._layouts.size(kind)
        for number in range(count_of(dims)):
            index = element_text("", dims, number)
            element_begin = begin + number * size
            if kind is BOOL:
                yield _Place(index, BOOL, begin + number // 8, number % 8)
            elif any(self._mask[element_begin : element_begin + size]):
                for place in self.places(kind, (), element_begin):
                    yield place._replace(path=index + place.path)

    def _members(self, kind: Structure, begin: int) -> Iterator[_Place]:
        """Yield the places of the values in a structure; bits of a hidden integer get member names."""
        bits = {bit_member.at.upper(): bit_member.name for bit_member in kind.members if bit_member.at}
        for member, offset, bit in self._layouts.places(kind):
            if bit is not None:
                yield _Place(f".{member.name}", BOOL, begin + offset, bit)
            elif member.hidden and isinstance(member.type, Elementary):
                for number in range(member.type.bits):
                    name = bits.get(f"{member.name}.{number}".upper())
                    if name is not None:
                        yield _Place(f".{name}", BOOL, begin + offset + number // 8, number % 8)
            else:
                for place in self.places(member.type, member.dims, begin + offset):
                    yield place._replace(path=f".{member.name}{place.path}")
