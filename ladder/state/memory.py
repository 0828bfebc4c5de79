"""A program's memory: one cell per leaf, shared by the compiled program and its readers.

A cell is a cell of a Python closure. The compiled program uses it as a variable; readers use `cell_contents`.
An array is a list that is never replaced. An image consists of the rack's own words. A tag in bytes is a
`TagBytes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Mapping, Sequence
from functools import partial
from operator import getitem
from types import CellType, MappingProxyType
from typing import Any, Protocol

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image
from scanrack.io_images.site import Site

from ..model.errors import LadderError
from ..model.operands import subscripts_of
from ..model.stretches import Spot
from ..model.tags import Layout, Leaf, Presets, Tag, tag_in
from ..model.types import BOOL, DataType, Elementary, Member, Structure, count_of, dims_text
from .initials import load_bytes
from .named_parts import alias_target
from .tag_bytes import TagBytes, chars, set_chars
from .values import checked

Value = bool | int | float

Passed = Value | bytes
"""A parameter of a routine; a structure or an array is passed as bytes."""

NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(slots=True)
class _InputCopy:
    """An input image that the program writes."""

    copy: memoryview  # the program's words
    rack: memoryview  # the module's words
    last_copied: bytes = b""


class Memory:
    """Values of all leaves of a layout, initially the tags' values and the `defaults` of structures."""

    def __init__(
        self,
        layout: Layout,
        presets: Presets = MappingProxyType({}),
        defaults: Mapping[str, Presets] = NOTHING,
    ) -> None:
        """Set the defaults of types, then the initial values of tags, then the presets from rungs."""
        self.layout = layout
        self.left = 1  # unused here, see `Store`
        self.cells: dict[str, CellType] = {}  # by identifier
        self._own_images: dict[Leaf, Image] = {}
        self._copied: list[_InputCopy] = []
        self._attached = False
        self._faults = layout.faults
        self._lists: dict[str, Any] = dict(layout.lists)  # lists and bytes by identifier
        self._lists |= {ident: TagBytes(kind, count) for ident, kind, count in layout.byte_tags}
        for ident, values in self._lists.items():
            self.cells[ident] = CellType(values)
        for leaf in layout.single:
            self.cells[leaf.ident] = CellType(self._blank(leaf))
        self._defaults = defaults
        self._initial_value_flags: dict[int, bool] = {}
        for tag in layout.tags().values():
            try:
                self._load_defaults(tag.name, tag.type, count_of(tag.dims))
                if tag.initial is not None and not self._load_bytes(tag):
                    self.load(tag.name, tag.type, tag.dims, 0, tag.initial)
            except ValueError as error:
                raise LadderError(str(error), Site(tag=tag.name)) from None
        for (path, index), value in presets.items():
            self.write(layout.leaf(path), index, value)

    def copy(self) -> Memory:
        """Return a memory with the same values, not attached to a rack."""
        other = type(self).__new__(type(self))
        other.layout, other.left, other._faults = self.layout, 1, self._faults
        other._defaults, other._initial_value_flags = self._defaults, self._initial_value_flags
        other._copied, other._attached, other.cells = [], False, {}
        other._lists = {ident: values.copy() for ident, values in self._lists.items()}
        other._own_images = {
            leaf: Image(buffer=bytearray(image.raw)) for leaf, image in self._own_images.items()
        }
        images = {leaf.ident: image.words for leaf, image in other._own_images.items()}
        for ident, cell in self.cells.items():
            value = cell.cell_contents
            copied = other._lists.get(ident, images.get(ident))
            if copied is None:
                copied = [*value] if type(value) is list else value
            other.cells[ident] = CellType(copied)
        return other

    def put_outputs(self, first: Mapping[int, bytes]) -> None:
        """Set the memory's own output images to initial values, by slot."""
        for leaf, image in self._own_images.items():
            if leaf.output and leaf.slot is not None and leaf.slot in first:
                set_initial_bytes(image, first[leaf.slot])

    def _load_bytes(self, tag: Tag) -> bool:
        """Set the initial value of a tag in bytes at once; return False if that is impossible."""
        name = tag.name.upper()
        remainder = self.layout.rests.get(name)
        if remainder is not None and self._has_initial_value(tag.type):
            return False
        values = self._lists.get(
            remainder.ident if remainder is not None else self.layout.boxed.get(name, "")
        )
        if not isinstance(values, TagBytes) or not load_bytes(values, tag.type, tag.dims, tag.initial):
            return False
        for leaf in remainder.variables.values() if remainder is not None else ():
            spot = self.layout.rest_spot(leaf)
            value = values.values(spot, leaf.size) if leaf.dims else values.get(spot.view, spot.at(0))
            self.cells[leaf.ident].cell_contents = value
        return True

    def _load_defaults(self, path: str, kind: DataType, count: int) -> None:
        """Set the initial values of a structure's members in all elements."""
        if isinstance(kind, Elementary) or not self._has_initial_value(kind):
            return
        for member in kind.members:
            if isinstance(member.type, Structure) and not member.at:
                inner_path = f"{path}.{member.name}"
                self._load_defaults(inner_path, member.type, count * count_of(member.dims))
            if member.initial is not None:
                for element in range(count):
                    self._load_member(path, kind, member, element, member.initial)
        for (member_path, index), value in self._defaults.get(kind.name.upper(), {}).items():
            leaf = self.layout.leaf(f"{path}.{member_path}")
            for element in range(index, leaf.size, leaf.size // count):
                self.write(leaf, element, value)

    def _has_initial_value(self, kind: DataType) -> bool:
        """Return whether a type has a member, at any depth, with an initial value."""
        if isinstance(kind, Elementary):
            return False
        has_value = self._initial_value_flags.get(id(kind))  # equal types may have different initial values
        if has_value is None:
            has_value = kind.name.upper() in self._defaults or any(
                member.initial is not None or self._has_initial_value(member.type) for member in kind.members
            )
            self._initial_value_flags[id(kind)] = has_value
        return has_value

    def _blank(self, leaf: Leaf) -> Any:
        """Return the initial storage of a leaf: an image's words, a list of zeros, or one zero."""
        if leaf.is_image:
            self._own_images[leaf] = Image(size=leaf.size)
            return self._own_images[leaf].words
        return [leaf.type.zero] * leaf.size if leaf.dims else leaf.type.zero

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""
        cell = self.cells.get(leaf.ident)
        if cell is None:
            values, spot = self._list_and_spot(leaf)
            if spot.view:
                return values.get(spot.view, spot.at(index))  # type: ignore[no-any-return]
            return values[spot.at(index)]  # type: ignore[no-any-return]
        value = cell.cell_contents
        return value[index] if leaf.dims else value  # type: ignore[no-any-return]

    def reader(self, leaf: Leaf, index: int = 0) -> Callable[[], Value]:
        """Return a function that reads a value, for callers that read it in each scan."""
        cell = self.cells.get(leaf.ident)
        if cell is None:
            values, spot = self._list_and_spot(leaf)
            offset = spot.at(index)
            read: Callable[[], Any] = (
                partial(values.get, spot.view, offset) if spot.view else partial(getitem, values, offset)
            )
            return read
        return (lambda: cell.cell_contents[index]) if leaf.dims else (lambda: cell.cell_contents)

    def elements(self, leaf: Leaf, begin: int, count: int) -> list[Value]:
        """Return adjacent values of an array."""
        cell = self.cells.get(leaf.ident)
        if cell is not None:
            return list(cell.cell_contents[begin : begin + count])
        values, spot = self._list_and_spot(leaf)
        offsets = map(spot.at, range(begin, begin + count))
        return (
            [values.get(spot.view, offset) for offset in offsets]
            if spot.view
            else [values[offset] for offset in offsets]
        )

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value of the leaf's type."""
        cell = self.cells.get(leaf.ident)
        if cell is None:
            values, spot = self._list_and_spot(leaf)
            if spot.view:
                values.put(spot.view, spot.at(index), value)
            else:
                values[spot.at(index)] = value
        elif leaf.dims:
            cell.cell_contents[index] = value
        else:
            cell.cell_contents = value

    def has(self, leaf: Leaf) -> bool:
        """Return whether memory contains a leaf; it contains an image only if the program uses it."""
        return leaf.ident in self.cells or self.layout.spot(leaf) is not None

    def is_read_only(self, leaf: Leaf) -> bool:
        """Return whether a leaf is an input image or a fault of a rack, which only the module writes."""
        if leaf.slot is None or leaf.output or leaf.ident not in self.cells:
            return False
        if not leaf.is_image:
            return self._attached
        words = self.cells[leaf.ident].cell_contents
        return isinstance(words, memoryview) and words.readonly

    def _list_and_spot(self, leaf: Leaf) -> tuple[Any, Spot]:
        """Return the list or bytes with a leaf's values, and the leaf's place in it."""
        spot = self.layout.spot(leaf)
        assert spot is not None, leaf.path
        return self._lists[spot.ident], spot

    def column(self, leaf: Leaf, begin: int, step: int, count: int) -> Column | None:
        """Return the slice of every `step`th value of a leaf, see `Store`."""
        cell = self.cells.get(leaf.ident)
        if cell is None:
            values, spot = self._list_and_spot(leaf)
            return column_in(values, spot.at, begin, step, count)
        return column_in(cell.cell_contents, int, begin, step, count) if leaf.dims else None

    def bytes_at(self, leaf: Leaf, index: int) -> BytesAt | None:
        """Return the place of a value in bytes, see `Store`."""
        spot = self.layout.spot(leaf)
        if spot is None or not spot.view:
            return None
        if self.layout.rests and tag_in(leaf.path).upper() in self.layout.rests:
            return None
        return self._lists[spot.ident], spot.at(index) * spot.unit // 8

    def values(self, leaf: Leaf) -> Value | list[Value]:
        """Return the value of a leaf, or all its elements."""
        cell = self.cells.get(leaf.ident)
        if cell is None:
            values, spot = self._list_and_spot(leaf)
            if spot.view and leaf.dims:
                return values.values(spot, leaf.size)  # type: ignore[no-any-return]
            if spot.view:
                return values.get(spot.view, spot.at(0))  # type: ignore[no-any-return]
            return [values[spot.at(index)] for index in range(leaf.size)] if leaf.dims else values[spot.at(0)]
        return list(cell.cell_contents) if leaf.dims else cell.cell_contents

    def attach(self, slots: Mapping[int, Any], written: Container[str] = ()) -> None:
        """Use the images of a rack's slots as memory, or raise a ValueError for a missing slot.

        Inputs that the program writes are copied, so that recordings contain the modules' own inputs; see
        `take_inputs`.
        """
        for leaf in (*self.layout.images, *self.layout.faults):
            if leaf.slot is None or leaf.slot not in slots:
                listed = ", ".join(map(str, slots)) or "none"
                raise ValueError(f"the program uses slot {leaf.slot} ({leaf.path}), the rack has {listed}")
        for leaf in self.layout.images:
            slot = slots[leaf.slot]  # type: ignore[index]  # as checked above
            image = slot.outputs if leaf.output else slot.inputs
            if len(image) != leaf.size:
                raise ValueError(
                    f"the program was built for {leaf.size} words of {leaf.path}, slot {leaf.slot} has "
                    f"{len(image)}: load it with its rack"
                )
            self.cells[leaf.ident].cell_contents = image.words
        self._copied = []
        self._attached = True
        for leaf in self.layout.images:
            if leaf.ident in written and not leaf.output:
                copied = self._own_images[leaf]
                self.cells[leaf.ident].cell_contents = copied.words
                self._copied.append(_InputCopy(copied.raw, slots[leaf.slot].inputs.raw))  # type: ignore[index]

    @property
    def copies_inputs(self) -> bool:
        """Whether inputs are copied before each scan."""
        return bool(self._copied)

    def take_inputs(self, *, updated: bool) -> None:
        """Copy the inputs that the program writes, if the modules have updated them.

        An image that differs from its last copy is always copied, because a force has changed it.
        """
        for image in self._copied:
            if updated or image.last_copied != image.rack:
                image.last_copied = bytes(image.rack)
                image.copy[:] = image.last_copied

    def take_faults(self, slots: Mapping[int, Any]) -> None:
        """Copy connection faults from slots by number: 0, or -1 while the module does not answer."""
        for leaf in self._faults:
            fault = slots[leaf.slot].fault  # type: ignore[index]  # of a module, as `attach` has checked
            if fault != self.read(leaf):
                self.write(leaf, 0, fault)

    def snapshot(self) -> dict[str, Value | list[Value]]:
        """Return all values by path, including hidden ones."""
        return {leaf.path: self.values(leaf) for leaf in self.layout.leaves.values()}

    # --- whole values, for people

    def dump(self, path: str, kind: DataType, dims: tuple[int, ...], index: int = 0) -> Any:
        """Return a value in readable form: a list per dimension, a dict of members, a str for a STRING."""
        if dims:
            length, inner = dims[0], dims[1:]
            if not inner and isinstance(kind, Elementary):
                return self.elements(self.layout.leaf(path), index * length, length)
            return [self.dump(path, kind, inner, index * length + number) for number in range(length)]
        if isinstance(kind, Elementary):
            return self.read(self.layout.leaf(path), index)
        if kind.is_string:
            return self.text(path, index).decode("latin-1")
        return {
            member.name: self._dump_member(path, kind, member, index)
            for member in kind.members
            if not member.hidden
        }

    def _dump_member(self, path: str, kind: Structure, member: Member, index: int) -> Any:
        """Return a member in readable form; a member with `at` is a part of another member."""
        if not member.at:
            return self.dump(f"{path}.{member.name}", member.type, member.dims, index)
        target = alias_target(path, kind, member, index)
        value = self.dump(target.path, target.type, target.dims, target.index)
        return value if target.bit is None else bool(value >> target.bit & 1)

    def _load_member(self, path: str, kind: Structure, member: Member, index: int, value: Any) -> None:
        """Set a member in the form of `dump`; a member with `at` is a part of another member."""
        if not member.at:
            self.load(f"{path}.{member.name}", member.type, member.dims, index, value)
            return
        target = alias_target(path, kind, member, index)
        if target.bit is None:
            self.load(target.path, target.type, target.dims, target.index, value)
            return
        leaf = self.layout.leaf(target.path)
        word, mask = int(self.read(leaf, target.index)), mask_of(leaf.type, target.bit)
        on = checked(f"{path}.{member.name}", BOOL, value)
        self.write(leaf, target.index, word | mask if on else word & ~mask)

    def load(self, path: str, kind: DataType, dims: tuple[int, ...], index: int, value: Any) -> None:
        """Set a value in the form of `dump`; keep missing parts. Raise a ValueError if it does not fit."""
        if dims:
            self._load_array(path, kind, dims, index, value)
        elif isinstance(kind, Elementary):
            self.write(self.layout.leaf(path), index, checked(path, kind, value))
        elif kind.is_string and isinstance(value, str):
            self._load_text(path, index, value)
        else:
            self._load_structure(path, kind, index, value)

    def _load_array(self, path: str, kind: DataType, dims: tuple[int, ...], index: int, value: Any) -> None:
        """Set the first elements of an array, as many as the list has."""
        if isinstance(value, str) or not isinstance(value, Sequence) or len(value) > dims[0]:
            raise ValueError(f"{path}: {value!r} is not a list of up to {dims[0]} values")
        for number, item in enumerate(value):
            self.load(path, kind, dims[1:], index * dims[0] + number, item)

    def _load_structure(self, path: str, kind: Structure, index: int, value: Any) -> None:
        """Set the members in a dict; raise a ValueError for an unknown member."""
        if not isinstance(value, Mapping):
            raise ValueError(f"{path}: {value!r} is not a dict of members of {kind.name}")
        for name, member_value in value.items():
            member = kind.member(name)
            if member is None:
                names = ", ".join(member.name for member in kind.members)
                raise ValueError(f"{path}: {kind.name} has no member {name}; members are {names}")
            self._load_member(path, kind, member, index, member_value)

    def text(self, path: str, index: int) -> bytes:
        """Return the characters of a STRING."""
        return text_in(self, self.layout, path, index)

    def _load_text(self, path: str, index: int, value: str) -> None:
        """Set a STRING to a str; raise a ValueError if it is too long."""
        capacity = self.layout.leaf(f"{path}.DATA").dims[-1]
        codes = value.encode("latin-1", errors="replace")
        if len(codes) > capacity:
            raise ValueError(f"{path}: {len(codes)} characters are too long; must be at most {capacity}")
        self.set_text(path, index, codes)

    def set_text(self, path: str, index: int, value: bytes) -> None:
        """Set a STRING to characters, truncated to its size and padded with 0."""
        set_text_in(self, self.layout, path, index, value)


def set_initial_bytes(image: Image, data: bytes) -> None:
    """Set an image to initial bytes, up to the end of the shorter one."""
    count = min(len(image.raw), len(data))
    image.raw[:count] = data[:count]


Column = tuple[list[Any], slice]
"""A list, and a slice of it."""

BytesAt = tuple[TagBytes, int]
"""A tag in bytes, and the number of a byte in it."""


def column_in(values: Any, at: Callable[[int], int], begin: int, step: int, count: int) -> Column | None:
    """Return the slice of every `step`th value, at least two, in a list; None if not equidistant."""
    if type(values) is not list or count < 2:
        return None
    first, last = at(begin), at(begin + step * (count - 1))
    stride = at(begin + step) - first
    if stride < 1 or last - first != stride * (count - 1) or last >= len(values):
        return None
    return values, slice(first, last + 1, stride)


class Store(Protocol):
    """Values of a memory, or of an add-on's argument that has `left` elements to the end of its array."""

    left: int

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value of the leaf's type."""

    def column(self, leaf: Leaf, begin: int, step: int, count: int) -> Column | None:
        """Return the slice of every `step`th value of a leaf; None if they must be accessed one by one."""

    def bytes_at(self, leaf: Leaf, index: int) -> BytesAt | None:
        """Return the place of a value in bytes; None if it is not in bytes or is accessed individually."""


class CompiledAddOnStore:
    """An argument of a compiled add-on: a list or bytes from `base` on, or the bits `mask` of an integer."""

    __slots__ = ("_base", "_layout", "_mask", "_values", "left")

    def __init__(
        self, layout: Layout, values: Any, base: int, left: int = 1, mask: int | None = None
    ) -> None:
        self._layout, self._values, self._base, self.left, self._mask = layout, values, base, left, mask

    def _spot(self, leaf: Leaf) -> Spot:
        spot = self._layout.spot(leaf)
        assert spot is not None
        return spot

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""
        spot = self._spot(leaf)
        offset = spot.begin(self._base) + spot.at(index)
        value: Value = self._values.get(spot.view, offset) if spot.view else self._values[offset]
        return value if self._mask is None else int(value) & self._mask != 0

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value of the leaf's type."""
        spot = self._spot(leaf)
        offset = spot.begin(self._base) + spot.at(index)
        if spot.view:
            self._values.put(spot.view, offset, value)
            return
        if self._mask is not None:
            word = self._values[offset]
            value = word | self._mask if value else word & ~self._mask
        self._values[offset] = value

    def column(self, leaf: Leaf, begin: int, step: int, count: int) -> Column | None:
        """See `Store`."""
        if self._mask is not None:
            return None
        spot = self._spot(leaf)
        return column_in(self._values, lambda index: self._base + spot.at(index), begin, step, count)

    def bytes_at(self, leaf: Leaf, index: int) -> BytesAt | None:
        """See `Store`."""
        spot = self._spot(leaf)
        return (self._values, self._base + spot.at(index) * spot.unit // 8) if spot.view else None


class InterpretedAddOnStore:
    """An argument of an interpreted add-on instruction, as a store for its own leaves.

    Attributes:
        path: path of the instance or the argument in the program.
        first: flat index in the path.
        left: number of elements from `first` to the end of the array.
        bit: bit of an integer; None for whole values.
    """

    __slots__ = ("_memory", "bit", "first", "left", "path")

    def __init__(self, memory: Memory, path: str, first: int, left: int, bit: int | None = None) -> None:
        self._memory, self.path, self.first, self.left, self.bit = memory, path, first, left, bit

    @property
    def text(self) -> str:
        """Name of an instance, with its subscripts."""
        leaf = self._memory.layout.leaf(f"{self.path}.EnableIn")
        return element_text(self.path, leaf.dims, self.first)

    def _target(self, leaf: Leaf, index: int) -> tuple[Leaf, int]:
        return self._memory.layout.leaf(self.path + leaf.rest), self.first * leaf.inner + index

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""
        value = self._memory.read(*self._target(leaf, index))
        return value if self.bit is None else bool(int(value) >> self.bit & 1)

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value of the leaf's type."""
        target, element = self._target(leaf, index)
        if self.bit is not None:
            word, mask = int(self._memory.read(target, element)), mask_of(target.type, self.bit)
            value = word | mask if value else word & ~mask
        self._memory.write(target, element, value)

    def column(self, leaf: Leaf, begin: int, step: int, count: int) -> Column | None:
        """See `Store`."""
        if self.bit is not None:
            return None
        return self._memory.column(*self._target(leaf, begin), step, count)

    def bytes_at(self, leaf: Leaf, index: int) -> BytesAt | None:
        """See `Store`."""
        return self._memory.bytes_at(*self._target(leaf, index))


def element_text(path: str, dims: tuple[int, ...], index: int) -> str:
    """Return the address of an element from its flat index.

    >>> element_text("Grid", (2, 3), 4)
    'Grid[1,1]'
    """
    return f"{path}{dims_text(tuple(int(subscript.value) for subscript in subscripts_of(dims, index)))}"


def mask_of(kind: Elementary, bit: int) -> int:
    """Return the integer with only that bit set.

    >>> from ..model.types import INT
    >>> mask_of(INT, 3), mask_of(INT, 15)
    (8, -32768)
    """
    return kind.lowest if kind.is_signed and bit == kind.bits - 1 else 1 << bit


def text_in(store: Store, layout: Layout, path: str, index: int) -> bytes:
    """Return the characters of string number `index` of a path."""
    data, counter = layout.leaf(f"{path}.DATA"), layout.leaf(f"{path}.LEN")
    capacity = data.dims[-1]
    place = store.bytes_at(counter, index)
    if place is not None:
        return chars(*place, capacity)
    length = store.read(counter, index)
    count = max(0, min(int(length), capacity))
    return bytes(int(store.read(data, index * capacity + number)) & 0xFF for number in range(count))


def set_text_in(store: Store, layout: Layout, path: str, index: int, value: bytes) -> None:
    """Set a string to characters, truncated to its size and padded with 0."""
    data, counter = layout.leaf(f"{path}.DATA"), layout.leaf(f"{path}.LEN")
    capacity = data.dims[-1]
    place = store.bytes_at(counter, index)
    if place is not None:
        set_chars(*place, capacity, value)
        return
    codes = value[:capacity]
    store.write(counter, index, len(codes))
    for number in range(capacity):
        code = codes[number] if number < len(codes) else 0
        store.write(data, index * capacity + number, code - 256 if code > 127 else code)


def same(a: object, b: object) -> bool:
    """Return whether two values of memory, or lists or tuples of them, are equal; NaN equals NaN."""
    if isinstance(a, list | tuple) and isinstance(b, list | tuple):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b):
        return True
    return a == b
