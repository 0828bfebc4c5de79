"""The layout of a scan: slots, their images, and the names of the words.

The payload of a scan is the rack's memory block, unchanged. It has each slot's output image, then its input
image, in slot order, and padding at the end, see `io_images.memory_layout`. An image has one little-endian
word for each name of the module's words.

    byte  0        16       32       48
          slot 1   slot 1   slot 2   slot 2
          outputs  inputs   outputs  inputs   ...

Word names are the public names of a trace: `/scan.slot1.inputs.position_msw`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from scanrack.io_images.amci3601.words import WORDS_3601, is_stepper
from scanrack.io_images.cards import KINDS
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords

_BY_NAME = ModuleWords("", (), ())
"""Placeholder for the default words of a module's name."""


@dataclass(frozen=True, slots=True)
class SlotInfo:
    """One slot of the recorded rack.

    Attributes:
        number: the slot's number in the rack, 0 or more.
        module: catalog name of its module, e.g. "amci3601".
        firmware: firmware version as text, e.g. "4.1"; empty for a module without firmware.
        words: names of its words and bits. The default is a 3601's names for an "amci3601", and `word0` to
            `word7` for any other module.
    """

    number: int
    module: str
    firmware: str = ""
    words: ModuleWords = _BY_NAME

    def __post_init__(self) -> None:
        """Use the default words if none are given, and add the kind of a card to its words."""
        if self.words is _BY_NAME:
            words = WORDS_3601 if self.module == "amci3601" else PLAIN_WORDS
            object.__setattr__(self, "words", words)
        kind = KINDS.get(self.module)
        if kind is not None and kind.has_members:
            card_words = replace(self.words, card=kind.name, data_bits=kind.data_bits)
            object.__setattr__(self, "words", card_words)

    @property
    def is_stepper(self) -> bool:
        """Whether the slot has the words of a 3601, which is true for a 3601 and for an adapter.

        >>> SlotInfo(1, "amci3601").is_stepper, SlotInfo(2, "my own").words.inputs[2]
        (True, 'word2')
        """
        return is_stepper(self.words)


def listed(slots: Iterable[SlotInfo]) -> str:
    """Return slots with their modules as text.

    >>> listed([SlotInfo(1, "amci3601"), SlotInfo(2, "")])
    'slot 1: amci3601, slot 2: -'
    """
    return ", ".join(f"slot {slot.number}: {slot.module or '-'}" for slot in slots)


def block_layout(slots: Sequence[SlotInfo]) -> MemoryLayout:
    """Return the locations of the slots' images in the memory block."""
    return memory_layout((slot.number, slot.words) for slot in slots)


def check_slots(slots: Sequence[SlotInfo]) -> tuple[SlotInfo, ...]:
    """Return the slots after checking that they can be recorded.

    Raises:
        ValueError: there are no slots, a slot number is negative, or a number is used twice.
    """
    slot_numbers = [slot.number for slot in slots]
    if not slot_numbers:
        raise ValueError("a trace needs at least one slot")
    if min(slot_numbers) < 0:
        raise ValueError(f"slot {min(slot_numbers)}: slot numbers are 0 or more")
    duplicates = sorted({number for number in slot_numbers if slot_numbers.count(number) > 1})
    if duplicates:
        raise ValueError(f"slot {duplicates[0]} is given twice")
    return tuple(slots)
