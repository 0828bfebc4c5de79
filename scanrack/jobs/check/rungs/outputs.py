"""Outputs of a ladder program, and the inputs behind the bits that switch them on.

XIC(FwdPB)XIO(RevCmd)OTE(FwdCmd);  XIC(FwdCmd)OTE(Forward);     Forward: FwdPB and not RevCmd
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.ladder.model.operands import Constant, Place

from ..facts import FileLine, OutputWrite
from ..logic import FALSE, INPUT, TRUE, AllOf, AnyOf, Bit, Compare, Condition, base_of, negated, plain
from .conditions import key_of
from .walk import Point

Placed = Sequence[tuple[Point, FileLine]]

DEPTH = 4
"""Bits behind a bit that are followed."""

SETTING = ("OTE", "OTL", ":=")


class OutputBits:
    """The output bits of a program.

    Args:
        places: operands by their keys.
        steppers: slots with 3601s.
    """

    def __init__(self, points: Placed, places: Mapping[str, Place], steppers: Collection[int]) -> None:
        self._points, self._places, self._steppers = points, places, steppers
        self._writers: dict[str, list[Point]] = {}
        for point, _ in points:
            bit = _bit_of(point)
            if bit is not None:
                self._writers.setdefault(key_of(bit), []).append(point)

    def writes(self) -> Iterator[OutputWrite]:
        """Yield what switches output bits on."""
        for point, place in self._points:
            bit = _bit_of(point)
            if bit is None or bit.leaf.slot is None or not bit.leaf.output or not _may_set(point):
                continue
            key = key_of(bit)
            of_module = bit.leaf.slot in self._steppers and bit.fixed_index == 0
            free = self._freed(_power(point), DEPTH, (key,))
            if of_module and isinstance(bit.bit, Constant):
                name = str(CommandMsw(1 << int(bit.bit.value)).name)
                yield OutputWrite(place, name, key, free, f"slot {bit.leaf.slot}")
            elif not of_module:
                yield OutputWrite(place, bit.text, key, free)

    def _freed(self, condition: Condition, depth: int, seen: tuple[str, ...]) -> Condition:
        """Return a condition of what is behind its bits."""
        match condition:
            case Bit():
                return self._bit(condition, depth, seen)
            case Compare():
                return plain(condition)
            case AllOf(parts):
                return AllOf(tuple(self._freed(each, depth, seen) for each in parts))
            case AnyOf(parts):
                return AnyOf(tuple(self._freed(each, depth, seen) for each in parts))
        return condition

    def _bit(self, bit: Bit, depth: int, seen: tuple[str, ...]) -> Condition:
        base = base_of(bit.name)
        place = self._places.get(base)
        if base in seen:
            return FALSE if bit.on else TRUE  # not sealed in yet
        if place is not None and place.leaf.slot is not None:
            is_input = not place.leaf.output and place.leaf.slot not in self._steppers
            return Bit(f"{INPUT}{base}" if is_input else base, bit.on)
        writers = self._writers.get(base, [])
        coils = [each for each in writers if _is_coil(each)]
        if depth == 0 or not writers or (coils and len(writers) > 1):
            return Bit(base, bit.on)
        inner = (*seen, base)
        if coils:
            found = self._freed(_power(coils[0]), depth - 1, inner)
            return found if bit.on else negated(found)
        if not bit.on:
            return Bit(base, False)
        sets = [self._freed(_power(each), depth - 1, inner) for each in writers if _may_set(each)]
        clears = [self._freed(_power(each), depth - 1, inner) for each in writers if not _may_set(each)]
        return AllOf((AnyOf(tuple(sets)), negated(AnyOf(tuple(clears)))))


def _bit_of(point: Point) -> Place | None:
    first = point.step.operands[0] if point.step.operands else None
    is_bit = (isinstance(first, Place) and first.type.is_bool) or getattr(first, "bit", None) is not None
    is_setting = point.step.name in (*SETTING, "OTU") and not point.argument
    return first if is_bit and is_setting and isinstance(first, Place) else None


def _may_set(point: Point) -> bool:
    source = point.step.operands[1] if point.step.name == ":=" else None
    return point.step.name != "OTU" and not (isinstance(source, Constant) and not source.value)


def _is_coil(point: Point) -> bool:
    return point.step.name == "OTE" or (point.step.name == ":=" and point.value != TRUE)


def _power(point: Point) -> Condition:
    return point.condition if point.value == TRUE else AllOf((point.condition, point.value))
