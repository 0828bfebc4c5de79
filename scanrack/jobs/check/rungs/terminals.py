"""Terminals and slots that a ladder program names: whether the rack has them, and which it uses."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.drives.translation import model_of
from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Constant, Group, Place, first_leaf
from scanrack.ladder.model.resolver import MEANINGS
from scanrack.ladder.model.tags import SlotAlias
from scanrack.ladder.state.lowered import LoweredLine, LoweredProgram, steps_of
from scanrack.runtime.config.rackspec import RackSpec

from ...load.program import EXPORT_SUFFIXES
from ..facts import FileLine, LocalFinding, UsesBit
from .blocks import OWNER, BlockCall


class Terminals:
    """The terminals that a program names.

    Args:
        path: its file.
        declared: returns the line that declares a name.
    """

    def __init__(
        self,
        lowered: LoweredProgram,
        mentions: Sequence[Mention],
        spec: RackSpec,
        path: Path,
        declared: Callable[[str], int],
    ) -> None:
        self._lowered, self._mentions, self._spec = lowered, mentions, spec
        self._path, self._declared = path, declared
        self._cards = {slot.number: slot.words for slot in spec.slot}
        self._steppers = [slot.number for slot in spec.slot if is_stepper(slot.words)]

    def misplaced(
        self, lines: Sequence[tuple[LoweredLine, FileLine]], calls: Sequence[BlockCall]
    ) -> Iterator[LocalFinding]:
        """Yield the instructions with a bit of a card that is not a terminal, or with a slot that is none."""
        if not self._cards:
            return
        for line, place in lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    text = self._no_terminal(operand) if isinstance(operand, Place | Group) else ""
                    if text:
                        yield LocalFinding(place, text)
        for each in self._lowered.layout.declarations.values():
            if isinstance(each, SlotAlias) and each.slot not in self._cards:
                text = f"SLOT {each.name} : {each.slot}: the rack has modules in {self._there()} only"
                yield LocalFinding(FileLine(str(self._path), self._declared(each.name)), text)
        yield from map(self._wrong_module, self._named_bits(calls))

    def _named_bits(self, calls: Sequence[BlockCall]) -> Iterator[tuple[str, int, FileLine]]:
        """Yield the first use of status, command or configuration bits of a module that has none."""
        seen = set()
        aliases = {name: each.slot for name, each in self._lowered.layout.declarations.items()
                   if isinstance(each, SlotAlias)}  # fmt: skip
        for each in self._mentions:
            name, _, rest = each.text.partition(".")
            slot = aliases.get(name.upper())
            if slot is None or slot not in self._cards or slot in self._steppers or slot in seen:
                continue
            group = rest.lower().partition(".")[0]
            if group.upper() in MEANINGS and group not in self._cards[slot].groups:
                seen.add(slot)
                yield each.text, slot, FileLine(str(self._path), self._declared(name))
        for call in calls:
            for name, operand in call.call.handed.items() if call.call.name == OWNER else ():
                slot = first_leaf(operand).slot
                if (
                    slot is not None
                    and slot in self._cards
                    and slot not in self._steppers
                    and model_of(self._cards[slot]) is None
                    and slot not in seen
                ):
                    seen.add(slot)
                    yield f"{operand.text} as {name.capitalize()} of Amci3601", slot, call.place

    def _wrong_module(self, use: tuple[str, int, FileLine]) -> LocalFinding:
        text, slot, place = use
        steppers = ", ".join(map(str, self._steppers)) or "no slot"
        module = next(each.module for each in self._spec.slot if each.number == slot)
        return LocalFinding(place, f"{text}: slot {slot} has a {module}; a 3601 is in {steppers}")

    def _there(self) -> str:
        return ", ".join(map(str, self._cards))

    def _no_terminal(self, operand: Place | Group) -> str:
        """Return that a bit is no terminal of its card; empty if it is one, or if that is unknown."""
        leaf = first_leaf(operand)
        slot = leaf.slot
        if slot is None or not leaf.is_image:
            return ""
        image = "O" if leaf.output else "I"
        if slot not in self._cards and self._path.suffix in EXPORT_SUFFIXES:
            return ""
        if slot not in self._cards:
            return f"{operand.text}: the rack has modules in slots {self._there()} only"
        bit = operand.bit if isinstance(operand, Place) else None
        word = operand.fixed_index if isinstance(operand, Place) else 0
        if word is None or (bit is not None and not isinstance(bit, Constant)):
            return ""
        there = self._cards[slot].terminals_instead(image, word, 0 if bit is None else int(bit.value))
        if bit is None and not there.startswith("no "):
            return ""
        return f"{operand.text}: the card in slot {slot} has {there}" if there else ""

    def uses_bit(self) -> UsesBit:
        """Return a test whether the program uses a bit of a card."""
        seen = [(first_leaf(each.where), each) for each in self._mentions]

        def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
            return any(
                leaf.slot == slot
                and leaf.is_image
                and leaf.output is (image == "O")
                and (each.reads if image == "I" else each.writes)
                and _reaches(each, word, bit)
                for leaf, each in seen
            )

        return uses


def _reaches(mention: Mention, word: int, bit: int) -> bool:
    where = mention.where
    if isinstance(where, Group):
        return True
    at = where.fixed_index
    if at is None or (mention.stretch and at <= word):
        return True
    return at == word and (not isinstance(where.bit, Constant) or where.bit.value == bit)
