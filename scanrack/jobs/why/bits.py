"""Bits in the images of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from scanrack.io_images.addresses import Address
from scanrack.io_images.dataclass import dataclass
from scanrack.traces.format.layout import SlotInfo

from .past import ALL_BITS


@dataclass(frozen=True, slots=True)
class Bits:
    """Bits in a word of an image."""

    slot: int
    image: str  # "in" or "out"
    word: int
    mask: int

    @classmethod
    def at(cls, place: Address) -> Bits:
        """Return the bits at an address."""
        mask = ALL_BITS if place.bit is None else 1 << place.bit
        return cls(place.slot, "in" if place.image == "I" else "out", place.word, mask)

    @property
    def address(self) -> Address:
        """The address of the bit, or of the word if there are several bits."""
        bit = self.mask.bit_length() - 1 if self.mask & self.mask - 1 == 0 else None
        return Address(self.slot, "I" if self.image == "in" else "O", self.word, bit)


def read_bits(masks: Iterable[tuple[tuple[int, int], int]]) -> Iterator[Bits]:
    """Yield the inputs in read masks (see `Reads.masks`): each bit, or the word if all its bits were read."""
    for (slot, word), mask in masks:
        parts = [mask] if mask == ALL_BITS else [1 << bit for bit in range(16) if mask >> bit & 1]
        yield from (Bits(slot, "in", word, part) for part in parts)


def is_input_name(name: str) -> bool:
    """Return whether a status bit is named like an input, such as IN_HOME."""
    return name.lower().startswith(("in_", "input_"))


def shows_input(slot: SlotInfo, name: str) -> bool:
    """Return whether a status bit of a stepper shows an input."""
    return is_input_name(name) and name not in slot.words.errors
