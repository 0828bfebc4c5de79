"""Mistakes in writes to the output words of 3601s: commands never cleared, and words out of range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.amci3601 import CommandMsw, Limits
from scanrack.io_images.image import signed_word
from scanrack.runtime.config.rackspec import SlotSpec, profile_in

from ..facts import Violation
from ..groups import grouped
from .output_writes import Write

_COMMANDS = [bit for bit in CommandMsw if bit not in (CommandMsw.MODE_CONFIG, CommandMsw.RESERVED_14)]


def never_cleared(writes: Sequence[Write]) -> Iterator[Violation]:
    """Yield the first instruction that sets a command bit, for each bit that is never cleared."""
    command_writes = (write for write in writes if write.word == 0)
    for slot, slot_writes in grouped(command_writes, lambda write: write.slot).items():
        for bit in _COMMANDS:
            setting = [write for write in slot_writes if write.commands & bit.value]
            if setting and not any(write.clears_in_operation(bit.value) for write in slot_writes):
                text = f"slot {slot}: {bit.name} is set here, but nothing clears it after the command"
                yield Violation(setting[0].place, text)


def computed(writes: Sequence[Write]) -> Iterator[str]:
    """Yield, for each slot, the text of the first instruction that writes unknown words."""
    slots = set()
    for write in writes:
        if not write.known and write.slot not in slots:
            slots.add(write.slot)
            line = f"{write.place.file}:{write.place.line}"
            yield f"slot {write.slot}: output words that the program computes or a block writes, as in {line}"


def word_ranges(limits: Limits) -> Mapping[int, tuple[int, int]]:
    """Return the range that the commands allow in each of words 2 to 7 [chapter 5, notes 4 to 8]."""
    high, rate = (0, limits.speed // 1000), (0, limits.rate)
    return {2: (-8388, 8388), 3: (-999, 999), 4: high, 5: (0, 999), 6: rate, 7: rate}


def words_out_of_range(writes: Sequence[Write], slots: Mapping[int, SlotSpec]) -> Iterator[Violation]:
    """Yield constants that are out of range for their output word, from 2 to 7."""
    for write in writes:
        ranges = word_ranges(profile_in(slots.values(), write.slot).limits)
        if not write.known or write.word not in ranges:
            continue
        value = signed_word(write.sets)
        least, most = ranges[write.word]
        if not least <= value <= most:
            text = f"slot {write.slot}: output word {write.word} is {value}: must be {least} to {most}"
            yield Violation(write.place, text)
