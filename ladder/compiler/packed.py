"""BOOLs in bytes: bits of a byte."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from ..model.operands import Constant, Place
from ..model.tags import Leaf
from .writer import Writer


class BitWriter(Protocol):
    """What these functions need from the `ValueWriter`."""

    writer: Writer

    def subscripts(self, leaf: Leaf, indices: Any, text: str) -> Sequence[str]:
        """Return text for checked subscripts."""

    def keep(self, text: str) -> str:
        """Return a name for a value that is computed once."""


def read_packed(values: BitWriter, place: Place) -> str:
    """Return text for a BOOL in bytes."""
    texts = values.subscripts(place.leaf, place.indices, place.text)
    byte, mask = byte_of(values, place.leaf, texts)
    return f"({values.writer.name(place.leaf)}[{byte}] & {mask if mask.isdigit() else f'({mask})'} != 0)"


def assign_packed(values: BitWriter, place: Place, text: str) -> None:
    """Write an assignment of a bool expression to a BOOL in bytes."""
    fixed = all(isinstance(each, Constant) for each in place.indices)
    if not fixed and text not in ("True", "False"):
        text = values.keep(text)
    byte, mask = byte_of(values, place.leaf, values.subscripts(place.leaf, place.indices, place.text))
    target = f"{values.writer.name(place.leaf)}[{byte if byte.isdigit() else values.keep(byte)}]"
    others = str(255 ^ int(mask)) if mask.isdigit() else ""
    mask = mask if mask.isdigit() else values.keep(mask)
    on, off = f"{target} | {mask}", f"{target} & {others or f'~{mask}'}"
    changed = {"True": on, "False": off}.get(text)
    values.writer.line(f"{target} = {changed or f'{on} if {text} else {off}'}")


def byte_of(values: BitWriter, leaf: Leaf, subscripts: Sequence[str]) -> tuple[str, str]:
    """Return text for the byte of a BOOL, and for its mask, which may use a variable that the former sets."""
    spot = values.writer.layout.spot(leaf)
    assert spot is not None
    fixed, bits = spot.part.offset, list[str]()
    whole = [spot.base] if values.writer.base(leaf, spot) else []
    for text, stride in zip(subscripts, spot.strides, strict=False):
        if text.isdigit():
            fixed += int(text) * stride
        elif stride % 8:
            bits.append(f"{text} * {stride}" if stride != 1 else text)
        else:
            whole.append(f"{text} * {stride // 8}" if stride != 8 else text)
    if bits:
        bit = values.writer.temporary()
        place = " + ".join([*bits, str(fixed)] if fixed else bits)
        return " + ".join([*whole, f"(({bit} := {place}) >> 3)"]), f"1 << ({bit} & 7)"
    return " + ".join([*whole, str(fixed // 8)] if fixed > 7 or not whole else whole), str(1 << fixed % 8)
