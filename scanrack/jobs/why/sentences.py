"""Describes a change and its line in words.

An answer:

    slot1.command.ABSOLUTE_MOVE is 1 since scan 751 (1.502 s): line.py:56 in logic
        outputs.load(move.to_image())
      inside of if pulse and not line.pulse_before [pulse = True, line.pulse_before = False]
      read before it in that scan: slot 1: IN_CAPTURE 1
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.module_words import CONFIGURES
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.image_text import in_thousands

from .source.conditions import source_line

if TYPE_CHECKING:  # a ladder program needs no lines of Python
    from .source.lines import Line
    from .source.senders import Sender
    from .traced_run import TracedChange

Words = Callable[[int], Sequence[int]]
"""The input images of slots, by slot number."""


def place_of(line: Line) -> str:
    """Return file and line as text.

    >>> from scanrack.jobs.why.source.lines import Line
    >>> place_of(Line("/plant/line.py", 56, "logic"))
    'line.py:56 in logic'
    """
    return f"{Path(line.file).name}:{line.number} in {line.function}"


def change_lines(head: str, change: TracedChange, slots: Iterable[SlotInfo], inputs: Words) -> Iterator[str]:
    """Yield sentences about a change and its line: the code, its conditions, and the inputs read before."""
    line = change.line
    yield f"{head}: {place_of(line)}"
    yield f"    {source_line(line.file, line.number)}"
    known: set[str] = set()
    for text, names in change.stands.inside:
        yield f"  inside of {text}{_values(change.values, names, known)}"
    with_ = _values(change.values, change.stands.names, known)
    if with_:
        yield f"  with{with_}"
    yield f"  read before it in that scan: {read(change.masks, slots, inputs)}"


def sender_lines(head: str, sender: Sender) -> Iterator[str]:
    """Yield sentences about an axis command and the line that awaits it."""
    if sender.line.number:
        yield f"{head}: {place_of(sender.line)}{f', sent by {sender.text}' if sender.text else ''}"
        yield f"    {source_line(sender.line.file, sender.line.number)}"
    else:
        yield f"{head}: sent by {sender.text}"


def _values(values: Mapping[str, str], names: Iterable[str], known: set[str]) -> str:
    """Return the values of names that have not been shown yet, as ` [a = 1, b = 2]`."""
    new = [name for name in dict.fromkeys(names) if name in values and name not in known]
    known.update(new)
    values_text = ", ".join(f"{name} = {values[name]}" for name in new)
    return f" [{values_text}]" if values_text else ""


def read(masks: Mapping[tuple[int, int], int], slots: Iterable[SlotInfo], inputs: Words) -> str:
    """Return the bits and words read from the input images, with their values; see `Reads.masks`."""
    parts = []
    for slot in slots:
        own = {word: mask for (number, word), mask in masks.items() if number == slot.number}
        names = list(_names(slot, own, inputs(slot.number)))
        if names:
            parts.append(f"slot {slot.number}: {', '.join(names)}")
    return "; ".join(parts) or "no input"


def _names(slot: SlotInfo, masks: Mapping[int, int], words: Sequence[int]) -> Iterator[str]:
    numbers = {quantity.word: quantity for quantity in slot.words.quantities_in("in") if quantity.words > 1}
    whole_words = [word for word, mask in masks.items() if mask in (0, 0xFFFF)]
    for word, mask in sorted(masks.items()):
        if word not in whole_words:
            yield from _bits(slot, word, mask, words[word])
        elif word in numbers and word + 1 in whole_words:
            yield f"{numbers[word].name} {in_thousands(numbers[word], words):,}"
        elif word - 1 in numbers and word - 1 in whole_words:
            continue
        else:
            yield f"{slot.words.inputs[word]} {words[word]}"


def _bits(slot: SlotInfo, word: int, mask: int, value: int) -> Iterator[str]:
    named = {bit: name for name, bit in slot.words.bits("I", word)}
    for bit in range(16):
        # every read of another status bit of a stepper also reads MODE_CONFIG, which gives it its meaning
        modes = slot.words.modes
        of_meaning = modes is not None and (word, bit) == (modes.input, CONFIGURES) and not value >> bit & 1
        if mask >> bit & 1 and not of_meaning:
            yield f"{named.get(bit, f'{slot.words.inputs[word]}.{bit}')} {value >> bit & 1}"
