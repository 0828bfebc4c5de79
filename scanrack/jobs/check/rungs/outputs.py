"""Outputs of a ladder program, and the inputs that switch them on, directly or through other bits.

XIC(FwdPB)XIO(RevCmd)OTE(FwdCmd);  XIC(FwdCmd)OTE(Forward);     Forward: FwdPB and not RevCmd
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scanrack.io_images.amci3601 import CommandMsw
from scanrack.ladder.model.operands import Constant, Place

from ..facts import OutputWrite
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
"""Maximum number of bits to follow in a chain."""

BIT_INSTRUCTIONS = ("OTE", "OTL", ":=", "OTU")


class OutputBits:
    """The output bits of a program."""

    def __init__(self, view: LadderView) -> None:
        self._points, self._places, self._steppers = view.main, view.places, view.steppers
        self._writers: dict[str, list[Point]] = {}  # by key of the bit that they write
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
            is_command = bit.leaf.slot in self._steppers and bit.fixed_index == 0
            free = self._freed(point.power, DEPTH, (key,))
            if is_command and isinstance(bit.bit, Constant):
                name = str(CommandMsw(1 << int(bit.bit.value)).name)
                yield OutputWrite(point.place, name, key, free, f"slot {bit.leaf.slot}")
            elif not is_command:
                yield OutputWrite(point.place, bit.text, key, free)

    def _freed(self, condition: Condition, depth: int, followed: tuple[str, ...]) -> Condition:
        """Return a condition in which bits are replaced by the conditions that switch them on.

        Args:
            depth: number of additional bits to follow.
            followed: keys of the bits that have been replaced around this condition.
        """

        def replacement(leaf: Condition) -> Condition:
            return self._bit_condition(leaf, depth, followed) if isinstance(leaf, Bit) else plain(leaf)

        return with_leaves(condition, replacement)

    def _bit_condition(self, bit: Bit, depth: int, followed: tuple[str, ...]) -> Condition:
        """Return the condition that replaces a bit."""
        base = base_of(bit.name)
        place = self._places.get(base)
        writers = self._writers.get(base, [])
        if base in followed:
            return FixedTruth(not bit.on)  # off, as before it seals in
        if place is not None and place.leaf.slot is not None:
            is_input = not place.leaf.output and place.leaf.slot not in self._steppers
            return Bit(f"{INPUT}{base}" if is_input else base, bit.on)
        power = None
        if bit.on or any(map(_is_coil, writers)):
            power = self._power(writers, depth - 1, (*followed, base))
        power = power or Bit(base)
        return power if bit.on else negated(power)

    def _power(self, writers: Sequence[Point], depth: int, followed: tuple[str, ...]) -> Condition | None:
        """Return the condition under which a bit is on: from its only coil, or from its latches.

        Return None if that is unknown.
        """
        if depth < 0 or not writers or (len(writers) > 1 and any(map(_is_coil, writers))):
            return None
        if _is_coil(writers[0]):
            return self._freed(writers[0].power, depth, followed)
        sets: list[Condition] = []
        clears: list[Condition] = []
        for point in writers:
            (sets if _may_set(point) else clears).append(self._freed(point.power, depth, followed))
        return AllOf((AnyOf(tuple(sets)), negated(AnyOf(tuple(clears)))))


def _bit_of(point: Point) -> Place | None:
    """Return the bit that an instruction in the user's code sets, clears or assigns."""
    first = first_of(point.step, BIT_INSTRUCTIONS) if not point.argument else None
    return first if isinstance(first, Place) and first.type.is_bool else None


def _may_set(point: Point) -> bool:
    source = point.step.operands[1] if point.step.name == ":=" else None
    return point.step.name != "OTU" and not is_zero(source)


def _is_coil(point: Point) -> bool:
    return point.step.name == "OTE" or (point.step.name == ":=" and point.value != TRUE)
