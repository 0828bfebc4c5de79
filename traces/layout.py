"""What sits where in a scan: slots, their images, and the names of the words.

The rack's memory block is the payload of a scan as it stands: per slot, in
slot order, the output image, then the input image, eight little-endian words
each.

    byte  0        16       32       48
          slot 1   slot 1   slot 2   slot 2
          outputs  inputs   outputs  inputs   ...

Word names are the public names of a trace: `/scan.slot1.in.position_msw`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..io_images.image import IMAGE_BYTES, WORDS

SLOT_BYTES = 2 * IMAGE_BYTES
"""Bytes of a slot in the memory block: output image, input image."""


@dataclass(frozen=True, slots=True)
class SlotInfo:
    """One slot of the recorded rack.

    Attributes:
        number: the slot's number in the rack, 0 or more.
        module: catalog name of what sits in it, e.g. "amci3601".
        firmware: its firmware as text, e.g. "4.1"; empty where the module has none.
    """

    number: int
    module: str
    firmware: str = ""


@dataclass(frozen=True, slots=True)
class ModuleWords:
    """The names of a module's words.

    Attributes:
        message: stem of its message types, letters and digits, the first one a capital.
        outputs: names of the eight words from logic to module, lower case.
        inputs: names of the eight words from module to logic.
    """

    message: str
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]


# fmt: off
WORDS_3601 = ModuleWords(
    "Amci3601",
    # chapter 5, output data in command mode    chapter 6, input data in command mode
    outputs=("command_msw", "command_lsw",      "target_msw", "target_lsw",
             "speed_msw", "speed_lsw",          "acceleration", "deceleration"),
    inputs=("status_msw", "status_lsw",         "position_msw", "position_lsw",
            "encoder_msw", "encoder_lsw",       "captured_msw", "captured_lsw"),
)
# fmt: on

SPEAK_3601 = ("amci3601", "pcl601-adapter", "pmc006-adapter")
"""Modules whose words are those of a 3601: itself, and the adapters, which answer as one."""

MODULE_WORDS: Mapping[str, ModuleWords] = dict.fromkeys(SPEAK_3601, WORDS_3601)
"""Modules whose words have names, by catalog name."""

PLAIN_WORDS = ModuleWords(
    "Plain",
    outputs=tuple(f"word{index}" for index in range(WORDS)),
    inputs=tuple(f"word{index}" for index in range(WORDS)),
)
"""The words of any other module."""


def module_words(module: str) -> ModuleWords:
    """Return the word names of a module, `word0` to `word7` for one that has none.

    >>> module_words("amci3601").inputs[2], module_words("my own").inputs[2]
    ('position_msw', 'word2')
    """
    return MODULE_WORDS.get(module, PLAIN_WORDS)


def check_slots(slots: Sequence[SlotInfo]) -> tuple[SlotInfo, ...]:
    """Return the slots as given, once they are known to be recordable.

    Raises:
        ValueError: no slot at all, a negative number, or a number used twice.
    """
    numbers = [slot.number for slot in slots]
    if not numbers:
        raise ValueError("a trace needs at least one slot")
    if min(numbers) < 0:
        raise ValueError(f"slot {min(numbers)}: slot numbers are 0 or more")
    twice = sorted({number for number in numbers if numbers.count(number) > 1})
    if twice:
        raise ValueError(f"slot {twice[0]} is given twice")
    return tuple(slots)
