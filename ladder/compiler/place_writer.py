"""Python code that reads and writes places: tags, elements, bits and strings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

from ..model.operands import Constant, Group, Place, Resolved, StringConstant, first_leaf
from ..model.stretches import BITS, Spot, row_strides
from ..model.tags import OWN, FrameLayout, Leaf
from ..model.types import DINT
from ..state.memory import mask_of
from .string_places import StringPlace
from .terms import Term, calculates, times
from .writer import Writer


class PlaceWriter(ABC):
    """Writes places; subscripts are computed by `term`."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self.site = 0

    @abstractmethod
    def term(self, operand: Resolved, width: int) -> Term:
        """Return a number, computed in integers of that width, or in SINGLE or DOUBLE."""

    def keep(self, text: str) -> str:
        """Store a value in a variable; return its name."""
        if text.isidentifier() and text.startswith("__"):
            return text
        name = self.writer.temporary()
        self.writer.line(f"{name} = {text}")
        return name

    def kept_number(self, text: str) -> str:
        """Return a number unchanged; store any other value in a variable, and return its name."""
        return text if text.isdigit() else self.keep(text)

    # --- reading

    def read(self, place: Place) -> str:
        """Return text for the value of a place."""
        if self.is_packed(place.leaf):
            return self._read_packed(place)
        word = self.word(place)
        if place.bit is None:
            mask = self.writer.mask(place.leaf)
            return f"({word} if {mask} is None else {word} & {mask} != 0)" if mask else word
        if isinstance(place.bit, Constant):
            number = int(place.bit.value)
            if number == place.leaf.type.bits - 1 and place.leaf.type.is_signed:
                return f"({word} < 0)"
            return f"({word} & {1 << number} != 0)"
        if calculates(place.bit) and any(not isinstance(index, Constant) for index in place.indices):
            word = self.keep(word)  # see `terms`
        number_text = self.index(place.bit, place.leaf.type.bits, place.text)
        return f"({word} >> {number_text} & 1 != 0)"

    def word(self, place: Place) -> str:
        """Return text for the value of a place; for a bit, text for the integer that contains it."""
        name, element = self.writer.name(place.leaf), self.element(place)
        return f"{name}[{element}]" if element else name

    def is_packed(self, leaf: Leaf) -> bool:
        """Return whether a leaf's values are bits in bytes."""
        spot = self.writer.layout.spot(leaf)
        return spot is not None and spot.view == BITS

    def element(self, place: Place) -> str:
        """Return text for the list index of a place; "" if it is not in a list."""
        leaf = place.leaf
        if not leaf.dims and self.writer.layout.spot(leaf) is None:
            return ""
        return self.offset(leaf, self.subscripts(leaf, place.indices, place.text))

    def subscripts(self, leaf: Leaf, indices: Sequence[Resolved], tag: str) -> list[str]:
        """Return texts for the checked subscripts of a leaf."""
        lengths: list[int | str] = [*leaf.dims]
        if elements_left := self.writer.elements_left(leaf):
            lengths[0] = elements_left
        texts = []
        for position, (index, length) in enumerate(zip(indices, lengths, strict=False), start=1):
            text = self.index(index, length, tag)
            first = not text.isdigit() and any(map(calculates, indices[position:]))
            texts.append(self.keep(text) if first else text)  # see `terms`
        return texts

    def offset(self, leaf: Leaf, subscripts: Sequence[str]) -> str:
        """Return text for the list index of a value, from the text of its subscripts."""
        return self.placed(self.writer.layout.spot(leaf), leaf, subscripts)

    def placed(self, spot: Spot | None, leaf: Leaf, subscripts: Sequence[str]) -> str:
        """Return text for an index, from the text of subscripts; for a structure in bytes, its first byte."""
        fixed, strides = (spot.part.offset, spot.strides) if spot else (0, row_strides(leaf.dims, 1))
        base = self.writer.base(leaf, spot) if spot else ""
        terms = [base] if base else []
        for text, stride in zip(subscripts, strides, strict=False):
            if text.isdigit():
                fixed += int(text) * stride
            else:
                terms.append(times(text, stride))
        return " + ".join([*terms, str(fixed)] if fixed or not terms else terms)

    def row(self, leaf: Leaf, number: int) -> str:
        """Return text for the list index of an element, from its flat index."""
        spot = self.writer.layout.spot(leaf)
        if spot is None:
            return str(number)
        index, base = str(spot.at(number)), self.writer.base(leaf, spot)
        return f"{base} + {index}" if base else index

    def flat(self, leaf: Leaf, indices: Sequence[Resolved], tag: str) -> str:
        """Return text for the flat index of an element."""
        strides = row_strides(leaf.dims[: len(indices)], 1)
        texts = self.subscripts(leaf, indices, tag)
        if all(text.isdigit() for text in texts):
            return str(sum(int(text) * stride for text, stride in zip(texts, strides, strict=True)))
        return " + ".join(map(times, texts, strides))

    def index(self, index: Resolved, length: int | str, tag: str) -> str:
        """Return text for a checked subscript; the length can be a variable."""
        if isinstance(index, Constant):
            value = str(index.value)
            return value if isinstance(length, int) else f"subscript({value}, {length}, {self.site}, {tag!r})"
        term = self.term(index, DINT.bits)
        if term.text.isidentifier():
            name = term.text
            return f"({name} if 0 <= {name} < {length} else outside({name}, {length}, {self.site}, {tag!r}))"
        return f"subscript({term.text}, {length}, {self.site}, {tag!r})"

    # --- writing

    def assign(self, place: Place, text: str) -> None:
        """Write an assignment to a place other than a bit of a tag."""
        self.writer.assigned(place.leaf)
        if self.is_packed(place.leaf):
            self._assign_packed(place, text)
            return
        word = self.word(place)
        mask = self.writer.mask(place.leaf)
        if not mask:
            self.writer.line(f"{word} = {text}")
            return
        value = self.keep(text)
        with self.writer.block(f"if {mask} is None:"):
            self.writer.line(f"{word} = {value}")
        with self.writer.block("else:"):
            self.writer.line(f"{word} = {word} | {mask} if {value} else {word} & ~{mask}")

    def set_bit(self, place: Place, power: str) -> None:
        """Write an assignment of a bool expression to a bit."""
        if place.bit is None:
            self.assign(place, power)
            return
        self.writer.assigned(place.leaf)
        target = self.writer.name(place.leaf)
        element = self.element(place)
        if element:
            if "(" in element:
                element = self.keep(element)
            target = f"{target}[{element}]"
        bits = place.leaf.type.bits
        if isinstance(place.bit, Constant):
            bit_mask = mask_of(place.leaf.type, int(place.bit.value))
            on, off = f"{target} | {bit_mask}", f"{target} & {~bit_mask}"
            changed = {"True": on, "False": off}.get(power)
            self.writer.line(f"{target} = {changed or f'{on} if {power} else {off}'}")
            return
        mask = self.keep(f"1 << {self.index(place.bit, bits, place.text)}")
        self.writer.line(
            f"{target} = wrap({target} | {mask} if {power} else {target} & ~{mask}, {place.leaf.type.wraps})"
        )

    # --- BOOLs in bytes

    def _read_packed(self, place: Place) -> str:
        """Return text for a BOOL in bytes."""
        byte, mask = self.byte_of(place.leaf, self.subscripts(place.leaf, place.indices, place.text))
        return f"({self.writer.name(place.leaf)}[{byte}] & {mask if mask.isdigit() else f'({mask})'} != 0)"

    def _assign_packed(self, place: Place, text: str) -> None:
        """Write an assignment of a bool expression to a BOOL in bytes."""
        fixed = all(isinstance(index, Constant) for index in place.indices)
        if not fixed and text not in ("True", "False"):
            text = self.keep(text)
        byte, mask = self.byte_of(place.leaf, self.subscripts(place.leaf, place.indices, place.text))
        target = f"{self.writer.name(place.leaf)}[{self.kept_number(byte)}]"
        cleared = str(255 ^ int(mask)) if mask.isdigit() else ""
        mask = self.kept_number(mask)
        on, off = f"{target} | {mask}", f"{target} & {cleared or f'~{mask}'}"
        changed = {"True": on, "False": off}.get(text)
        self.writer.line(f"{target} = {changed or f'{on} if {text} else {off}'}")

    def byte_of(self, leaf: Leaf, subscripts: Sequence[str]) -> tuple[str, str]:
        """Return text for the byte and mask of a BOOL; the mask may use a variable set by that text."""
        spot = self.writer.layout.spot(leaf)
        assert spot is not None
        fixed, bit_terms = spot.part.offset, list[str]()
        byte_terms = [spot.base] if self.writer.base(leaf, spot) else []
        for text, stride in zip(subscripts, spot.strides, strict=False):
            if text.isdigit():
                fixed += int(text) * stride
            elif stride % 8:
                bit_terms.append(times(text, stride))
            else:
                byte_terms.append(times(text, stride // 8))
        if bit_terms:
            bit = self.writer.temporary()
            bit_text = " + ".join([*bit_terms, str(fixed)] if fixed else bit_terms)
            return " + ".join([*byte_terms, f"(({bit} := {bit_text}) >> 3)"]), f"1 << ({bit} & 7)"
        if fixed > 7 or not byte_terms:
            byte_terms.append(str(fixed // 8))
        return " + ".join(byte_terms), str(1 << fixed % 8)

    # --- strings and stores

    def characters(self, operand: Resolved) -> str:
        """Return text for the characters of a STRING."""
        if isinstance(operand, StringConstant):
            return repr(operand.value.encode("latin-1", errors="replace"))
        assert isinstance(operand, Group)
        place = self.string(operand)
        if place is None:
            return f"text{self._in_store(operand)})"
        return place.read(self.writer.temporary(), f"chars({place})") if place.is_fixed else f"chars({place})"

    def set_characters(self, operand: Group, text: str) -> None:
        """Write an assignment of characters, in a variable, to a string."""
        place = self.string(operand)
        if place is None:
            self.writer.line(f"set_text{self._in_store(operand)}, {text})")
        else:
            self.writer.line(
                place.store(text, f"len({text}) if len({text}) < {place.capacity} else {place.capacity}")
            )

    def string(self, operand: Group) -> StringPlace | None:
        """Return the place of a STRING in bytes; None if it is not in bytes."""
        spot = self.writer.layout.byte_spot(operand.path)
        if spot is None:
            return None
        texts = self.subscripts(first_leaf(operand), operand.indices, operand.text)
        capacity = operand.layout.leaf(f"{operand.path}.DATA").dims[-1]
        return StringPlace(spot.ident, self.placed(spot, first_leaf(operand), texts), capacity)

    def _in_store(self, operand: Group) -> str:
        """Return text for the arguments that find a string: path, index, store."""
        path, leaf = operand.path, first_leaf(operand)
        first = self.flat(leaf, operand.indices, operand.text)
        if not leaf.root:
            return f"({path!r}, {first}"
        return f"_in({self.store_of(leaf)}, {leaf.frame!r}, {path!r}, {first}"

    def stores(self) -> str:
        """Return text for all stores of an add-on instruction by `Leaf.root`; "" in a program."""
        layout = self.writer.layout
        if not isinstance(layout, FrameLayout):
            return ""
        stores = [
            f"{root!r}: stretch({layout.frame!r}, {', '.join(self.writer.handed(root))})"
            for root in (OWN, *layout.inouts)
        ]
        return f"{{{', '.join(stores)}}}"

    def store_of(self, leaf: Leaf) -> str:
        """Return text for the store of a leaf; the text `None` means the program's memory."""
        if not leaf.root:
            return "None"
        return f"stretch({leaf.frame!r}, {', '.join(self.writer.handed(leaf.root))})"
