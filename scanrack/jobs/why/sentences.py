"""Describes a change and its line in words.

An answer:

    slot1.command.ABSOLUTE_MOVE is 1 since scan 751 (1.502 s): line.py:56 in logic
        outputs.load(move.to_image())
      inside of if pulse and not line.pulse_before [pulse = True, line.pulse_before = False]
      read before it in this scan: slot 1: IN_CAPTURE 1
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.module_words import CONFIGURES, Quantity
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
    """Return the file and line as text.

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
    shown: set[str] = set()
    for text, names in change.stands.inside:
        yield f"  inside of {text}{_new_values(change.values, names, shown)}"
    line_values = _new_values(change.values, change.stands.names, shown)
    if line_values:
        yield f"  with{line_values}"
    yield f"  read before it in this scan: {read_text(change.masks, slots, inputs)}"


def sender_lines(head: str, sender: Sender) -> Iterator[str]:
    """Yield sentences about an axis command and the line that awaits it."""
    if sender.line.number:
        yield f"{head}: {place_of(sender.line)}{f', sent by {sender.text}' if sender.text else ''}"
        yield f"    {source_line(sender.line.file, sender.line.number)}"
    else:
        yield f"{head}: sent by {sender.text}"


def _new_values(values: Mapping[str, str], names: Iterable[str], shown: set[str]) -> str:
    """Return the values of names that have not been shown yet, as ` [a = 1, b = 2]`; note them as shown."""
    new = [name for name in dict.fromkeys(names) if name in values and name not in shown]
    shown.update(new)
    values_text = ", ".join(f"{name} = {values[name]}" for name in new)
    return f" [{values_text}]" if values_text else ""


def read_text(masks: Mapping[tuple[int, int], int], slots: Iterable[SlotInfo], inputs: Words) -> str:
    """Return the bits and words read from the input images, with their values; see `Reads.masks`."""
    parts = []
    for slot in slots:
        slot_masks = {word: mask for (number, word), mask in masks.items() if number == slot.number}
        values = list(_read_values(slot, slot_masks, inputs(slot.number)))
        if values:
            parts.append(f"slot {slot.number}: {', '.join(values)}")
    return "; ".join(parts) or "no input"


def _long_quantities(slot: SlotInfo) -> dict[int, Quantity]:
    """Return the input quantities of more than one word, by their first word."""
    return {quantity.word: quantity for quantity in slot.words.quantities_in("in") if quantity.words > 1}


def _read_values(slot: SlotInfo, masks: Mapping[int, int], words: Sequence[int]) -> Iterator[str]:
    """Yield the names and values of a slot's bits, words and two-word quantities that were read."""
    quantities = _long_quantities(slot)
    whole_words = [word for word, mask in masks.items() if mask in (0, 0xFFFF)]
    for word, mask in sorted(masks.items()):
        if word not in whole_words:
            yield from _read_bits(slot, word, mask, words[word])
        elif word in quantities and word + 1 in whole_words:
            yield f"{quantities[word].name} {in_thousands(quantities[word], words):,}"
        elif word - 1 in quantities and word - 1 in whole_words:
            continue  # the LSW of the quantity that was just yielded
        else:
            yield f"{slot.words.inputs[word]} {words[word]}"


def _read_bits(slot: SlotInfo, word: int, mask: int, value: int) -> Iterator[str]:
    """Yield each masked bit of a word with its value, such as `IN_CAPTURE 1`."""
    names = {bit: name for name, bit in slot.words.bits("I", word)}
    modes = slot.words.modes
    if modes is not None and word == modes.input and not value >> CONFIGURES & 1:
        # a stepper's program reads MODE_CONFIG with every status bit; it tells nothing unless it is on
        mask &= ~(1 << CONFIGURES)
    for bit in range(16):
        if mask >> bit & 1:
            yield f"{names.get(bit, f'{slot.words.inputs[word]}.{bit}')} {value >> bit & 1}"
