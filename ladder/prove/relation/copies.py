"""Copies and fills of regions in a scan on terms; see `state.regions`.

The first element and the number of elements can be terms. Each element is then copied under the condition
that its number is below the count.
"""

from __future__ import annotations

from typing import Any

from ...state.memory import Store
from ...state.regions import ArrayRegion, End
from ..algebra.meaning import INT
from ..algebra.numbers import lt
from ..algebra.terms import const, ite, mk
from .patterns import Pattern, constant_bytes, pack, unpack
from .places import kind_of
from .stored import TermPlaces
from .symbols import TermSymbol, UnmodeledError, term_of

MOST_COPIED = 4096
"""Maximum number of values in a copy."""


class TermCopies(TermPlaces):
    """Copies and fills regions."""

    def copy(self, source: End, target: End, length: Any) -> None:
        """Copy bytes for `length` elements of the target, up to the end of either array."""
        if _have_same_fields(source[1], target[1]):
            self._copy_fields(source, target, length)
        else:
            self._copy_bytes(source, target, length)

    def fill(self, target: End, length: Any, value: Any) -> None:
        """Set each member of the elements to a value, up to the end of the array."""
        store, region, first = target
        count = self._least(length, region.left(first, store))
        for number in range(_most(count, region)):
            for part in region.parts:
                index = (first + number) * part.per_element + part.field.index
                filling = self.converted(part.leaf.type, value)
                self._write(store, part.leaf, index, filling, number, count)

    def take_bytes(self, store: Store, region: ArrayRegion, first: Any, count: Any) -> Any:
        """Return elements as bytes."""
        cells: Pattern = [None] * (_constant_count(count, region) * region.size)
        for number in range(_constant_count(count, region)):
            for part in region.parts:
                value = store.read(part.leaf, (first + number) * part.per_element + part.field.index)
                term = term_of(value, kind_of(part.leaf.type)[0])
                pack(cells, number * region.size + part.field.offset, part.field, term)
        return cells

    def put_bytes(self, store: Store, region: ArrayRegion, first: Any, count: Any, data: Any) -> None:
        """Set elements from bytes."""
        cells = constant_bytes(data) if isinstance(data, bytes) else data
        for number in range(_constant_count(count, region)):
            for part in region.parts:
                offset = number * region.size + part.field.offset
                term = unpack(cells, offset, part.field, self)
                index = (first + number) * part.per_element + part.field.index
                store.write(part.leaf, index, self.symbol(term))

    # --- copy by members or by bytes

    def _copy_fields(self, source: End, target: End, length: Any) -> None:
        """Copy each value as a term, for elements with the same fields."""
        source_store, source_region, source_first = source
        target_store, target_region, target_first = target
        count = self._least(
            self._least(length, target_region.left(target_first, target_store)),
            source_region.left(source_first, source_store),
        )
        numbers = range(_most(count, target_region))
        elements = [  # all of them before the first write, because the regions may overlap
            [
                source_store.read(part.leaf, (source_first + number) * part.per_element + part.field.index)
                for part in source_region.parts
            ]
            for number in numbers
        ]
        for number, values in zip(numbers, elements, strict=True):
            for part, value in zip(target_region.parts, values, strict=True):
                index = (target_first + number) * part.per_element + part.field.index
                self._write(target_store, part.leaf, index, value, number, count)

    def _copy_bytes(self, source: End, target: End, length: Any) -> None:
        """Copy bytes, for elements of different types; past the source's end, the target is unchanged."""
        source_store, source_region, source_first = source
        target_store, target_region, target_first = target
        count = _constant_count(
            self._least(length, target_region.left(target_first, target_store)), target_region
        )
        if count <= 0:
            return
        requested = count * target_region.size
        needed = -(-requested // source_region.size)  # rounded up
        origin_count = _constant_count(
            self._least(needed, source_region.left(source_first, source_store)), source_region
        )
        data = self.take_bytes(source_store, source_region, source_first, origin_count)[:requested]
        if len(data) < requested:
            data += self.take_bytes(target_store, target_region, target_first, count)[len(data) :]
        self.put_bytes(target_store, target_region, target_first, count, data)

    def _write(self, store: Store, leaf: Any, index: Any, value: Any, number: int, count: Any) -> None:
        """Write a value of an element, on condition that the element's number is below the count."""
        if isinstance(count, TermSymbol) and number >= count.t.lo:
            old_value = store.read(leaf, index)
            kind = kind_of(leaf.type)[0]
            new, old = term_of(value, kind), term_of(old_value, kind)
            value = self.symbol(ite(lt(const(number), count.t), new, old))
        store.write(leaf, index, value)

    def _least(self, a: Any, b: Any) -> Any:
        """Return the smaller of two numbers."""
        first, second = term_of(a, INT), term_of(b, INT)
        if first.hi <= second.lo:
            return a
        if second.hi <= first.lo:
            return b
        least = min(first.lo, second.lo), min(first.hi, second.hi)
        return self.symbol(mk("ite", (lt(first, second), first, second), INT, None, *least))


def _have_same_fields(a: ArrayRegion, b: ArrayRegion) -> bool:
    """Return whether elements of both regions have the same fields at the same offsets."""
    return a.size == b.size and _shape(a) == _shape(b)


def _shape(region: ArrayRegion) -> list[tuple[Any, ...]]:
    """Return the type, the offset and the bit of each field in an element."""
    fields = (part.field for part in region.parts)
    return [(field.type, field.offset, field.bit) for field in fields]


def _most(count: Any, region: ArrayRegion) -> int:
    """Return the maximum value that an element count can have."""
    most: int = count.t.hi if isinstance(count, TermSymbol) else count
    if most * len(region.parts) > MOST_COPIED:
        raise UnmodeledError(f"a copy of {most} elements of {len(region.parts)} values")
    return max(0, most)


def _constant_count(count: Any, region: ArrayRegion) -> int:
    """Return an element count, at least 0; refuse a computed count."""
    if isinstance(count, TermSymbol):
        raise UnmodeledError("a copy of a computed length between types")
    return _most(count, region)
