"""Instructions on stretches of memory: COP, CPS, FLL."""

from __future__ import annotations

from .. import arithmetic as math
from ..memory import Value
from ..operands import Place, Resolved
from ..regions import copy, region_of
from .values import Values, width_of


class FileInstructions(Values):
    """Copy and fill."""

    def _cop(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        regions = [region_of(each, self._memory.layout) for each in (source, target)]
        firsts = [
            each.first(lambda index, most, each=each: self._subscript(index, most, each.text))  # type: ignore[misc]
            for each in regions
        ]
        copy(self._memory, regions[0], firsts[0], regions[1], firsts[1], self._integer(length))

    def _fll(self, source: Resolved, target: Resolved, length: Resolved) -> None:
        region = region_of(target, self._memory.layout)
        first = region.first(lambda index, most: self._subscript(index, most, region.text))
        count = min(self._integer(length), region.left(first))
        value = self._number(source, width_of(source))
        leaf = region.parts[0].leaf
        for number in range(count):
            element = Place(leaf, (), None, region.text)
            self._memory.write(leaf, first + number, self._converted(element, value))

    def _converted(self, place: Place, value: Value) -> Value:
        """Convert as FLL does: without flags and faults."""
        if place.type.is_real:
            return math.real(value)
        return math.wrap(math.whole(value) if isinstance(value, float) else int(value), place.type.bits)
