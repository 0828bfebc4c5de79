"""Motion structures in memory: axes, coordinate systems, and the instructions that move them.

An axis stores the instruction of a motion as a claim: the number of the MOTION_INSTRUCTION and the number of
its request. A claim of an earlier request no longer sets bits of the instruction.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import field

from scanrack.io_images.dataclass import dataclass

from ...model.predefined.motion_types import MOTION_BITS, PLANNERS
from ...model.tags import Leaf
from ...state.memory import Memory, Value
from ...state.regions import converted
from .axes import AxisSettings


@dataclass(frozen=True, slots=True)
class MotionPart:
    """A structure of a program, given by the path of its tag and the index of the array element."""

    path: str
    index: int
    name: str  # its name in messages
    kind: str = ""  # name of its type
    leaves: dict[str, Leaf] = field(
        default_factory=dict, compare=False, repr=False
    )  # leaves by member, filled on first use


@dataclass(frozen=True, slots=True)
class Ideal:
    """The ideal axes and coordinate systems of a program, and its motion instructions."""

    axes: tuple[tuple[MotionPart, AxisSettings], ...]  # the first has number -1
    systems: tuple[tuple[MotionPart, tuple[int, ...]], ...]  # number 1 is the first; with axis numbers
    controls: tuple[MotionPart, ...]  # number 1 is the first

    def renumber_motions(self, old: Ideal, memory: Memory) -> None:
        """Renumber the instructions and masters of motions under way, after an online edit of `old`."""
        controls = _new_numbers(old.controls, self.controls)
        axes = _new_numbers([part for part, _ in old.axes], [part for part, _ in self.axes])
        for owners, claims in ((self.axes, CLAIMS_OF_AXES), (self.systems, CLAIMS_OF_SYSTEMS)):
            for part, _ in owners:
                spot = MotionSpot(memory, part)
                for name in claims:
                    number, ticket = divmod(int(spot[f"~{name}"]), 1 << 32)
                    spot.set_hidden(**{name: controls.get(number, 0) << 32 | ticket})
        for part, _ in self.axes:
            spot = MotionSpot(memory, part)
            master = int(spot["~master"])
            if master < 0:
                spot.set_hidden(master=-axes.get(-master, 0))


CLAIMS_OF_AXES = (*(f"{planner}_claim" for planner in PLANNERS), "watch_claim")
CLAIMS_OF_SYSTEMS = ("claim", "next_claim", "transform")
"""Hidden members that refer to an instruction."""


def _new_numbers(old: Sequence[MotionPart], new: Sequence[MotionPart]) -> dict[int, int]:
    """Return the new number for each old number, from 1; 0 if the structure no longer exists."""
    numbers = {(part.path.upper(), part.index): number for number, part in enumerate(new, 1)}
    return {number: numbers.get((part.path.upper(), part.index), 0) for number, part in enumerate(old, 1)}


class MotionSpot:
    """A structure in memory: `spot["~kind"]`, `spot.put(MoveStatus=True)`."""

    def __init__(self, memory: Memory, part: MotionPart) -> None:
        self.memory, self.part = memory, part

    def _leaf(self, name: str) -> Leaf:
        leaves = self.part.leaves
        if name not in leaves:
            leaves[name] = self.memory.layout.leaf(f"{self.part.path}.{name}")
        return leaves[name]

    def __getitem__(self, name: str) -> Value:
        """Return a member."""
        return self.memory.read(self._leaf(name), self.part.index)

    def put(self, **members: Value) -> None:
        """Set members that are not in an array."""
        for name, value in members.items():
            leaf = self._leaf(name)
            self.memory.write(leaf, self.part.index, converted(leaf.type, value))

    def set_hidden(self, **members: Value) -> None:
        """Set hidden members."""
        self.put(**{f"~{name}": value for name, value in members.items()})

    def set_array(self, name: str, values: Iterable[float]) -> None:
        """Set the elements of an array member."""
        leaf = self._leaf(name)
        for index, value in enumerate(values, self.part.index * leaf.dims[-1]):
            self.memory.write(leaf, index, converted(leaf.type, value))

    def set_bits(self, positions: dict[str, str], **bits: bool) -> None:
        """Set bits by name; `positions` has each bit's word and number, such as `FLAGS.3`."""
        words: dict[str, int] = {}
        for name, on in bits.items():
            word, _, bit = positions[name].partition(".")
            value = words[word] if word in words else int(self[word])
            words[word] = value | 1 << int(bit) if on else value & ~(1 << int(bit))
        self.put(**words)


FLAGS = {name: f"FLAGS.{bit}" for name, bit in MOTION_BITS.items()}


def report(memory: Memory, ideal: Ideal, claim: int, error: int = 0, **bits: bool) -> None:
    """Set bits and ERR of a claim's instruction, unless that instruction has begun again since."""
    number, ticket = claim >> 32, claim & 0xFFFF_FFFF
    if not number:
        return
    control = MotionSpot(memory, ideal.controls[number - 1])
    if control["~ticket"] == ticket:
        control.set_bits(FLAGS, **bits)
        if error:
            control.put(ERR=error)


ENDED = {"IP": False, "AC": False, "ACCEL": False, "DECEL": False}
"""Bits of an instruction after its motion has ended."""
