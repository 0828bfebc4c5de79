"""Forces: values that no program can change.

The compiled program forces values in variables itself, see `compiler.observed`. A list, or a view of bytes,
keeps its own forced elements against every writer: an array access, a copy, or an add-on instruction. The
interpreter writes through the memory, which applies all forces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from scanrack.io_images.dataclass import dataclass
from typing_extensions import override

from ..compiler.observed import held_name, kept_name
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
    left: int | None  # mask of the unforced bits, as a value of the leaf's type; None if all are forced
    value: Value  # the forced bits

    def merged(self, value: Any) -> Any:
        """Return a value with its forced bits replaced."""
        return self.value if self.left is None else value & self.left | self.value


def held_values(layout: Layout, forces: Forces) -> tuple[ForcedValue, ...]:
    """Return the forced values of a program."""
    leaves = {leaf.ident: leaf for leaf in layout.leaves.values()}
    return tuple(_held(leaves[ident], index, force) for (ident, index), force in forces.items())


def _held(leaf: Leaf, index: int, force: Force) -> ForcedValue:
    mask, value = force
    if mask is None:
        return ForcedValue(leaf, index, None, value)
    bits = leaf.type.wraps
    return ForcedValue(leaf, index, wrap(~mask, bits), wrap(int(value) & mask, bits))


class HeldList(list[Any]):
    """A list with forced elements `held`, by number."""

    __slots__ = ("held",)

    def __init__(self, values: Iterable[Any], held: Mapping[int, ForcedValue]) -> None:
        super().__init__(values)
        self.held = held
        self._hold()

    @override
    def __setitem__(self, place: Any, value: Any) -> None:
        if place.__class__ is int:
            held = self.held.get(place)
            super().__setitem__(place, value if held is None else held.merged(value))
            return
        super().__setitem__(place, value)
        self._hold()

    def _hold(self) -> None:
        for number, held in self.held.items():
            super().__setitem__(number, held.merged(self[number]))


class HeldView:
    """A view of bytes that forces values again after every write."""

    __slots__ = ("_hold", "_view", "format")

    def __init__(self, view: Any, hold: Callable[[], None]) -> None:
        self._view, self._hold, self.format = view, hold, getattr(view, "format", "B")

    def __getitem__(self, place: Any) -> Any:
        return self._view[place]

    def __setitem__(self, place: Any, value: Any) -> None:
        self._view[place] = value
        self._hold()


class HeldBytes(TagBytes):
    """A tag in bytes with forced elements `held`, by view and number; `free` is the tag without forces."""

    __slots__ = ("free", "held")

    def __init__(self, free: TagBytes, held: Mapping[tuple[str, int], ForcedValue]) -> None:
        self.free, self.held = free, held
        for name in TagBytes.__slots__:
            if name == "hidden":
                self.hidden = free.hidden
            elif hasattr(free, name):
                setattr(self, name, HeldView(getattr(free, name), self._hold))
        self._hold()

    def _hold(self) -> None:
        for place, held in self.held.items():
            self.free.put(*place, held.merged(self.free.get(*place)))


def in_lists(layout: Layout, held: Iterable[ForcedValue]) -> dict[str, dict[Any, ForcedValue]]:
    """Return the forced values in lists by identifier and index, and in bytes by view and index."""
    by_ident: dict[str, dict[Any, ForcedValue]] = {}
    for forced in held:
        spot = layout.spot(forced.leaf)
        if spot is not None and spot.view:
            by_ident.setdefault(spot.ident, {})[spot.view, spot.at(forced.index)] = forced
        elif spot is not None:
            by_ident.setdefault(spot.ident, {})[spot.at(forced.index)] = forced
        elif forced.leaf.dims:
            by_ident.setdefault(forced.leaf.ident, {})[forced.index] = forced
    return by_ident


def in_variables(layout: Layout, held: Iterable[ForcedValue]) -> tuple[ForcedValue, ...]:
    """Return the forced values that have their own variables."""
    return tuple(forced for forced in held if not forced.leaf.dims and layout.spot(forced.leaf) is None)


def names_of(held: Iterable[ForcedValue]) -> dict[str, Value]:
    """Return the names of the compiled program's variables for forces."""
    names: dict[str, Value] = {}
    for forced in held:
        names[held_name(forced.leaf.ident)] = forced.value
        if forced.left is not None:
            names[kept_name(forced.leaf.ident)] = forced.left
    return names
