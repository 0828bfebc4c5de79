"""Module contracts as terms. A contract is a condition that the inputs of a slot always satisfy.

A MicroLogix exchanges images in each scan:

    scan        n-1            n
    inputs      was            now
    outputs        sent ------->     outputs of scan n-1, in force until the inputs of scan n

A CompactLogix exchanges images every RPI, which is at least as long as a scan. Inputs change only in the
first scan after an exchange. Outputs wait for an exchange and are in force until the next one.

    exchange             |                   |                   |
    scan          n-1         n       n+1         n+2
    inputs        was         now     (now)
    outputs       left ->| waits: sent from here to the next exchange

In the first scan, `was` is an impossible image: the axis moves both ways, and Module OK is clear. Therefore a
contract between two images does not constrain the first scan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from scanrack.io_images.amci3601.bits import StatusMsw
from scanrack.io_images.amci3601.contracts import TYPICAL, Contract, Reading, Side

from ..run.engine import Engine
from .algebra.meaning import BOOL, INT
from .algebra.numbers import bit, eq, le
from .algebra.terms import TRUE, T, all_of, and_, any_of, const, ite, not_, numbers_in, or_, var
from .system import ProgramSystem

Words = tuple[int, ...]

NO_IMAGE = ((StatusMsw.MOVING_CW | StatusMsw.MOVING_CCW).value, 0, 0, 0, 0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class KeptBy:
    """Builds the condition that a slot's images keep their contracts.

    Attributes:
        slot: number of the slot.
        contracts: the contracts that its module keeps in this rack; see `contracts_of`.
        at_rpi: whether images are exchanged every RPI, and no scan is longer.
    """

    slot: int
    contracts: tuple[Contract, ...]
    at_rpi: bool = False

    def __call__(self, program: ProgramSystem) -> T:
        """Return the condition as a term over one scan."""
        images = (_TermsAtRpi if self.at_rpi else _Terms)(program, self.slot)
        program.likely[images.word(Side.NOW, 0)[1].val] = TYPICAL
        return images.in_scan(all_of(contract.fact.read(images) for contract in self.contracts))

    def watch(self, engine: Engine) -> Callable[[], bool]:
        """Return a function that checks the images against the contracts; call it before each scan."""
        layout, memory = engine.lowered.layout, engine.memory
        images = [layout.image(self.slot, output=output) for output in (False, True)]
        was: Words = NO_IMAGE
        in_force: set[Words] = {(0,) * 8}  # possibly in force: images don't show when exchanges happen

        def keeps() -> bool:
            """Return whether any outputs explain the inputs; store the outputs possibly in force now."""
            nonlocal was, in_force
            now, sent = (tuple(int(memory.read(leaf, word)) for word in range(8)) for leaf in images)
            possible = in_force if self.at_rpi else {sent}
            exchanged = any(self._keeps(now, was, words) for words in possible)
            in_force = {sent} if exchanged else set()
            if self.at_rpi and now == was:
                in_force |= possible
            was = now
            return bool(in_force)

        return keeps

    def _keeps(self, now: Words, was: Words, sent: Words) -> bool:
        return all(contract.fact.holds(now, was, sent) for contract in self.contracts)


class _Terms(Reading[T]):
    """The images of a slot as terms."""

    def __init__(self, program: ProgramSystem, slot: int) -> None:
        layout = program.lowered.layout
        self._program = program
        self._paths = {output: layout.image(slot, output=output).path.upper() for output in (False, True)}

    def any_of(self, side: Side, word: int, mask: int) -> T:
        return any_of(self._bit(side, word, number) for number in numbers_in(mask & 0xFFFF))

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
        """Return a bit. A bit from the previous scan is a separate state, so invariants can use it."""
        path, value = self.word(side, word)
        bit_now = bit(value, number)
        if side is not Side.WAS:
            return bit_now
        return self._program.before(f"{path}[{word}].{number}", bit_now, NO_IMAGE[word] >> number & 1 == 1)

    def word(self, side: Side, word: int) -> tuple[str, T]:
        """Return the path of a word, and its value before the scan."""
        path = self._paths[side is Side.SENT]
        return path, self._program.now((path, word))

    def in_scan(self, keeps_contracts: T) -> T:
        """Return the condition for a scan, given the condition that its exchange keeps the contracts."""
        return keeps_contracts


class _TermsAtRpi(_Terms):
    """The images of a slot as terms, where only some scans begin with an exchange."""

    def __init__(self, program: ProgramSystem, slot: int) -> None:
        super().__init__(program, slot)
        begun = program.before(f"~begun:{slot}", TRUE, False)
        self._exchanged = or_(not_(begun), var(f"~exchanged:{slot}", BOOL))
        self._sent = [self._in_force(slot, word) for word in range(8)]

    def _in_force(self, slot: int, word: int) -> T:
        """Return an output word that was in force before a scan's exchange."""
        written = super().word(Side.SENT, word)[1]
        sent = var(f"~was:~sent:{slot}[{word}]", INT, written.lo, written.hi)
        return self._program.before(f"~sent:{slot}[{word}]", ite(self._exchanged, written, sent), 0)

    def word(self, side: Side, word: int) -> tuple[str, T]:
        """Return the path and the value of a word; for an output, the value in force."""
        path, value = super().word(side, word)
        return path, self._sent[word] if side is Side.SENT else value

    def in_scan(self, keeps_contracts: T) -> T:
        """Return the condition that an exchange keeps the contracts, or that no input changes."""
        unchanged = TRUE
        for word in range(8):
            path, now = self.word(Side.NOW, word)
            unchanged = and_(unchanged, eq(now, self._program.before(f"{path}[{word}]", now, NO_IMAGE[word])))
        return ite(self._exchanged, keeps_contracts, unchanged)
