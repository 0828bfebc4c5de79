"""Contracts of modules as terms: what the inputs of a slot never do, in each scan of a run in question.

    scan        n-1            n
    inputs      was            now
    outputs        told ------->     what scan n-1 left: in force until the inputs of scan n

In the first scan `was` is an image that no module shows, so a contract of two images says nothing of it: the
axis moves both ways, and Module OK is clear.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

from ...io_images.amci3601.bits import StatusMsw
from ...io_images.amci3601.contracts import TYPICAL, Contract, Reading, Side
from ..run.engine import Engine
from ..state.lowered import LoweredProgram
from .algebra.numbers import bit, le
from .algebra.terms import FALSE, TRUE, T, and_, const, not_, or_

Key = tuple[str, int]

NO_IMAGE = ((StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW).value, 0, 0, 0, 0, 0, 0, 0)


class Sight(Protocol):
    """A program with terms of its values, such as a `Problem`."""

    lowered: LoweredProgram
    likely: dict[str, Sequence[int]]

    def now(self, key: Key) -> T:
        """Return the value of a place that a scan begins with."""

    def before(self, name: str, value: T, first: bool | int) -> T:
        """Return the value that a term had in the scan before."""


@dataclass(frozen=True, slots=True)
class KeptBy:
    """What makes the truth that a slot's images keep contracts.

    Attributes:
        slot: number of the slot.
        contracts: those that its module keeps in this rack, see `contracts_of`.
    """

    slot: int
    contracts: tuple[Contract, ...]

    def __call__(self, program: Sight) -> T:
        """Return the truth of a scan."""
        images, kept = _Terms(program, self.slot), TRUE
        program.likely[images.word(Side.NOW, 0)[1].val] = TYPICAL
        for each in self.contracts:
            kept = and_(kept, each.fact.read(images))
        return kept

    def watch(self, engine: Engine) -> Callable[[], bool]:
        """Return what tells, once before each scan of an engine, whether its images keep the contracts."""
        layout, memory = engine.lowered.layout, engine.memory
        inputs, outputs = (layout.image(self.slot, output=output) for output in (False, True))
        was: Sequence[int] = NO_IMAGE

        def keeps() -> bool:
            nonlocal was
            now, told = ([int(memory.read(leaf, word)) for word in range(8)] for leaf in (inputs, outputs))
            kept = all(each.fact.holds(now, was, told) for each in self.contracts)
            was = now
            return kept

        return keeps


class _Terms(Reading[T]):
    """The images of a slot as terms."""

    def __init__(self, program: Sight, slot: int) -> None:
        layout = program.lowered.layout
        self._program = program
        self._paths = {output: layout.image(slot, output=output).path.upper() for output in (False, True)}

    def any_of(self, side: Side, word: int, mask: int) -> T:
        found = FALSE
        for number in range(16):
            if mask >> number & 1:
                found = or_(found, self._bit(side, word, number))
        return found

    def within(self, side: Side, word: int, least: int, most: int) -> T:
        path, value = self.word(side, word)
        if side is Side.WAS:
            value = self._program.before(f"{path}[{word}]", value, NO_IMAGE[word])
        return and_(le(const(least), value), le(value, const(most)))

    def both(self, first: T, second: T) -> T:
        return and_(first, second)

    def negated(self, truth: T) -> T:
        return not_(truth)

    def _bit(self, side: Side, word: int, number: int) -> T:
        """Return a bit; one of the scan before is a truth of its own, so that invariants speak of it."""
        path, value = self.word(side, word)
        here = bit(value, number)
        if side is not Side.WAS:
            return here
        return self._program.before(f"{path}[{word}].{number}", here, NO_IMAGE[word] >> number & 1 == 1)

    def word(self, side: Side, word: int) -> tuple[str, T]:
        """Return path and value of a word that is there before the scan."""
        path = self._paths[side is Side.TOLD]
        return path, self._program.now((path, word))
