"""Outputs of a ladder program, and the inputs that switch them on, directly or through other bits.

XIC(FwdPB)XIO(RevCmd)OTE(FwdCmd);  XIC(FwdCmd)OTE(Forward);     Forward: FwdPB and not RevCmd
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.ladder.model.operands import Constant, Place

from ..facts import OutputWrite
from ..groups import grouped
from ..logic import (
    INPUT,
    TRUE,
    AllOf,
    AnyOf,
    Bit,
    Condition,
    FixedTruth,
    base_of,
    negated,
    plain,
    with_leaves,
)
from .operands import first_of, is_zero, key_of
from .view import LadderView
from .walk import Point

DEPTH = 4
"""Maximum number of bits that are followed one after another."""

BIT_INSTRUCTIONS = ("OTE", "OTL", ":=", "OTU")


class OutputBits:
    """The output bits of a program."""

    def __init__(self, view: LadderView) -> None:
        self._points, self._places, self._steppers = view.main, view.places, view.steppers
        self._writers: dict[str, list[Point]] = {}
        for point in self._points:
            bit = _bit_of(point)
            if bit is not None:
                self._writers.setdefault(key_of(bit), []).append(point)

    def writes(self) -> Iterator[OutputWrite]:
        """Yield the writes that switch output bits on."""
        for point in self._points:
            bit = _bit_of(point)
            if bit is None or bit.leaf.slot is None or not bit.leaf.output or not _may_set(point):
                continue
            key = key_of(bit)
            of_module = bit.leaf.slot in self._steppers and bit.fixed_index == 0
            free = self._freed(point.power, DEPTH, (key,))
            if of_module and isinstance(bit.bit, Constant):
                name = str(CommandMsw(1 << int(bit.bit.value)).name)
                yield OutputWrite(point.place, name, key, free, f"slot {bit.leaf.slot}")
            elif not of_module:
                yield OutputWrite(point.place, bit.text, key, free)

    def _freed(self, condition: Condition, depth: int, seen: tuple[str, ...]) -> Condition:
        """Return a condition in which bits are replaced by the conditions that switch them on."""

        def of(leaf: Condition) -> Condition:
            return self._bit(leaf, depth, seen) if isinstance(leaf, Bit) else plain(leaf)

        return with_leaves(condition, of)

    def _bit(self, bit: Bit, depth: int, seen: tuple[str, ...]) -> Condition:
        base = base_of(bit.name)
        place = self._places.get(base)
        writers = self._writers.get(base, [])
        if base in seen:
            return FixedTruth(not bit.on)  # before it has sealed in
        if place is not None and place.leaf.slot is not None:
            is_input = not place.leaf.output and place.leaf.slot not in self._steppers
            return Bit(f"{INPUT}{base}" if is_input else base, bit.on)
        is_followed = bit.on or any(map(_is_coil, writers))
        followed = self._power(writers, depth - 1, (*seen, base)) if is_followed else None
        power = followed or Bit(base)
        return power if bit.on else negated(power)

    def _power(self, writers: Sequence[Point], depth: int, seen: tuple[str, ...]) -> Condition | None:
        """Return the condition under which a bit is on, by its only coil or its latches; None if unclear."""
        if depth < 0 or not writers or (len(writers) > 1 and any(map(_is_coil, writers))):
            return None
        powers = [(point, self._freed(point.power, depth, seen)) for point in writers]
        if _is_coil(writers[0]):
            return powers[0][1]
        by_way = grouped(powers, lambda each: _may_set(each[0]))
        sets, clears = (AnyOf(tuple(power for _, power in by_way.get(way, ()))) for way in (True, False))
        return AllOf((sets, negated(clears)))


def _bit_of(point: Point) -> Place | None:
    """Return the bit that an instruction in the user's code sets, clears or assigns."""
    first = first_of(point.step, BIT_INSTRUCTIONS) if not point.argument else None
    return first if isinstance(first, Place) and first.type.is_bool else None


def _may_set(point: Point) -> bool:
    source = point.step.operands[1] if point.step.name == ":=" else None
    return point.step.name != "OTU" and not is_zero(source)


def _is_coil(point: Point) -> bool:
    return point.step.name == "OTE" or (point.step.name == ":=" and point.value != TRUE)
