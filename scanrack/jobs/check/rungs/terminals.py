"""Terminals and slots in a ladder program: the used terminals, and those that the rack lacks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeGuard

from scanrack.io_images.drives.translation import model_of
from scanrack.ladder.debug.crossref import Mention
from scanrack.ladder.model.operands import Constant, Group, Place, first_leaf
from scanrack.ladder.model.resolver import MEANINGS
from scanrack.ladder.model.tags import Leaf, SlotAlias
from scanrack.ladder.state.lowered import steps_of

from ...load.program import EXPORT_SUFFIXES
from ..facts import FileLine, UsesBit, Violation
from .view import LadderView


class Terminals:
    """The terminals that a program names."""

    def __init__(self, view: LadderView) -> None:
        self._view = view
        self._cards = {slot.number: slot.words for slot in view.spec.slot}

    def misplaced(self) -> Iterator[Violation]:
        """Yield the instructions that use a bit without a terminal on its card, or a missing slot."""
        if not self._cards:
            return
        for line, place in self._view.lines:
            for step in steps_of(line.nodes):
                for operand in step.operands:
                    text = self._no_terminal(operand) if isinstance(operand, Place | Group) else ""
                    if text:
                        yield Violation(place, text)
        for alias in self._view.lowered.layout.declarations.values():
            if isinstance(alias, SlotAlias) and alias.slot not in self._cards:
                text = f"SLOT {alias.name} : {alias.slot}: the rack has modules in {self._slots()} only"
                yield Violation(self._view.declaration(alias.name), text)
        yield from map(self._wrong_module, self._named_bits())

    def _named_bits(self) -> Iterator[tuple[str, int, FileLine]]:
        """Yield, by slot, the first use of status, command or configuration bits that its module lacks."""
        first_uses: dict[int, tuple[str, int, FileLine]] = {}
        for text, slot, place in (*self._aliased_bits(), *self._owned_images()):
            first_uses.setdefault(slot, (text, slot, place))
        yield from first_uses.values()

    def _is_other_module(self, slot: int | None) -> TypeGuard[int]:
        return slot in self._cards and slot not in self._view.steppers

    def _aliased_bits(self) -> Iterator[tuple[str, int, FileLine]]:
        """Yield uses of bit groups that a slot's module does not have, through the name of the slot."""
        declared = self._view.lowered.layout.declarations
        aliases = {name: alias.slot for name, alias in declared.items() if isinstance(alias, SlotAlias)}
        for mention in self._view.mentions:
            name, _, members = mention.text.partition(".")
            slot = aliases.get(name.upper())
            group = members.lower().partition(".")[0]
            is_group = group.upper() in MEANINGS
            if is_group and self._is_other_module(slot) and group not in self._cards[slot].groups:
                yield mention.text, slot, self._view.declaration(name)

    def _owned_images(self) -> Iterator[tuple[str, int, FileLine]]:
        """Yield the images of other modules, except networked drives, that a call of Amci3601 receives."""
        for call in self._view.calls:
            for name, operand in call.call.handed.items() if call.is_owner else ():
                slot = first_leaf(operand).slot
                if self._is_other_module(slot) and model_of(self._cards[slot]) is None:
                    yield f"{operand.text} as {name.capitalize()} of Amci3601", slot, call.place

    def _wrong_module(self, use: tuple[str, int, FileLine]) -> Violation:
        text, slot, place = use
        steppers = ", ".join(map(str, self._view.steppers)) or "no slot"
        modules = {spec.number: spec.module for spec in self._view.spec.slot}
        return Violation(place, f"{text}: slot {slot} has a {modules[slot]}; a 3601 is in {steppers}")

    def _slots(self) -> str:
        return ", ".join(map(str, self._cards))

    def _no_terminal(self, operand: Place | Group) -> str:
        """Return a message if a bit is not a terminal of its card; "" if it is one, or if unknown."""
        leaf = first_leaf(operand)
        if leaf.slot is None or not leaf.is_image:
            return ""
        if leaf.slot in self._cards:
            alternative = self._terminals_instead(operand, leaf)
            return f"{operand.text}: the card in slot {leaf.slot} has {alternative}" if alternative else ""
        is_export = self._view.path.suffix in EXPORT_SUFFIXES
        return "" if is_export else f"{operand.text}: the rack has modules in slots {self._slots()} only"

    def _terminals_instead(self, operand: Place | Group, leaf: Leaf) -> str:
        """Return the terminals that a card has instead of an operand; "" if it exists or is unknown."""
        bit = operand.bit if isinstance(operand, Place) else None
        word = operand.fixed_index if isinstance(operand, Place) else 0
        if leaf.slot is None or word is None or not isinstance(bit, Constant | None):
            return ""
        image, number = "O" if leaf.output else "I", 0 if bit is None else int(bit.value)
        alternative = self._cards[leaf.slot].terminals_instead(image, word, number)
        return alternative if bit is not None or alternative.startswith("no ") else ""

    def uses_bit(self) -> UsesBit:
        """Return a function that tests whether the program uses a bit of a card."""
        read = [mention for mention in self._view.mentions if mention.reads]
        writes = [mention for mention in self._view.mentions if mention.writes]
        uses_by_image = {"I": _by_slot(read, output=False), "O": _by_slot(writes, output=True)}

        def uses(slot: int, image: str, _name: str, word: int, bit: int) -> bool:
            return any(_may_use(mention, word, bit) for mention in uses_by_image[image].get(slot, ()))

        return uses


def _by_slot(mentions: Iterable[Mention], *, output: bool) -> Mapping[int | None, list[Mention]]:
    """Return the operands in input or output images, by slot."""
    by_slot: dict[int | None, list[Mention]] = {}
    for mention in mentions:
        leaf = first_leaf(mention.where)
        if leaf.is_image and leaf.output is output:
            by_slot.setdefault(leaf.slot, []).append(mention)
    return by_slot


def _may_use(mention: Mention, word: int, bit: int) -> bool:
    """Whether an operand in an image may include a bit."""
    where = mention.where
    if isinstance(where, Group):
        return True
    index = where.fixed_index
    if index is None or (mention.stretch and index <= word):
        return True
    return index == word and (not isinstance(where.bit, Constant) or where.bit.value == bit)
