"""Cells: single values in memory, or bits of a value."""

from __future__ import annotations

from collections.abc import Iterator

from scanrack.io_images.dataclass import dataclass

from ..model.operands import Calculation, Constant, Group, Place, fixed_index_in, leaves_in
from ..model.tags import Leaf
from ..model.types import COUNTER, HIDDEN, TIMER, count_of
from ..state.memory import Memory, Value, element_text


def places_in(operand: object) -> Iterator[Place]:
    """Yield the single values that an operand or a condition reads."""
    if isinstance(operand, Place):
        yield operand
    elif isinstance(operand, Calculation):
        for inner in operand.operands:
            yield from places_in(inner)


@dataclass(frozen=True, slots=True)
class Cell:
    """A value in memory, or some of its bits."""

    leaf: Leaf
    index: int  # flat index in the leaf
    mask: int | None = None  # mask of its bits; None for the whole value

    @property
    def name(self) -> str:
        """The address of the cell."""
        name = element_text(self.leaf.path, self.leaf.dims, self.index)
        return name if self.mask is None else f"{name}.{self.mask.bit_length() - 1}"

    def masked(self, value: Value) -> Value:
        """Return a value of the leaf, masked to the cell's bits."""
        return value if self.mask is None else int(value) & self.mask

    def in_value(self, value: Value) -> Value:
        """Return the cell's part of a leaf's value; a bit as a bool."""
        return value if self.mask is None else bool(int(value) & self.mask)

    def read(self, memory: Memory) -> Value:
        """Return the cell's current value; a bit as a bool."""
        return self.in_value(memory.read(self.leaf, self.index))

    def overlaps(self, other: Cell) -> bool:
        """Return whether two cells share memory."""
        if self.leaf is not other.leaf or self.index != other.index:
            return False
        return self.mask is None or other.mask is None or bool(self.mask & other.mask)


def cell_of(place: Place) -> Cell:
    """Return the cell of a place with fixed subscripts; raise a ValueError if they are computed."""
    index = place.fixed_index
    if index is None or place.can_fault:
        raise ValueError(f"{place.text} has a computed subscript; name one element")
    mask = 1 << int(place.bit.value) if isinstance(place.bit, Constant) else None
    return Cell(place.leaf, index, mask)


def place_in_snapshot(memory: Memory, cell: Cell) -> tuple[str, int | None] | None:
    """Return the variable and index of a cell's value in a snapshot; None if it is stored in bytes."""
    leaf = cell.leaf
    if leaf.ident in memory.cells:
        return leaf.ident, cell.index if leaf.dims else None
    spot = memory.layout.spot(leaf)
    if spot is None or spot.view or spot.ident not in memory.cells:
        return None
    return spot.ident, spot.at(cell.index)


def cells_of(tag: Place | Group, *, counts: bool = False) -> list[Cell]:
    """Return the cells of a tag; for a timer or counter, its bits and, if `counts`, its numbers.

    Raises:
        ValueError: a subscript of the tag is computed.
    """
    return [cell_of(tag)] if isinstance(tag, Place) else list(_cells_in(tag, counts))


def is_counted(operand: Place | Group) -> bool:
    """Return whether an operand is a single timer or counter."""
    return isinstance(operand, Group) and not operand.dims and operand.type in (TIMER, COUNTER)


def _cells_in(group: Group, counts: bool) -> Iterator[Cell]:
    """Yield the cells of a group's visible members; of a timer or counter, only bits unless `counts`."""
    for leaf in leaves_in(group):
        if HIDDEN in leaf.path or (is_counted(group) and not counts and not leaf.type.is_bool):
            continue
        first = fixed_index_in(leaf.dims, group.indices)
        if first is None:
            raise ValueError(f"{group.text} has a computed subscript; name one element")
        size = count_of(leaf.dims[len(group.indices) :])
        yield from (Cell(leaf, first * size + number) for number in range(size))
