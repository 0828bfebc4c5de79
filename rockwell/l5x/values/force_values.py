"""Forces in a document: the addresses that are forced, with their values [1756-RM084, forced tag data].

| form | example |
|---|---|
| beside a value | `ForceValue="1"` of a BOOL; `2#...._0..._...1`: a dot for a bit that is not forced |
| bytes of the tag | `<ForceData>00 00 00 00 01 00 FF FF 01 00 B8 22</ForceData>` |
| bytes as a list | `<ForceData Format="L5K"><![CDATA[[0,0,1,0,3,0]]]></ForceData>` |

The bytes are three times the tag's memory: its image, the mask of forced bits, and their values.

Forces are read and listed; a run applies them on request.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Sequence
from typing import Any

from scanrack.ladder.model.types import BOOL, REAL, DataType, Elementary, Structure, count_of
from scanrack.ladder.state.memory import element_text

from ..xml.data import Data
from ..xml.records import Element
from .datatypes import Types
from .layouts import Layouts
from .raw import RawReader, bytes_in, fits
from .value_texts import ValueTextError

Force = tuple[str, bool | int | float]
"""The rest of an address after the tag's name, and its value."""

_LIST = re.compile(r"\s*\[\s*(-?\d{1,3}(?:\s*,\s*-?\d{1,3})*+)\s*\]\s*")
_PATTERN = re.compile(r"2#([01.]{1,64})")
_INDEX = re.compile(r"\[\d{1,9}(?:,\d{1,9})*+\]")


def forces_of(forced: Sequence[Data], kind: DataType, dims: tuple[int, ...], types: Types) -> Iterator[Force]:
    """Yield the forces of a tag, from `Data` elements that show forces, else from its `ForceData`.

    Raises:
        ValueTextError: force data that can't be read.
    """
    images = [part.element for part in forced if part.element.tag == "ForceData"]
    data = (part.element for part in forced if part.element.tag != "ForceData")
    forces = [force for element in data for inner in element.iterchildren("*") for force in _shown(inner, "")]
    if forces or not images:
        yield from forces
    else:
        yield from _of_image(_bytes(images[0]), kind, dims, types)


