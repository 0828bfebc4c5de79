"""Tags by name, for tests, displays and logic in Python."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..model.operands import Calculation, Constant, Group, Place, Resolved, leaves_in
from ..model.resolver import Resolver
from ..state.lowered import LoweredProgram
from ..state.memory import Memory, mask_of
from ..state.values import checked


class Tags:
    """A program's tags by name: `tags["Fill.ACC"]`, or `tags.Run` for a plain name.

    Values are bool, int, float, a str for a STRING, nested lists for an array, or a dict of a structure's
    members. Setting a shorter list or a dict sets only the elements or members in it. Names ignore case. Tags
    of `program` hide the controller's tags.
    """

    __slots__ = ("_cache", "_lowered", "_memory", "_resolver")

    def __init__(self, lowered: LoweredProgram, memory: Memory, program: str = "") -> None:
        object.__setattr__(self, "_lowered", lowered)
        object.__setattr__(self, "_memory", memory)
        object.__setattr__(self, "_resolver", Resolver(lowered.layout, program))
        object.__setattr__(self, "_cache", {})

    def __getitem__(self, name: str) -> Any:
        tag = self._resolve(name)
        if isinstance(tag, Place):
            return self._get(tag)
        return self._memory.dump(tag.path, tag.type, tag.dims, self._flat(tag.indices, tag))

    def __setitem__(self, name: str, value: object) -> None:
        tag = self._resolve(name)
        if any(map(self._memory.is_read_only, leaves_in(tag))):
            raise ValueError(f"{name} is an input image, which every scan overwrites; force it instead")
        if isinstance(tag, Place):
            self._set(tag, checked(name, tag.type, value))
        else:
            self._memory.load(tag.path, tag.type, tag.dims, self._flat(tag.indices, tag), value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: object) -> None:
        self[name] = value

    def __iter__(self) -> Iterator[str]:
        return iter([tag.name for tag in self._lowered.layout.tags().values()])

    def __contains__(self, name: str) -> bool:
        try:
            self._resolve(name)
        except ValueError:
            return False
        return True

    def __repr__(self) -> str:
        return f"Tags({', '.join(self)})"

    def where(self, name: str) -> Place | Group:
        """Return the place or group of a name, or raise a ValueError."""
        tag: Place | Group = self._resolver.named(name)
        return tag

    def _resolve(self, name: str) -> Place | Group:
        """Return and cache the place of a name; raise a ValueError if it is unknown or an unused image."""
        tag: Place | Group | None = self._cache.get(name)
        if tag is None:
            tag = self._resolver.named(name)
            if not all(map(self._memory.has, leaves_in(tag))):
                raise ValueError(f"{name}: the program does not use this image")
            self._cache[name] = tag
        return tag

    def _get(self, place: Place) -> bool | int | float:
        """Return the value at a place; a bit of a word and a BOOL as a bool."""
        value = self._memory.read(place.leaf, self._flat(place.indices, place) if place.indices else 0)
        if place.bit is None:
            return bool(value) if place.type.is_bool else value
        return bool(int(value) >> self._index(place.bit, place.leaf.type.bits, place) & 1)

    def _set(self, place: Place, value: bool | int | float) -> None:
        """Write a value of the place's type; for a bit, change that bit of its word."""
        index = self._flat(place.indices, place)
        if place.bit is not None:
            bits = place.leaf.type.bits
            number = self._index(place.bit, bits, place)
            word = int(self._memory.read(place.leaf, index))
            mask = mask_of(place.leaf.type, number)
            value = word | mask if value else word & ~mask
        self._memory.write(place.leaf, index, value)

    def _flat(self, indices: tuple[Resolved, ...], tag: Place | Group) -> int:
        """Return the flat index that subscripts select; 0 without subscripts."""
        if not indices:
            return 0
        dims = tag.leaf.dims if isinstance(tag, Place) else self._dims(tag)
        flat = 0
        for index, length in zip(indices, dims, strict=False):
            flat = flat * length + self._index(index, length, tag)
        return flat

    def _dims(self, group: Group) -> tuple[int, ...]:
        """Return the dimensions of a group's first leaf; they begin with the group's dimensions."""
        prefix = group.path.upper()
        leaves = self._lowered.layout.leaves
        return next(
            leaf.dims for path, leaf in leaves.items() if path == prefix or path.startswith(f"{prefix}.")
        )

    def _index(self, index: Resolved, length: int, tag: Place | Group) -> int:
        """Return a subscript or bit number; raise a ValueError if it is out of range."""
        value = self._value(index)
        if not 0 <= value < length:
            raise ValueError(f"{tag.text}: index {value} is out of range; must be 0 to {length - 1}")
        return value

    def _value(self, index: Resolved) -> int:
        """Return the current value of a subscript."""
        if isinstance(index, Constant):
            return int(index.value)
        if isinstance(index, Place):
            return int(self._get(index))
        assert isinstance(index, Calculation)
        raise ValueError("an index can be an expression only in rungs; compute the index first")
