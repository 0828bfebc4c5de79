"""Mistakes in writes to the output words of 3601s: commands never cleared, and words out of range."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from scanrack.io_images.amci3601 import CommandMsw, Limits
from scanrack.runtime.config.rackspec import SlotSpec, profile_in

from ..facts import Violation
from ..groups import grouped
from .output_writes import Write

_COMMANDS = [bit for bit in CommandMsw if bit not in (CommandMsw.MODE_CONFIG, CommandMsw.RESERVED_14)]


def held(writes: Sequence[Write]) -> Iterator[Violation]:
    """Yield the first instruction that sets a command bit, for each bit that is never cleared."""
    for slot, every in grouped(writes, lambda each: each.slot).items():
        own = [each for each in every if each.word == 0]
        for bit in _COMMANDS:
            setting = [each for each in own if each.commands & bit.value]
            if setting and not any(each.takes_back(bit.value) for each in own):
                text = f"slot {slot}: {bit.name} is set here, and nothing takes it back after the command"
                yield Violation(setting[0].place, text)


def computed(writes: Sequence[Write]) -> Iterator[str]:
    """Yield, for each slot, the text of the first instruction that writes unknown words."""
    slots = set()
    for each in writes:
        if not each.known and each.slot not in slots:
            slots.add(each.slot)
            where = f"{each.place.file}:{each.place.line}"
            yield f"slot {each.slot}: output words that the program computes or a block writes, as in {where}"


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
        value = write.sets - (1 << 16) * (write.sets >> 15)
        least, most = ranges[write.word]
        if not least <= value <= most:
            text = f"slot {write.slot}: output word {write.word} is {value}: must be {least} to {most}"
            yield Violation(write.place, text)