def _of_image(image: bytes, kind: DataType, dims: tuple[int, ...], types: Types) -> Iterator[Force]:
    count, remainder = divmod(len(image), 3)
    mask, values = image[count : 2 * count], image[2 * count :]
    if not any(image if remainder else mask):
        return
    if remainder or not fits(mask, kind, dims, types.layouts):
        raise ValueTextError(f"its force data have {len(image)} bytes, which are not three times its memory")
    if not (isinstance(kind, Elementary) or types.layouts.is_known(kind)):
        raise ValueTextError(f"the order of the bytes of a {kind.name} is not known")
    for text, type_, offset, bit in _ForceMask(mask, types.layouts).places(kind, dims, 0):
        if bit is None:
            place = slice(offset, offset + max(1, type_.bits // 8))
            yield from _of_bytes(text, type_, mask[place], values[place])
        elif mask[offset] >> bit & 1:
            yield text, bool(values[offset] >> bit & 1)


def _of_bytes(text: str, kind: Elementary, mask: bytes, values: bytes) -> Iterator[Force]:
    if any(mask):
        bits = int.from_bytes(mask, "little"), int.from_bytes(values, "little")
        yield from _of_bits(text, kind, *bits, 8 * len(mask))


def image_of(forced: Sequence[Data], kind: DataType, layouts: Layouts) -> Any:
    """Return the value of a tag that has only force data, from their first third; None for zeros."""
    for record in forced:
        if record.element.tag == "ForceData":
            data = _bytes(record.element)
            image = data[: len(data) // 3]
            if layouts.is_known(kind) and fits(image, kind, (), layouts):
                return RawReader(image, layouts, keep=False).read(kind, ())
    return None


def _bytes(element: Element) -> bytes:
    text = "".join(element.itertext())
    match = _LIST.fullmatch(text)
    if match:
        return bytes(int(byte) & 0xFF for byte in match[1].split(","))
    data = bytes_in(element)
    if data is None:
        raise ValueTextError(f"its force data {text.strip()[:20]!r} are no bytes")
    return data


def _of_bits(text: str, kind: DataType | None, mask: int, value: int, width: int) -> Iterator[Force]:
    """Yield the force of a whole value, or of its bits."""
    if mask == (1 << width) - 1:
        yield text, _number(kind, value, width)
        return
    for bit in range(width):
        if mask >> bit & 1:
            yield f"{text}.{bit}", bool(value >> bit & 1)


def _number(kind: DataType | None, pattern: int, width: int) -> int | float:
    if isinstance(kind, Elementary) and (kind.is_real or kind.is_double):
        value: float = struct.unpack(f"<{kind.code}", pattern.to_bytes(width // 8, "little"))[0]
        return value
    unsigned = isinstance(kind, Elementary) and not kind.is_signed
    return pattern if unsigned or not pattern >> (width - 1) else pattern - (1 << width)


# --- beside values


def _shown(element: Element, path: str) -> Iterator[Force]:
    """Yield the forces of a decorated value and of nested ones."""
    todo = [(element, path)]
    while todo:
        node, node_path = todo.pop()
        forced = node.get("ForceValue")
        if forced is not None:
            yield from _beside(node_path, forced, node.get("DataType", ""))
        inside = []
        for child in node.iterchildren("*"):
            index = child.get("Index", "")
            if child.tag == "Structure":
                inside.append((child, node_path))
            elif child.tag == "Element" and _INDEX.fullmatch(index):
                inside.append((child, node_path + index))
            elif child.get("Name"):
                inside.append((child, f"{node_path}.{child.get('Name')}"))
        todo += reversed(inside)


def _beside(path: str, text: str, name: str) -> Iterator[Force]:
    if text in ("0", "1"):
        yield path, text == "1"
        return
    match = _PATTERN.fullmatch(text.replace("_", ""))
    if match is None:
        raise ValueTextError(f"its force {text[:40]!r} is no pattern of bits")
    bits = match[1]
    mask = int(re.sub("[01]", "1", bits).replace(".", "0"), 2)
    value = int(bits.replace(".", "0"), 2)
    yield from _of_bits(path, REAL if name.upper() == "REAL" else None, mask, value, len(bits))


# --- in bytes


class _ForceMask:
    """Finds the values of a tag that have forced bits."""

    def __init__(self, mask: bytes, layouts: Layouts) -> None:
        self._mask, self._layouts = mask, layouts

    def places(
        self, kind: DataType, dims: tuple[int, ...], at: int
    ) -> Iterator[tuple[str, Elementary, int, int | None]]:
        """Yield the address, type and byte of each value, and the bit of a BOOL."""
        if dims:
            yield from self._elements(kind, dims, at)
        elif isinstance(kind, Structure):
            yield from self._members(kind, at)
        else:
            yield "", kind, at, 0 if kind is BOOL else None

    def _elements(
        self, kind: DataType, dims: tuple[int, ...], at: int
    ) -> Iterator[tuple[str, Elementary, int, int | None]]:
        size = self._layouts.size(kind)
        for number in range(count_of(dims)):
            index = element_text("", dims, number)
            if kind is BOOL:
                yield index, BOOL, at + number // 8, number % 8
            elif any(self._mask[at + number * size : at + (number + 1) * size]):
                for text, *place in self.places(kind, (), at + number * size):
                    yield index + text, *place  # type: ignore[misc]

    def _members(self, kind: Structure, at: int) -> Iterator[tuple[str, Elementary, int, int | None]]:
        bits = {bit_member.at.upper(): bit_member.name for bit_member in kind.members if bit_member.at}
        for member, offset, bit in self._layouts.places(kind):
            if bit is not None:
                yield f".{member.name}", BOOL, at + offset, bit
            elif member.hidden and isinstance(member.type, Elementary):
                for number in range(member.type.bits):
                    name = bits.get(f"{member.name}.{number}".upper())
                    if name is not None:
                        yield f".{name}", BOOL, at + offset + number // 8, number % 8
            else:
                for text, *place in self.places(member.type, member.dims, at + offset):
                    yield f".{member.name}{text}", *place  # type: ignore[misc]
