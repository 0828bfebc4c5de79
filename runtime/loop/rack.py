"""The rack: modules in numbered slots, with their images in one block of memory.

    memory   | slot 1 outputs | slot 1 inputs | slot 3 outputs | slot 3 inputs | ...
    bytes      0           16              32               48              64

The `ModuleWords` of a module determine the length of its images, see `io_images.memory_layout`. A recorder
copies the memory after every scan. The images that logic and modules use are views of this memory.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TypeVar

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image
from scanrack.io_images.memory_layout import ImagePlaces, MemoryLayout, memory_layout
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords

from .module import Module


@dataclass(frozen=True, slots=True)
class Card:
    """A module to be installed in a rack."""

    slot: int  # number of its slot, 1 or more (slot 0 is the controller)
    module: Module
    catalog: str = ""  # catalog name, such as "amci3601"; only for the trace
    firmware: str = ""  # such as "4.1"; only for the trace
    words: ModuleWords = PLAIN_WORDS  # names of its words and bits, which addresses use
    round_trip_ms: int = 0  # longest time from a command to its response, ms; 0 = set by the scan loop


@dataclass(frozen=True, slots=True)
class Slot:
    """A slot of a rack with its module and its two images, which are views of the rack's memory."""

    number: int
    module: Module
    catalog: str
    firmware: str
    outputs: Image
    inputs: Image
    words: ModuleWords
    round_trip_ms: int

    @property
    def fault(self) -> int:
        """Connection fault, as on a CompactLogix: -1 while the module is not answering, otherwise 0.

        A module without a link always answers (reading A-90).
        """
        return 0 if getattr(self.module, "linked", True) else -1


Seat = TypeVar("Seat")
"""Type of the items in `Slots`: a slot, or a slot's bench."""


class Slots(dict[int, Seat]):
    """The slots of a rack by number, in ascending order; accessing an empty slot raises a ValueError."""

    def __missing__(self, number: object) -> Slot:
        """Raise ValueError for an empty slot."""
        raise ValueError(f"slot {number!r} is empty: modules sit in {', '.join(map(str, self)) or 'none'}")


class Rack:
    """Modules in their slots and one block of memory with all of their images.

    Attributes:
        memory: the images in slot number order; each slot has its output image, then its input image.
        layout: the layout of the images in the memory.
        slots: the slots by number.

    Raises:
        ValueError: a slot number is not a positive integer, or is used twice.
    """

    __slots__ = ("layout", "memory", "slots")

    def __init__(self, cards: Iterable[Card]) -> None:
        ordered = sorted(_checked(cards), key=lambda card: card.slot)
        self.layout: MemoryLayout = memory_layout((card.slot, card.words) for card in ordered)
        self.memory = bytearray(self.layout.size)
        view = memoryview(self.memory)
        self.slots: Mapping[int, Slot] = Slots(
            (card.slot, _slot(card, view, self.layout.places[card.slot])) for card in ordered
        )


def as_logic_sees(slots: Mapping[int, Slot]) -> Mapping[int, Slot]:
    """Return the slots with the same images, but with read-only inputs."""
    return Slots((number, replace(slot, inputs=slot.inputs.read_only())) for number, slot in slots.items())


def _slot(card: Card, memory: memoryview, places: ImagePlaces) -> Slot:
    """Return the slot of a card, with its images as parts of the rack's memory."""
    outputs, inputs = Image(buffer=memory[places.outputs]), Image(buffer=memory[places.inputs])
    description = card.slot, card.module, card.catalog, card.firmware
    return Slot(*description, outputs, inputs, card.words, card.round_trip_ms)


def check_slot_number(number: object) -> None:
    """Raise ValueError unless the value is a valid slot number."""
    if not isinstance(number, int) or isinstance(number, bool) or number < 1:
        raise ValueError(f"slot number {number!r}: must be a whole number, 1 or more")


def _checked(cards: Iterable[Card]) -> list[Card]:
    """Return the cards; raise a ValueError for an invalid slot number, or one that is used twice."""
    cards_by_slot: dict[int, Card] = {}
    for card in cards:
        check_slot_number(card.slot)
        if card.slot in cards_by_slot:
            raise ValueError(f"slot {card.slot} is used twice: each module needs its own slot")
        cards_by_slot[card.slot] = card
    return list(cards_by_slot.values())
