"""Operands of instructions as Python code: structures, arrays of numbers, elements in bytes.

The code reads and writes in the same order as `interpreter.files`, so that both back ends detect the same
fault first.
"""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.dataclass import dataclass

from ..model.operands import Group, Place, Resolved, first_leaf, width_moved
from ..model.stretches import BITS, row_strides
from ..model.types import Elementary, Structure
from ..state.regions import ArrayRegion, region_of
from .rungs import RungWriter
from .terms import Term, times
from .value_writer import ValueWriter


class MemberText:
    """A structure: `alarm["Acked"]` is text for a member, and `alarm.set(Acked="True")` writes a member."""

    def __init__(self, rungs: RungWriter, group: Group) -> None:
        self._group = group
        self._values, self._writer = rungs.values, rungs.writer
        self.keep, self.block = rungs.values.keep, rungs.writer.block

    def __getitem__(self, name: str) -> str:
        """Return text for a member."""
        return self._values.read(self._group.member(name))

    def set(self, **members: object) -> None:
        """Write assignments to members; the text must have the types of the members."""
        for name, text in members.items():
            self._values.assign(self._group.member(name), str(text))


class ControlText(MemberText):
    """A CONTROL."""

    def check(self) -> None:
        """Write a check that faults if LEN or POS is negative."""
        length, position = self["LEN"], self["POS"]
        arguments = f"{self._values.site}, {self._group.text!r}, {length}, {position}"
        self._writer.line(f"if {length} < 0 or {position} < 0: negative_control({arguments})")

    def begin_again(self) -> None:
        """Write the reset of DN and POS after the last element."""
        with self.block(f"if {self['DN']}:"):
            self.set(DN=False, POS=0)


class ElementText:
    """Elements of an array of numbers, starting at an operand; writes the checks of its subscripts.

    Only for operands for which `has_elements` is true.
    """

    def __init__(self, rungs: RungWriter, operand: Resolved) -> None:
        assert isinstance(operand, (Place, Group))
        self._values, self._writer = rungs.values, rungs.writer
        self.leaf = first_leaf(operand)
        self.region = region_of(operand, extent=True)
        self.type = self.leaf.type
        texts = subscripts_kept(rungs.values, operand)
        self.row = rungs.writer.name(self.leaf)  # variable of the list or view
        # text for the index of the operand in `row`, and for the number of elements from there
        self.at = rungs.values.kept_number(rungs.values.offset(self.leaf, texts))
        self.left = rungs.values.kept_number(elements_left(rungs, self.region, texts))

    def check(self, number: str) -> None:
        """Write a check that faults if an element number is beyond the array."""
        arguments = f"{number}, {self.left}, {self._values.site}, {self.region.text!r}"
        if not (number.isdigit() and self.left.isdigit() and int(number) < int(self.left)):
            self._writer.line(f"if not 0 <= {number} < {self.left}: outside({arguments})")

    def __getitem__(self, number: str) -> str:
        """Return text for an element."""
        return f"{self.row}[{plus(self.at, number)}]"

    def value_of(self, source: Resolved) -> str:
        """Return text for a number, converted to the type of the elements."""
        term = self._values.term(source, width_moved(source, self.type))
        return self._values.keep(converted_text(term, self.type))


def has_elements(rungs: RungWriter, operand: Resolved) -> bool:
    """Return whether an operand is an array of numbers in a list or a view."""
    assert isinstance(operand, (Place, Group))
    leaf = first_leaf(operand)
    spot = rungs.writer.layout.spot(leaf)
    is_row = bool(leaf.dims) or spot is not None
    packed = spot is not None and spot.view == BITS
    return is_row and isinstance(operand.type, Elementary) and not packed and not rungs.writer.mask(leaf)


def converted_text(term: Term, kind: Elementary) -> str:
    """Return text for a number converted to a type, without flags and faults."""
    if term.real:
        is_converted = kind.is_double or (kind.is_real and not term.double)
    else:
        may_be_bit = term.high == 1 and not term.text.isdigit()
        in_range = kind.lowest <= term.low and term.high <= kind.highest
        is_converted = kind.is_integer and not may_be_bit and in_range
    if is_converted:
        return term.text
    return f"converted(types[{kind.name!r}], {term.text})"


@dataclass(frozen=True, slots=True)
class ByteEnd:
    """Elements in bytes, starting at an operand."""

    tag: str  # variable of the bytes
    at: str  # text for the first byte
    left: str  # text for the number of bytes to the end of its array
    size: int  # bytes per element
    surely: int  # lower bound of `left`, known at compilation


def byte_end(rungs: RungWriter, operand: Resolved) -> ByteEnd | None:
    """Return an operand in bytes, after writing checks of its subscripts; None if it is not in bytes."""
    assert isinstance(operand, (Place, Group))
    values, leaf = rungs.values, first_leaf(operand)
    if isinstance(operand.type, Structure):
        assert isinstance(operand, Group)
        spot = rungs.writer.layout.byte_spot(operand.path)
    else:
        spot = rungs.writer.layout.spot(leaf)
    if spot is None or not spot.view or spot.unit == 1:
        return None
    region = region_of(operand, extent=True)
    texts = subscripts_kept(values, operand)
    offset, width = values.placed(spot, leaf, texts), spot.unit // 8
    if width > 1:
        offset = str(int(offset) * width) if offset.isdigit() else f"({offset}) * {width}"
    surely = 0 if region.whole else region.size
    return ByteEnd(spot.ident, offset, elements_left(rungs, region, texts, region.size), region.size, surely)


def subscripts_kept(values: ValueWriter, operand: Place | Group) -> list[str]:
    """Return text for the checked subscripts of an operand: numbers or variables."""
    texts = values.subscripts(first_leaf(operand), operand.indices, operand.text)
    return list(map(values.kept_number, texts))


def elements_left(rungs: RungWriter, region: ArrayRegion, texts: Sequence[str], size: int = 1) -> str:
    """Return text for the number of elements from the one at these subscripts to the end of its array.

    Args:
        size: factor for the result, such as an element's number of bytes.
    """
    first = region.fixed_first
    if first is not None and not region.whole:
        return str(region.fixed_left(first) * size)
    strides = row_strides(region.dims, region.rest)
    flat = " + ".join(map(times, texts, strides))
    factor = f" * {size}" if size != 1 else ""
    if region.whole:
        length = rungs.writer.handed(region.root)[2]
        return f"({length} - ({flat})){factor}" if flat else f"{length}{factor}"
    if region.array == 1:
        return str(size)
    return f"({region.array} - ({flat}) % {region.array}){factor}"


def plus(a: str, b: str) -> str:
    """Return text for a sum; for two numbers, their sum."""
    if a == "0" or b == "0":
        return b if a == "0" else a
    return str(int(a) + int(b)) if a.isdigit() and b.isdigit() else f"{a} + {b}"
