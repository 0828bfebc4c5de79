"""Forces: values that no program can change.

The compiled program itself forces values in variables, see `compiler.observed`. A list or a view of bytes
protects its forced elements from every writer: an array access, a copy, or an add-on instruction. The
interpreter writes through the memory, which applies all forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from scanrack.io_images.dataclass import dataclass
from typing_extensions import override

from ..compiler.observed import force_variable, free_mask_variable
from ..model.arithmetic import wrap
from ..model.tags import Layout, Leaf
from ..state.memory import Value
from ..state.tag_bytes import TagBytes

Force = tuple[int | None, Value]
"""A mask of forced bits, or None for the whole value; and the forced value."""

Forces = Mapping[tuple[str, int], Force]
"""Forces by leaf identifier and flat index."""


@dataclass(frozen=True, slots=True)
class ForcedValue:
    """A forced value."""

    leaf: Leaf  # the forced leaf
    index: int  # the forced element
    free_mask: int | None  # mask of the unforced bits, as a value of the leaf's type; None if all are forced
    value: Value  # the forced bits

    def merged(self, value: Any) -> Any:
        """Return a value with its forced bits replaced."""
        return self.value if self.free_mask is None else value & self.free_mask | self.value


def forced_values(layout: Layout, forces: Forces) -> tuple[ForcedValue, ...]:
    """Return the forced values of a program."""
    leaves = {leaf.ident: leaf for leaf in layout.leaves.values()}
    return tuple(_forced_value(leaves[ident], index, force) for (ident, index), force in forces.items())


def _forced_value(leaf: Leaf, index: int, force: Force) -> ForcedValue:
    """Return a force as a forced value with bits and a free mask that fit the leaf's type."""
    mask, value = force
    if mask is None:
        return ForcedValue(leaf, index, None, value)
    bits = leaf.type.wraps
    return ForcedValue(leaf, index, wrap(~mask, bits), wrap(int(value) & mask, bits))


class ForcedList(list[Any]):
    """A list with forced elements; `forces` has them by number."""

    __slots__ = ("forces",)

    def __init__(self, values: Iterable[Any], forces: Mapping[int, ForcedValue]) -> None:
        super().__init__(values)
        self.forces = forces
        self._force()

    @override
    def __setitem__(self, position: Any, value: Any) -> None:
        """Set an element except its forced bits, or set a slice and force all elements again."""
        if position.__class__ is int:
            forces = self.forces.get(position)
            super().__setitem__(position, value if forces is None else forces.merged(value))
            return
        super().__setitem__(position, value)
        self._force()

    def _force(self) -> None:
        """Force all elements again."""
        for number, forces in self.forces.items():
            super().__setitem__(number, forces.merged(self[number]))


class ForcedView:
    """A view of bytes that forces values again after every write."""

    __slots__ = ("_force", "_view", "format")

    def __init__(self, view: Any, force: Callable[[], None]) -> None:
        self._view, self._force, self.format = view, force, getattr(view, "format", "B")

    def __getitem__(self, position: Any) -> Any:
        return self._view[position]

    def __setitem__(self, position: Any, value: Any) -> None:
        self._view[position] = value
        self._force()


class ForcedBytes(TagBytes):
    """A tag in bytes; `forces` has forced elements by view and number, `free` is the tag without forces."""

    __slots__ = ("forces", "free")

    def __init__(self, free: TagBytes, forces: Mapping[tuple[str, int], ForcedValue]) -> None:
        self.free, self.forces = free, forces
        for name in TagBytes.__slots__:  # every view forces after a write
            if name == "hidden":
                self.hidden = free.hidden
            elif hasattr(free, name):
                setattr(self, name, ForcedView(getattr(free, name), self._force))
        self._force()

    def _force(self) -> None:
        """Force all elements again, in the tag without forces."""
        for position, forces in self.forces.items():
            self.free.put(*position, forces.merged(self.free.get(*position)))


def forced_in_lists(
    layout: Layout, forced_values: Iterable[ForcedValue]
) -> dict[str, dict[Any, ForcedValue]]:
    """Return the forced values in lists by identifier and index, and in bytes by view and index."""
    by_ident: dict[str, dict[Any, ForcedValue]] = {}
    for forced in forced_values:
        spot = layout.spot(forced.leaf)
        if spot is not None and spot.view:
            by_ident.setdefault(spot.ident, {})[spot.view, spot.at(forced.index)] = forced
        elif spot is not None:
            by_ident.setdefault(spot.ident, {})[spot.at(forced.index)] = forced
        elif forced.leaf.dims:
            by_ident.setdefault(forced.leaf.ident, {})[forced.index] = forced
    return by_ident


def forced_in_variables(layout: Layout, forced_values: Iterable[ForcedValue]) -> tuple[ForcedValue, ...]:
    """Return the forced values that have their own variables."""
    return tuple(
        forced for forced in forced_values if not forced.leaf.dims and layout.spot(forced.leaf) is None
    )


def force_variables(forced_values: Iterable[ForcedValue]) -> dict[str, Value]:
    """Return the values of the compiled program's variables for forces, by name."""
    names: dict[str, Value] = {}
    for forced in forced_values:
        names[force_variable(forced.leaf.ident)] = forced.value
        if forced.free_mask is not None:
            names[free_mask_variable(forced.leaf.ident)] = forced.free_mask
    return names
