"""A program's memory: one cell per leaf, shared by the compiled program and its readers.

A cell is a cell of a Python closure: the compiled program reads and writes it as a
variable, all others through `cell_contents`. An array is one list that stays
the same list; an image is the eight words of the rack.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import CellType
from typing import Any

from ..io_images.image import Image
from .arithmetic import real
from .tags import Layout, Leaf
from .types import STRING, DataType, Elementary, Structure

Value = bool | int | float


class Memory:
    """Values of all leaves of a layout.

    Attributes:
        layout: what is where.
        cells: by identifier.

    Args:
        layout: what is where.
        presets: initial values by path, over those of the declarations.
    """

    def __init__(self, layout: Layout, presets: Mapping[str, int] | None = None) -> None:
        self.layout = layout
        self.cells: dict[str, CellType] = {}
        self._own: dict[Leaf, Image] = {}
        self._faults = layout.faults
        for leaf in layout.leaves.values():
            self.cells[leaf.ident] = CellType(self._blank(leaf))
        for tag in layout.tags().values():
            if tag.initial is not None:
                self.load(tag.name, tag.type, tag.dims, 0, tag.initial)
        for path, value in (presets or {}).items():
            self.write(layout.leaf(path), 0, value)

    def _blank(self, leaf: Leaf) -> Any:
        if leaf.is_image:
            self._own[leaf] = Image()
            return self._own[leaf].words
        return [leaf.type.zero] * leaf.size if leaf.dims else leaf.type.zero

    def read(self, leaf: Leaf, index: int = 0) -> Value:
        """Return a value."""
        found = self.cells[leaf.ident].cell_contents
        return found[index] if leaf.dims else found  # type: ignore[no-any-return]

    def write(self, leaf: Leaf, index: int, value: Value) -> None:
        """Set a value, which is of the leaf's type already."""
        cell = self.cells[leaf.ident]
        if leaf.dims:
            cell.cell_contents[index] = value
        else:
            cell.cell_contents = value

    def attach(self, slots: Mapping[int, Any]) -> None:
        """Use the images of a rack's slots as memory.

        Args:
            slots: by number, each with `inputs` and `outputs`.

        Raises:
            ValueError: the program names a slot that the rack does not have.
        """
        for leaf in (*self.layout.images, *self.layout.faults):
            if leaf.slot is None or leaf.slot not in slots:
                there = ", ".join(map(str, slots)) or "none"
                raise ValueError(f"the program uses slot {leaf.slot} ({leaf.path}), the rack has {there}")
        for leaf in self.layout.images:
            slot = slots[leaf.slot]  # type: ignore[index]  # as checked above
            image = slot.outputs if leaf.output else slot.inputs
            self.cells[leaf.ident].cell_contents = image.words

    def take_faults(self, slots: Mapping[int, Any]) -> None:
        """Take the connection faults that the program reads, as the rack has them now.

        Args:
            slots: by number, each with `fault`: 0, or -1 while its module does not answer.
        """
        for leaf in self._faults:
            fault = slots[leaf.slot].fault  # type: ignore[index]  # of a module, as `attach` has checked
            if fault != self.read(leaf):
                self.write(leaf, 0, fault)

    def snapshot(self) -> dict[str, Value | list[Value]]:
        """Return all values by path, hidden ones too."""
        return {
            leaf.path: list(self.cells[leaf.ident].cell_contents)
            if leaf.dims
            else self.cells[leaf.ident].cell_contents
            for leaf in self.layout.leaves.values()
        }

    # --- whole values, for people

    def dump(self, path: str, kind: DataType, dims: tuple[int, ...], at: int = 0) -> Any:
        """Return a value as people see it: a list per dimension, a dict of members, a str of a STRING."""
        if dims:
            length, inner = dims[0], dims[1:]
            return [self.dump(path, kind, inner, at * length + number) for number in range(length)]
        if isinstance(kind, Elementary):
            return self.read(self.layout.leaf(path), at)
        if kind is STRING:
            return self.text(path, at).decode("latin-1")
        return {
            each.name: self.dump(f"{path}.{each.name}", each.type, each.dims, at) for each in kind.members
        }

    def load(self, path: str, kind: DataType, dims: tuple[int, ...], at: int, value: Any) -> None:
        """Set a value in the form in which `dump` gives it; parts that are left out stay.

        Raises:
            ValueError: it does not fit; the part, the value and what is allowed.
        """
        if dims:
            self._load_array(path, kind, dims, at, value)
        elif isinstance(kind, Elementary):
            self.write(self.layout.leaf(path), at, checked(path, kind, value))
        elif kind is STRING and isinstance(value, str):
            self._load_text(path, at, value)
        else:
            self._load_structure(path, kind, at, value)

    def _load_array(self, path: str, kind: DataType, dims: tuple[int, ...], at: int, value: Any) -> None:
        if isinstance(value, str) or not isinstance(value, Sequence) or len(value) > dims[0]:
            raise ValueError(f"{path}: {value!r} is not a list of up to {dims[0]} values")
        for number, each in enumerate(value):
            self.load(path, kind, dims[1:], at * dims[0] + number, each)

    def _load_structure(self, path: str, kind: Structure, at: int, value: Any) -> None:
        if not isinstance(value, Mapping):
            raise ValueError(f"{path}: {value!r} is not a dict of members of {kind.name}")
        for name, each in value.items():
            member = kind.member(name)
            if member is None:
                names = ", ".join(member.name for member in kind.members)
                raise ValueError(f"{path}: {kind.name} has no member {name}; members are {names}")
            self.load(f"{path}.{member.name}", member.type, member.dims, at, each)

    def text(self, path: str, at: int) -> bytes:
        """Return the characters of a STRING."""
        length = self.read(self.layout.leaf(f"{path}.LEN"), at)
        data = self.layout.leaf(f"{path}.DATA")
        room = data.dims[-1]
        count = max(0, min(int(length), room))
        codes = [int(self.read(data, at * room + number)) & 0xFF for number in range(count)]
        return bytes(codes)

    def _load_text(self, path: str, at: int, value: str) -> None:
        room = self.layout.leaf(f"{path}.DATA").dims[-1]
        codes = value.encode("latin-1", errors="replace")
        if len(codes) > room:
            raise ValueError(f"{path}: {len(codes)} characters do not fit, {room} do")
        self.set_text(path, at, codes)

    def set_text(self, path: str, at: int, value: bytes) -> None:
        """Set a STRING to characters, as many as fit; the others become 0."""
        data = self.layout.leaf(f"{path}.DATA")
        room = data.dims[-1]
        codes = value[:room]
        self.write(self.layout.leaf(f"{path}.LEN"), at, len(codes))
        for number in range(room):
            code = codes[number] if number < len(codes) else 0
            self.write(data, at * room + number, code - 256 if code > 127 else code)


def checked(name: str, kind: Elementary, value: object) -> Value:
    """Return a value as a tag of that type holds it.

    Raises:
        ValueError: it is of another kind or out of range.
    """
    if kind.is_bool:
        if value in (0, 1) and isinstance(value, int):
            return bool(value)
        raise ValueError(f"{name}: {value!r} is not a BOOL: allowed are False and True")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"{name}: {value!r} is not of type {kind.name}")
    if kind.is_real:
        return real(value)
    if isinstance(value, float):
        raise ValueError(f"{name}: {value!r} is not of type {kind.name}: a whole number is needed")
    if not kind.lowest <= value <= kind.highest:
        raise ValueError(f"{name}: {value} is out of range: allowed are {kind.lowest} to {kind.highest}")
    return value


def same(a: object, b: object) -> bool:
    """Whether two values of memory are equal; NaN is equal to NaN."""
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b):
        return True
    return a == b
